"""From a configuration to a plan, checked by building the models at its corners once."""

import json
from dataclasses import asdict
from itertools import product

import numpy as np

from pipeline.config.compose import Settings
from pipeline.config.physical import AXIS_KEYS, TEMPERATURE, describe, value_of
from pipeline.config.systems import SECTIONS, described, section_of
from pipeline.errors import ConfigurationError, refused
from pipeline.plan.axes import ROLES, axes_of
from pipeline.plan.kinds import APART, BEVEL, KINDS, kind_of
from pipeline.plan.numerics import (
    balance_of,
    continuation_of,
    frame_of,
    model_at,
    row_axis,
    row_system,
    seeds_of,
    sweep_axis,
)
from pipeline.plan.plan import Plan
from pipeline.plan.scales import cycle_note, scales_from, teeth_note
from pipeline.plan.thermal import thermal_numbers
from pipeline.plan.traits import feels, lowest_stiffness
from pipeline.plan.unfelt import unfelt_harmonics
from solver import GearPair, Model, ParameterError, ProvenSeeds
from solver.enumeration.condensed import UnprovableError, condensed_over

__all__ = ["asked_numbers", "check_numbers", "gear_of", "plan", "warnings"]

#: Values of an axis, and rows of all layers together; and blocks of rows, each of which has a file per array.
_MOST_VALUES, _MOST_BLOCKS = 10**6, 10**5
#: Temperatures at which a gear is tried before anything runs.
_MOST_TEMPERATURES = 1000
#: Parameters of which one mesh force makes two follow from the third.
_DAMPING_PARTS = ("xi_mesh", "xi_translation", "kappa")


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
    found = _parts(settings)
    gear, physical = found["gear"], found["physical"]
    names = {axis.name for role in ROLES if (axis := found.get(role)) is not None}
    omega = found["omega"]
    if "omega" in names and omega is not None:
        raise ConfigurationError(f"plane.omega = {omega!r} is not allowed: omega is an axis of this plane")
    if "omega" not in names and (omega is None or not 0.0 < omega < np.inf):
        raise refused("plane.omega", omega, "a finite number above 0")
    if physical is not None:
        _check_axis_keys(settings, names)
    for name in names & set(gear):
        key = KINDS[found["kind"]].key(name)
        if settings.overridden(key):
            raise ConfigurationError(f"{key} is not allowed here: {name} is an axis of this plane")
        if isinstance(gear[name], list) and len(set(map(str, gear[name]))) > 1:
            raise ConfigurationError(
                f"{key} = {gear[name]} is not allowed: {name} is an axis, so it must be one number"
            )
    # What an axis replaces does not belong to the configuration.
    result = Plan(**{**found, "gear": {key: value for key, value in gear.items() if key not in names}})
    check_numbers(result)
    _check_provable(result)
    return result


def _parts(settings: Settings) -> dict:
    """Keyword arguments of the plan, each for itself; the gear still has what an axis replaces."""
    config = settings.config
    kind, gear, physical = gear_of(config.gear)
    scales = scales_from(physical)
    axes = axes_of(config.plane, KINDS[kind], scales)
    omega = config.plane.omega
    return {
        "gear": gear,
        **axes,
        "omega": None if omega is None else value_of("plane.omega", "omega", omega, scales),
        "solver": asdict(config.solver),
        **{name: getattr(config.store, name) for name in ("max_solutions", "max_branches", "max_points")},
        "physical": physical,
        "thermal": _thermal(settings, physical) if axes["parameter"].name == TEMPERATURE else None,
        "kind": kind,
    }


def asked_numbers(settings: Settings) -> dict:
    """What a configuration asks for, as `Plan.inputs` has it, whether or not it makes a plane as a whole.

    The gear still has what an axis replaces.

    Raises
    ------
    ConfigurationError
        If one of its parts is not allowed.
    """
    parts = _parts(settings)
    return json.loads(json.dumps({name: asdict(part) if name in ROLES else part for name, part in parts.items()}))


def gear_of(config) -> tuple[str, dict, dict | None]:
    """The kind of a system, its numbers as the kind takes them, and what these come from where units were given."""
    if (section := section_of(config)) is not None:
        return section, *json.loads(json.dumps(described(section, config)))
    return BEVEL.name, *_bevel(config)


def _bevel(config) -> tuple[dict, dict | None]:
    """Keyword arguments of the dimensionless model, and what it comes from where that is a gear in physical units."""
    values = asdict(config)
    for name in ("physical", "thermal", *SECTIONS):
        del values[name]
    if config.physical is None:
        for key, value in values.items():
            if value is None:
                raise ConfigurationError(f"gear.{key} has no value")
        variation = values.pop("variation")
        values.update({f"variation_{part}": variation[part] for part in ("translation", "rotation")})
        return values, None
    for key, value in values.items():
        if value is not None:
            raise refused(f"gear.{key}", value, "null, because it follows from gear.physical")
    physical = describe(config.physical)
    # As a store gives it back.
    gear = json.loads(json.dumps(asdict(GearPair(**physical["gear"]).model())))
    return gear, json.loads(json.dumps(physical))


def _thermal(settings: Settings, physical: dict | None) -> dict:
    """The laws of temperature, as plain data."""
    config, where = settings.config.gear.thermal, "plane.parameter.name = 'temperature' is not allowed"
    if physical is None or "gear" not in physical:
        raise ConfigurationError(f"{where}: it needs a gear in physical units, such as gear=miter")
    if config is None:
        raise ConfigurationError(f"{where}: gear.thermal, the laws of temperature, has no value")
    return json.loads(json.dumps(thermal_numbers(config, GearPair(**physical["gear"]))))


def _check_axis_keys(settings: Settings, names: set[str]) -> None:
    for name in names & set(AXIS_KEYS):
        key = f"gear.physical.{AXIS_KEYS[name]}"
        if settings.overridden(key):
            raise ConfigurationError(f"{key} is not allowed here: {name}, which follows from it, is an axis")


def _outer_planes(plan: Plan) -> list[Plan]:
    """The plane itself; the first and the last layer of a volume."""
    return [plan] if plan.parameter2 is None else [plan.layer(0), plan.layer(-1)]


def check_numbers(plan: Plan) -> None:
    """Build the models at the plane's corners and the solver once, so that a bad value shows before anything runs."""
    _check_sizes(plan)
    _check_axes(plan)
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
        step = -(-plan.parameter.num // _MOST_TEMPERATURES)
        rows += plan.parameter.values[step:-1:step].tolist()
    for plane in _outer_planes(plan):
        for row, column in product(rows, (plan.sweep.low, plan.sweep.high)):
            try:
                model_at(plane, row, column)
            except ParameterError as error:
                key = _key_of(error, plan)
                message = str(error).replace(error.name, key, 1)
                raise ConfigurationError(message) from None


def _check_provable(plan: Plan) -> None:
    """Raise if every solution is to be proven of a system of which nothing can be, before every row fails of it."""
    if plan.kind == BEVEL.name or not isinstance(seeds_of(plan.solver), ProvenSeeds):
        return
    ends = np.array([plan.sweep.low, plan.sweep.high])
    for plane in _outer_planes(plan):
        for row in (plan.parameter.low, plan.parameter.high):
            try:
                condensed_over(row_system(plane, row), sweep_axis(plane), ends, plane.frequency(row))
            except UnprovableError as error:
                asked = plan.solver["certify"]
                raise ConfigurationError(
                    f"solver.certify = {asked!r} is not allowed for this gear: it must be none, because {error}"
                ) from None


def _check_axes(plan: Plan) -> None:
    """Raise if two axes move the same numbers, or one moves nothing."""
    kind, names = kind_of(plan), [axis.name for axis in plan.axes]
    for one, other in APART:
        if {one, other} <= set(names):
            role = ROLES[max(names.index(one), names.index(other))]
            raise ConfigurationError(
                f"plane.{role}.name = {names[ROLES.index(role)]!r} is not allowed: {one} and {other} move the same "
                "numbers, of which one axis can be"
            )
    try:
        system = frame_of(_outer_planes(plan)[0])[0]
        felt = {name for name in kind.axes if feels(system, kind.solver_axis(name))}
    except ParameterError:
        # Said below, with its key.
        return
    for role, name in zip(ROLES, names, strict=False):
        if name in kind.axes and name not in felt:
            others = ", ".join(["omega", *(one for one in kind.axes if one in felt)])
            raise ConfigurationError(
                f"plane.{role}.name = {name!r} is not allowed: it changes nothing of this gear; "
                f"it must be one of {others}"
            )


def _check_sizes(plan: Plan) -> None:
    """Raise if a plane has more values, rows or blocks than memory should ever be asked for."""
    for role, axis in zip(ROLES, plan.axes, strict=False):
        if axis.num > _MOST_VALUES:
            raise refused(f"plane.{role}.num", axis.num, f"at most {_MOST_VALUES}")
    roles = " x ".join(f"plane.{role}.num" for role, _ in zip(ROLES[1:], plan.row_axes, strict=False))
    if plan.rows > _MOST_VALUES:
        raise refused(roles, plan.rows, f"at most {_MOST_VALUES} rows")
    if plan.n_blocks > _MOST_BLOCKS:
        raise ConfigurationError(
            f"{roles} = {plan.rows} is not allowed: in chunks of {plan.rows_per_block} rows it must be at most "
            f"{_MOST_BLOCKS * plan.rows_per_block}; fewer columns or store.max_points make room for more"
        )


def _key_of(error, plan: Plan) -> str:
    """The key that a model's parameter has its value from; between the ends of an axis, the axis itself."""
    name = error.name.split("[")[0]
    for role, axis in zip(ROLES, plan.axes, strict=False):
        if name == axis.name:
            return {axis.low: f"plane.{role}.min", axis.high: f"plane.{role}.max"}.get(error.value, name)
    return kind_of(plan).key(error.name)


def warnings(plan: Plan, settings: Settings | None = None) -> list[str]:
    """What is allowed but worth a line: stiffness that turns negative, harmonics that the balance does not feel, mesh
    damping that breaks the physics.

    Parameters
    ----------
    plan : Plan
    settings : Settings, optional
        What the user typed: that the published gear's own mesh damping breaks it is then left out, unless that was
        changed or is an axis.
    """
    lines = []
    corners = [
        model_at(plane, row, column)
        for plane in _outer_planes(plan)
        for row in (plan.parameter.low, plan.parameter.high)
        for column in (plan.sweep.low, plan.sweep.high)
    ]
    lowest = min(map(lowest_stiffness, corners))
    if lowest < 0.0:
        lines.append(
            f"the mesh stiffness falls to {lowest:.3g} of its mean somewhere in this plane: below 0 is unphysical"
        )
    if (unfelt := unfelt_harmonics(plan)) is not None:
        lines.append(unfelt.sentence)
    if isinstance(corners[0], Model):
        lines += _mesh_damping(plan, settings, corners[0])
    if plan.physical is not None:
        lines += [*cycle_note(plan), *teeth_note(plan)]
    return lines


def _mesh_damping(plan: Plan, settings: Settings | None, model: Model) -> list[str]:
    """That mesh damping breaks the physics, where it does."""
    names = {axis.name for axis in plan.axes}
    changed = any(name in names or (settings and settings.overridden(f"gear.{name}")) for name in _DAMPING_PARTS)
    if settings is not None and settings.choices["gear"] == "published" and not changed:
        return []
    ratios = tuple(xi / model.xi_mesh for xi in model.xi_translation) if model.xi_mesh > 0.0 else model.kappa
    if all(abs(ratio - kappa) <= 1e-9 for ratio, kappa in zip(ratios, model.kappa, strict=True)):
        return []
    shown, wanted = (", ".join(f"{x:g}" for x in dict.fromkeys(values)) for values in (ratios, model.kappa))
    moved = [f" at {axis.name} = {axis.low:g}" for axis in plan.axes if axis.name in _DAMPING_PARTS]
    hint = "; plane.parameter.name=mesh_damping moves both" if "xi_mesh" in names else ""
    return [
        f"gear.xi_translation/gear.xi_mesh = {shown}{''.join(moved)} differs from gear.kappa = {wanted}: "
        f"one mesh force would make them equal{hint}"
    ]
