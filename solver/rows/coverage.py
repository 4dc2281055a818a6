"""The branches of a row that are found so far, and which solutions at chosen values of the axis they pass."""

import numpy as np

from solver.continuation.on_curve import Crossings, Known
from solver.continuation.solution_curve import Curve, Event
from solver.enumeration.solutions import Proof, RowSolutions
from solver.rows.degree import missing_degree
from solver.rows.phases import distance_to_curve, equal_motions, one_phase
from solver.rows.span import RowSpan, ends_notes

__all__ = ["Coverage", "CorrectedCoverage", "ProvenCoverage"]

#: Points and refused steps after which a row stops tracing what is missing: a second or two.
_MOST_STEPS = 200_000
#: In scaled unknowns: how far branch switching steps off a branch, and how near a known one is passed.
_OFF, _ON = 2e-2, 4e-3


class Coverage:
    """Branches, and where they meet the probes.

    Parameters
    ----------
    span : RowSpan
    probes : (P,) array
        Ascending values of the axis.

    Attributes
    ----------
    branches : list of (Curve, Crossings)
        In the order in which they were found.
    """

    def __init__(self, span: RowSpan, probes: np.ndarray):
        self.span, self.probes = span, probes
        self.branches: list[tuple[Curve, Crossings]] = []
        self._lost: list[np.ndarray] = []
        self._given_up = False

    @property
    def curves(self) -> tuple[Curve, ...]:
        """All branches."""
        return tuple(curve for curve, _ in self.branches)

    @property
    def met(self) -> tuple[Crossings, ...]:
        """Where each of them meets the probes."""
        return tuple(met for _, met in self.branches)

    @property
    def notes(self) -> tuple[str, ...]:
        """What could not be traced, in sentences."""
        sentences = ends_notes(self.span, self.curves)
        if self._lost:
            more = f" and {len(self._lost) - 1} more solutions" if len(self._lost) > 1 else ""
            sentences.append(f"No branch can be followed from {self.span.described(self._lost[0])}{more}.")
        if self._given_up:
            sentences.append(f"Tracing was given up after {_MOST_STEPS} steps.")
        return tuple(sentences)

    def missing(self) -> np.ndarray:
        """Where the degree does not add up, (P,) bool."""
        return missing_degree(self.span, self.probes, self.met)


class ProvenCoverage(Coverage):
    """Branches through proven solutions.

    Parameters
    ----------
    span : RowSpan
    probes : (P,) array
    solutions : RowSolutions
        All solutions at the probes, at most S at one.
    """

    def __init__(self, span: RowSpan, probes: np.ndarray, solutions: RowSolutions):
        super().__init__(span, probes)
        self.solutions = solutions
        self._known = Known(solutions.motions, solutions.stable, (solutions.proof == Proof.PROVEN).astype(np.int8))

    @property
    def on_curve(self) -> np.ndarray:
        """Which of the solutions the branches pass, (P, S) bool."""
        return _any_on_curve(self.met, self.solutions.stable.shape)

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
            slot = int(np.argmax(missing[column]))
            missing[column, slot] = False
            curve, met = self._trace(int(column), slot)
            steps += len(curve.points) + curve.refused
            missing &= ~met.on_curve

    def _trace(self, column: int, slot: int) -> tuple[Curve, Crossings]:
        """Follow the branch through one solution and keep it, unless it is a part of one that is known."""
        y = np.append(self.solutions.motions[column, slot], self.probes[column])
        curve = self.span.traced(y)
        met = self.span.crossings(curve, self.probes, self._known)
        if len(curve.points) < 2:
            self._lost.append(y)
            return curve, met
        met.on_curve[column, slot] = True
        # Regular points lie on one branch. Curves share solutions where a corrector failed or steps became too small,
        # which hid a part of one, or where a step jumped over a needle and joined two: then the others hold all of it.
        for _, other in self.branches:
            shared = met.on_curve & other.on_curve
            if np.any(shared) and np.sum(met.on_curve) - np.sum(shared) <= 1:
                other.on_curve[column, slot] = True
                return curve, met
        kept = [*self.branches, (curve, met)]
        for old in self.branches:
            if np.any(met.on_curve & old[1].on_curve):
                rest = _any_on_curve([other for _, other in kept if other is not old[1]], met.on_curve.shape)
                if not np.any(old[1].on_curve & ~rest):
                    kept = [pair for pair in kept if pair[1] is not old[1]]
        self.branches = kept
        return curve, met


def _any_on_curve(met, shape: tuple[int, int]) -> np.ndarray:
    """Which solutions (P, S) at least one of several curves passes."""
    return np.logical_or.reduce([crossing.on_curve for crossing in met], initial=False, axis=0) | np.zeros(shape, bool)


class CorrectedCoverage(Coverage):
    """Branches through what a corrector reaches from guesses; motions of several periods count once."""

    def __init__(self, span: RowSpan, probes: np.ndarray):
        super().__init__(span, probes)
        # Columns (k,), ascending, and motions (k, n) of what is known: curve by curve, and what could not be followed.
        self._known: list[tuple[np.ndarray, np.ndarray]] = []

    def motions(self, column: int) -> np.ndarray:
        """Solutions known at one probe, (k, n)."""
        nothing = np.empty((0, self.span.problem.unknowns))
        return np.concatenate([nothing, *(motions[columns == column] for columns, motions in self._known)])

    def know(self, curve: Curve) -> Crossings:
        """From now on no branch is followed from what a curve passes at the probes; where that is."""
        met = self.span.crossings(curve, self.probes)
        ascending = np.argsort(met.column, kind="stable")
        self._known.append((met.column[ascending], met.unknowns[ascending]))
        return met

    def add(self, columns: np.ndarray, starts: np.ndarray) -> None:
        """Correct starts (k, n) at probes (k,), and follow the branches of those that are new, one after the other."""
        solutions = self.span.corrected(np.column_stack([starts, self.probes[columns]]))
        reached = ~np.isnan(solutions[:, 0])
        columns, solutions = columns[reached], solutions[reached]
        new = np.ones(columns.size, bool)
        for known in self._known:
            new &= ~self._among(known, columns, solutions[:, :-1])
        while np.any(new):
            first, before = int(np.argmax(new)), len(self._known)
            self._follow(solutions[first])
            for known in self._known[before:]:
                new &= ~self._among(known, columns, solutions[:, :-1])
            if new[first]:
                # Known from now on, so that it is not followed again.
                self._known.append((columns[[first]], solutions[[first], :-1]))
                new &= ~self._among(self._known[-1], columns, solutions[:, :-1])
                self._lost.append(solutions[first])

    def _among(self, known: tuple[np.ndarray, np.ndarray], columns: np.ndarray, motions: np.ndarray) -> np.ndarray:
        """Which of the motions (k, n) at columns (k,) are among those known, (k,) bool."""
        scale, period = self.span.problem.scale[:-1], self.span.balance.period
        first, end = (np.searchsorted(known[0], columns, side) for side in ("left", "right"))
        among = np.zeros(columns.size, bool)
        for rank in range(int(np.max(end - first, initial=0))):
            there = end - first > rank
            among[there] |= equal_motions(motions[there], known[1][first[there] + rank], scale, period)
        return among

    def _follow(self, y: np.ndarray) -> None:
        """Keep the branch through a solution, and those that cross it."""
        curve = one_phase(self.span, self.span.traced(y))
        if len(curve.points) < 2:
            return
        self.branches.append((curve, self.know(curve)))
        for y in curve.points[curve.event == Event.BRANCH_POINT]:
            self._switch(y)

    def _switch(self, y: np.ndarray) -> None:
        """Follow the branch that crosses another at a point of it, if it is a new one."""
        span, problem, n = self.span, self.span.problem, self.span.problem.unknowns
        _, jacobian = problem.evaluated(y)
        null = np.linalg.svd(jacobian[:, :n] * problem.scale[:n])[2][-1]
        normal = np.append(null, 0.0)
        off = y + _OFF * normal * problem.scale
        start = problem.corrected(off, span.continuation.corrector, normal, max_iterations=20)
        if start is None or not span.low <= start[n] <= span.high:
            return
        period = span.balance.period
        if all(distance_to_curve(start, other, problem.scale, period) >= _ON for other in self.curves):
            self._follow(start)
