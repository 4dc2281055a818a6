"""The motions at one place of a plane, solved exactly there."""

from dataclasses import dataclass

import numpy as np

from pipeline.config.quantities import READ
from pipeline.plan.numerics import balance_of, continuation_of, point_of, row_of, seeds_of
from pipeline.plan.plan import Plan
from pipeline.plan.traits import dead_zone
from solver import all_solutions, domain_code, domain_label
from solver.contact.impact import impact_of_range
from solver.enumeration.solutions import Above, Proof, Solutions
from solver.harmonic.quantities import balance_quantities
from solver.stability import assess

__all__ = ["MOTION", "SolvedMotions", "label_of", "motions_of_place", "proven_label", "solved_motions"]

#: What is told of a motion, besides the quantities that are read of it.
MOTION = ("amplitude", "phase", "stable", "impact", "instability", "multiplier")


@dataclass(frozen=True, eq=False)
class SolvedMotions:
    """The motions at a place, by ascending amplitude; S of them with n unknowns.

    Parameters
    ----------
    unknowns : (S, n) array
        (Lambda_0, c_1, s_1, ...) of lambda.
    amplitude, phase : (S,) arrays
        Of the mesh frequency.
    stable, impact, instability : (S,) int arrays
        As in a store.
    multiplier : (S,) array
        Largest modulus over the motion's period.
    quantities : (S, 13) array
        By `solver.contact.quantities.Slot`.
    proof : Proof or None
        That they are all up to the amplitude ceiling; None at higher orders, which have none.
    doubts : tuple of str
        Why there may be others, in sentences.
    """

    unknowns: np.ndarray
    amplitude: np.ndarray
    phase: np.ndarray
    stable: np.ndarray
    impact: np.ndarray
    instability: np.ndarray
    multiplier: np.ndarray
    quantities: np.ndarray
    proof: Proof | None
    doubts: tuple[str, ...]

    @property
    def values(self) -> dict[str, np.ndarray]:
        """Name -> (S,) array, those of `MOTION` and of `pipeline.config.quantities.READ`."""
        return {name: getattr(self, name) for name in MOTION} | {one.name: self.quantities[:, one.slot] for one in READ}


def motions_of_place(plan: Plan, x: float, p: float) -> SolvedMotions:
    """Every motion at a place: at first order enumerated, else those of its row.

    Raises
    ------
    solver.RowError
        If the row cannot be solved.
    """
    return _enumerated(plan, x, p) if plan.is_first_order else _of_row(plan, x, p)


def _solutions(plan: Plan, x: float, p: float) -> Solutions:
    model, omega = point_of(plan, p, x)
    return all_solutions(model, omega, amplitude_max=float(plan.solver["amplitude_max"]))


def _unproven(plan: Plan, x: float, p: float, proof: Proof) -> ArithmeticError:
    return ArithmeticError(f"{proof.sentence} It is asked at { {plan.sweep.name: x, plan.parameter.name: p} }.")


def proven_label(plan: Plan, x: float, p: float) -> str:
    """The label n/I at a place of a plane of first order; raises as `solved_motions`."""
    found, ends = _solutions(plan, x, p), dead_zone(point_of(plan, p, x)[0])
    if found.proof is not Proof.PROVEN:
        raise _unproven(plan, x, p, found.proof)
    return label_of(found.stable, impact_of_range(found.mean - found.amplitude, found.mean + found.amplitude, *ends))


def label_of(stable: np.ndarray, impact: np.ndarray) -> str:
    """The n/I label of the motions at a place.

    Examples
    --------
    >>> label_of(np.array([1, 0, 1]), np.array([0, 1, 1]))
    '2/0-1'
    """
    states = impact[stable == 1].astype(np.int64)
    return domain_label(int(domain_code(np.array(states.size), np.bitwise_or.reduce(1 << states, initial=0))))


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
    found = motions_of_place(plan, x, p)
    if found.proof not in (None, Proof.PROVEN):
        raise _unproven(plan, x, p, found.proof)
    return found.values


def _enumerated(plan: Plan, x: float, p: float) -> SolvedMotions:
    found, balance = _solutions(plan, x, p), balance_of(plan.solver)
    model, omega = point_of(plan, p, x)
    motions, places = np.column_stack([found.mean, found.cos, found.sin]), np.full(found.mean.size, omega)
    kind, modulus = np.empty(0, np.int8), np.empty(0)
    if places.size:
        stability = assess(model, "omega", places, motions, balance=balance, static=found.stable)
        kind, modulus = stability.kind.astype(np.int8), stability.modulus
    told = (found.proof, Proof.PROVEN), (found.above, Above.EMPTY)
    return SolvedMotions(
        motions,
        found.amplitude,
        np.arctan2(-found.sin, found.cos),
        found.stable,
        impact_of_range(*balance.extremes(motions), *dead_zone(model)),
        kind,
        modulus,
        balance_quantities(balance, model, "omega", places, motions),
        found.proof,
        tuple(known.sentence for known, wanted in told if known is not wanted),
    )


def _of_row(plan: Plan, x: float, p: float) -> SolvedMotions:
    settings, columns = plan.solver, np.union1d(plan.sweep.values, [x])
    row = row_of(plan, p, balance_of(settings), continuation_of(settings), seeds_of(settings), columns)
    column = int(np.searchsorted(columns, x))
    here = row.stable[column] >= 0
    doubts = (
        ("Branches that are not known, or above the amplitude ceiling, may pass here.",) if row.open[column] else ()
    )
    described = (getattr(row, name)[column, here] for name in (*MOTION, "quantities"))
    return SolvedMotions(row.motions[column, here], *described, None, doubts)
