"""One bifurcation curve out of the pieces that continuation traced, with its special points named."""

import numpy as np

from solver.boundaries.bifurcation_plane import BifurcationPlane
from solver.boundaries.curve import BoundaryCurve, Piece, SpecialPoint
from solver.continuation.continuation import Curve, EndReason, Event

__all__ = ["named_points"]

# A turning point of a fold curve at which x stands still as well is a cusp.
_STILL = 1e-6


def named_points(
    plane: BifurcationPlane, kind: Event, pieces: list[Piece], ends: tuple[EndReason, EndReason]
) -> BoundaryCurve:
    """One curve of its pieces, which follow each other, with the special points named."""
    shown, points, slopes, lengths, special, stable = list(plane.seen(kind)), [], [], [], [], []
    travelled, joint = 0.0, ends[1] is EndReason.CLOSED and len(pieces) > 1
    for number, piece in enumerate(pieces):
        curve = piece.curve
        codes = np.zeros(len(curve.points), np.int8)
        for i in np.flatnonzero(curve.event):
            if curve.event[i] == Event.FOLD:
                codes[i] = _turning_point(plane, kind, piece, curve, i)
            elif curve.event[i] != Event.BRANCH_POINT:
                codes[i] = SpecialPoint.FOLD_GRAZING
        if number > 0 or joint:
            codes[0] = _departure(kind, pieces[number - 1].curve, curve)
        if (number < len(pieces) - 1 or joint) and curve.ends[1] is EndReason.STEP_TOO_SMALL:
            codes[-1] = SpecialPoint.FOLD_GRAZING if kind is Event.FOLD else SpecialPoint.CORNER
        points.append(curve.points[:, shown])
        slopes.append((curve.tangents * piece.problem.scale)[:, shown])
        lengths.append(travelled + curve.arclength)
        travelled = lengths[-1][-1]
        special.append(codes)
        determinants = [0.0 if kind is Event.FOLD else plane.static_determinant(kind, y) for y in curve.points]
        stable.append((np.array(determinants) > 0.0) & (codes != SpecialPoint.FOLD_GRAZING))
    codes, points = np.concatenate(special), np.concatenate(points)
    borders = np.array([plane.x_range, plane.p_range])
    for end, place in zip(ends, (0, -1), strict=True):
        if end is EndReason.RANGE_LEFT:
            outside = np.any(points[place, 3:, None] == borders)
            # What a Neimark-Sacker leaves elsewhere is the range of its second frequency.
            codes[place] = SpecialPoint.BORDER if outside else SpecialPoint.RESONANCE
    return BoundaryCurve(
        kind,
        points,
        np.concatenate(slopes),
        np.concatenate(lengths),
        np.concatenate(stable).astype(np.int8),
        codes,
        ends,
        tuple(pieces),
        plane.seen(kind),
    )


def _departure(kind: Event, before: Curve, after: Curve) -> SpecialPoint:
    """What a fold curve does at a corner: where it reverses in the plane, two folds meet."""
    if kind is Event.FOLD and before.tangents[-1, -2:] @ after.tangents[0, -2:] < 0.0:
        return SpecialPoint.CUSP
    return SpecialPoint.NONE


def _turning_point(plane: BifurcationPlane, kind: Event, piece: Piece, curve: Curve, index: int) -> SpecialPoint:
    """What a curve does at an interior point where it turns round in p; for folds see `solver.boundaries.special`."""
    if kind is not Event.FOLD:
        return SpecialPoint.EXTREMUM
    if np.max(np.abs(curve.tangents[index, -2:])) < _STILL:
        return SpecialPoint.CUSP
    bends = np.sign(curve.tangents[index + 1, -1] - curve.tangents[index - 1, -1])
    definite = bends * _multiplicity_grows(plane, piece, curve.points[index]) > 0.0
    return SpecialPoint.ISOLA if definite else SpecialPoint.MERGER


def _multiplicity_grows(plane: BifurcationPlane, piece: Piece, y: np.ndarray) -> float:
    """Sign of the direction of p in which a fold's pair of solutions appears at fixed x, as in
    `solver.boundaries.special`.

    It is that of -(d det J [v]) (v . adj(J) E_p) with the null vector v of J = dE/du. From J = W S V^T with its last
    singular value 0, adj J is v w^T times det(W) det(V) and the other singular values; w is the left null vector.
    """
    n = plane.balance.unknowns
    problem = piece.problem
    jacobian = np.empty((n + 1, n + 2))
    problem.balance(problem.theta, problem.direction, y, np.empty(n + 1), jacobian)
    left, _, right = np.linalg.svd(jacobian[:n, :n])
    v, w = right[-1], left[:, -1]
    sign = np.sign(np.linalg.det(left) * np.linalg.det(right)) * plane.sign
    return -np.sign((jacobian[n, :n] @ v) * sign * (w @ jacobian[:n, n + 1]))
