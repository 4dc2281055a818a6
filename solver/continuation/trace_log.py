"""The log of continuation: what became of every step that the kernel tried, accepted or refused.

The kernel that traces writes it while it traces; without a log there is nothing to write to, and nothing else differs.
"""

from dataclasses import dataclass, field

import numpy as np

from solver.continuation import arclength
from solver.continuation.continuation import Continuation
from solver.continuation.problem import Problem
from solver.continuation.solution_curve import Curve, Outcome

__all__ = ["LoggedContinuation", "Outcome", "Steps", "Trace"]


@dataclass(frozen=True)
class Steps:
    """Every step of one trace, in order.

    Parameters
    ----------
    outcome : (m,) int array
        `Outcome` of every step; `accepted` where it gave points of the curve.
    length : (m,) array
        Step length in scaled unknowns, as tried.
    iterations : (m,) int array
        Of the corrector; -1 where it did not converge.
    stray, turn : (m,) arrays
        Distance of the corrected from the predicted point in scaled unknowns, and angle between the tangents (rad); nan
        where the corrector did not converge. Points round a corner are placed otherwise: iterations 0, stray nan.
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

    @property
    def accepted(self) -> np.ndarray:
        """Which steps gave points of the curve, (m,) bool."""
        return np.isin(self.outcome, (Outcome.ACCEPTED, Outcome.ROUND_A_CORNER))


@dataclass(frozen=True)
class Trace:
    """One call of `Continuation.trace`.

    Parameters
    ----------
    problem : Problem
    start, heading : arrays
        Where it began, and where it headed.
    curve : Curve
    steps : Steps
    """

    problem: Problem
    start: np.ndarray
    heading: np.ndarray
    curve: Curve
    steps: Steps


@dataclass(frozen=True)
class LoggedContinuation(Continuation):
    """A continuation that logs everything it traces; the curves are the same to the bit.

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
    >>> log = LoggedContinuation()
    >>> row = sweep_row(gear, "omega", [0.05, 2.0], continuation=log)
    >>> (trace,) = log.traces
    >>> refused = ~trace.steps.accepted
    >>> int(trace.steps.points[-1]) == len(trace.curve.points), int(refused.sum()) == trace.curve.refused
    (True, True)
    """

    traces: list[Trace] = field(default_factory=list, compare=False)

    def trace(self, problem: Problem, start: np.ndarray, low, high, heading=1) -> Curve:
        """As `Continuation.trace`."""
        room = self.max_points
        while True:
            log = np.full((room, arclength.PLACE + problem.unknowns + 1), np.nan)
            curve = self._trace(problem, start, low, high, heading, log)
            if np.isnan(log[-1, arclength.OUTCOME]):
                break
            # More steps than expected were refused; the kernel does the same again.
            room *= 2
        log = log[~np.isnan(log[:, arclength.OUTCOME])]
        steps = Steps(
            log[:, arclength.OUTCOME].astype(int),
            log[:, arclength.STEP],
            log[:, arclength.ITERATIONS].astype(int),
            log[:, arclength.STRAY],
            log[:, arclength.TURN],
            np.minimum(log[:, arclength.POINTS].astype(int), len(curve.points)),
            log[:, arclength.PLACE :],
        )
        start, heading = np.array(start, dtype=float), np.array(heading, dtype=float)
        self.traces.append(Trace(problem, start, heading, curve, steps))
        return curve
