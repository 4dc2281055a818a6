"""From a plan to the objects of the solver: balance, continuation, seeds, the system at a place, one row."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING

from pipeline.config.allowed import check_one
from pipeline.config.schema import Solver
from pipeline.plan.kinds import kind_of
from pipeline.plan.plan import Plan
from pipeline.plan.thermal import thermal_pair
from solver import (
    Balance,
    Broyden,
    ContactSystem,
    Continuation,
    DescribingFunction,
    LiftedSeeds,
    LinearSeeds,
    Model,
    Newton,
    ParameterError,
    ProvenSeeds,
)
from solver.model.mesh_damping import MESH_DAMPING
from solver.model.parameter_path import ParameterPath, place_on

if TYPE_CHECKING:
    from solver import Row
    from solver.rows.seeds import Seeds

__all__ = [
    "System",
    "balance_of",
    "continuation_of",
    "frame_of",
    "gear_at",
    "model_at",
    "point_of",
    "row_axis",
    "row_of",
    "row_system",
    "seeds_of",
    "sweep_axis",
    "system_along",
]

#: What a plane is made of.
System = Model | ContactSystem

CORRECTORS = {"newton": Newton, "broyden": Broyden}
NOT_CONTINUATION = ("balance", "order", "period", "certify", "certify_columns")


def balance_of(settings: dict) -> Balance:
    """The harmonic balance that the solver settings describe."""
    _check_word("balance", settings)
    if settings["balance"] == "galerkin":
        # Its kernels are many, and first-order runs do without them.
        from solver.harmonic.galerkin import Galerkin

        return Galerkin(settings["order"], settings["period"])
    for name in ("order", "period"):
        if settings[name] != 1:
            raise ParameterError(name, settings[name], "1 for the describing function; solver=hb balances more")
    return DescribingFunction()


def _check_word(name: str, settings: dict) -> None:
    """A plan may come from a store, whose settings no schema has seen."""
    check_one(Solver, f"solver.{name}", str(settings[name]))


def continuation_of(settings: dict) -> Continuation:
    """The continuation that the solver settings describe."""
    settings = {key: value for key, value in settings.items() if key not in NOT_CONTINUATION}
    _check_word("corrector", settings)
    name, tolerance = settings.pop("corrector"), settings.pop("tolerance")
    return Continuation(corrector=CORRECTORS[name](tolerance=tolerance), **settings)


def seeds_of(settings: dict) -> Seeds:
    """Where branches start, as the solver settings describe."""
    _check_word("certify", settings)
    if settings["certify"] == "none":
        return LinearSeeds()
    if settings["balance"] == "galerkin":
        if settings["certify"] == "all":
            raise ParameterError("certify", "all", "none or columns for solver=hb: only first order can be proven")
        return LiftedSeeds(settings["certify_columns"])
    return ProvenSeeds(settings["certify_columns"], every_column=settings["certify"] == "all")


def model_at(plan: Plan, row: float, column: float) -> System:
    """The system at one point of the plane; omega, if it is an axis, is not the system's."""
    return _on_path(plan, row, kind_of(plan).system(plan.gear, _values(plan, row, column)))


def row_system(plan: Plan, row: float) -> System:
    """The system of one row, to be varied along `sweep_axis`; its own value of that is not used."""
    values = _values(plan, row, plan.sweep.low)
    return _on_path(plan, row, kind_of(plan).system(plan.gear, values, (plan.sweep.name,)))


def system_along(plan: Plan, row: float, column: float, *names: str) -> tuple[System, *tuple[str, ...]]:
    """The system through a place, to be varied along some parameters, axes of the plane or not; and what the solver
    calls these."""
    kind = kind_of(plan)
    system = _on_path(plan, row, kind.system(plan.gear, _values(plan, row, column), names))
    return system, *map(kind.solver_axis, names)


def gear_at(plan: Plan, row: float, column: float) -> dict:
    """The numbers of a plan's gear with those that its axes have at a place."""
    system = model_at(plan, row, column)
    if isinstance(system, Model):
        return asdict(system)
    return {**plan.gear, **{name: value for name, value in _values(plan, row, column).items() if name != "omega"}}


def sweep_axis(plan: Plan) -> str:
    """The swept parameter as the solver calls it."""
    return kind_of(plan).solver_axis(plan.sweep.name)


def row_axis(plan: Plan) -> str | ParameterPath:
    """The row parameter as the solver takes it: a name, or the path along which it moves numbers of the gear."""
    if plan.thermal is not None:
        return thermal_pair(plan.thermal).path
    return MESH_DAMPING if plan.parameter.name == MESH_DAMPING.name else kind_of(plan).solver_axis(plan.parameter.name)


def frame_of(plan: Plan) -> tuple:
    """The system to start from, both axes and the ranges of both, as boundaries and regions take them."""
    x, p = plan.sweep, plan.parameter
    start = kind_of(plan).system(plan.gear, _values(plan, p.low, x.low), (x.name, p.name))
    return start, sweep_axis(plan), row_axis(plan), (x.low, x.high), (p.low, p.high)


def _values(plan: Plan, row: float, column: float) -> dict[str, float]:
    """The values of the axes at a point; without the row's, where a path moves the gear."""
    rows = {plan.parameter.name: row} if isinstance(row_axis(plan), str) else {}
    return {plan.sweep.name: column, **rows}


def _on_path(plan: Plan, row: float, start: System) -> System:
    """The gear after the row parameter has moved it, where that is a path."""
    axis = row_axis(plan)
    # At the reference temperature the gear is its own model: even that c is geometric stays, which enumeration encloses
    # a little wider than the number.
    at_reference = plan.thermal is not None and row == 0.0
    return start if isinstance(axis, str) or at_reference else place_on(axis, row, start)[0]


def point_of(plan: Plan, row: float, column: float) -> tuple[System, float]:
    """The system and the mesh frequency at one point of the plane."""
    axes = {plan.parameter.name: row, plan.sweep.name: column}
    return model_at(plan, row, column), axes.get("omega", plan.omega)


def row_of(plan: Plan, value: float, balance: Balance, continuation: Continuation, seeds: Seeds, columns=None) -> Row:
    """One row of the plane, with whatever balance; raises as `solver.sweep_row` does.

    `columns` (X,) are values of the sweep axis from its first to its last, the plane's own unless given.
    """
    # Most of the solver, which a plan can do without.
    from solver import sweep_row

    grid = plan.sweep.values if columns is None else columns
    kept = dict(omega=plan.frequency(value), continuation=continuation, seeds=seeds, balance=balance)
    return sweep_row(row_system(plan, value), sweep_axis(plan), grid, **kept)
