"""Where the branches of a balance of order H start: first-order solutions, guesses of every size, switching.

At order H nothing is proven. What is done instead: at evenly spaced values of the axis every proven first-order
solution is corrected to order H, and so are motions of one harmonic at a few amplitudes and phases; where the signs of
det J do not add up to the degree, the solution that grows out of the linear one is added. On a multiple of the forcing
period, guesses carry subharmonics as well, and branches are switched where a subharmonic one crosses.
"""

import dataclasses
from dataclasses import dataclass

import numpy as np

from solver.continuation.continuation import Curve, EndReason, Event
from solver.harmonic.galerkin import Galerkin
from solver.model.checks import ParameterError, instance_of, whole_number
from solver.rows.crossings import Crossings, crossings
from solver.rows.seeds import Branches, grown_solution, missing_degree, proven_solutions
from solver.rows.span import RowSpan, ends_notes, runs

__all__ = ["LiftedSeeds", "equal_motions"]

_SAME = 1e-6
#: Of the guesses: every so many values of the axis, amplitudes in units of lambda's size, and number of phases.
_EVERY, _AMPLITUDES, _PHASES = 14, (0.7, 1.6), 4
#: Amplitudes of the subharmonics that are added to known motions.
_SUBHARMONICS = (0.2, 0.6)
#: How far branch switching steps off the branch, and how small the subharmonics of a motion of the forcing period are.
#: Subharmonics of a branch at which continuation may give up for that reason.
_OFF, _NO_SUBHARMONIC, _VANISHING = 2e-2, 1e-6, 2e-2


@dataclass(frozen=True)
class LiftedSeeds:
    """Starts for a `Galerkin` balance; see the module.

    Parameters
    ----------
    columns : int
        Number of evenly spaced values, both ends included.
    """

    columns: int = 197

    def __post_init__(self):
        whole_number("certify_columns", self.columns, 2, 10**6)

    def branches(self, span: RowSpan, grid: np.ndarray) -> Branches:
        """All branches found; raises ParameterError if the balance is none of `Galerkin`."""
        instance_of("span", span, RowSpan)
        if not isinstance(span.balance, Galerkin):
            raise ParameterError("seeds", self, f"ProvenSeeds or LinearSeeds for {span.balance}")
        probes = np.linspace(span.low, span.high, self.columns)
        order = [0, self.columns - 1, *range(1, self.columns - 1)]
        if span.balance.period > 1:
            # Where subharmonics vanish the curve is singular: no use in creeping up to it.
            settings = dataclasses.replace(span.continuation, smallest_step=max(span.continuation.smallest_step, 1e-5))
            span = dataclasses.replace(span, continuation=settings)
        found = _Found(span, probes)
        lifted = span.balance.lifted(proven_solutions(span, probes).motions)
        single = _single_harmonics(span)
        columns, starts = [], []
        for rank, column in enumerate(order):
            here = lifted[column][~np.isnan(lifted[column, :, 0])]
            for some in (here, single) if rank % _EVERY == 0 else (here,):
                columns += [column] * len(some)
                starts.append(some)
        found.add(np.array(columns), np.concatenate(starts))
        if span.balance.period > 1:
            for column in order[::_EVERY]:
                starts = _with_subharmonics(span, found.motions(column))
                found.add(np.full(len(starts), column), starts)
        for first_missing, last_missing in runs(found.missing()):
            column = (first_missing + last_missing) // 2
            start = grown_solution(span, float(probes[column]))
            if start is not None:
                found.add(np.array([column]), start[None, :-1])
        return Branches(tuple(found.curves), notes=found.notes)


def _single_harmonics(span: RowSpan) -> np.ndarray:
    """Guesses of the mean and one harmonic, (k, n)."""
    balance: Galerkin = span.balance
    size, phases = span.problem.scale[0], 2.0 * np.pi * np.arange(_PHASES) / _PHASES
    starts = np.zeros((len(_AMPLITUDES), _PHASES, span.problem.unknowns))
    starts[:, :, 0] = 0.5 * size
    circle = np.column_stack([np.cos(phases), np.sin(phases)])
    starts[:, :, list(balance.fundamental)] = size * np.multiply.outer(_AMPLITUDES, circle)
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


class _Found:
    """The curves found so far and where they pass the probes."""

    def __init__(self, span: RowSpan, probes: np.ndarray):
        self.span, self.probes = span, probes
        self.curves: list[Curve] = []
        self._met: list[Crossings] = []
        self._lost: list[str] = []
        # Columns (k,), ascending, and motions (k, n) of what is known: curve by curve, and what could not be followed.
        self._at: list[tuple[np.ndarray, np.ndarray]] = []

    def motions(self, column: int) -> np.ndarray:
        """Solutions known at one probe, (k, n)."""
        nothing = np.empty((0, self.span.problem.unknowns))
        return np.concatenate([nothing, *(motions[columns == column] for columns, motions in self._at)])

    def missing(self) -> np.ndarray:
        """Where the degree does not add up, (probes,) bool."""
        return missing_degree(self.span, self.probes, self._met)

    def _among(self, known: tuple[np.ndarray, np.ndarray], columns: np.ndarray, motions: np.ndarray) -> np.ndarray:
        """Which of the motions (k, n) at columns (k,) are among those known, (k,) bool."""
        scale, period = self.span.problem.scale[:-1], self.span.balance.period
        first, end = (np.searchsorted(known[0], columns, side) for side in ("left", "right"))
        among = np.zeros(columns.size, bool)
        for rank in range(int(np.max(end - first, initial=0))):
            there = end - first > rank
            among[there] |= equal_motions(motions[there], known[1][first[there] + rank], scale, period)
        return among

    def add(self, columns: np.ndarray, starts: np.ndarray) -> None:
        """Correct starts (k, n) at probes (k,), and follow the branches of those that are new, one after the other."""
        found = self.span.corrected(np.column_stack([starts, self.probes[columns]]))
        reached = ~np.isnan(found[:, 0])
        columns, found = columns[reached], found[reached]
        new = np.ones(columns.size, bool)
        for known in self._at:
            new &= ~self._among(known, columns, found[:, :-1])
        while np.any(new):
            first, before = int(np.argmax(new)), len(self._at)
            self._follow(found[first])
            for known in self._at[before:]:
                new &= ~self._among(known, columns, found[:, :-1])
            if new[first]:
                # Known from now on, so that it is not followed again.
                self._at.append((columns[[first]], found[[first], :-1]))
                new &= ~self._among(self._at[-1], columns, found[:, :-1])
                self._lost.append(f"Continuation leaves the solution found at {self.span.place(found[first])}.")

    @property
    def notes(self) -> tuple[str, ...]:
        """What could not be traced, in sentences."""
        return (*ends_notes(self.span, self.curves), *self._lost)

    def _follow(self, y: np.ndarray) -> None:
        curve = _one_phase(self.span, self.span.traced(y))
        if len(curve.points) < 2:
            return
        self.curves.append(curve)
        met = crossings(self.span, curve, self.probes)
        self._met.append(met)
        ascending = np.argsort(met.column, kind="stable")
        self._at.append((met.column[ascending], met.unknowns[ascending]))
        for place in np.flatnonzero(curve.event == Event.BRANCH_POINT):
            self._switch(curve, int(place))

    def _switch(self, curve: Curve, place: int) -> None:
        """Follow the branch that crosses a curve at one of its points, if it is a new one."""
        span, problem, y = self.span, self.span.problem, curve.points[place]
        n = problem.unknowns
        _, jacobian = problem.evaluated(y)
        null = np.linalg.svd(jacobian[:, :n] * problem.scale[:n])[2][-1]
        normal = np.append(null, 0.0)
        off = y + _OFF * normal * problem.scale
        start = problem.corrected(off, span.continuation.corrector, normal, max_iterations=20)
        if start is None or not span.low <= start[n] <= span.high:
            return
        if all(_far(start, other, problem.scale, span.balance.period) for other in self.curves):
            self._follow(start)


def _far(y: np.ndarray, curve: Curve, scale: np.ndarray, period: int) -> bool:
    """Whether a point is not on a curve: no stretch between two of its points passes it closely."""
    for shift in range(period):
        moved = np.append(shifted(y[:-1], shift, period), y[-1])
        steps = np.diff(curve.points, axis=0) / scale
        ahead = (moved - curve.points[:-1]) / scale
        along = np.clip(np.sum(ahead * steps, axis=1) / np.maximum(np.sum(steps**2, axis=1), 1e-300), 0.0, 1.0)
        if np.min(np.linalg.norm(ahead - along[:, None] * steps, axis=1)) < 0.2 * _OFF:
            return False
    return True


def shifted(motions: np.ndarray, periods: int, period: int) -> np.ndarray:
    """Motions (..., n) that many forcing periods later."""
    k = np.arange(1, motions.shape[-1] // 2 + 1)
    moved = (motions[..., 1::2] - 1j * motions[..., 2::2]) * np.exp(2j * np.pi * k * periods / period)
    result = motions.copy()
    result[..., 1::2], result[..., 2::2] = moved.real, -moved.imag
    return result


def equal_motions(left: np.ndarray, right: np.ndarray, scale, period: int) -> np.ndarray:
    """Whether solutions are one motion, perhaps some forcing periods later.

    Parameters
    ----------
    left, right : (..., n) arrays
    scale : float or (n,) array
        Size of the unknowns.
    period : int
        nu, forcing periods of the balance.

    Returns
    -------
    (...) bool array
    """
    return np.logical_or.reduce(
        [
            np.max(np.abs((shifted(left, shift, period) if shift else left) - right) / scale, axis=-1) <= _SAME
            for shift in range(period)
        ]
    )


def _one_phase(span: RowSpan, curve: Curve) -> Curve:
    """A subharmonic curve cut where its subharmonics vanish: beyond, it is the same motions one period later.

    There it is singular, so that continuation gives up close by or steps across.
    """
    period = span.balance.period
    if period == 1 or not len(curve.points):
        return curve
    strange = np.repeat(np.arange(1, span.balance.harmonics + 1) % period != 0, 2)
    motions = curve.points[:, 1:-1][:, strange]
    size = np.linalg.norm(motions, axis=1) / span.problem.scale[0]
    if np.max(size) < _NO_SUBHARMONIC:
        return curve
    largest = int(np.argmax(size))
    # Across the singular point the subharmonics change sign from one point to the next.
    turned = np.flatnonzero(np.sum(motions[1:] * motions[:-1], axis=1) < 0.0)
    first = max((int(i) + 1 for i in turned if i < largest), default=0)
    last = min((int(i) for i in turned if i >= largest), default=len(size) - 1)
    ends = tuple(
        EndReason.JOINED if place != whole or (end is EndReason.STEP_TOO_SMALL and size[place] < _VANISHING) else end
        for place, whole, end in zip((first, last), (0, len(size) - 1), curve.ends, strict=True)
    )
    return curve.between(first, last, ends)
