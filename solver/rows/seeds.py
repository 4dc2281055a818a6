"""Where the branches of a row start, and when it has them all.

At first order `ProvenSeeds` enumerates all solutions at many values of the swept parameter, and traces from every
solution that no branch passes yet. `LinearSeeds` starts from the linear pair without backlash at both ends, which is
what continuation alone can do, and where the degree does not add up. At order H nothing is proven: `LiftedSeeds`
corrects every proven first-order solution at evenly spaced values to order H (none of a system of which nothing can be
proven), and so motions of one harmonic at a few amplitudes and phases; where the degree does not add up, the solution
that grows out of the linear one is added. On a multiple of the forcing period, guesses carry subharmonics as well, and
branches are switched where one crosses.
"""

import dataclasses
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from solver.continuation.on_curve import Crossings
from solver.continuation.solution_curve import Curve
from solver.enumeration.condensed import UnprovableError
from solver.enumeration.solutions import Proof, RowSolutions, enumerate_values
from solver.model.checks import ParameterError, ascending_grid, instance_of, whole_number
from solver.model.contact_system import ContactSystem
from solver.rows.coverage import CorrectedCoverage, Coverage, ProvenCoverage
from solver.rows.degree import grown_solution
from solver.rows.span import RowError, RowSpan, runs

__all__ = ["Branches", "LiftedSeeds", "LinearSeeds", "ProvenSeeds", "Seeds", "proven_solutions", "spread_columns"]

#: Of `LinearSeeds`: values at which the degree is looked at, how often, and when two solutions are one.
_PROBES, _PASSES, _SAME, _PLACES = 97, 4, 1e-6, 9
#: Of guesses at order H: every so many values of the axis, amplitudes in units of lambda's size, and number of phases.
_EVERY, _AMPLITUDES, _PHASES = 14, (0.7, 1.6), 4
#: Amplitudes of the subharmonics that are added to known motions, and the smallest step where such are followed.
_SUBHARMONICS, _SMALLEST_STEP = (0.2, 0.6), 1e-5


@dataclass(frozen=True)
class Branches:
    """What seeds find in a row of X grid values.

    Parameters
    ----------
    curves : tuple of Curve
        In the order in which they were found.
    solutions : RowSolutions, optional
        All solutions at the grid values, where these were enumerated; then also
    on_curve : (X, S) bool array
        Which of them lie on one of the curves, and
    strays : tuple of Crossings
        What each curve passes at the grid values besides them.
    notes : tuple of str
        What could not be done, in sentences.
    by_enumeration : bool
        Whether enumeration was used, and may be asked further.
    """

    curves: tuple[Curve, ...]
    solutions: RowSolutions | None = None
    on_curve: np.ndarray | None = None
    strays: tuple[Crossings, ...] = ()
    notes: tuple[str, ...] = ()
    by_enumeration: bool = False


class Seeds(Protocol):
    """How the branches of a row are found."""

    def branches(self, span: RowSpan, grid: np.ndarray) -> Branches:
        """All branches that are found over the span, which reaches from the first to the last of the grid values."""


@dataclass(frozen=True)
class ProvenSeeds:
    """Starts from all solutions at many values of the swept parameter, proven by enumeration.

    Parameters
    ----------
    columns : int
        Neighbouring values lie no further apart than those of so many evenly spaced ones.
    every_column : bool
        Whether the values are the row's grid values, with others between them where the grid is coarser than `columns`.
        Every grid value is proven then. Otherwise they are `columns` evenly spaced values, both ends included.

    Raises
    ------
    ParameterError
        If `columns` is not a whole number from 2 to 1000000, or `every_column` is neither True nor False.
    """

    columns: int = 197
    every_column: bool = True

    def __post_init__(self):
        whole_number("certify_columns", self.columns, 2, 10**6)
        instance_of("every_column", self.every_column, bool)

    def branches(self, span: RowSpan, grid: np.ndarray) -> Branches:
        """All branches through the solutions at the chosen values: those at both ends first, then ascending.

        Raises
        ------
        ParameterError
            If the balance is not the describing function of first order, or the grid is not allowed.
        RowError
            If somewhere the balance leaves the mean open: a continuum of solutions.
        """
        grid = _checked(span, grid)
        if not span.balance.truncated:
            raise ParameterError("seeds", self, f"LiftedSeeds for {span.balance}, whose solutions nothing proves")
        if self.every_column:
            probes, at = spread_columns(grid, self.columns)
        else:
            probes, at = np.linspace(span.low, span.high, self.columns), np.empty(0, np.int64)
        coverage = ProvenCoverage(span, probes, proven_solutions(span, probes))
        coverage.complete()
        if not self.every_column:
            return Branches(coverage.curves, notes=coverage.notes, by_enumeration=True)
        return Branches(
            coverage.curves,
            coverage.solutions.take(at),
            coverage.on_curve[at],
            tuple(_at_columns(met, at) for met in coverage.met),
            coverage.notes,
            by_enumeration=True,
        )


def _checked(span: RowSpan, grid: np.ndarray) -> np.ndarray:
    """The grid; raises ParameterError where it is not ascending, or what seeds are asked for is no row of one."""
    instance_of("span", span, RowSpan)
    return ascending_grid("grid", grid)


def spread_columns(grid: np.ndarray, columns: int) -> tuple[np.ndarray, np.ndarray]:
    """The grid values and, evenly spread between them, as many others as make their gaps those of `columns` values.

    Parameters
    ----------
    grid : (X,) array
        Ascending.
    columns : int
        So many evenly spaced values have the widest gap allowed.

    Returns
    -------
    values : (P,) array
        Ascending.
    at : (X,) int array
        Where the grid values are among them.
    """
    gaps = np.diff(grid)
    widest = (grid[-1] - grid[0]) / (columns - 1)
    parts = np.ceil(gaps / widest * (1.0 - 1e-9)).astype(np.int64).clip(1)
    at = np.concatenate([[0], np.cumsum(parts)])
    values = np.interp(np.arange(at[-1] + 1), at, grid)
    values[at] = grid
    return values, at


def _at_columns(met: Crossings, at: np.ndarray) -> Crossings:
    """What a curve passes at those of the probes that are grid values."""
    column = np.searchsorted(at, met.column).clip(0, at.size - 1)
    unreached = np.searchsorted(at, met.unreached).clip(0, at.size - 1)
    here, there = at[column] == met.column, at[unreached] == met.unreached
    return Crossings(column[here], met.unknowns[here], met.stable[here], unreached[there], met.on_curve[at])


def proven_solutions(span: RowSpan, probes: np.ndarray) -> RowSolutions:
    """All first-order solutions at values of the axis.

    Raises
    ------
    RowError
        If somewhere the balance leaves the mean open: a continuum of solutions.
    """
    solutions = enumerate_values(span.system, span.axis, probes, span.omega, span.continuation.amplitude_max)
    if np.any(solutions.proof == Proof.CONTINUUM):
        where = probes[solutions.proof == Proof.CONTINUUM]
        raise RowError(f"{Proof.CONTINUUM.sentence} First at {span.axis} = {where[0]:.9g}.")
    return solutions


@dataclass(frozen=True)
class LinearSeeds:
    """Starts from the linear pair without backlash at both ends of the range, and where the degree does not add up.

    Of a contact that is no bounded change of a linear one no degree is known: branches start from what Newton's method
    finds at a few places, and the notes say so.
    """

    def branches(self, span: RowSpan, grid: np.ndarray) -> Branches:
        """The branches found; isolas, whose signs cancel, are not among them.

        Raises
        ------
        ParameterError
            If it is no row, or the grid is not ascending.
        """
        _checked(span, grid)
        coverage, starts = Coverage(span, np.linspace(span.low, span.high, _PROBES)), [span.low, span.high]
        if isinstance(span.system, ContactSystem) and not span.system.bounded_change:
            return self._guessed(span)
        for _ in range(_PASSES):
            before = len(coverage.branches)
            for p in starts:
                curve = self._new_curve(span, p, coverage.curves)
                if curve is not None:
                    coverage.branches.append((curve, span.crossings(curve, coverage.probes)))
            starts = [coverage.probes[(first + last) // 2] for first, last in runs(coverage.missing())]
            if len(coverage.branches) == before or not starts:
                break
        return Branches(coverage.curves)

    @staticmethod
    def _guessed(span: RowSpan) -> Branches:
        """Branches through what guesses of the mean and one harmonic lead to at a few places of the row."""
        curves: tuple[Curve, ...] = ()
        guesses = _single_harmonics(span)
        for p in np.linspace(span.low, span.high, _PLACES):
            found = span.corrected(np.column_stack([guesses, np.full(len(guesses), p)]))
            for start in found[np.all(np.isfinite(found), axis=1)]:
                if not any(_lies_on(span, curve, start) for curve in curves):
                    curve = span.traced(start)
                    curves += (curve,) if len(curve.points) > 1 else ()
        note = f"Nothing tells whether other branches than those met at {_PLACES} values of {span.axis} are missing."
        return Branches(curves, notes=(note,))

    @staticmethod
    def _new_curve(span: RowSpan, p: float, curves: tuple[Curve, ...]) -> Curve | None:
        """The branch through the solution that grows out of the linear one at p, if it is a new one."""
        start = grown_solution(span, p)
        if start is None or any(_lies_on(span, curve, start) for curve in curves):
            return None
        curve = span.traced(start)
        return curve if len(curve.points) > 1 else None


def _lies_on(span: RowSpan, curve: Curve, start: np.ndarray) -> bool:
    unknowns = span.crossings(curve, start[-1:]).unknowns
    gap = np.max(np.abs(unknowns - start[:-1]) / span.problem.scale[:-1], axis=1, initial=0.0)
    return bool(np.any(gap < _SAME))


@dataclass(frozen=True)
class LiftedSeeds:
    """Starts for a balance of order H, `solver.harmonic.galerkin.Galerkin`: see the module.

    Parameters
    ----------
    columns : int
        Number of evenly spaced values, both ends included.

    Raises
    ------
    ParameterError
        If `columns` is not a whole number from 2 to 1000000.
    """

    columns: int = 197

    def __post_init__(self):
        whole_number("certify_columns", self.columns, 2, 10**6)

    def branches(self, span: RowSpan, grid: np.ndarray) -> Branches:
        """All branches found over the span.

        Raises
        ------
        ParameterError
            If the balance is the describing function, or the grid is not ascending.
        """
        _checked(span, grid)
        if span.balance.truncated:
            raise ParameterError("seeds", self, f"ProvenSeeds or LinearSeeds for {span.balance}")
        probes = np.linspace(span.low, span.high, self.columns)
        order = [0, self.columns - 1, *range(1, self.columns - 1)]
        if span.balance.period > 1:
            # Where subharmonics vanish the curve is singular: no use in creeping up to it.
            settings = dataclasses.replace(
                span.continuation, smallest_step=max(span.continuation.smallest_step, _SMALLEST_STEP)
            )
            span = dataclasses.replace(span, continuation=settings)
        coverage = CorrectedCoverage(span, probes)
        try:
            motions = proven_solutions(span, probes).motions
        except UnprovableError:
            motions = np.full((probes.size, 1, 3), np.nan)
        lifted = span.balance.lifted(motions)
        single = _single_harmonics(span)
        columns, starts = [], []
        for rank, column in enumerate(order):
            here = lifted[column][~np.isnan(lifted[column, :, 0])]
            for some in (here, single) if rank % _EVERY == 0 else (here,):
                columns += [column] * len(some)
                starts.append(some)
        coverage.add(np.array(columns), np.concatenate(starts))
        if span.balance.period > 1:
            for column in order[::_EVERY]:
                starts = _with_subharmonics(span, coverage.motions(column))
                coverage.add(np.full(len(starts), column), starts)
        for first_missing, last_missing in runs(coverage.missing()):
            column = (first_missing + last_missing) // 2
            start = grown_solution(span, float(probes[column]))
            if start is not None:
                coverage.add(np.array([column]), start[None, :-1])
        return Branches(coverage.curves, notes=coverage.notes)


def _single_harmonics(span: RowSpan) -> np.ndarray:
    """Guesses of the mean and one harmonic, (k, n)."""
    size, phases = span.problem.scale[0], 2.0 * np.pi * np.arange(_PHASES) / _PHASES
    starts = np.zeros((len(_AMPLITUDES), _PHASES, span.problem.unknowns))
    starts[:, :, 0] = 0.5 * size
    circle = np.column_stack([np.cos(phases), np.sin(phases)])
    starts[:, :, list(span.balance.fundamental)] = size * np.multiply.outer(_AMPLITUDES, circle)
    return starts.reshape(-1, span.problem.unknowns)


def _with_subharmonics(span: RowSpan, known: np.ndarray) -> np.ndarray:
    """Motions (m, n) with every one of their subharmonics, at a few sizes and phases, added: (k, n)."""
    period, size = span.balance.period, span.problem.scale[0]
    # Half a turn of the subharmonic is a motion one forcing period later.
    phases = 2.0 * np.pi * np.arange(_PHASES) / _PHASES / period
    added = [
        (k, amplitude * size * np.array([np.cos(phase), np.sin(phase)]))
        for k in range(1, period)
        for amplitude in _SUBHARMONICS
        for phase in phases
    ]
    starts = np.repeat(known[:, None], len(added), axis=1)
    for i, (k, pair) in enumerate(added):
        starts[:, i, 2 * k - 1 : 2 * k + 1] += pair
    return starts.reshape(-1, span.problem.unknowns)
