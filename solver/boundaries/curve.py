"""A boundary in the plane of two parameters, and what is special about its points."""

import enum
from dataclasses import dataclass, field

import numpy as np

from solver.boundaries.contact_angles import X
from solver.boundaries.incidence import distances
from solver.boundaries.refine import refined
from solver.continuation.continuation import Continuation, Curve, EndReason, Event, Problem
from solver.continuation.on_curve import curve_crossings

__all__ = ["BoundaryCurve", "Piece", "SpecialPoint", "SEEN"]

#: Which components of y = (lambda_m, lambda_c, lambda_s, phi_f, phi_b, x, p) a boundary curve shows.
SEEN = (0, 1, 2, X, X + 1)


class SpecialPoint(enum.IntEnum):
    """What is special about a point of a boundary."""

    NONE = 0
    BORDER = 1
    CUSP = 2
    FOLD_GRAZING = 3
    ISOLA = 4
    MERGER = 5
    EXTREMUM = 6
    DOUBLE_GRAZING = 7
    RESONANCE = 8
    CORNER = 9

    @property
    def sentence(self) -> str:
        """What it means for the motions nearby."""
        return _SENTENCES[self]


_SENTENCES = {
    SpecialPoint.NONE: "A regular point.",
    SpecialPoint.BORDER: "The boundary leaves the plane here.",
    SpecialPoint.CUSP: "Two folds meet and end: beyond it the jump is gone.",
    SpecialPoint.FOLD_GRAZING: "The folding motion just touches a flank: the jump changes its contact state.",
    SpecialPoint.ISOLA: "The fold curve turns round in the row parameter: an isolated branch shrinks to a point.",
    SpecialPoint.MERGER: "The fold curve turns round in the row parameter: two branches touch and reconnect.",
    SpecialPoint.EXTREMUM: "The grazing curve turns round in the row parameter: a contact state begins or ends.",
    SpecialPoint.DOUBLE_GRAZING: "The motion just touches both flanks.",
    SpecialPoint.RESONANCE: "The second frequency of a Neimark-Sacker boundary comes to 0, on a fold, or to half the "
    "motion's, on a period doubling: it ends there.",
    SpecialPoint.CORNER: "The bifurcating motion just touches a flank: the boundary has a corner.",
}


@dataclass(frozen=True)
class Piece:
    """The part of a boundary within one pair of zones of the contact angles, smooth to the end."""

    problem: Problem
    curve: Curve


@dataclass(frozen=True)
class BoundaryCurve:
    """One boundary; its k points are in order of arc length.

    Where the fold's motion touches a flank, the curve in (lambda_m, ..., p) has a corner: the point is stored twice
    (alike within rounding), with the slopes of arrival and of departure. So is the joint of a closed curve.

    Parameters
    ----------
    kind : Event
        FOLD, the grazing that happens along it, PERIOD_DOUBLING or NEIMARK_SACKER.
    points : (k, 5) array
        lambda_m, lambda_c, lambda_s, x, p.
    slopes : (k, 5) array
        Their derivatives by arc length.
    arclength : (k,) array
        In scaled unknowns, contact angles included.
    stable : (k,) int8 array
        1 where the motion is statically stable; 0 where it is not and along folds.
    special : (k,) int8 array
        `SpecialPoint`. A corner at which the curve reverses in the plane is FOLD_GRAZING where it arrives and CUSP
        where it departs.
    ends : tuple of EndReason
        Why it ends at its first and at its last point. RANGE_LEFT is the border of the plane, or a DOUBLE_GRAZING
        beyond which the motion has no contact (f_pm = 0: the balance does not determine the mean there).
    pieces : tuple of Piece
        What continuation computed, for those who need more points.
    seen : tuple of int
        Which components of the pieces' y are shown.
    """

    kind: Event
    points: np.ndarray
    slopes: np.ndarray
    arclength: np.ndarray
    stable: np.ndarray
    special: np.ndarray
    ends: tuple[EndReason, EndReason]
    pieces: tuple[Piece, ...] = field(repr=False, compare=False)
    seen: tuple[int, ...] = SEEN

    @property
    def x(self) -> np.ndarray:
        """First axis of the plane, (k,)."""
        return self.points[:, 3]

    @property
    def parameter(self) -> np.ndarray:
        """Second axis of the plane, (k,)."""
        return self.points[:, 4]

    @property
    def mean(self) -> np.ndarray:
        """lambda_m, (k,)."""
        return self.points[:, 0]

    @property
    def cos(self) -> np.ndarray:
        """lambda_c, (k,)."""
        return self.points[:, 1]

    @property
    def sin(self) -> np.ndarray:
        """lambda_s, (k,)."""
        return self.points[:, 2]

    @property
    def amplitude(self) -> np.ndarray:
        """lambda_a, (k,)."""
        return np.hypot(self.cos, self.sin)

    @property
    def closed(self) -> bool:
        """Whether the last point is the first one again."""
        return self.ends[1] is EndReason.CLOSED

    def crossings(self, values, continuation: Continuation | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Where the boundary meets given values of p, solved and not interpolated.

        Parameters
        ----------
        values : (v,) array_like
            Ascending.
        continuation : Continuation, optional
            Whose corrector is used.

        Returns
        -------
        column : (c,) int array
            Which value each place belongs to.
        points : (c, 5) array
            lambda_m, lambda_c, lambda_s, x, p.
        """
        values, continuation = np.asarray(values, dtype=float), continuation or Continuation()
        columns, points = [np.empty(0, np.int64)], [np.empty((0, 5))]
        for piece in self.pieces:
            column, unknowns, _ = curve_crossings(piece.problem, piece.curve, values, continuation)
            columns.append(column)
            points.append(np.column_stack([unknowns[:, self.seen[:-1]], values[column]]))
        return np.concatenate(columns), np.concatenate(points)

    def distances(self, points: np.ndarray, continuation: Continuation | None = None) -> np.ndarray:
        """Distance of points (n, 5) from the boundary in scaled unknowns, (n,); see `solver.boundaries.incidence`."""
        continuation = continuation or Continuation()
        if not self.pieces:
            return np.full(len(points), np.inf)
        targets = np.zeros((len(points), self.pieces[0].problem.unknowns + 1))
        targets[:, self.seen] = points
        pieces = [distances(piece.problem, piece.curve, targets, self.seen, continuation) for piece in self.pieces]
        return np.min(pieces, axis=0)

    def refined(
        self, x_step: float, p_step: float, window=None, continuation: Continuation | None = None
    ) -> np.ndarray:
        """Points (n, 5) no further apart than asked for in the plane, solved and not interpolated.

        Parameters
        ----------
        x_step, p_step : float
            Largest distance along each axis, > 0.
        window : (x_low, x_high, p_low, p_high), optional
            Only steps of the curve that may touch this part of the plane are divided.
        continuation : Continuation, optional
            Whose corrector is used.
        """
        continuation = continuation or Continuation()
        parts = [self.points[:1]] if not self.pieces else []
        for piece in self.pieces:
            places = piece.curve.points[:, self.seen[3:]]
            moves = np.abs(np.diff(places, axis=0))
            number = np.maximum(np.ceil(np.max(moves / [x_step, p_step], axis=1)), 1.0)
            if window is not None:
                # A step may bulge beyond its ends by about its own length where the curve turns.
                lowest = np.minimum(places[:-1], places[1:]) - moves
                highest = np.maximum(places[:-1], places[1:]) + moves
                near = (highest[:, 0] >= window[0]) & (lowest[:, 0] <= window[1])
                near &= (highest[:, 1] >= window[2]) & (lowest[:, 1] <= window[3])
                number = np.where(near, number, 1.0)
            parts.append(refined(piece.problem, piece.curve, number, continuation)[:, self.seen])
        return np.concatenate(parts)
