"""The motions at one place of a plane: stored in its cell, or solved exactly there."""

import numpy as np

from pipeline.config.quantities import READ
from pipeline.plan.numerics import balance_of, continuation_of, point_of, row_of, seeds_of
from pipeline.plan.plan import Plan
from solver import all_solutions, domain_code, domain_label, impact_state
from solver.enumeration.solutions import Proof, Solutions
from solver.harmonic.quantities import balance_quantities
from solver.stability import assess

__all__ = ["MOTION", "is_enumerated", "proven_at", "proven_label", "solved_motions"]

#: What is told of a motion, besides the quantities that are read of it.
MOTION = ("amplitude", "phase", "stable", "impact", "instability", "multiplier")


def is_enumerated(plan: Plan) -> bool:
    """Whether every solution at a place can be found with proof: of first order alone."""
    return plan.solver["balance"] == "describing_function"


def proven_at(plan: Plan, x: float, p: float) -> Solutions:
    """Every solution at a place of a plane of first order.

    Raises
    ------
    ArithmeticError
        If they are not proven to be all, as on a boundary.
    """
    model, omega = point_of(plan, p, x)
    found = all_solutions(model, omega, amplitude_max=float(plan.solver["amplitude_max"]))
    if found.proof is not Proof.PROVEN:
        where = {plan.sweep.name: x, plan.parameter.name: p}
        raise ArithmeticError(f"{found.proof.sentence} It is asked at {where}.")
    return found


def proven_label(plan: Plan, x: float, p: float) -> str:
    """The label n/I at a place of a plane of first order; raises as `proven_at`."""
    found, b = proven_at(plan, x, p), point_of(plan, p, x)[0].b
    states = impact_state(found.mean - found.amplitude, found.mean + found.amplitude, b)[found.stable == 1]
    mask = np.bitwise_or.reduce(1 << states.astype(np.int64), initial=0)
    return domain_label(int(domain_code(np.array(states.size), mask)))


def solved_motions(plan: Plan, x: float, p: float) -> dict[str, np.ndarray]:
    """Every motion at a place, by ascending amplitude: at first order enumerated with proof, else those of its row.

    Returns
    -------
    dict
        Name -> (S,) array, those of `MOTION` and of `pipeline.config.quantities.READ`.

    Raises
    ------
    ArithmeticError
        If at first order they are not proven to be all, or the row cannot be solved.
    """
    return _enumerated(plan, x, p) if is_enumerated(plan) else _of_row(plan, x, p)


def _enumerated(plan: Plan, x: float, p: float) -> dict[str, np.ndarray]:
    found, balance = proven_at(plan, x, p), balance_of(plan.solver)
    model, omega = point_of(plan, p, x)
    motions, places = np.column_stack([found.mean, found.cos, found.sin]), np.full(found.mean.size, omega)
    kind, modulus = np.empty(0, np.int8), np.empty(0)
    if places.size:
        stability = assess(model, "omega", places, motions, balance=balance, static=found.stable)
        kind, modulus = stability.kind.astype(np.int8), stability.modulus
    quantities = balance_quantities(balance, model, "omega", places, motions)
    return {
        "amplitude": found.amplitude,
        "phase": np.arctan2(-found.sin, found.cos),
        "stable": found.stable,
        "impact": impact_state(*balance.extremes(motions), model.b),
        "instability": kind,
        "multiplier": modulus,
        **{one.name: quantities[:, one.slot] for one in READ},
    }


def _of_row(plan: Plan, x: float, p: float) -> dict[str, np.ndarray]:
    settings, columns = plan.solver, np.union1d(plan.sweep.values, [x])
    row = row_of(plan, p, balance_of(settings), continuation_of(settings), seeds_of(settings), columns)
    column = int(np.searchsorted(columns, x))
    here = row.stable[column] >= 0
    values = {name: getattr(row, name)[column, here] for name in MOTION}
    return values | {one.name: row.quantities[column, here, one.slot] for one in READ}
