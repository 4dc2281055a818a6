"""One boundary out of the pieces that continuation traced, with its special points named."""

import numpy as np

from solver.boundaries.contact_angles import P, X
from solver.boundaries.curve import SEEN, BoundaryCurve, Piece, SpecialPoint
from solver.boundaries.plane import Plane
from solver.boundaries.special import static_determinant, turning_point
from solver.continuation.continuation import EndReason, Event

__all__ = ["assembled", "unfollowed"]


def unfollowed(kind: Event, point: np.ndarray) -> BoundaryCurve:
    """A start from which no boundary could be followed."""
    nothing = np.zeros(1, np.int8)
    return BoundaryCurve(
        kind, point[None], np.zeros((1, 5)), np.zeros(1), nothing, nothing, (EndReason.STEP_TOO_SMALL,) * 2, ()
    )


def assembled(plane: Plane, kind: Event, pieces: list[Piece], ends: tuple[EndReason, EndReason]) -> BoundaryCurve:
    """One curve of its pieces, which follow each other, with the special points named."""
    shown, points, slopes, lengths, special, stable = list(SEEN), [], [], [], [], []
    travelled, closed = 0.0, ends[1] is EndReason.CLOSED
    for number, piece in enumerate(pieces):
        curve, scale = piece.curve, piece.problem.scale
        codes = np.zeros(len(curve.points), np.int8)
        for i in np.flatnonzero(curve.event):
            if kind is not Event.FOLD:
                codes[i] = SpecialPoint.EXTREMUM if curve.event[i] == Event.FOLD else SpecialPoint.FOLD_GRAZING
            elif curve.event[i] == Event.FOLD:
                codes[i] = turning_point(piece.problem, curve, i)
        joined = closed and len(pieces) > 1
        if kind is Event.FOLD and (number > 0 or joined):
            before, tangent = pieces[number - 1].curve.tangents[-1, [X, P]], curve.tangents[0, [X, P]]
            codes[0] = SpecialPoint.CUSP if before @ tangent < 0.0 else SpecialPoint.NONE
        if number < len(pieces) - 1 or joined:
            codes[-1] = SpecialPoint.FOLD_GRAZING if kind is Event.FOLD else SpecialPoint.DOUBLE_GRAZING
        points.append(curve.points[:, shown])
        slopes.append((curve.tangents * scale)[:, shown])
        lengths.append(travelled + curve.arclength)
        travelled = lengths[-1][-1]
        special.append(codes)
        determinants = [0.0 if kind is Event.FOLD else static_determinant(piece.problem, y) for y in curve.points]
        stable.append((np.array(determinants) > 0.0) & (codes != SpecialPoint.FOLD_GRAZING))
    codes = np.concatenate(special)
    points = np.concatenate(points)
    borders = np.array([plane.x_range, plane.p_range])
    for end, place in zip(ends, (0, -1), strict=True):
        if end is EndReason.RANGE_LEFT:
            outside = np.any(points[place, 3:, None] == borders)
            # What ends elsewhere ends where contact does.
            codes[place] = SpecialPoint.BORDER if outside else SpecialPoint.DOUBLE_GRAZING
    return BoundaryCurve(
        kind,
        points,
        np.concatenate(slopes),
        np.concatenate(lengths),
        np.concatenate(stable).astype(np.int8),
        codes,
        ends,
        tuple(pieces),
    )
