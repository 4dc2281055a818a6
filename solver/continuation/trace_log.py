"""The diary of continuation: what became of every step that the kernel tried, accepted or refused.

The kernel that traces notes it while it traces; without a diary there is nothing to write to, and nothing else differs.
"""

import enum
from dataclasses import dataclass, field

import numpy as np

from solver.continuation import arclength
from solver.continuation.continuation import Continuation, Curve
from solver.continuation.problem import Problem

__all__ = ["DiaryContinuation", "Outcome", "Steps", "Trace"]


class Outcome(enum.IntEnum):
    """What became of a step."""

    ACCEPTED = arclength.ACCEPTED
    NOT_CORRECTED = arclength.NOT_CORRECTED
    TURNED = arclength.TURNED
    STRAYED = arclength.STRAYED
    FLIPPED = arclength.FLIPPED
    HIDES_A_PAIR = arclength.HIDES_A_PAIR
    NOT_LOCATED = arclength.NOT_LOCATED

    @property
    def sentence(self) -> str:
        """What it means."""
        return _OUTCOME_SENTENCES[self]


_OUTCOME_SENTENCES = {
    Outcome.ACCEPTED: "The step was taken.",
    Outcome.NOT_CORRECTED: "The corrector did not converge.",
    Outcome.TURNED: "The tangent turned by more than largest_angle.",
    Outcome.STRAYED: "The corrected point lies further from the predicted one than largest_distance allows.",
    Outcome.FLIPPED: "The bordered determinant changed sign: the point may lie on another branch.",
    Outcome.HIDES_A_PAIR: "The cubic through both ends folds or grazes twice inside: a pair of events may hide.",
    Outcome.NOT_LOCATED: "An event or the end of the branch in this step was not located.",
}


@dataclass(frozen=True)
class Steps:
    """Every step of one trace, in order.

    Parameters
    ----------
    outcome : (m,) int array
        `Outcome` of every step.
    length : (m,) array
        Step length in scaled unknowns, as tried.
    iterations : (m,) int array
        Of the corrector; -1 where it did not converge.
    stray, turn : (m,) arrays
        Distance of the corrected from the predicted point in scaled unknowns, and angle between the tangents (rad); nan
        where the corrector did not converge.
    points : (m,) int array
        How many points the curve had after the step; where there was no room for its last ones, all that there are.
    places : (m, n + 1) array
        y = (u, p): the new point of an accepted step, the place that was refused otherwise.
    """

    outcome: np.ndarray
    length: np.ndarray
    iterations: np.ndarray
    stray: np.ndarray
    turn: np.ndarray
    points: np.ndarray
    places: np.ndarray


@dataclass(frozen=True)
class Trace:
    """One call of `Continuation.trace`: the problem, the seed, where it headed, the curve and the steps."""

    problem: Problem
    start: np.ndarray
    heading: np.ndarray
    curve: Curve
    steps: Steps


@dataclass(frozen=True)
class DiaryContinuation(Continuation):
    """A continuation that keeps a diary of everything it traces; the curves are the same to the bit.

    Parameters
    ----------
    traces : list of Trace
        Grows with every call of `trace`; copies with other settings write into the same list.

    Examples
    --------
    >>> from solver import Model, sweep_row
    >>> gear = Model(b=1.0, alpha=0.2, f_e=0.2, f_pm=0.5, kappa=0.5, xi_mesh=0.05, xi_translation=0.0125,
    ...     xi_support=0.01, k_support=1.0, pitch_cone_angle=45.0, pressure_angle=20.0, translation_coupling=0.3173,
    ...     rotation_coupling=0.7719, variation_translation=1.0, variation_rotation=0.0)
    >>> diary = DiaryContinuation()
    >>> row = sweep_row(gear, "omega", [0.05, 2.0], continuation=diary)
    >>> (trace,) = diary.traces
    >>> accepted = trace.steps.outcome == Outcome.ACCEPTED
    >>> int(trace.steps.points[-1]) == len(trace.curve.points), int((~accepted).sum()) == trace.curve.refused
    (True, True)
    """

    traces: list[Trace] = field(default_factory=list, compare=False)

    def trace(self, problem: Problem, start: np.ndarray, low, high, heading=1) -> Curve:
        """As `Continuation.trace`."""
        room = self.max_points
        while True:
            diary = np.full((room, arclength.PLACE + problem.unknowns + 1), np.nan)
            curve = self._trace(problem, start, low, high, heading, diary)
            if np.isnan(diary[-1, arclength.OUTCOME]):
                break
            # More steps than expected were refused; the kernel does the same again.
            room *= 2
        diary = diary[~np.isnan(diary[:, arclength.OUTCOME])]
        self.traces.append(
            Trace(
                problem,
                np.array(start, dtype=float),
                np.array(heading, dtype=float),
                curve,
                Steps(
                    diary[:, arclength.OUTCOME].astype(int),
                    diary[:, arclength.STEP],
                    diary[:, arclength.ITERATIONS].astype(int),
                    diary[:, arclength.STRAY],
                    diary[:, arclength.TURN],
                    np.minimum(diary[:, arclength.POINTS].astype(int), len(curve.points)),
                    diary[:, arclength.PLACE :],
                ),
            )
        )
        return curve
