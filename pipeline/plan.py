"""What a run will compute: the axes, the gear of every row, and the blocks of rows that are chunks and tasks."""

import hashlib
import json
import math
from dataclasses import asdict, dataclass, replace
from itertools import product

import numpy as np

from pipeline.axes import ROLES, TEMPERATURE, Axis, axes_of, value_of
from pipeline.config import Settings
from pipeline.errors import ConfigurationError

__all__ = [
    "ROLES",
    "TEMPERATURE",
    "Axis",
    "Block",
    "Plan",
    "check_numbers",
    "gear_of",
    "numbers_digest",
    "plan",
    "plan_of",
    "warnings",
]

#: Raised when stored numbers would no longer mean the same; part of the configuration's digest. Only stores of this
#: version are read.
SCHEMA_VERSION = 3

_BLOCK_BYTES = 2**20
_BLOCKS_AT_LEAST = 16


@dataclass(frozen=True)
class Block:
    """Rows start ... stop - 1: one chunk of the store and one task. Rows of a volume are numbered through, layer by
    layer; a block belongs to one layer."""

    start: int
    stop: int


@dataclass(frozen=True)
class Plan:
    """A plane, or a volume of planes, to be computed, independent of files and executors.

    Parameters
    ----------
    gear : dict
        Keyword arguments of `solver.Model`, without what the axes replace.
    sweep, parameter : Axis
        Along a row, and from row to row.
    omega : float or None
        The frequency, where it is not an axis.
    solver : dict
        Continuation settings.
    max_solutions, max_branches, max_points : int
        Room per row.
    physical : dict or None
        A gear in SI units, `pipeline.physical.describe`; None where it is dimensionless.
    thermal : dict or None
        Laws of temperature in SI units, where that is the row parameter; see `pipeline.thermal`.
    parameter2 : Axis or None
        From layer to layer of a volume; None for a plane.
    """

    gear: dict
    sweep: Axis
    parameter: Axis
    omega: float | None
    solver: dict
    max_solutions: int
    max_branches: int
    max_points: int
    physical: dict | None = None
    thermal: dict | None = None
    parameter2: Axis | None = None

    @property
    def numbers(self) -> dict:
        """Everything that changes numbers, as plain data; what they mean in physical units included, where they do."""
        numbers = json.loads(json.dumps(asdict(self)))
        for name in ("physical", "thermal", "parameter2"):
            if numbers[name] is None:
                del numbers[name]
        return numbers

    @property
    def digest(self) -> str:
        """Digest of `numbers`."""
        return numbers_digest(self.numbers)

    @property
    def row_axes(self) -> tuple[Axis, ...]:
        """The axes that rows are numbered along, the slowest first."""
        return (self.parameter,) if self.parameter2 is None else (self.parameter2, self.parameter)

    @property
    def axes(self) -> tuple[Axis, ...]:
        """All axes, as people name them: the columns' first."""
        return (self.sweep, *reversed(self.row_axes))

    @property
    def rows(self) -> int:
        """Number of rows, all layers together."""
        return math.prod(axis.num for axis in self.row_axes)

    def layer(self, index: int) -> "Plan":
        """The plane that one layer of a volume is."""
        name, value = self.parameter2.name, float(self.parameter2.values[index])
        if name == "omega":
            return replace(self, omega=value, parameter2=None)
        return replace(self, gear={**self.gear, name: value}, parameter2=None)

    def row(self, number: int) -> tuple["Plan", float]:
        """The plane that a row belongs to, and its value there of the row parameter."""
        layer, place = divmod(number, self.parameter.num)
        return self if self.parameter2 is None else self.layer(layer), float(self.parameter.values[place])

    def row_text(self, number: int) -> str:
        """Which row that is, for messages."""
        places = np.unravel_index(number, [axis.num for axis in self.row_axes])
        values = ", ".join(f"{axis.name} = {axis.values[i]:.6g}" for axis, i in zip(self.row_axes, places, strict=True))
        return f"row {number} ({values})"

    def place(self, block: Block) -> tuple[int | slice, ...]:
        """Where a block is in arrays along `row_axes`."""
        layer, start = divmod(block.start, self.parameter.num)
        rows = slice(start, start + block.stop - block.start)
        return (rows,) if self.parameter2 is None else (layer, rows)

    @property
    def motion_size(self) -> int:
        """Numbers of a motion stored beside mean, amplitude and phase: all harmonics of a Galerkin balance."""
        unknowns = 2 * int(self.solver["order"]) * int(self.solver["period"]) + 1
        return unknowns if self.solver["balance"] == "galerkin" else 0

    @property
    def rows_per_block(self) -> int:
        """Rows of a chunk: about 1 MB of the largest array, and at least sixteen blocks in all; no more is needed to
        keep workers busy, and the number of workers may not matter."""
        row_bytes = 8 * max(self.motion_size, 1) * max(self.sweep.num * self.max_solutions, self.max_points)
        return max(1, min(_BLOCK_BYTES // row_bytes, -(-self.rows // _BLOCKS_AT_LEAST), self.parameter.num))

    @property
    def blocks(self) -> list[Block]:
        """All blocks in order."""
        layer = self.parameter.num
        return [block for first in range(0, self.rows, layer) for block in self.blocks_of(Block(first, first + layer))]

    def blocks_of(self, rows: Block) -> list[Block]:
        """The blocks that hold some rows of one layer, in order."""
        size, layer = self.rows_per_block, self.parameter.num
        first = rows.start - rows.start % layer
        begin = (rows.start - first) // size * size
        return [Block(first + i, first + min(i + size, layer)) for i in range(begin, rows.stop - first, size)]

    @property
    def bytes(self) -> int:
        """Upper bound of the store's size, uncompressed."""
        extra = 8 * self.motion_size
        solution = 35 + (16 + extra if extra else 0)
        return self.rows * (self.sweep.num * (solution * self.max_solutions + 8) + (53 + extra) * self.max_points)


def numbers_digest(numbers: dict) -> str:
    """Digest of what changes numbers, the same on every machine."""
    text = json.dumps({"schema": SCHEMA_VERSION, **numbers}, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def plan_of(numbers: dict) -> Plan:
    """The plan that `Plan.numbers` came from; a store keeps it, so that only the sweep needs a configuration."""
    axes = {role: Axis(**numbers[role]) for role in ROLES if role in numbers}
    return Plan(**{**numbers, **axes})


def plan(settings: Settings) -> Plan:
    """Check a configuration and turn it into a plan.

    Parameters
    ----------
    settings : Settings

    Returns
    -------
    Plan

    Raises
    ------
    ConfigurationError
        Naming the key, its value and what is allowed.
    """
    from solver import SCALAR_PARAMETERS

    config = settings.config
    gear, physical = gear_of(config.gear)
    scales = None if physical is None else _scales(physical)
    axes = axes_of(config.plane, SCALAR_PARAMETERS, scales)
    thermal = _thermal(settings, physical) if axes["parameter"].name == TEMPERATURE else None
    names = {axis.name for axis in axes.values()}
    omega = config.plane.omega
    if omega is not None:
        omega = value_of("plane.omega", "omega", omega, scales)
    if "omega" in names and omega is not None:
        raise ConfigurationError(f"plane.omega = {omega!r} is not allowed: omega is an axis of this plane")
    if "omega" not in names and (omega is None or not 0.0 < omega < np.inf):
        raise ConfigurationError(f"plane.omega = {omega!r} is not allowed: it must be a finite number above 0")
    for name in ("max_solutions", "max_branches", "max_points"):
        low, high = (2, 10**7) if name == "max_points" else (1, 100)
        value = getattr(config.store, name)
        if not low <= value <= high:
            raise ConfigurationError(f"store.{name} = {value} is not allowed: it must be from {low} to {high}")

    if physical is not None:
        _check_axis_keys(settings, names)
    for name in names & set(gear):
        key = f"gear.{name.replace('variation_', 'variation.')}"
        if settings.overridden(key):
            raise ConfigurationError(f"{key} is not allowed here: {name} is an axis of this plane")
        if isinstance(gear[name], list) and len(set(map(str, gear[name]))) > 1:
            raise ConfigurationError(
                f"{key} = {gear[name]} is not allowed: {name} is an axis, so it must be one number"
            )
    # What an axis replaces does not belong to the configuration.
    result = Plan(
        gear={key: value for key, value in gear.items() if key not in names},
        **axes,
        omega=omega,
        solver=asdict(config.solver),
        max_solutions=config.store.max_solutions,
        max_branches=config.store.max_branches,
        max_points=config.store.max_points,
        physical=physical,
        thermal=thermal,
    )
    check_numbers(result)
    return result


def gear_of(config) -> tuple[dict, dict | None]:
    """Keyword arguments of the dimensionless model, and what it comes from where that is a gear in physical units."""
    values = asdict(config)
    del values["physical"], values["thermal"]
    if config.physical is None:
        for key, value in values.items():
            if value is None:
                raise ConfigurationError(f"gear.{key} has no value")
        variation = values.pop("variation")
        values.update({f"variation_{part}": variation[part] for part in ("translation", "rotation")})
        return values, None
    for key, value in values.items():
        if value is not None:
            raise ConfigurationError(
                f"gear.{key} = {value!r} is not allowed: it must be null, because it follows from gear.physical"
            )
    from pipeline.physical import describe
    from solver import GearPair

    physical = describe(config.physical)
    # As a store gives it back.
    gear = json.loads(json.dumps(asdict(GearPair(**physical["gear"]).model())))
    return gear, json.loads(json.dumps(physical))


def _thermal(settings: Settings, physical: dict | None) -> dict:
    """The laws of temperature, as plain data."""
    config, where = settings.config.gear.thermal, "plane.parameter.name = 'temperature' is not allowed"
    if physical is None:
        raise ConfigurationError(f"{where}: it needs a gear in physical units, such as gear=miter")
    if config is None:
        raise ConfigurationError(f"{where}: gear.thermal, the laws of temperature, has no value")
    from pipeline.thermal import thermal_numbers
    from solver import GearPair

    return json.loads(json.dumps(thermal_numbers(config, GearPair(**physical["gear"]))))


def _scales(physical: dict):
    from solver import GearPair, Scales

    return Scales(GearPair(**physical["gear"]))


def _check_axis_keys(settings: Settings, names: set[str]) -> None:
    from pipeline.physical import AXIS_KEYS

    for name in names & set(AXIS_KEYS):
        key = f"gear.physical.{AXIS_KEYS[name]}"
        if settings.overridden(key):
            raise ConfigurationError(f"{key} is not allowed here: {name}, which follows from it, is an axis")


def _outer_planes(plan: Plan) -> list[Plan]:
    """The plane itself; the first and the last layer of a volume."""
    return [plan] if plan.parameter2 is None else [plan.layer(0), plan.layer(-1)]


def check_numbers(plan: Plan) -> None:
    """Build the models at the plane's corners and the solver once, so that a bad value shows before anything runs."""
    from pipeline.sweep import balance_of, continuation_of, model_at, row_axis, seeds_of
    from solver import ParameterError

    axis = row_axis(plan)
    if not isinstance(axis, str) and plan.sweep.name in axis.uses:
        raise ConfigurationError(
            f"plane.sweep.name = {plan.sweep.name!r} is not allowed: over {axis} it must be another parameter than "
            f"{', '.join(axis.uses)}, which follow from the {axis}"
        )
    try:
        balance_of(plan.solver)
        continuation_of(plan.solver)
        seeds_of(plan.solver)
    except ParameterError as error:
        raise ConfigurationError(f"solver.{error}") from None
    rows = [plan.parameter.low, plan.parameter.high]
    if plan.thermal is not None:
        # Gears may jam between temperatures at which they do not.
        rows += plan.parameter.values[1:-1].tolist()
    for plane in _outer_planes(plan):
        for row, column in product(rows, (plan.sweep.low, plan.sweep.high)):
            try:
                model_at(plane, row, column)
            except ParameterError as error:
                key = _key_of(error, plan)
                message = str(error).replace(error.name, key, 1)
                raise ConfigurationError(message) from None


def _key_of(error, plan: Plan) -> str:
    """The key that a model's parameter has its value from; between the ends of an axis, the axis itself."""
    name = error.name.split("[")[0]
    for role, axis in zip(ROLES, plan.axes, strict=False):
        if name == axis.name:
            return {axis.low: f"plane.{role}.min", axis.high: f"plane.{role}.max"}.get(error.value, name)
    return f"gear.{error.name.replace('variation_', 'variation.')}"


def warnings(plan: Plan) -> list[str]:
    """What is allowed but worth a line: stiffness that turns negative, and mesh damping that breaks the physics."""
    from pipeline.sweep import model_at

    lines = []
    corners = [
        model_at(plane, row, column)
        for plane in _outer_planes(plan)
        for row in (plan.parameter.low, plan.parameter.high)
        for column in (plan.sweep.low, plan.sweep.high)
    ]
    lowest = min(model.lowest_stiffness() for model in corners)
    if lowest < 0.0:
        lines.append(
            f"the mesh stiffness falls to {lowest:.3g} of its mean somewhere in this plane: below 0 is unphysical"
        )
    model = corners[0]
    ratios = tuple(xi / model.xi_mesh for xi in model.xi_translation) if model.xi_mesh > 0.0 else model.kappa
    if any(abs(ratio - kappa) > 1e-9 for ratio, kappa in zip(ratios, model.kappa, strict=True)):
        shown, wanted = (", ".join(f"{x:g}" for x in dict.fromkeys(values)) for values in (ratios, model.kappa))
        parts = ("xi_mesh", "xi_translation", "kappa")
        moved = [f" at {axis.name} = {axis.low:g}" for axis in plan.axes if axis.name in parts]
        names = {axis.name for axis in plan.axes}
        hint = "; plane.parameter.name=mesh_damping moves both" if "xi_mesh" in names else ""
        lines.append(
            f"gear.xi_translation/gear.xi_mesh = {shown}{''.join(moved)} differs from gear.kappa = {wanted}: "
            f"one mesh force would make them equal{hint}"
        )
    if plan.physical is not None:
        from pipeline.physical import cycle_note

        lines += cycle_note(plan)
    if plan.parameter2 is not None:
        lines.append(
            "a volume has no boundaries of its own: plane.layer=VALUE takes out the plane of one layer, which has"
        )
    return lines
