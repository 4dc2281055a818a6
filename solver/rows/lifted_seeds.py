"""Where the branches of a balance of order H start: first-order solutions, guesses of every size, switching.

At order H nothing is proven. What is done instead: at evenly spaced values of the axis every proven first-order
solution is corrected to order H, and so are motions of one harmonic at a few amplitudes and phases; where the signs of
det J do not add up to the degree, the solution that grows out of the linear one is added. On a multiple of the forcing
period, guesses carry subharmonics as well, and branches are switched where a subharmonic one crosses.
"""

import dataclasses
from collections.abc import Iterator
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
        for rank, column in enumerate(order):
            for start in lifted[column]:
                if not np.isnan(start[0]):
                    found.add(column, start)
            if rank % _EVERY == 0:
                for start in _guesses(span, found.motions(column)):
                    found.add(column, start)
        for first_missing, last_missing in runs(found.missing()):
            column = (first_missing + last_missing) // 2
            start = grown_solution(span, float(probes[column]))
            if start is not None:
                found.add(column, start[:-1])
        return Branches(tuple(found.curves), notes=found.notes)


def _guesses(span: RowSpan, known: list[np.ndarray]) -> Iterator[np.ndarray]:
    """Motions of one harmonic, and known motions with subharmonics added."""
    balance: Galerkin = span.balance
    size, n = span.problem.scale[0], span.problem.unknowns
    phases = 2.0 * np.pi * np.arange(_PHASES) / _PHASES
    for amplitude in _AMPLITUDES:
        for phase in phases:
            start = np.zeros(n)
            start[0] = 0.5 * size
            start[list(balance.fundamental)] = amplitude * size * np.cos(phase), amplitude * size * np.sin(phase)
            yield start
    for motion in known:
        for k in range(1, balance.period):
            for amplitude in (0.2, 0.6):
                # Half a turn of the subharmonic is a motion one forcing period later.
                for phase in phases / balance.period:
                    start = motion.copy()
                    start[2 * k - 1 : 2 * k + 1] += amplitude * size * np.array([np.cos(phase), np.sin(phase)])
                    yield start


class _Found:
    """The curves found so far and where they pass the probes."""

    def __init__(self, span: RowSpan, probes: np.ndarray):
        self.span, self.probes = span, probes
        self.curves: list[Curve] = []
        self._met: list[Crossings] = []
        self._lost: list[str] = []
        self._at: list[list[np.ndarray]] = [[] for _ in probes]

    def motions(self, column: int) -> list[np.ndarray]:
        """Solutions known at one probe."""
        return list(self._at[column])

    def missing(self) -> np.ndarray:
        """Where the degree does not add up, (probes,) bool."""
        return missing_degree(self.span, self.probes, self._met)

    def _known(self, column: int, motion: np.ndarray) -> bool:
        scale, period = self.span.problem.scale[:-1], self.span.balance.period
        return any(equal_motions(motion, other, scale, period) for other in self._at[column])

    def add(self, column: int, start: np.ndarray) -> None:
        """Correct a start (n,) at one probe, and follow its branch if it is a new one."""
        y = self.span.corrected(np.append(start, self.probes[column]))
        if y is not None and not self._known(column, y[:-1]):
            self._follow(y)
            if not self._known(column, y[:-1]):
                # Known from now on, so that it is not followed again.
                self._at[column].append(y[:-1])
                self._lost.append(f"Continuation leaves the solution found at {self.span.place(y)}.")

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
        for at, motion in zip(met.column.tolist(), met.unknowns, strict=True):
            self._at[at].append(motion)
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


def shifted(motion: np.ndarray, periods: int, period: int) -> np.ndarray:
    """A motion (n,) that many forcing periods later."""
    k = np.arange(1, motion.size // 2 + 1)
    moved = (motion[1::2] - 1j * motion[2::2]) * np.exp(2j * np.pi * k * periods / period)
    result = motion.copy()
    result[1::2], result[2::2] = moved.real, -moved.imag
    return result


def equal_motions(left: np.ndarray, right: np.ndarray, scale, period: int) -> bool:
    """Whether two solutions are one motion, perhaps some forcing periods later.

    Parameters
    ----------
    left, right : (n,) arrays
    scale : float or (n,) array
        Size of the unknowns.
    period : int
        nu, forcing periods of the balance.
    """
    return any(np.max(np.abs(shifted(left, shift, period) - right) / scale) <= _SAME for shift in range(period))


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
