"""Where the branches of a first-order row start, and when it has them all.

`ProvenSeeds` enumerates all solutions at many values of the swept parameter, and traces from every solution that no
branch passes yet. `LinearSeeds` starts from the linear pair without backlash at both ends, which is what continuation
alone can do. The dead zone is a bounded change of a linear force, so the signs of det J over all solutions at a point
add up to the sign of the linear system's determinant; where they do not, a branch is missing or lies above the
amplitude ceiling. What order H does is in `solver.rows.lifted_seeds`.
"""

import dataclasses
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from solver.continuation.continuation import Curve, EndReason
from solver.enumeration.solutions import Proof, RowSolutions, enumerate_values
from solver.model.checks import ParameterError, ascending_grid, instance_of, whole_number
from solver.rows.crossings import Crossings, Known, crossings
from solver.rows.span import RowError, RowSpan, ends_notes, runs

__all__ = [
    "Branches",
    "LinearSeeds",
    "ProvenSeeds",
    "Seeds",
    "grown_solution",
    "missing_degree",
    "proven_solutions",
    "spread_columns",
]

_PROBES = 97
_PASSES = 4
_SAME = 1e-6
_SEED_STEP = 0.25
# Points and refused steps after which a row stops tracing what is missing: a second or two.
_MOST_STEPS = 200_000


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
            probes, place = spread_columns(grid, self.columns)
        else:
            probes, place = np.linspace(span.low, span.high, self.columns), np.empty(0, np.int64)
        coverage = _Coverage(span, probes, proven_solutions(span, probes))
        coverage.complete()
        if not self.every_column:
            return Branches(coverage.curves, notes=coverage.notes, by_enumeration=True)
        return Branches(
            coverage.curves,
            coverage.solutions.take(place),
            coverage.on_curve[place],
            tuple(_at_columns(met, place) for met in coverage.met),
            coverage.notes,
            by_enumeration=True,
        )


def _checked(span: RowSpan, grid: np.ndarray) -> np.ndarray:
    """The grid; raises ParameterError where it is not ascending, or what seeds are asked for is no row of one."""
    instance_of("span", span, RowSpan)
    return ascending_grid("grid", grid, 2)


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
    place : (X,) int array
        Where the grid values are among them.
    """
    gaps = np.diff(grid)
    widest = (grid[-1] - grid[0]) / (columns - 1)
    parts = np.ceil(gaps / widest * (1.0 - 1e-9)).astype(np.int64).clip(1)
    place = np.concatenate([[0], np.cumsum(parts)])
    values = np.interp(np.arange(place[-1] + 1), place, grid)
    values[place] = grid
    return values, place


class _Coverage:
    """Which proven solutions the branches found so far pass through.

    Attributes
    ----------
    solutions : RowSolutions
    on_curve : (P, S) bool array
    curves : tuple of Curve
    met : tuple of Crossings
        Where each of them meets the probes.
    notes : tuple of str
    """

    def __init__(self, span: RowSpan, probes: np.ndarray, solutions: RowSolutions):
        self._span, self._probes = span, probes
        self.solutions = solutions
        self._known = Known(solutions.motions, solutions.stable, (solutions.proof == Proof.PROVEN).astype(np.int8))
        self._found: list[tuple[Curve, Crossings]] = []
        self._lost: list[np.ndarray] = []
        self._given_up = False

    @property
    def curves(self) -> tuple[Curve, ...]:
        return tuple(curve for curve, _ in self._found)

    @property
    def met(self) -> tuple[Crossings, ...]:
        return tuple(met for _, met in self._found)

    @property
    def on_curve(self) -> np.ndarray:
        return np.logical_or.reduce([met.on_curve for met in self.met], initial=False, axis=0) | np.zeros(
            self.solutions.stable.shape, bool
        )

    @property
    def notes(self) -> tuple[str, ...]:
        sentences = ends_notes(self._span, self.curves)
        if self._lost:
            more = f" and {len(self._lost) - 1} more solutions" if len(self._lost) > 1 else ""
            sentences.append(f"No branch can be followed from {self._span.place(self._lost[0])}{more}.")
        if self._given_up:
            sentences.append(f"Tracing was given up after {_MOST_STEPS} steps.")
        return tuple(sentences)

    def complete(self) -> None:
        """Trace branches until one passes through every solution, or nothing more can be traced."""
        missing, steps = self.solutions.stable >= 0, 0
        while True:
            columns = np.flatnonzero(np.any(missing, axis=1))
            if not columns.size:
                return
            if steps > _MOST_STEPS:
                self._given_up = True
                return
            # The ends first.
            column = columns[-1] if columns[-1] == missing.shape[0] - 1 and columns[0] != 0 else columns[0]
            place = int(np.argmax(missing[column]))
            missing[column, place] = False
            curve, met = self._trace(int(column), place)
            steps += len(curve.points) + curve.refused
            missing &= ~met.on_curve

    def _trace(self, column: int, place: int) -> tuple[Curve, Crossings]:
        """Follow the branch through one solution and keep it, unless it is a part of one that is known."""
        y = np.append(self.solutions.motions[column, place], self._probes[column])
        curve = self._span.traced(y)
        met = crossings(self._span, curve, self._probes, self._known)
        if len(curve.points) < 2:
            self._lost.append(y)
            return curve, met
        met.on_curve[column, place] = True
        # Regular points lie on one branch. Curves share solutions where a corrector failed or steps became too small,
        # which hid a part of one, or where a step jumped over a needle and joined two: then the others hold all of it.
        for _, other in self._found:
            shared = met.on_curve & other.on_curve
            if np.any(shared) and np.sum(met.on_curve) - np.sum(shared) <= 1:
                other.on_curve[column, place] = True
                return curve, met
        kept = [*self._found, (curve, met)]
        for old in self._found:
            if np.any(met.on_curve & old[1].on_curve):
                rest = np.logical_or.reduce([other.on_curve for _, other in kept if other is not old[1]])
                if not np.any(old[1].on_curve & ~rest):
                    kept = [pair for pair in kept if pair[1] is not old[1]]
        self._found = kept
        return curve, met


def _at_columns(met: Crossings, place: np.ndarray) -> Crossings:
    """What a curve passes at those of the probes that are grid values."""
    column = np.searchsorted(place, met.column).clip(0, place.size - 1)
    unreached = np.searchsorted(place, met.unreached).clip(0, place.size - 1)
    here, there = place[column] == met.column, place[unreached] == met.unreached
    return Crossings(column[here], met.unknowns[here], met.stable[here], unreached[there], met.on_curve[place])


def proven_solutions(span: RowSpan, probes: np.ndarray) -> RowSolutions:
    """All first-order solutions at values of the axis.

    Raises
    ------
    RowError
        If somewhere the balance leaves the mean open: a continuum of solutions.
    """
    solutions = enumerate_values(*span.first_order_vectors, probes, span.continuation.amplitude_max)
    if np.any(solutions.proof == Proof.CONTINUUM):
        where = probes[solutions.proof == Proof.CONTINUUM]
        raise RowError(f"{Proof.CONTINUUM.sentence} First at {span.axis} = {where[0]:.9g}.")
    return solutions


@dataclass(frozen=True)
class LinearSeeds:
    """Starts from the linear pair without backlash at both ends of the range, and where the degree does not add up."""

    def branches(self, span: RowSpan, grid: np.ndarray) -> Branches:
        """The branches found; isolas, whose signs cancel, are not among them.

        Raises
        ------
        ParameterError
            If it is no row, or the grid is not ascending.
        """
        _checked(span, grid)
        probes = np.linspace(span.low, span.high, _PROBES)
        curves: list[Curve] = []
        met: list[Crossings] = []
        places = [span.low, span.high]
        for _ in range(_PASSES):
            before = len(curves)
            for p in places:
                curve = self._new_curve(span, p, curves)
                if curve is not None:
                    curves.append(curve)
                    met.append(crossings(span, curve, probes))
            missing = missing_degree(span, probes, met)
            places = [probes[(first + last) // 2] for first, last in runs(missing)]
            if len(curves) == before or not places:
                break
        return Branches(tuple(curves))

    @staticmethod
    def _new_curve(span: RowSpan, p: float, curves: list[Curve]) -> Curve | None:
        """The branch through the solution that grows out of the linear one at p, if it is a new one."""
        start = grown_solution(span, p)
        if start is None or any(_lies_on(span, curve, start) for curve in curves):
            return None
        curve = span.traced(start)
        return curve if len(curve.points) > 1 else None


def grown_solution(span: RowSpan, p: float) -> np.ndarray | None:
    """A solution at p, by continuing the backlash from 0; None if that leads above the amplitude ceiling."""
    model, omega = span.model, span.omega
    if span.axis == "omega":
        omega = p
    else:
        model = model.replace(**{span.axis: p})
    problem = span.balance.problem(model, "b", 0.0, model.b or 1.0, omega)
    degree, unknowns = span.balance.linear_solution(problem, 0.0)
    if degree == 0.0 or not np.all(np.isfinite(unknowns)):
        return None
    if model.b > 0.0:
        strides = dataclasses.replace(span.continuation, parameter_step=_SEED_STEP)
        curve = strides.trace(problem, np.append(unknowns, 0.0), 0.0, model.b)
        if curve.ends[1] is not EndReason.RANGE_LEFT or curve.points[-1, -1] != model.b:
            return None
        unknowns = curve.points[-1, :-1]
    return np.append(unknowns, p)


def _lies_on(span: RowSpan, curve: Curve, start: np.ndarray) -> bool:
    unknowns = crossings(span, curve, start[-1:]).unknowns
    gap = np.max(np.abs(unknowns - start[:-1]) / span.problem.scale[:-1], axis=1, initial=0.0)
    return bool(np.any(gap < _SAME))


def missing_degree(span: RowSpan, grid: np.ndarray, met) -> np.ndarray:
    """Whether the signs of det J over the solutions at each grid value fail to add up to the linear system's sign.

    Parameters
    ----------
    span : RowSpan
    grid : (X,) array
    met : sequence of Crossings
        What every curve passes there.

    Returns
    -------
    (X,) bool array
    """
    degree = np.zeros(grid.size, dtype=np.int64)
    for crossing in met:
        np.add.at(degree, crossing.column, 2 * crossing.stable.astype(np.int64) - 1)
    return degree != span.balance.degree(span.problem, grid)
