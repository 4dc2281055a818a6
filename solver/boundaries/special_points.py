"""What is special about points of a boundary: their names, and how they are told apart."""

import numpy as np

from solver.boundaries.problem import SPECTRAL, BoundaryProblem, Plane, Stretch
from solver.continuation.continuation import Event
from solver.explained import Explained

__all__ = ["SpecialPoint", "end_of", "joint", "named_points"]

# A turning point of a fold curve at which x stands still as well is a cusp. x and p are located to about 1e-12 of the
# tangent there; a cusp this close to an extremum is of higher codimension.
_STILL = 1e-6


class SpecialPoint(Explained):
    """What is special about a point of a boundary."""

    NONE = 0, "A regular point."
    BORDER = 1, "The boundary leaves the plane here."
    CUSP = 2, "Two folds meet and end: beyond it the jump is gone."
    FOLD_GRAZING = 3, "The folding motion just touches a flank: the jump changes its contact state."
    ISOLA = 4, "The fold curve turns round in the row parameter: an isolated branch shrinks to a point."
    MERGER = 5, "The fold curve turns round in the row parameter: two branches touch and reconnect."
    EXTREMUM = 6, "The boundary turns round in the row parameter: what happens along it begins or ends there."
    DOUBLE_GRAZING = 7, "The motion just touches both flanks."
    RESONANCE_1_1 = 8, "The critical pair of multipliers meets at 1: the Neimark-Sacker boundary ends."
    CORNER = 9, "The bifurcating motion just touches a flank: the boundary has a corner."
    RESONANCE_1_2 = 10, "The critical pair meets at -1: the Neimark-Sacker boundary ends on a period doubling."
    FOLD_CROSSING = 11, "The bifurcating motion folds as well: beyond, it is statically unstable."


def named_points(boundary: BoundaryProblem, kind: Event, stretch: Stretch) -> np.ndarray:
    """`SpecialPoint` of every point of a stretch, without regard to its ends: (k,) int8 array.

    Parameters
    ----------
    boundary : BoundaryProblem
    kind : Event
    stretch : Stretch
        Of k points.
    """
    codes = np.zeros(len(stretch.curve.points), np.int8)
    for i in np.flatnonzero(stretch.curve.event):
        if stretch.curve.event[i] == Event.FOLD:
            codes[i] = _turning_point(boundary, stretch, i) if kind is Event.FOLD else SpecialPoint.EXTREMUM
        elif stretch.curve.event[i] != Event.BRANCH_POINT:
            codes[i] = SpecialPoint.FOLD_CROSSING if kind in SPECTRAL else SpecialPoint.FOLD_GRAZING
    return codes


def joint(kind: Event, before: Stretch, after: Stretch) -> tuple[SpecialPoint, SpecialPoint]:
    """What the last point of a stretch is, and the first point of the one that follows.

    A fold curve that reverses in the plane has a cusp there: two folds meet.

    Parameters
    ----------
    kind : Event
    before, after : Stretch
    """
    if kind in SPECTRAL:
        return SpecialPoint.CORNER, SpecialPoint.NONE
    if kind is not Event.FOLD:
        return SpecialPoint.DOUBLE_GRAZING, SpecialPoint.NONE
    reversing = before.curve.tangents[-1, -2:] @ after.curve.tangents[0, -2:] < 0.0
    return SpecialPoint.FOLD_GRAZING, SpecialPoint.CUSP if reversing else SpecialPoint.NONE


def end_of(plane: Plane, kind: Event, y: np.ndarray) -> SpecialPoint:
    """What the end of a boundary that leaves its box is.

    Parameters
    ----------
    plane : Plane
    kind : Event
    y : array
        (..., x, p).
    """
    if np.any(y[-2:, None] == np.array([plane.x_range, plane.p_range])):
        return SpecialPoint.BORDER
    # What ends elsewhere ends where contact does, or where the critical pair becomes real.
    if kind is not Event.NEIMARK_SACKER:
        return SpecialPoint.DOUBLE_GRAZING
    return SpecialPoint.RESONANCE_1_1 if y[-3] > 0.0 else SpecialPoint.RESONANCE_1_2


def _pairs_appear(boundary: BoundaryProblem, stretch: Stretch, y: np.ndarray) -> float:
    """Sign of the direction of p in which a fold's pair of solutions appears at fixed x.

    With null vectors J v = 0, w J = 0, the balance near a fold is w E_p dp + w E_uu[v, v] xi^2/2 = 0, so that the pair
    exists where dp has the sign of -(w E_p)(w E_uu[v, v]). As adj J = s v w and, by Jacobi's formula,
    d det J [v] = s w E_uu[v, v], the product is (d det J [v]) s (w E_p), whatever the signs of v and w. From
    J = W S V^T with its last singular value 0, s is det(W) det(V) times the other singular values.
    """
    square, by_p, gradient = boundary.fold_rows(stretch.problem, y)
    left, _, right = np.linalg.svd(square)
    v, w = right[-1], left[:, -1]
    sign = np.sign(np.linalg.det(left) * np.linalg.det(right))
    return -np.sign((gradient @ v) * sign * (w @ by_p))


def _turning_point(boundary: BoundaryProblem, stretch: Stretch, index: int) -> SpecialPoint:
    """What a fold curve does at an interior point where it turns round in p.

    Near an extremum p* of the fold curve the solutions at one p form a curve over xi (along v) and eta = x - x*,

        A xi^2/2 + B xi eta + C eta^2/2 + h (p - p*) = 0,    A = w E_uu[v, v],    h = w E_p.

    Its folds, A xi + B eta = 0, lie at p - p* = -(A C - B^2) eta^2/(2 h A), so that p'' of the fold curve has the sign
    of -h A (A C - B^2). Where the form is definite, A C > B^2, the curve shrinks to a point; otherwise it is a saddle,
    where two branches reconnect. No second derivative by x is needed to tell them apart: -h A is the direction of p in
    which pairs of solutions appear.
    """
    curve = stretch.curve
    if np.max(np.abs(curve.tangents[index, -2:])) < _STILL:
        return SpecialPoint.CUSP
    bends = np.sign(curve.tangents[index + 1, -1] - curve.tangents[index - 1, -1])
    definite = bends * _pairs_appear(boundary, stretch, curve.points[index]) > 0.0
    return SpecialPoint.ISOLA if definite else SpecialPoint.MERGER
