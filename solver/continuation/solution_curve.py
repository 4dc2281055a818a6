"""A traced solution curve: its points, what is special about them, and why it ends. No kernel is needed to read it."""

from dataclasses import dataclass

import numpy as np

from solver.continuation.setup import Strand
from solver.explained import Explained
from solver.model.checks import ParameterError, instance_of, instances_of, whole_number

__all__ = ["Curve", "EndReason", "Event", "Outcome"]


class EndReason(Explained):
    """Why a branch ends."""

    RANGE_LEFT = 1, "The branch left the range of the swept parameter."
    CLOSED = 2, "The branch returned to where it started: it is a closed curve."
    AMPLITUDE_CEILING = 3, "The branch rose above the amplitude ceiling; what lies above is not excluded."
    STEP_TOO_SMALL = 4, "The corrector refused every step down to the smallest one."
    ITERATION_LIMIT = 5, "The branch has more points than there is room for."
    JOINED = 6, "The branch ends on one of a shorter period: beyond, it is the same motions one period later."
    NO_SOLUTION = 7, "The start is no solution, and the corrector found none from it: there is no branch to follow."
    NO_TANGENT = 8, "The Jacobian is singular at the start, so that the direction of the branch cannot be told."


class Event(Explained):
    """What is special about a point of a branch."""

    NONE = 0, "A regular point."
    FOLD = 1, "The branch turns round in the swept parameter; static stability changes."
    MIN_AT_DRIVE = 2, "lambda_min = b: the drive flanks just touch all the time."
    MIN_AT_BACK = 3, "lambda_min = -b: the back flanks are just reached."
    MAX_AT_DRIVE = 4, "lambda_max = b: the drive flanks are just reached."
    MAX_AT_BACK = 5, "lambda_max = -b: the back flanks just touch all the time."
    BRANCH_POINT = 6, "Another branch crosses here."
    PERIOD_DOUBLING = 7, "A multiplier passes -1: motions of twice the period branch off."
    NEIMARK_SACKER = 8, "A pair of multipliers passes the unit circle: quasi-periodic motions branch off."
    UNIT_MULTIPLIER = 9, "A multiplier passes +1 where no branch folds: the order of the balance is too low."


class Outcome(Explained):
    """What became of a step of continuation."""

    ACCEPTED = 0, "The step was taken."
    NOT_CORRECTED = 1, "The corrector did not converge."
    TURNED = 2, "The tangent turned by more than largest_angle."
    STRAYED = 3, "The corrected point lies further from the predicted one than largest_distance allows."
    FLIPPED = 4, "The bordered determinant changed sign: the point may lie on another branch."
    HIDES_A_PAIR = 5, "The cubic through both ends folds or grazes twice inside: a pair of events may hide."
    NOT_LOCATED = 6, "An event or the end of the branch in this step was not located."
    ROUND_A_CORNER = 7, "The step was taken round the corner where contact begins or ends, by the depth of contact."


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
        Why the curve ends at its first and at its last point. Without any point: why there is no curve.
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

    @property
    def strand(self) -> Strand:
        """What kernels read of it."""
        return Strand(self.points, self.tangents, self.arclength, self.stable, self.event)

    def reversed(self) -> "Curve":
        """The same curve, the other way."""
        points, tangents, arclength, stable, event = (part[::-1].copy() for part in self.strand)
        return Curve(points, -tangents, arclength[:1] - arclength, stable, event, self.ends[::-1], self.refused)

    def followed_by(self, other: "Curve") -> "Curve":
        """This curve and one that starts at its last point, as one; what it says of that point is the other's.

        Raises
        ------
        ParameterError
            If the other is no curve.
        """
        instance_of("other", other, Curve)
        further = other.strand._replace(arclength=self.arclength[-1] + other.arclength)
        parts = (np.concatenate([here[:-1], there]) for here, there in zip(self.strand, further, strict=True))
        return Curve(*parts, (self.ends[0], other.ends[1]), self.refused + other.refused)

    def between(self, first: int, last: int, ends: tuple[EndReason, EndReason]) -> "Curve":
        """The part from one point to another, both included.

        Parameters
        ----------
        first, last : int
            Its first and its last point.
        ends : (EndReason, EndReason)
            Why it ends there.

        Raises
        ------
        ParameterError
            If there are no such points, or an end is no reason.
        """
        last = whole_number("last", last, 0, len(self.points) - 1)
        first = whole_number("first", first, 0, last)
        ends = instances_of("ends", ends, EndReason)
        if len(ends) != 2:
            raise ParameterError("ends", ends, "two reasons")
        strand = Strand(*(part[first : last + 1] for part in self.strand))
        return Curve(*strand._replace(arclength=strand.arclength - self.arclength[first]), ends, self.refused)
