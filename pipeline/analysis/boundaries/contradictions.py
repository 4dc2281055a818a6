"""Where a multiplier passes +1 and no branch folds: the borders of what static and dynamic stability contradict.

Rows do not locate these places. They are sought where neighbouring cells say so, along the folds, next to which they
lie where the order of the balance is high enough, and where a Neimark-Sacker boundary ends at the resonance 1:1.
"""

from collections.abc import Iterable

import numpy as np

from pipeline.plan.numerics import balance_of, continuation_of, frame_of
from pipeline.plan.plan import Plan
from pipeline.plane.stored import StoredPlane
from solver import Event
from solver.boundaries import BoundaryCurve, SpecialPoint
from solver.boundaries.tracer import events_near
from solver.stability import Instability

__all__ = ["contradiction_starts", "contradictory_cells"]

# A place may be this far from where it is sought, as a share of the sweep axis. One is sought every so many points of a
# fold curve, and every so many rows along cells that follow one another.
_REACH, _EVERY = 0.01, 10
# Such cells are at most so many columns apart, and their motions so far, as a share of their size.
_COLUMNS, _MOTION = 1.5, 0.1


def contradictory_cells(part: StoredPlane) -> np.ndarray:
    """Motions (k, n + 2), (u, x, p), half-way between two neighbouring cells of a row of which one is contradictory."""
    stable, columns = part.stable == 1, part.plan.sweep.values
    contradictory = stable & (part.instability == Instability.CONTRADICTORY)
    somewhere = contradictory.any(axis=-1)
    row, column = np.nonzero(somewhere[:, :-1] | somewhere[:, 1:])
    if not row.size:
        return np.empty((0, balance_of(part.plan.solver).unknowns + 2))
    ours, theirs = part.motions_in(row, column), part.motions_in(row, column + 1)
    both = stable[row, column][:, :, None] & stable[row, column + 1][:, None]
    apart = np.where(both, np.abs(ours[:, :, None] - theirs[:, None]).max(axis=-1), np.inf)
    nearest = apart.argmin(axis=2)
    becomes = np.take_along_axis(contradictory[row, column + 1], nearest, axis=1)
    pair, motion = np.nonzero(both.any(axis=2) & (contradictory[row, column] != becomes))
    row, column = row[pair], column[pair]
    middles = 0.5 * (ours[pair, motion] + theirs[pair, nearest[pair, motion]])
    return np.column_stack([middles, 0.5 * (columns[column] + columns[column + 1]), part.rows[row]])


def _sparse(plan: Plan, cells: np.ndarray) -> np.ndarray:
    """Of cells that follow one another from row to row, as along one boundary, the first two and every tenth.

    The very first may lie on the border of the plane, where boundaries are started last.
    """
    row = np.searchsorted(plan.parameter.values, cells[:, -1])
    reach = _COLUMNS * (plan.sweep.high - plan.sweep.low) / (plan.sweep.num - 1)
    number = np.zeros(len(cells), dtype=int)
    for i, cell in enumerate(cells):
        before = np.flatnonzero(row == row[i] - 1)
        gaps = np.abs(cells[before] - cell)
        apart = np.maximum(gaps[:, -2] / reach, gaps[:, :-2].max(axis=1) / (_MOTION * np.abs(cell[:-2]).max()))
        if apart.min(initial=np.inf) <= 1.0:
            number[i] = number[before[apart.argmin()]] + 1
    return cells[(number == 1) | (number % _EVERY == 0)]


def contradiction_starts(
    plan: Plan, cells: np.ndarray, curves: Iterable[BoundaryCurve]
) -> list[tuple[Event, np.ndarray]]:
    """Starts of the boundaries along which a multiplier passes +1.

    Parameters
    ----------
    plan : Plan
    cells : (k, n + 2) array
        `contradictory_cells` of all rows.
    curves : iterable of BoundaryCurve
        The folds and Neimark-Sacker boundaries of the plane.
    """
    balance = balance_of(plan.solver)
    guesses = [_sparse(plan, cells)]
    for curve in curves:
        for number, stretch in enumerate(curve.stretches):
            y = stretch.curve.points
            y = y[:, [*range(balance.unknowns), -2, -1]]
            if curve.kind is Event.FOLD and balance.truncated:
                guesses.append(y[::_EVERY])
            elif curve.kind is Event.NEIMARK_SACKER:
                ends = {0: number == 0, -1: number == len(curve.stretches) - 1}
                at = [i for i, last in ends.items() if last and curve.special[i] == SpecialPoint.RESONANCE_1_1]
                guesses.append(y[at])
    omega = None if "omega" in (plan.sweep.name, plan.parameter.name) else plan.omega
    return events_near(
        *frame_of(plan),
        [(Event.UNIT_MULTIPLIER, guess) for guess in np.concatenate(guesses)],
        _REACH * (plan.sweep.high - plan.sweep.low),
        omega=omega,
        balance=balance,
        continuation=continuation_of(plan.solver),
    )
