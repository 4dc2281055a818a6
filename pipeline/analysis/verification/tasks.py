"""What workers do for a verification: integrate from solutions of the map, and sweep its rows at higher orders."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.analysis.verification.starts import Start
from pipeline.analysis.verification.verdicts import Seen, Verdict, seen_of, settling_of
from pipeline.plan.numerics import continuation_of, point_of, row_of
from pipeline.plan.plan import Block, Plan
from pipeline.plane.stored import StoredPlane
from solver import LiftedSeeds, Row, RowError, gear_system
from solver.stability import Instability

__all__ = ["CheckedRows", "check_rows", "follow_starts"]

#: What a wrong number, and not a wrong program, raises.
_NUMERICAL = (ArithmeticError, ValueError, np.linalg.LinAlgError, MemoryError)


def follow_starts(plan: Plan, starts: tuple[Start, ...], max_periods: int, tolerance: float) -> list[Seen]:
    """Start on solutions of the map and integrate until settled.

    Parameters
    ----------
    plan : Plan
    starts : tuple of Start
        Those of one cell follow each other.
    max_periods : int
    tolerance : float
        How far mean and amplitude may be off, as a share of the size of lambda (gap and static deflection).

    Returns
    -------
    list of Seen
        One per start; what fails is told there.
    """
    from solver.timedomain import orbit_state, settle

    settling, period = settling_of(max_periods), int(plan.solver["period"])
    found = []
    for start in starts:
        model, omega = point_of(plan, *_place(plan, start.row, start.column))
        system = gear_system(model)
        try:
            state = orbit_state(system, omega, start.coefficients, period)
            (attractor,) = settle(system, omega, state[None], settling=settling)
            room = tolerance * system.motion_size
            found.append(seen_of(attractor, start.mean, start.amplitude, start.impact, room, period))
        except _NUMERICAL as error:
            found.append(Seen(Verdict.FAILED, message=_reason(error)))
    return found


@dataclass(frozen=True)
class CheckedRows:
    """Labels of some rows at two higher orders.

    Parameters
    ----------
    block : Block
    low, high : (rows, X) uint16 arrays
        Codes of the labels, 0 where a row could not be swept.
    unstable : (rows, X) int8 array
        1 where a statically stable solution of the map is dynamically unstable at the higher order, -1 unknown.
    messages : tuple of str
        Why a row could not be swept, else empty.
    """

    block: Block
    low: np.ndarray
    high: np.ndarray
    unstable: np.ndarray
    messages: tuple[str, ...]


def check_rows(path: str, plan: Plan, orders: tuple[int, int], columns: int, block: Block) -> CheckedRows:
    """Sweep the complete rows of a block at two orders.

    Parameters
    ----------
    path : str
        The store.
    plan : Plan
    orders : (int, int)
        The lower and the higher order.
    columns : int
        Values of the axis at which branches are sought.
    block : Block
    """
    plane = StoredPlane(Path(path), plan, block=block)
    shape = (plane.rows.size, plan.sweep.num)
    low, high, unstable = np.zeros(shape, np.uint16), np.zeros(shape, np.uint16), np.full(shape, -1, np.int8)
    messages = [""] * shape[0]
    for i in np.flatnonzero(plane.complete).tolist():
        value = float(plane.rows[i])
        try:
            rows = [_row(plan, value, order, columns) for order in orders]
        except _NUMERICAL as error:
            messages[i] = _reason(error)
            continue
        low[i], high[i] = rows[0].domain, rows[1].domain
        counted = np.where(plane.stable[i] == 1, 1.0, np.nan)
        unstable[i] = _counts_unstable(plane.mean[i] * counted, plane.amplitude[i] * counted, rows[1])
    return CheckedRows(block, low, high, unstable, tuple(messages))


def _row(plan: Plan, value: float, order: int, columns: int) -> Row:
    from solver.harmonic.galerkin import Galerkin

    balance = Galerkin(order, int(plan.solver["period"]))
    return row_of(plan, value, balance, continuation_of(plan.solver), LiftedSeeds(columns))


def _counts_unstable(mean: np.ndarray, amplitude: np.ndarray, row: Row) -> np.ndarray:
    """Where one of the map's solutions (X, S; nan: none) is unstable: the nearest one of the row stands for it."""
    stable = row.stable == 1
    gaps = np.maximum(
        np.abs(mean[:, :, None] - row.mean[:, None, :]), np.abs(amplitude[:, :, None] - row.amplitude[:, None, :])
    )
    gaps = np.where(stable[:, None, :] & ~np.isnan(gaps), gaps, np.inf)
    nearest = np.argmin(gaps, axis=2)
    known = np.isfinite(np.min(gaps, axis=2))
    # What is contradictory or undecided is not called unstable.
    bad = stable & (row.instability > Instability.NONE) & (row.instability < Instability.CONTRADICTORY)
    return np.any(known & np.take_along_axis(bad, nearest, axis=1), axis=1).astype(np.int8)


def _place(plan: Plan, row: int, column: int) -> tuple[float, float]:
    return float(plan.parameter.values[row]), float(plan.sweep.values[column])


def _reason(error: Exception) -> str:
    text = " ".join(str(error).split())
    return text if isinstance(error, RowError) else f"{type(error).__name__}: {text}"
