"""Every branch of a row: where continuation starts, and when it has them all.

`ProvenSeeds` starts from the enumeration of all solutions at many values of the swept parameter, so that a branch can
only be missed if it fits between two of them. `LinearSeeds` starts from the linear pair without backlash at both ends,
which is what continuation alone can do. The dead zone is a bounded change of a linear force, so the signs of det J over
all solutions at a point add up to the sign of the linear system's determinant; where they do not, a branch is missing
or lies above the amplitude ceiling.
"""

import dataclasses
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from solver.continuation.continuation import Continuation, Curve, EndReason, Problem
from solver.continuation.correctors import workspace_rows
from solver.continuation.on_curve import curve_crossings
from solver.continuation.problem import Balance
from solver.enumeration.solutions import Proof, RowSolutions, enumerate_row
from solver.model.checks import ParameterError
from solver.model.gear_model import Model

__all__ = [
    "LinearSeeds",
    "ProvenSeeds",
    "RowError",
    "RowSpan",
    "grown_solution",
    "missing_degree",
    "proven_solutions",
    "runs",
]

_PROBES = 97
_PASSES = 4
_SAME = 1e-6
_SEED_STEP = 0.25


class RowError(ArithmeticError):
    """A row could not be computed; the message says why."""


@dataclass(frozen=True)
class RowSpan:
    """What is continued in a row: a model over one axis from `low` to `high`, at `omega` unless that is the axis."""

    balance: Balance
    model: Model
    axis: str
    low: float
    high: float
    omega: float | None
    continuation: Continuation

    @cached_property
    def problem(self) -> Problem:
        """The balance over the axis."""
        return self.balance.problem(self.model, self.axis, self.low, self.high, self.omega)

    def corrected(self, start: np.ndarray, iterations: int = 20) -> np.ndarray | None:
        """The solution y = (u, p) that Newton's method reaches from a start at the same p; None if it reaches none."""
        problem, y = self.problem, np.array(start, dtype=float)
        corrector = self.continuation.corrector
        n = problem.unknowns
        found = corrector.kernel(
            problem.balance,
            problem.theta,
            problem.direction,
            problem.scale,
            y,
            np.eye(n + 1)[n],
            corrector.tolerance,
            iterations,
            np.empty((workspace_rows(n), n + 1)),
        )
        y[n] = start[-1]
        within = np.sqrt(np.sum(y[1:n] ** 2)) <= self.continuation.amplitude_max
        return y if found > 0 and np.all(np.isfinite(y)) and within else None

    def traced(self, start: np.ndarray) -> Curve:
        """The whole branch through a solution y = (u, p), however it ends."""
        if start[-1] in (self.low, self.high):
            heading = 1 if start[-1] == self.low else -1
            return self.continuation.trace(self.problem, start, self.low, self.high, heading)
        return self.continuation.trace_both_ways(self.problem, start, self.low, self.high)

    def whole(self, curve: Curve) -> Curve:
        """The curve itself.

        Raises
        ------
        RowError
            If it ends for want of step size or room.
        """
        for end, place in zip(curve.ends, (0, -1), strict=True):
            if end in (EndReason.STEP_TOO_SMALL, EndReason.ITERATION_LIMIT):
                at = curve.points[place]
                raise RowError(f"{end.sentence} It happened at {self.axis} = {at[-1]:.9g} with mean {at[0]:.6g}.")
        return curve

    def follow(self, start: np.ndarray) -> Curve:
        """Trace the whole branch through a solution y = (u, p); raises RowError as `whole`."""
        curve = self.traced(start)
        if not len(curve.points):
            raise RowError(
                f"No branch can be followed from {self.axis} = {start[-1]:.9g} with mean {start[0]:.6g}: "
                f"{curve.ends[1].sentence}"
            )
        return self.whole(curve)

    def crossings(self, curve: Curve, grid: np.ndarray):
        """`curve_crossings` of one of the row's curves."""
        return curve_crossings(self.problem, curve, grid, self.continuation)


@dataclass(frozen=True)
class ProvenSeeds:
    """Starts from all solutions at evenly spaced values of the swept parameter, both ends included.

    Parameters
    ----------
    columns : int
        How many values.
    every_column : bool
        Whether the row's grid values are enumerated as well.
    """

    columns: int = 197
    every_column: bool = False

    def __post_init__(self):
        if not 2 <= self.columns <= 10**6:
            raise ParameterError("certify_columns", self.columns, "from 2 to 1000000")

    def branches(self, span: RowSpan, grid: np.ndarray) -> tuple[tuple[Curve, ...], int]:
        """All branches through the solutions at the chosen values, and how many of them needed no grid value.

        They come in the order of the evenly spaced values, the ends first, then of the grid values: what every column
        adds stands at the end.
        """
        spaced = np.linspace(span.low, span.high, self.columns)
        probes = np.union1d(spaced, grid) if self.every_column else spaced
        first = np.searchsorted(probes, spaced)
        first = [first[0], first[-1], *first[1:-1]]
        order = [*first, *np.setdiff1d(np.arange(probes.size), first)]
        unknowns = proven_solutions(span, probes)
        wanted = ~np.isnan(unknowns[:, :, 0])
        curves: list[Curve] = []
        early = 0
        for rank, column in enumerate(order):
            for place in np.flatnonzero(wanted[column]):
                if not wanted[column, place]:
                    continue
                curve = span.follow(np.append(unknowns[column, place], probes[column]))
                columns, found, _ = span.crossings(curve, probes)
                gap = np.abs(unknowns[columns] - found[:, None]) / span.problem.scale[:3]
                np.logical_and.at(wanted, columns, np.max(gap, axis=2) > _SAME)
                if wanted[column, place]:
                    raise RowError(
                        f"continuation leaves the solution proven at {span.axis} = {probes[column]:.9g} "
                        f"with mean {unknowns[column, place, 0]:.6g}"
                    )
                curves.append(curve)
                early += rank < self.columns
        return tuple(curves), early


def proven_solutions(span: RowSpan, probes: np.ndarray) -> np.ndarray:
    """First-order solutions (lambda_m, lambda_c, lambda_s) at values of the axis, (X, S, 3), nan beyond their number.

    Raises
    ------
    RowError
        If somewhere the balance leaves the mean open: a continuum of solutions.
    """
    solutions: RowSolutions = enumerate_row(
        span.model, span.axis, probes, omega=span.omega, amplitude_max=span.continuation.amplitude_max
    )
    if np.any(solutions.proof == Proof.CONTINUUM):
        where = probes[solutions.proof == Proof.CONTINUUM]
        raise RowError(f"{Proof.CONTINUUM.sentence} First at {span.axis} = {where[0]:.9g}.")
    return np.stack([solutions.mean, solutions.cos, solutions.sin], axis=2)


@dataclass(frozen=True)
class LinearSeeds:
    """Starts from the linear pair without backlash at both ends of the range, and where the degree does not add up."""

    every_column = False

    def branches(self, span: RowSpan, grid: np.ndarray) -> tuple[tuple[Curve, ...], int]:
        """The branches found, and their number; isolas, whose signs cancel, are not among them."""
        probes = np.linspace(span.low, span.high, _PROBES)
        curves: list[Curve] = []
        seeds = [span.low, span.high]
        for _ in range(_PASSES):
            found = [curve for curve in (self._follow(span, p, curves) for p in seeds) if curve]
            missing = missing_degree(span, probes, [span.crossings(curve, probes) for curve in curves])
            seeds = [probes[(first + last) // 2] for first, last in runs(missing)]
            if not found or not seeds:
                break
        return tuple(curves), len(curves)

    @staticmethod
    def _follow(span: RowSpan, p: float, curves: list[Curve]) -> Curve | None:
        """Trace the branch through the solution that grows out of the linear one at p and add it if it is new."""
        start = grown_solution(span, p)
        if start is None or any(_lies_on(span, curve, start) for curve in curves):
            return None
        curves.append(span.follow(start))
        return curves[-1]


def grown_solution(span: RowSpan, p: float) -> np.ndarray | None:
    """A solution at p, by continuing the backlash from 0; None if that leads above the amplitude ceiling."""
    model, omega = span.model, span.omega
    if span.axis == "omega":
        omega = p
    else:
        model = model.replace(**{span.axis: p})
    problem = span.balance.problem(model, "b", 0.0, model.b or 1.0, omega)
    degree, unknowns = span.balance.linear_solution(problem, 0.0)
    if degree == 0.0:
        return None
    if model.b > 0.0:
        strides = dataclasses.replace(span.continuation, parameter_step=_SEED_STEP)
        curve = strides.trace(problem, np.append(unknowns, 0.0), 0.0, model.b)
        if curve.ends[1] is not EndReason.RANGE_LEFT or curve.points[-1, -1] != model.b:
            return None
        unknowns = curve.points[-1, :-1]
    return np.append(unknowns, p)


def _lies_on(span: RowSpan, curve: Curve, start: np.ndarray) -> bool:
    _, unknowns, _ = span.crossings(curve, start[-1:])
    gap = np.max(np.abs(unknowns - start[:-1]) / span.problem.scale[:-1], axis=1, initial=0.0)
    return bool(np.any(gap < _SAME))


def missing_degree(span: RowSpan, grid: np.ndarray, parts) -> np.ndarray:
    """Whether the signs of det J over the solutions at each grid value fail to add up to the linear system's sign.

    Parameters
    ----------
    span : RowSpan
    grid : (X,) array
    parts : sequence
        What `curve_crossings` found on every curve.

    Returns
    -------
    (X,) bool array
    """
    degree = np.zeros(grid.size, dtype=np.int64)
    for column, _, stable in parts:
        np.add.at(degree, column, 2 * stable.astype(np.int64) - 1)
    return degree != span.balance.degree(span.problem, grid)


def runs(flags: np.ndarray) -> list[tuple[int, int]]:
    """First and last index of every run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return [(int(first), int(last) - 1) for first, last in zip(edges[::2], edges[1::2], strict=True)]
