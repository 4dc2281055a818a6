"""One row of a plane: its branches, the solutions at the row's grid values, and whether these are proven to be all."""

import dataclasses
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from solver.contact.impact import domain_code, impact_state
from solver.continuation.continuation import Continuation, Curve, EndReason, Event
from solver.continuation.on_curve import curve_crossings
from solver.continuation.problem import Balance
from solver.enumeration.solutions import Above, Proof, RowSolutions, enumerate_row
from solver.harmonic.describing_function import DescribingFunction
from solver.model.checks import ParameterError
from solver.model.condensation import axis_vectors
from solver.model.gear_model import Model
from solver.rows.seeds import ProvenSeeds, RowError, RowSpan, missing_degree
from solver.stability import assess
from solver.stability.bifurcations import with_bifurcations

__all__ = ["Row", "sweep_row"]

# Continuation and enumeration know a solution to about 1e-12 of its scale, except next to a fold.
_AGREE = 1e-6


@dataclass(frozen=True)
class Row:
    """Branches and raster of one row. X is the number of grid values, S the largest number of solutions at one.

    Parameters
    ----------
    balance : Balance
        Of which the motions are solutions, with n unknowns.
    axis, grid : str, (X,) array
        The swept parameter and its grid values.
    b : (X,) array
        Half backlash at the grid values.
    curves : tuple of Curve
        Every branch, in the order in which they were found.
    motions : (X, S, n) array
        Unknowns (Lambda_0, c_1, s_1, ...) of all solutions, sorted by amplitude; nan beyond their number.
    stable, impact : (X, S) int8 arrays
        Static stability and `ImpactState`; -1 beyond the number of solutions.
    instability : (X, S) int8 array
        Dynamic stability, `solver.stability.Instability`; -1 beyond the number of solutions.
    multiplier : (X, S) array
        Largest modulus of the multipliers; nan beyond the number of solutions.
    open : (X,) int8 array
        1 where solutions above the amplitude ceiling exist or are not excluded, and on both sides of a place where a
        branch left through it.
    certified : (X,) int8 array
        1 where the solutions are proven to be all of them, 0 where that is undecided, -1 where it was not asked.
    early : int
        How many of the curves were found without looking at the grid values.
    everywhere : bool
        Whether seeds were sought at the grid values as well.
    """

    balance: Balance
    axis: str
    grid: np.ndarray
    b: np.ndarray
    curves: tuple[Curve, ...]
    motions: np.ndarray
    stable: np.ndarray
    impact: np.ndarray
    instability: np.ndarray
    multiplier: np.ndarray
    open: np.ndarray
    certified: np.ndarray
    early: int
    everywhere: bool

    @property
    def n_folds(self) -> int:
        """Folds on the curves that were found without looking at the grid values."""
        return sum(int(np.sum(curve.event == Event.FOLD)) for curve in self.curves[: self.early])

    @property
    def n_gained(self) -> int:
        """Curves that only the grid values brought; -1 where they were not looked at."""
        return len(self.curves) - self.early if self.everywhere else -1

    @property
    def mean(self) -> np.ndarray:
        """lambda_m, (X, S)."""
        return self.motions[:, :, 0]

    @property
    def cos(self) -> np.ndarray:
        """lambda_c, the cosine amplitude of the mesh frequency, (X, S)."""
        return self.motions[:, :, self.balance.fundamental[0]]

    @property
    def sin(self) -> np.ndarray:
        """lambda_s, the sine amplitude of the mesh frequency, (X, S)."""
        return self.motions[:, :, self.balance.fundamental[1]]

    @property
    def amplitude(self) -> np.ndarray:
        """lambda_a of the mesh frequency, (X, S)."""
        return np.hypot(self.cos, self.sin)

    @cached_property
    def extremes(self) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest lambda over the period, two (X, S) arrays."""
        return self.balance.extremes(self.motions)

    def branch_motions(self, curve: Curve) -> np.ndarray:
        """lambda_m, lambda_c and lambda_s at the points of one of the curves, (3, points)."""
        return curve.points[:, [0, *self.balance.fundamental]].T

    def branch_impact(self, curve: Curve) -> np.ndarray:
        """`ImpactState` at the points of one of the curves, int8."""
        b = curve.points[:, -1] if self.axis == "b" else self.b[0]
        return impact_state(*self.balance.extremes(curve.points[:, :-1]), b)

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
    seeds=None,
    balance: Balance | None = None,
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
    seeds : ProvenSeeds, LinearSeeds or solver.rows.lifted_seeds.LiftedSeeds, optional
        How branches are found; `ProvenSeeds` unless given. With `ProvenSeeds(every_column=True)` the solutions at every
        grid value are compared with their enumeration. `LiftedSeeds` are for the Galerkin balance.
    balance : Balance, optional
        The describing function of first order unless given.

    Returns
    -------
    Row

    Raises
    ------
    ParameterError
        If the grid or the frequency is not allowed.
    RowError
        If a branch ends for want of step size or room, a grid value cannot be solved, or continuation does not find
        what enumeration proves to exist.
    """
    grid = np.array(grid, dtype=float)
    continuation = continuation or Continuation()
    if grid.ndim != 1 or grid.size < 2 or not np.all(np.isfinite(grid)) or not np.all(np.diff(grid) > 0.0):
        raise ParameterError("grid", f"array of shape {grid.shape}", "at least two finite ascending values")
    frequency = grid[0] if axis == "omega" else omega
    if frequency is None or not 0.0 < frequency < np.inf:
        raise ParameterError("omega", frequency, "a finite number above 0")
    axis_vectors(model, axis, omega)
    if axis != "omega":
        for value in (grid[0], grid[-1]):
            model.replace(**{axis: float(value)})
    balance = balance or DescribingFunction()
    span = RowSpan(balance, model, axis, float(grid[0]), float(grid[-1]), omega, continuation)
    seeds = seeds or ProvenSeeds()
    curves, early = seeds.branches(span, grid)
    curves = tuple(_with_bifurcations(span, curve) for curve in curves)
    b = grid if axis == "b" else np.full(grid.size, model.b)
    row = _assemble(span, grid, b, curves, early, seeds.every_column)
    if not isinstance(seeds, ProvenSeeds):
        return row
    # Enumeration knows what lies above the ceiling; it is asked where branches left, or everywhere.
    asked = np.full(grid.size, seeds.every_column) | (row.open == 1)
    solutions = enumerate_row(model, axis, grid[asked], omega=omega, amplitude_max=continuation.amplitude_max)
    row.open[asked] = solutions.above != Above.EMPTY
    row.open[_beside(grid, _exits(curves))] = 1
    return _certify(row, solutions, float(span.problem.scale[0])) if seeds.every_column else row


def _with_bifurcations(span: RowSpan, curve: Curve) -> Curve:
    """The curve with the points at which dynamic stability changes."""
    try:
        return with_bifurcations(span.balance, span.problem, curve, span.continuation)
    except ArithmeticError as error:
        raise RowError(str(error)) from error


def _assemble(span: RowSpan, grid, b, curves, early: int, everywhere: bool) -> Row:
    """Solve at the grid values and sort the solutions of each by amplitude."""
    try:
        parts = [curve_crossings(span.problem, curve, grid, span.continuation) for curve in curves]
    except ArithmeticError as error:
        raise RowError(str(error)) from error
    missing = missing_degree(span, grid, parts)
    n = span.problem.unknowns
    column = np.concatenate([part[0] for part in parts]) if parts else np.empty(0, np.int64)
    unknowns = np.concatenate([part[1] for part in parts]) if parts else np.empty((0, n))
    stable = np.concatenate([part[2] for part in parts]) if parts else np.empty(0, np.int8)
    amplitude = np.linalg.norm(unknowns[:, list(span.balance.fundamental)], axis=1)
    order = np.lexsort((unknowns[:, 0], amplitude, column))
    column, unknowns, stable = column[order], unknowns[order], stable[order]
    counts = np.bincount(column, minlength=grid.size)
    place = np.arange(column.size) - np.repeat(np.cumsum(counts) - counts, counts)
    shape = (grid.size, max(int(counts.max(initial=0)), 1))
    motions = np.full((*shape, n), np.nan)
    motions[column, place] = unknowns
    stabilities = np.full(shape, -1, dtype=np.int8)
    stabilities[column, place] = stable
    impact = impact_state(*span.balance.extremes(motions), b[:, None])
    stability = assess(
        span.model, span.axis, grid[column], unknowns, omega=span.omega, balance=span.balance, static=stable
    )
    instability, multiplier = np.full(shape, -1, dtype=np.int8), np.full(shape, np.nan)
    instability[column, place], multiplier[column, place] = stability.kind, stability.modulus
    return Row(
        span.balance,
        span.axis,
        grid,
        b,
        tuple(curves),
        motions,
        stabilities,
        impact,
        instability,
        multiplier,
        _open(grid, curves, missing).astype(np.int8),
        np.full(grid.size, -1, dtype=np.int8),
        early,
        everywhere,
    )


def _certify(row: Row, solutions: RowSolutions, scale: float) -> Row:
    """Compare every column with its enumeration.

    Raises
    ------
    RowError
        If a proven solution is not among the continued ones, or the other way round where the count is proven.
    """
    proven = solutions.proof == Proof.PROVEN
    theirs = np.stack([solutions.mean, solutions.cos, solutions.sin], axis=2)
    gap = np.max(np.abs(theirs[:, :, None] - row.motions[:, None]), axis=3) / scale
    near = np.nan_to_num(gap, nan=np.inf) <= _AGREE
    unmatched = np.any(~np.any(near, axis=2) & ~np.isnan(solutions.mean), axis=1)
    wrong = unmatched | (proven & (solutions.n_solutions != row.n_solutions))
    wrong |= proven & (np.sum(solutions.stable == 1, axis=1) != row.n_stable)
    if np.any(solutions.proof == Proof.CONTRADICTION):
        raise RowError(Proof.CONTRADICTION.sentence)
    if np.any(wrong):
        column = int(np.flatnonzero(wrong)[0])
        raise RowError(
            f"enumeration and continuation disagree at {np.sum(wrong)} columns, first at {row.axis} = "
            f"{row.grid[column]:.9g}: {solutions.n_solutions[column]} solutions against {row.n_solutions[column]}"
        )
    return dataclasses.replace(row, certified=proven.astype(np.int8))


def _exits(curves) -> np.ndarray:
    """Axis values at which branches left through the amplitude ceiling, ascending."""
    ends = (
        curve.points[place, -1]
        for curve in curves
        for end, place in zip(curve.ends, (0, -1), strict=True)
        if end is EndReason.AMPLITUDE_CEILING
    )
    return np.sort(np.fromiter(ends, dtype=float))


def _beside(grid: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Indices of the grid values on both sides of every place."""
    right = np.searchsorted(grid, places)
    return np.concatenate([right - 1, right]).clip(0, grid.size - 1)


def _open(grid: np.ndarray, curves, missing: np.ndarray) -> np.ndarray:
    """Grid values at which solutions above the ceiling exist, or lie between places where branches left through it."""
    flags, beside = missing.copy(), _beside(grid, _exits(curves))
    if beside.size:
        flags[beside.min() : beside.max() + 1] = True
    return flags
