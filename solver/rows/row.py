"""One row of a plane: its branches, the solutions at the row's grid values, and whether these are proven to be all."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from solver.contact.impact import domain_code, impact_of_range
from solver.contact.quantities import Slot
from solver.continuation.continuation import Continuation, Curve, EndReason, Event
from solver.continuation.problem import Balance
from solver.enumeration.solutions import Above, Proof
from solver.harmonic.describing_function import DescribingFunction
from solver.harmonic.quantities import fill_read
from solver.model.checks import ascending_grid, has_methods, instance_of
from solver.model.contact_system import ContactSystem
from solver.model.gear_model import Model
from solver.model.packing import check_axis, dead_zone_ends, packed
from solver.rows.degree import missing_degree
from solver.rows.seeds import Branches, ProvenSeeds, Seeds, proven_solutions
from solver.rows.span import BROKEN, RowSpan, ends_for
from solver.stability import assess
from solver.stability.bifurcations import KnownMotions, locate_bifurcations
from solver.stability.multipliers import TESTS

__all__ = ["Row", "sweep_row"]


@dataclass(frozen=True)
class Row:
    """Branches and raster of one row. X is the number of grid values, S the largest number of solutions at one.

    Parameters
    ----------
    balance : Balance
        Of which the motions are solutions, with n unknowns.
    system : Model or ContactSystem
        Its own value of the swept parameter is not used.
    axis, grid : str, (X,) array
        The swept parameter and its grid values.
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
    quantities : (X, S, 13) array
        What is read of the motions, by `solver.contact.quantities.Slot`; nan beyond the number of solutions, and where
        it cannot be computed.
    open : (X,) int8 array
        1 where solutions above the amplitude ceiling exist or are not excluded, and on both sides of a place where a
        branch left through it. Where nothing is proven also where the solutions do not add up to the degree of the
        balance, between such places unless enumeration excludes it, and beside those where a branch breaks off.
    certified : (X,) int8 array
        1 where the solutions are proven to be all of them, 0 where that is undecided, -1 where it was not asked.
    notes : tuple of str
        What could not be decided or traced, in sentences.
    """

    balance: Balance
    system: Model | ContactSystem
    axis: str
    grid: np.ndarray
    curves: tuple[Curve, ...]
    motions: np.ndarray
    stable: np.ndarray
    impact: np.ndarray
    instability: np.ndarray
    multiplier: np.ndarray
    quantities: np.ndarray
    open: np.ndarray
    certified: np.ndarray
    notes: tuple[str, ...]

    @property
    def n_folds(self) -> int:
        """Folds on all curves."""
        return sum(int(np.sum(curve.event == Event.FOLD)) for curve in self.curves)

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

    def branch_motions(self, curve: Curve) -> np.ndarray:
        """lambda_m, lambda_c and lambda_s at the points of one of the curves, (3, points).

        Raises
        ------
        ParameterError
            If it is no curve.
        """
        instance_of("curve", curve, Curve)
        return curve.points[:, [0, *self.balance.fundamental]].T

    def branch_impact(self, curve: Curve) -> np.ndarray:
        """`ImpactState` at the points of one of the curves, int8.

        Raises
        ------
        ParameterError
            If it is no curve.
        """
        instance_of("curve", curve, Curve)
        ends = dead_zone_ends(self.system, self.axis, curve.points[:, -1])
        return impact_of_range(*self.balance.extremes(curve.points[:, :-1]), *ends)

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
    system: Model | ContactSystem,
    axis: str,
    grid,
    *,
    omega: float | None = None,
    continuation: Continuation | None = None,
    seeds: Seeds | None = None,
    balance: Balance | None = None,
) -> Row:
    """Continue all branches over one axis and solve at the grid values.

    Parameters
    ----------
    system : Model or ContactSystem
    axis : str
        One of `solver.model.packing.AXES`, or of `SYSTEM_AXES` for a ContactSystem; its own value is not used.
    grid : (X,) array_like
        Ascending values of the axis, at least two; the branches are traced between the first and the last.
    omega : float, optional
        The frequency, > 0; needed unless it is the axis.
    continuation : Continuation, optional
    seeds : ProvenSeeds, LinearSeeds or LiftedSeeds, optional
        How branches are found; `ProvenSeeds` unless given, which prove the solutions at every grid value.
        `LiftedSeeds` are for the Galerkin balance.
    balance : Balance, optional
        The describing function of first order unless given.

    Returns
    -------
    Row
        What could not be decided or traced is marked at its grid values and said in the notes.

    Raises
    ------
    ParameterError
        If an argument is not allowed, or proven solutions are asked for of a system of which nothing can be proven.
    RowError
        If at a grid value the balance leaves the mean open, so that there is a continuum of solutions.
    """
    grid = ascending_grid("grid", grid)
    balance = DescribingFunction() if balance is None else has_methods("balance", balance, "problem", "extremes")
    continuation = Continuation() if continuation is None else instance_of("continuation", continuation, Continuation)
    seeds = ProvenSeeds() if seeds is None else has_methods("seeds", seeds, "branches")
    check_axis(system, axis, float(grid[0]), float(grid[-1]), omega)
    low, high = float(grid[0]), float(grid[-1])
    span = RowSpan(balance, system, axis, low, high, None if axis == "omega" else float(omega), continuation)
    branches = seeds.branches(span, grid)
    return _described(span, grid, branches, _raster(span, grid, branches))


class _Raster(NamedTuple):
    """Solutions at X grid values, one after the other; whether more lie above the ceiling, and what is proven."""

    column: np.ndarray
    unknowns: np.ndarray
    stable: np.ndarray
    open: np.ndarray
    certified: np.ndarray
    notes: tuple[str, ...]


def _raster(span: RowSpan, grid: np.ndarray, branches: Branches) -> _Raster:
    return _traced_raster(span, grid, branches) if branches.solutions is None else _proven_raster(span, grid, branches)


def _proven_raster(span: RowSpan, grid: np.ndarray, branches: Branches) -> _Raster:
    """The solutions that enumeration proves, and where it is undecided those that branches pass besides.

    What enumeration and continuation do not agree on is not certified.
    """
    solutions, notes = branches.solutions, []
    column, slot = np.nonzero(solutions.stable >= 0)
    columns, unknowns, stable = [column], [solutions.motions[column, slot]], [solutions.stable[column, slot]]
    undecided, contradicted = solutions.proof == Proof.UNDECIDED, solutions.proof == Proof.CONTRADICTION
    untraced, unknown = np.any((solutions.stable >= 0) & ~branches.on_curve, axis=1), np.zeros(grid.size, bool)
    for stray in branches.strays:
        decided = ~undecided[stray.column]
        unknown[stray.column[decided]] = True
        columns.append(stray.column[~decided])
        unknowns.append(stray.unknowns[~decided])
        stable.append(stray.stable[~decided])
    for flags, sentence in (
        (undecided, Proof.UNDECIDED.sentence),
        (contradicted, Proof.CONTRADICTION.sentence),
        (untraced, "No branch was traced through a proven solution."),
        (unknown, "A branch passes where enumeration proves that there is no solution."),
    ):
        notes += _note(span, grid, flags, sentence)
    is_open = (solutions.above != Above.EMPTY) | _between(grid, branches.curves, EndReason.AMPLITUDE_CEILING, False)
    certified = (solutions.proof == Proof.PROVEN) & ~untraced & ~unknown
    parts = (np.concatenate(part) for part in (columns, unknowns, stable))
    return _Raster(*parts, is_open, certified.astype(np.int8), tuple(notes))


def _traced_raster(span: RowSpan, grid: np.ndarray, branches: Branches) -> _Raster:
    """The solutions that the branches pass; open where these do not add up, and beside places where one breaks off."""
    met = [span.crossings(curve, grid) for curve in branches.curves]
    column = np.concatenate([np.empty(0, np.int64), *(part.column for part in met)])
    unknowns = np.concatenate([np.empty((0, span.problem.unknowns)), *(part.unknowns for part in met)])
    stable = np.concatenate([np.empty(0, np.int8), *(part.stable for part in met)])
    unreached = np.zeros(grid.size, bool)
    for part in met:
        unreached[part.unreached] = True
    notes = _note(span, grid, unreached, "A branch passes, but its solution could not be computed.")
    between = _between(grid, branches.curves, EndReason.AMPLITUDE_CEILING, True)
    if branches.by_enumeration and np.any(between):
        between[between] = proven_solutions(span, grid[between]).above != Above.EMPTY
    is_open = missing_degree(span, grid, met) | between
    is_open |= _between(grid, branches.curves, EndReason.AMPLITUDE_CEILING, False)
    for reason in BROKEN:
        is_open |= _between(grid, branches.curves, reason, False)
    return _Raster(column, unknowns, stable, is_open | unreached, np.full(grid.size, -1, np.int8), tuple(notes))


def _described(span: RowSpan, grid: np.ndarray, branches: Branches, raster: _Raster) -> Row:
    """The row, its solutions sorted by amplitude, with their states and their stability."""
    low, high = dead_zone_ends(span.system, span.axis, grid)
    amplitude = np.linalg.norm(raster.unknowns[:, list(span.balance.fundamental)], axis=1)
    order = np.lexsort((raster.unknowns[:, 0], amplitude, raster.column))
    column, unknowns, stable = raster.column[order], raster.unknowns[order], raster.stable[order]
    counts = np.bincount(column, minlength=grid.size)
    slot = np.arange(column.size) - np.repeat(np.cumsum(counts) - counts, counts)
    shape = (grid.size, max(int(counts.max(initial=0)), 1))

    def arranged(values, empty):
        result = np.full((*shape, *values.shape[1:]), empty, values.dtype)
        result[column, slot] = values
        return result

    motions = arranged(unknowns, np.nan)
    kind, modulus, tests = np.empty(0, np.int8), np.empty(0), np.empty((0, TESTS))
    if column.size:
        stability = assess(
            span.system, span.axis, grid[column], unknowns, omega=span.omega, balance=span.balance, static=stable
        )
        kind, modulus, tests = stability.kind.astype(np.int8), stability.modulus, stability.tests
    parameters = packed(span.system, span.axis, span.omega, span.balance.order, span.balance.period)
    quantities = np.empty((column.size, len(Slot)))
    fill_read(span.system, span.balance, parameters, grid[column], unknowns, quantities)
    known = KnownMotions(grid[column], unknowns, tests)
    located = [
        locate_bifurcations(parameters, span.problem, curve, span.continuation, known) for curve in branches.curves
    ]
    return Row(
        span.balance,
        span.system,
        span.axis,
        grid,
        tuple(curve for curve, _ in located),
        motions,
        arranged(stable, -1),
        impact_of_range(*span.balance.extremes(motions), low[:, None], high[:, None]),
        arranged(kind, -1),
        arranged(modulus, np.nan),
        arranged(quantities, np.nan),
        raster.open.astype(np.int8),
        raster.certified,
        (*branches.notes, *raster.notes, *(note for _, notes in located for note in notes)),
    )


def _note(span: RowSpan, grid: np.ndarray, flags: np.ndarray, sentence: str) -> list[str]:
    """A sentence with the grid values that it holds for; none where there are none."""
    values = grid[flags]
    if not values.size:
        return []
    more = f" and {values.size - 1} more" if values.size > 1 else ""
    return [f"At {span.axis} = {values[0]:.9g}{more}: {sentence}"]


def _between(grid: np.ndarray, curves: tuple[Curve, ...], reason: EndReason, all_between: bool) -> np.ndarray:
    """The grid values on both sides of every place at which a curve ends for one reason, (X,) bool.

    With `all_between` also those between the first and the last of these.
    """
    flags = np.zeros(grid.size, bool)
    right = np.searchsorted(grid, np.array([y[-1] for y in ends_for(curves, reason)], dtype=float))
    beside = np.concatenate([right - 1, right]).clip(0, grid.size - 1)
    flags[beside] = True
    if all_between and beside.size:
        flags[beside.min() : beside.max() + 1] = True
    return flags
