"""One row of a plane: every branch that continuation reaches, and the solutions at the row's grid values.

Seeds come from both ends of the swept range, each found by continuing the backlash from 0, where the balance is linear,
to its value. The dead zone is a bounded change of a linear force, so the signs of det J over all solutions at a point
add up to the sign of the linear system's determinant; where the branches found so far do not, one is missing, and
another seed is sought there. What still does not add up lies above the amplitude ceiling and is marked open.
"""

import dataclasses
from dataclasses import dataclass

import numpy as np

from solver.condensation import axis_vectors
from solver.continuation import Continuation, Curve, EndReason, Problem
from solver.crossings import curve_crossings
from solver.errors import ParameterError
from solver.harmonic.first_order import first_order_problem, linear_degree, linear_solution
from solver.impact import domain_code, impact_state
from solver.model import Model

__all__ = ["Row", "RowError", "sweep_row"]

_PROBES = 97
_PASSES = 4
_SAME = 1e-6
_SEED_STEP = 0.25


class RowError(ArithmeticError):
    """A row could not be computed; the message says why."""


@dataclass(frozen=True)
class Row:
    """Branches and raster of one row. X is the number of grid values, S the largest number of solutions at one.

    Parameters
    ----------
    axis, grid : str, (X,) array
        The swept parameter and its grid values.
    b : (X,) array
        Half backlash at the grid values.
    curves : tuple of Curve
        Every branch, in the order in which they were found.
    mean, cos, sin : (X, S) arrays
        lambda_m, lambda_c, lambda_s of all solutions, sorted by amplitude; nan beyond their number.
    stable, impact : (X, S) int8 arrays
        Static stability and `ImpactState`; -1 beyond the number of solutions.
    open : (X,) int8 array
        1 where solutions above the amplitude ceiling exist or are not excluded.
    """

    axis: str
    grid: np.ndarray
    b: np.ndarray
    curves: tuple[Curve, ...]
    mean: np.ndarray
    cos: np.ndarray
    sin: np.ndarray
    stable: np.ndarray
    impact: np.ndarray
    open: np.ndarray

    @property
    def amplitude(self) -> np.ndarray:
        """lambda_a, (X, S)."""
        return np.hypot(self.cos, self.sin)

    def branch_impact(self, curve: Curve) -> np.ndarray:
        """`ImpactState` at the points of one of the curves, int8."""
        b = curve.points[:, 3] if self.axis == "b" else self.b[0]
        return impact_state(curve.points[:, 0] - curve.amplitude, curve.points[:, 0] + curve.amplitude, b)

    @property
    def phase(self) -> np.ndarray:
        """Phase of Lambda_1 = lambda_c - i lambda_s in (-pi, pi], (X, S)."""
        return np.arctan2(-self.sin, self.cos)

    @property
    def n_solutions(self) -> np.ndarray:
        """Number of solutions, (X,)."""
        return np.sum(self.stable >= 0, axis=1)

    @property
    def n_stable(self) -> np.ndarray:
        """Number of statically stable solutions, the n of n/I, (X,)."""
        return np.sum(self.stable == 1, axis=1)

    @property
    def domain(self) -> np.ndarray:
        """Code of the n/I label, (X,) uint16."""
        bits = np.where(self.stable == 1, 1 << self.impact.astype(np.int64).clip(0), 0)
        return domain_code(self.n_stable, np.bitwise_or.reduce(bits, axis=1, initial=0))


def sweep_row(
    model: Model,
    axis: str,
    grid,
    *,
    omega: float | None = None,
    continuation: Continuation | None = None,
) -> Row:
    """Continue all branches over one axis and solve at the grid values.

    Parameters
    ----------
    model : Model
    axis : str
        "omega" or a scalar parameter of the gear; the model's own value of it is not used.
    grid : (X,) array_like
        Ascending values of the axis, at least two; the branches are traced between the first and the last.
    omega : float, optional
        The frequency, > 0; needed unless it is the axis.
    continuation : Continuation, optional

    Returns
    -------
    Row

    Raises
    ------
    ParameterError
        If the grid or the frequency is not allowed.
    RowError
        If a branch ends for want of step size or room, or a grid value cannot be solved.
    """
    grid = np.array(grid, dtype=float)
    continuation = continuation or Continuation()
    if grid.ndim != 1 or grid.size < 2 or not np.all(np.isfinite(grid)) or not np.all(np.diff(grid) > 0.0):
        raise ParameterError("grid", f"array of shape {grid.shape}", "at least two finite ascending values")
    frequency = grid[0] if axis == "omega" else omega
    if frequency is None or not 0.0 < frequency < np.inf:
        raise ParameterError("omega", frequency, "a finite number above 0")
    low, high = float(grid[0]), float(grid[-1])
    curves = _Search(model, axis, low, high, omega, continuation).run()
    problem = first_order_problem(model, axis, low, high, omega)
    b = grid if axis == "b" else np.full(grid.size, model.b)
    return _assemble(problem, axis, grid, b, curves, continuation)


class _Search:
    """Finds the branches of one row, one seed after the other."""

    def __init__(self, model, axis, low, high, omega, continuation):
        self.model, self.axis, self.low, self.high, self.omega = model, axis, low, high, omega
        self.continuation = continuation
        self.problem = first_order_problem(model, axis, low, high, omega)
        self.curves: list[Curve] = []

    def run(self) -> tuple[Curve, ...]:
        self._follow(self.low)
        self._follow(self.high)
        probes = np.linspace(self.low, self.high, _PROBES)
        for _ in range(_PASSES):
            parts = [curve_crossings(self.problem, curve, probes, self.continuation) for curve in self.curves]
            missing = _missing(self.problem, probes, parts)
            found = [self._follow(probes[(first + last) // 2]) for first, last in _runs(missing)]
            if not any(found):
                break
        return tuple(self.curves)

    def _follow(self, p: float) -> bool:
        """Trace the branch through the solution that grows out of the linear one at p; whether it is a new one."""
        start = self._seed(p)
        if start is None or any(self._lies_on(curve, start) for curve in self.curves):
            return False
        if p in (self.low, self.high):
            curve = self.continuation.trace(self.problem, start, self.low, self.high, 1 if p == self.low else -1)
        else:
            curve = self.continuation.trace_both_ways(self.problem, start, self.low, self.high)
        for end, place in zip(curve.ends, (0, -1), strict=True):
            if end in (EndReason.STEP_TOO_SMALL, EndReason.ITERATION_LIMIT):
                at = curve.points[place] if len(curve.points) else start
                raise RowError(f"{end.sentence} It happened at {self.axis} = {at[-1]:.9g} with mean {at[0]:.6g}.")
        self.curves.append(curve)
        return True

    def _seed(self, p: float) -> np.ndarray | None:
        """A solution at p, by continuing the backlash from 0; None if that leads above the amplitude ceiling."""
        if self.axis == "omega":
            model, omega, b = self.model, p, self.model.b
        elif self.axis == "b":
            model, omega, b = self.model, self.omega, p
        else:
            model, omega, b = self.model.replace(**{self.axis: p}), self.omega, self.model.b
        theta, direction = axis_vectors(model, "b", omega)
        unknowns = np.empty(3)
        if linear_solution(theta, direction, 0.0, unknowns) == 0.0:
            return None
        if b > 0.0:
            problem = first_order_problem(model, "b", 0.0, b, omega)
            strides = dataclasses.replace(self.continuation, parameter_step=_SEED_STEP)
            curve = strides.trace(problem, np.append(unknowns, 0.0), 0.0, b)
            if curve.ends[1] is not EndReason.RANGE_LEFT or curve.points[-1, 3] != b:
                return None
            unknowns = curve.points[-1, :3]
        return np.append(unknowns, p)

    def _lies_on(self, curve: Curve, start: np.ndarray) -> bool:
        _, unknowns, _ = curve_crossings(self.problem, curve, start[3:], self.continuation)
        distances = np.abs(unknowns - start[:3]) / self.problem.scale[:3]
        return bool(np.any(np.max(distances, axis=1) < _SAME)) if len(distances) else False


def _missing(problem: Problem, grid: np.ndarray, parts) -> np.ndarray:
    """Whether the signs of det J over the solutions at each grid value fail to add up to the linear system's sign.

    `parts` holds what `curve_crossings` found on every curve.
    """
    degree = np.zeros(grid.size, dtype=np.int64)
    for column, _, stable in parts:
        np.add.at(degree, column, 2 * stable.astype(np.int64) - 1)
    signs = np.empty(grid.size)
    linear_degree(problem.theta, problem.direction, grid, signs)
    return degree != signs


def _runs(flags: np.ndarray) -> list[tuple[int, int]]:
    """First and last index of every run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return [(int(first), int(last) - 1) for first, last in zip(edges[::2], edges[1::2], strict=True)]


def _assemble(problem: Problem, axis: str, grid, b, curves, continuation) -> Row:
    """Solve at the grid values and sort the solutions of each by amplitude."""
    try:
        parts = [curve_crossings(problem, curve, grid, continuation) for curve in curves]
    except ArithmeticError as error:
        raise RowError(str(error)) from error
    missing = _missing(problem, grid, parts)
    column = np.concatenate([part[0] for part in parts]) if parts else np.empty(0, np.int64)
    unknowns = np.concatenate([part[1] for part in parts]) if parts else np.empty((0, 3))
    stable = np.concatenate([part[2] for part in parts]) if parts else np.empty(0, np.int8)
    amplitude = np.hypot(unknowns[:, 1], unknowns[:, 2])
    order = np.lexsort((unknowns[:, 0], amplitude, column))
    column, unknowns, stable = column[order], unknowns[order], stable[order]
    counts = np.bincount(column, minlength=grid.size)
    place = np.arange(column.size) - np.repeat(np.cumsum(counts) - counts, counts)
    shape = (grid.size, max(int(counts.max(initial=0)), 1))
    values = np.full((3, *shape), np.nan)
    values[:, column, place] = unknowns.T
    stabilities = np.full(shape, -1, dtype=np.int8)
    stabilities[column, place] = stable
    size = np.hypot(values[1], values[2])
    impact = impact_state(values[0] - size, values[0] + size, b[:, None])
    return Row(
        axis, grid, b, tuple(curves), *values, stabilities, impact, _open(grid, curves, missing).astype(np.int8)
    )


def _open(grid: np.ndarray, curves, missing: np.ndarray) -> np.ndarray:
    """Grid values at which solutions above the ceiling exist, or lie between places where branches left through it."""
    flags = missing.copy()
    exits = [
        curve.points[place, -1]
        for curve in curves
        for end, place in zip(curve.ends, (0, -1), strict=True)
        if end is EndReason.AMPLITUDE_CEILING
    ]
    if exits:
        first = max(np.searchsorted(grid, min(exits), side="right") - 1, 0)
        last = min(np.searchsorted(grid, max(exits), side="left"), grid.size - 1)
        flags[first : last + 1] = True
    return flags
