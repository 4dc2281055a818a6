"""Pseudo-arc-length continuation of a solution curve E(u, p) = 0 in one parameter p.

Unknowns and parameter are scaled; the predictor is the tangent, the corrector works on the hyperplane across it. A step
is refused when the corrector fails, when the tangent turns too far, when the corrected point lies far from the
predicted one, or when the orientation of the bordered Jacobian flips: each of these is how a jump to another branch
shows. A step is also refused when the cubic through its two ends and tangents turns round twice in p, or reaches a
grazing and comes back: a pair of events may not hide inside one step. What is accepted has at most one event of each
kind between two points; it is located by a bracketed search along the curve and becomes a point of its own. Between
two neighbouring points of a curve p is therefore monotone and the kind of motion does not change.
"""

import enum
from dataclasses import dataclass, field

import numpy as np

from solver.continuation import arclength
from solver.continuation.correctors import Broyden, Newton
from solver.continuation.problem import Problem
from solver.model.checks import ParameterError

__all__ = ["Continuation", "Curve", "EndReason", "Event", "Problem"]


class EndReason(enum.IntEnum):
    """Why a branch ends."""

    RANGE_LEFT = arclength.RANGE_LEFT
    CLOSED = arclength.CLOSED
    AMPLITUDE_CEILING = arclength.AMPLITUDE_CEILING
    STEP_TOO_SMALL = arclength.STEP_TOO_SMALL
    ITERATION_LIMIT = arclength.ITERATION_LIMIT
    JOINED = 6

    @property
    def sentence(self) -> str:
        """What happened, for the reader of a log."""
        return _END_SENTENCES[self]


_END_SENTENCES = {
    EndReason.RANGE_LEFT: "The branch left the range of the swept parameter.",
    EndReason.CLOSED: "The branch returned to where it started: it is a closed curve.",
    EndReason.AMPLITUDE_CEILING: "The branch rose above the amplitude ceiling; what lies above is not excluded.",
    EndReason.STEP_TOO_SMALL: "The corrector refused every step down to the smallest one.",
    EndReason.ITERATION_LIMIT: "The branch has more points than there is room for.",
    EndReason.JOINED: "The branch ends on one of a shorter period: beyond, it is the same motions one period later.",
}


class Event(enum.IntEnum):
    """What is special about a point of a branch."""

    NONE = 0
    FOLD = arclength.FOLD
    MIN_AT_DRIVE = 2
    MIN_AT_BACK = 3
    MAX_AT_DRIVE = 4
    MAX_AT_BACK = 5
    BRANCH_POINT = arclength.BRANCH_POINT
    PERIOD_DOUBLING = 7
    NEIMARK_SACKER = 8

    @property
    def sentence(self) -> str:
        """What the event means."""
        return _EVENT_SENTENCES[self]


_EVENT_SENTENCES = {
    Event.NONE: "A regular point.",
    Event.FOLD: "The branch turns round in the swept parameter; static stability changes.",
    Event.MIN_AT_DRIVE: "lambda_min = b: the drive flanks just touch all the time.",
    Event.MIN_AT_BACK: "lambda_min = -b: the back flanks are just reached.",
    Event.MAX_AT_DRIVE: "lambda_max = b: the drive flanks are just reached.",
    Event.MAX_AT_BACK: "lambda_max = -b: the back flanks just touch all the time.",
    Event.BRANCH_POINT: "Another branch crosses here.",
    Event.PERIOD_DOUBLING: "A multiplier passes -1: motions of twice the period branch off.",
    Event.NEIMARK_SACKER: "A pair of multipliers passes the unit circle: quasi-periodic motions branch off.",
}


@dataclass(frozen=True)
class Curve:
    """A traced piece of a solution curve; its points are in order of arc length.

    Parameters
    ----------
    points, tangents : (count, n + 1) arrays
        y = (u, p), and unit tangents in scaled unknowns.
    arclength : (count,) array
        In scaled unknowns, from the first point.
    stable, event : (count,) int8 arrays
        Static stability (det dE/du > 0; 0 at folds) and `Event` of every point.
    ends : tuple of EndReason
        Why the curve ends at its first and at its last point.
    refused : int
        Steps that were refused on the way.
    """

    points: np.ndarray
    tangents: np.ndarray
    arclength: np.ndarray
    stable: np.ndarray
    event: np.ndarray
    ends: tuple[EndReason, EndReason]
    refused: int

    @property
    def amplitude(self) -> np.ndarray:
        """lambda_a at first order: the length of the second and third unknown, (count,)."""
        return np.hypot(self.points[:, 1], self.points[:, 2])

    @property
    def closed(self) -> bool:
        """Whether the last point is the first one again."""
        return self.ends[1] is EndReason.CLOSED


@dataclass(frozen=True)
class Continuation:
    """Pseudo-arc-length continuation with its tolerances.

    Parameters
    ----------
    corrector : Newton or Broyden
    first_step, largest_step, smallest_step : float
        Arc length of steps, in scaled unknowns.
    largest_angle : float
        A step is refused when the tangent turns by more (rad); step control aims at a third of it.
    largest_distance : float
        A step is refused when the correction is longer than this share of the step.
    parameter_step : float
        No step moves p by more than this share of its range.
    growth : float
        Where unknowns are large, steps may grow up to this share of them.
    amplitude_max : float
        A branch ends where its amplitude exceeds this.
    max_points : int
        A branch ends when it has this many points.

    Raises
    ------
    ParameterError
        If a setting is out of its range.
    """

    corrector: Newton | Broyden = field(default_factory=Newton)
    first_step: float = 1e-2
    largest_step: float = 0.2
    smallest_step: float = 1e-9
    largest_angle: float = 0.35
    largest_distance: float = 0.3
    parameter_step: float = 0.01
    growth: float = 0.1
    amplitude_max: float = 100.0
    max_points: int = 4096

    def __post_init__(self):
        for name in ("first_step", "largest_step", "smallest_step", "growth", "amplitude_max"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise ParameterError(name, getattr(self, name), "a finite number above 0")
        for name, top in (("largest_angle", np.pi), ("largest_distance", 10.0), ("parameter_step", 1.0)):
            if not 0.0 < getattr(self, name) <= top:
                raise ParameterError(name, getattr(self, name), f"above 0 and at most {top:g}")
        if not 2 <= self.max_points <= 10**7:
            raise ParameterError("max_points", self.max_points, "from 2 to 10000000")

    def trace(self, problem: Problem, start: np.ndarray, low, high, heading=1) -> Curve:
        """Follow the curve from a solution until it leaves a box or ends otherwise.

        Parameters
        ----------
        problem : Problem
        start : (n + 1,) array
            A solution y = (u, p) inside the box.
        low, high : float or (n + 1,) array
            Range of p, or the box for all of y: infinite where a component is free, finite for p.
        heading : {1, -1} or (n + 1,) array
            Whether to start towards growing or falling p, or the direction in scaled unknowns to whose side to start.

        Returns
        -------
        Curve
            `ends[0]` is RANGE_LEFT, as if the start lay on the border; the caller knows better where it does not.
        """
        return self._trace(problem, start, low, high, heading, np.empty((0, arclength.PLACE + problem.unknowns + 1)))

    def _trace(self, problem: Problem, start: np.ndarray, low, high, heading, diary: np.ndarray) -> Curve:
        """As `trace`; notes what became of every step in a row of `diary`, as many as it has."""
        n, room = problem.unknowns, self.max_points
        low, high, along = _box(low, n, -np.inf), _box(high, n, np.inf), _box(heading, n, 0.0)
        points, tangents = np.empty((room, n + 1)), np.empty((room, n + 1))
        length, stable, event = np.empty(room), np.empty(room, np.int8), np.empty(room, np.int8)
        settings = np.array(
            [
                self.first_step,
                self.largest_step,
                self.smallest_step,
                self.largest_angle,
                self.largest_distance,
                self.parameter_step * (high[n] - low[n]),
                self.growth,
                self.amplitude_max,
            ]
        )
        count, reason, refused = arclength.trace(
            self.corrector.kernel,
            self.corrector.tolerance,
            self.corrector.max_iterations,
            problem.balance,
            problem.monitor,
            problem.theta,
            problem.direction,
            problem.scale,
            problem.monitors,
            np.array(start, dtype=float),
            along,
            settings,
            low,
            high,
            points,
            tangents,
            length,
            stable,
            event,
            diary,
        )
        reason = EndReason(reason)
        return Curve(
            points[:count].copy(),
            tangents[:count].copy(),
            length[:count].copy(),
            stable[:count].copy(),
            event[:count].copy(),
            (EndReason.RANGE_LEFT, reason),
            refused,
        )

    def trace_both_ways(self, problem: Problem, start: np.ndarray, low, high, heading=1) -> Curve:
        """Follow the curve from a solution in both directions, as one curve in order of arc length; as for `trace`."""
        ahead = self.trace(problem, start, low, high, heading)
        if ahead.closed:
            return Curve(**{**vars(ahead), "ends": (EndReason.CLOSED, EndReason.CLOSED)})
        behind = self.trace(problem, start, low, high, -np.asarray(heading, dtype=float))
        if not len(ahead.points) or not len(behind.points):
            # Where the tangent cannot be told there is no curve, in neither direction.
            return ahead
        back = slice(None, 0, -1)
        return Curve(
            np.concatenate([behind.points[back], ahead.points]),
            np.concatenate([-behind.tangents[back], ahead.tangents]),
            np.concatenate([behind.arclength[-1] - behind.arclength[back], behind.arclength[-1] + ahead.arclength]),
            np.concatenate([behind.stable[back], ahead.stable]),
            np.concatenate([behind.event[back], ahead.event]),
            (behind.ends[1], ahead.ends[1]),
            ahead.refused + behind.refused,
        )


def _box(values, n: int, free: float) -> np.ndarray:
    """(n + 1,) array of the values, or with one number for the last component and `free` for the others."""
    if np.ndim(values) == 0:
        values = [*[free] * n, values]
    return np.array(values, dtype=float)
