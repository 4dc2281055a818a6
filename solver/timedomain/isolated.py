"""Branches that a row lacks: isolas, and motions of several forcing periods, from attractors found by integration.

An attractor that repeats after n forcing periods has harmonics of Omega / n. Newton's method of the balance of order H
on that period leads from them to a solution; where no branch that is known passes it, the branch through it is followed
over the range of the row.
"""

import math
from dataclasses import dataclass

import numpy as np

from solver.continuation.continuation import Continuation
from solver.continuation.solution_curve import Curve, EndReason
from solver.harmonic.galerkin import Galerkin
from solver.model.checks import ParameterError, finite_array, instance_of
from solver.model.contact_system import gear_system, reduced
from solver.model.gear_model import Model
from solver.model.packing import check_axis
from solver.rows.coverage import CorrectedCoverage
from solver.rows.phases import equal_motions, shifted
from solver.rows.row import Row
from solver.rows.span import RowSpan
from solver.stability.bifurcations import with_bifurcations
from solver.timedomain.attractor_row import AttractorRow, AttractorSearch
from solver.timedomain.attractors import find_attractors
from solver.timedomain.integrator import Status
from solver.timedomain.poincare import measure

__all__ = ["IsolatedBranch", "IsolatedBranches", "isolated_branches"]

#: Forcing periods that a balance can have.
_PERIODS = (1, 2, 3, 4)
#: A solution of the balance is that of an attractor if no unknown differs by more, in units of lambda's size.
_NEAR = 0.2


@dataclass(frozen=True, eq=False)
class IsolatedBranch:
    """A branch that no branch of the row has.

    Parameters
    ----------
    balance : Galerkin
        Of which its points are solutions: the order of the row's, on `balance.period` forcing periods.
    curve : Curve
        Its points, with folds, grazings, period doublings and Neimark-Sacker points.
    cell, slot : int
        The attractor that it was found from.
    """

    balance: Galerkin
    curve: Curve
    cell: int
    slot: int

    @property
    def period(self) -> int:
        """Forcing periods after which its motions repeat."""
        return self.balance.period

    @property
    def isolated(self) -> bool:
        """Whether it is a closed curve: no sweep along the axis can reach it."""
        return self.curve.closed

    @property
    def joined(self) -> bool:
        """Whether it begins or ends on a branch of a shorter period, at a period doubling."""
        return EndReason.JOINED in self.curve.ends


@dataclass(frozen=True, eq=False)
class IsolatedBranches:
    """What the attractors of a row lead to.

    Parameters
    ----------
    branches : tuple of IsolatedBranch
        Those of the shortest period first, then in the order of the cells that they were found from.
    attractors : AttractorRow
        They were found from.
    notes : tuple of str
        What could not be followed, in sentences.
    """

    branches: tuple[IsolatedBranch, ...]
    attractors: AttractorRow
    notes: tuple[str, ...]


def isolated_branches(
    row: Row,
    values,
    *,
    omega: float | None = None,
    attractors: AttractorRow | None = None,
    search: AttractorSearch | None = None,
    continuation: Continuation | None = None,
) -> IsolatedBranches:
    """The branches that a row lacks, sought from the attractors at some values of its axis.

    Parameters
    ----------
    row : Row
        Of the `Galerkin` balance on one forcing period; branches are followed over its range and at its order.
    values : (X,) array_like
        Of the row's axis, ascending and within the row's range: where attractors are sought.
    omega : float, optional
        The frequency, as it was for the row; needed unless it is the axis.
    attractors : AttractorRow, optional
        Those at the values, if they are known; sought from rest and from random states unless given.
    search : AttractorSearch, optional
        How they are sought.
    continuation : Continuation, optional

    Returns
    -------
    IsolatedBranches
        What integration does not meet is not found: a branch without a stable part, or whose basin no start lies in.

    Raises
    ------
    ParameterError
        If the row is of another balance, or an argument is not allowed.

    Notes
    -----
    Motions of more than four forcing periods are not followed.
    """
    balance = instance_of("row", row, Row).balance
    if not isinstance(balance, Galerkin) or balance.period != 1:
        raise ParameterError("row", balance, "a row of the Galerkin balance on one forcing period")
    low, high = float(row.grid[0]), float(row.grid[-1])
    values = finite_array("values", values, (None,))
    if not values.size or np.any(np.diff(values) <= 0.0) or not low <= values[0] <= values[-1] <= high:
        raise ParameterError("values", values, f"ascending, within {low:g} ... {high:g}")
    check_axis(row.system, row.axis, low, high, omega)
    omega = None if row.axis == "omega" else float(omega)
    continuation = Continuation() if continuation is None else instance_of("continuation", continuation, Continuation)
    search = AttractorSearch() if search is None else instance_of("search", search, AttractorSearch)
    if attractors is None:
        attractors = find_attractors(row.system, row.axis, values, omega=omega, search=search)
    elif len(instance_of("attractors", attractors, AttractorRow).kind) != values.size:
        raise ParameterError("attractors", f"a row of {len(attractors.kind)} cells", f"a row of {values.size} cells")
    branches, notes = [], []
    for period in _PERIODS:
        cells, slots = np.nonzero(attractors.kind == period)
        if not cells.size:
            continue
        own = Galerkin(balance.order, period)
        span = RowSpan(own, row.system, row.axis, low, high, omega, continuation)
        coverage = CorrectedCoverage(span, values)
        if period == 1:
            for curve in row.curves:
                coverage.know(curve)
        starts = np.array(
            [_harmonics(row, values[i], omega, attractors.state[i, k], own) for i, k in zip(cells, slots, strict=True)]
        )
        solutions = span.corrected(np.column_stack([starts, values[cells]]))[:, :-1]
        reached = np.max(np.abs(solutions - starts), axis=1) <= _NEAR * span.problem.scale[0]
        if not np.all(reached):
            first = values[cells[np.flatnonzero(~reached)[0]]]
            notes.append(
                f"{np.count_nonzero(~reached)} attractors of {period} forcing periods, the first at {row.axis} ="
                f" {first:.9g}, have no solution of order {balance.order} near them."
            )
        proper = reached & ~_shorter(solutions, span)
        for i, slot, start in zip(cells[proper], slots[proper], solutions[proper], strict=True):
            known = len(coverage.curves)
            coverage.add(np.array([i]), start[None])
            branches += [
                IsolatedBranch(own, with_bifurcations(own, span.problem, curve, span.continuation), int(i), int(slot))
                for curve in coverage.curves[known:]
                if not np.all(_shorter(curve.points[:, :-1], span))
            ]
        notes += coverage.notes
    return IsolatedBranches(tuple(branches), attractors, tuple(notes))


def _harmonics(row: Row, value: float, omega: float | None, state: np.ndarray, balance: Galerkin) -> np.ndarray:
    """Unknowns (n,) of the balance for the motion that starts from a state; nan where it cannot be integrated."""
    system = row.system
    if isinstance(system, Model):
        system = gear_system(system if row.axis == "omega" else system.replace(**{row.axis: float(value)}))
    else:
        system = system.at(row.axis, float(value))
    frequency, period = float(value) if omega is None else omega, balance.period
    start = state[np.isfinite(state)]
    found = measure(reduced(system), frequency, start, period, divisor=period, order=balance.harmonics)
    unknowns = np.full(balance.unknowns, math.nan)
    if found.status is Status.COMPLETE:
        unknowns[0] = found.harmonics[0].real
        unknowns[1::2], unknowns[2::2] = found.harmonics[1:].real, -found.harmonics[1:].imag
    return unknowns


def _shorter(motions: np.ndarray, span: RowSpan) -> np.ndarray:
    """Which motions (k, n) repeat after fewer forcing periods than the balance has, (k,) bool."""
    period, scale = span.balance.period, span.problem.scale[:-1]
    return np.logical_or.reduce(
        [
            equal_motions(shifted(motions, periods, period), motions, scale, 1)
            for periods in range(1, period)
            if period % periods == 0
        ]
        or [np.zeros(len(motions), bool)]
    )
