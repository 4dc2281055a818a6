"""Pseudo-arc-length continuation of a solution curve E(u, p) = 0 in one parameter p.

Unknowns and parameter are scaled; the predictor is the tangent, the corrector works on the hyperplane across it. A step
is refused when the corrector fails, when the tangent turns too far, when the corrected point lies far from the
predicted one, or when the orientation of the bordered Jacobian flips: each of these is how a jump to another branch
shows. A step is also refused when the cubic through its two ends and tangents turns round twice in p, or reaches a
grazing and comes back: a pair of events may not hide inside one step. What is accepted has at most one event of each
kind between two points; it is located by a bracketed search along the curve and becomes a point of its own. Between
two neighbouring points of a curve p is therefore monotone and the kind of motion does not change.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from solver.continuation import arclength
from solver.continuation.correctors import Broyden, Newton
from solver.continuation.problem import Problem
from solver.continuation.setup import Limits, Strand
from solver.continuation.solution_curve import Curve, EndReason, Event
from solver.model.checks import ParameterError, finite_array, finite_number, instance_of, number_array, whole_number

__all__ = ["Continuation", "Curve", "EndReason", "Event", "Problem"]


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
        instance_of("corrector", self.corrector, Newton, Broyden)
        for name in ("first_step", "largest_step", "smallest_step", "growth", "amplitude_max"):
            finite_number(name, getattr(self, name), above=0.0)
        for name, top in (("largest_angle", np.pi), ("largest_distance", 10.0), ("parameter_step", 1.0)):
            finite_number(name, getattr(self, name), above=0.0, at_most=top)
        whole_number("max_points", self.max_points, 2, 10**7)

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
            `ends[0]` is RANGE_LEFT, as if the start lay on the border; the caller knows better where it does not. A
            start that is no solution is corrected across `heading` first. Without any point `ends[1]` says why: the
            start could not be corrected (NO_SOLUTION), or the curve has no direction there (NO_TANGENT).

        Raises
        ------
        ParameterError
            If an argument has another size or is not finite, or p has no range.

        Notes
        -----
        Predictor along the tangent, corrector across it: H. B. Keller, "Numerical solution of bifurcation and nonlinear
        eigenvalue problems", Applications of Bifurcation Theory (1977) 359-384.
        """
        n = instance_of("problem", problem, Problem).unknowns
        return self._trace(problem, start, low, high, heading, np.empty((0, arclength.PLACE + n + 1)))

    def _trace(self, problem: Problem, start: np.ndarray, low, high, heading, log: np.ndarray) -> Curve:
        """As `trace`; notes what became of every step in a row of `log`, as many as it has."""
        n, room = problem.unknowns, self.max_points
        start = finite_array("start", start, (n + 1,))
        low, high, along = _box("low", low, n, -np.inf), _box("high", high, n, np.inf), _box("heading", heading, n, 0.0)
        if not -np.inf < low[n] < high[n] < np.inf or np.any(low > high):
            raise ParameterError("high", high.tolist(), f"above low, {low.tolist()}, and finite for p")
        if not along.any() or not np.isfinite(along).all():
            raise ParameterError("heading", along.tolist(), "1, -1 or a direction")
        limits = Limits(
            self.first_step,
            self.largest_step,
            self.smallest_step,
            self.largest_angle,
            self.largest_distance,
            self.parameter_step * (high[n] - low[n]),
            self.growth,
            self.amplitude_max,
            low,
            high,
        )
        strand = Strand(
            np.empty((room, n + 1)),
            np.empty((room, n + 1)),
            np.empty(room),
            np.empty(room, np.int8),
            np.empty(room, np.int8),
        )
        setup = problem.setup(self.corrector)
        count, reason, refused = arclength.trace(setup, limits, start, along, strand, log)
        parts = (part[:count].copy() for part in strand)
        return Curve(*parts, (EndReason.RANGE_LEFT, EndReason(reason)), refused)

    def trace_both_ways(self, problem: Problem, start: np.ndarray, low, high, heading=1) -> Curve:
        """Follow the curve from a solution in both directions, as one curve in order of arc length.

        Parameters
        ----------
        problem, start, low, high, heading
            As for `trace`.

        Raises
        ------
        ParameterError
            As `trace`.
        """
        ahead = self.trace(problem, start, low, high, heading)
        if ahead.closed:
            return replace(ahead, ends=(EndReason.CLOSED, EndReason.CLOSED))
        behind = self.trace(problem, start, low, high, -np.asarray(heading, dtype=float))
        if not len(ahead.points) or not len(behind.points):
            # Where the tangent cannot be told there is no curve, in neither direction.
            return ahead
        return behind.reversed().followed_by(ahead)


def _box(name: str, values, n: int, free: float) -> np.ndarray:
    """(n + 1,) array of the values, or with one number for the last component and `free` for the others."""
    values = number_array(name, values)
    if values.ndim == 0:
        return np.array([*[free] * n, values])
    if values.shape != (n + 1,) or np.isnan(values).any():
        raise ParameterError(name, values, f"one number, or {n + 1} numbers")
    return values.astype(float)
