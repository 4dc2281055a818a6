"""Telling cusps, isola births and mergers apart where a fold curve turns round in the row parameter."""

import numpy as np

from solver.boundaries.contact_angles import BACK, FRONT, P, X, angle_rows, determinant, plane_coefficients
from solver.boundaries.curve import SpecialPoint
from solver.continuation.continuation import Curve, Problem

__all__ = ["static_determinant", "turning_point"]

# A turning point of the fold curve at which x stands still as well is a cusp. x and p are located to about 1e-12 of the
# tangent there; a cusp this close to an extremum is of higher codimension.
_STILL = 1e-6


def static_determinant(problem: Problem, y: np.ndarray) -> float:
    """det dE/du of the first-order balance at y (7,)."""
    known = plane_coefficients(problem.theta, problem.direction, y)
    return determinant(known, problem.theta, y, np.empty(7), np.empty((3, 3)))


def _multiplicity_grows(problem: Problem, y: np.ndarray) -> float:
    """Sign of the direction of p in which a fold's pair of solutions appears at fixed x.

    With null vectors J v = 0, w J = 0, the balance near a fold is w E_p dp + w E_uu[v, v] xi^2/2 = 0, so that the pair
    exists where dp has the sign of -(w E_p)(w E_uu[v, v]). As adj J = s v w and, by Jacobi's formula,
    d det J [v] = s w E_uu[v, v], the product is (d det J [v]) (v . adj(J) E_p), whatever the signs of v and w.
    """
    jacobian, square, gradient = np.empty((5, 7)), np.empty((3, 3)), np.empty(7)
    known = plane_coefficients(problem.theta, problem.direction, y)
    angle_rows(known, problem.theta, y, np.empty(5), jacobian)
    determinant(known, problem.theta, y, gradient, square)
    angles = slice(FRONT, BACK + 1)
    slopes = np.diag(jacobian[3:5, angles])
    by_angle = -jacobian[3:5] / slopes[:, None]
    v = np.linalg.svd(square)[2][-1]
    along = gradient[:3] @ v + gradient[angles] @ (by_angle[:, :3] @ v)
    by_p = jacobian[:3, P] + jacobian[:3, angles] @ by_angle[:, P]
    columns = square.T
    adjugate = np.array([np.cross(columns[(i + 1) % 3], columns[(i + 2) % 3]) for i in range(3)])
    return -np.sign(along * (v @ adjugate @ by_p))


def turning_point(problem: Problem, curve: Curve, index: int) -> SpecialPoint:
    """What a fold curve does at an interior point where it turns round in p.

    Near an extremum p* of the fold curve the solutions at one p form a curve over xi (along v) and eta = x - x*,

        A xi^2/2 + B xi eta + C eta^2/2 + h (p - p*) = 0,    A = w E_uu[v, v],    h = w E_p.

    Its folds, A xi + B eta = 0, lie at p - p* = -(A C - B^2) eta^2/(2 h A), so that p'' of the fold curve has the sign
    of -h A (A C - B^2). Where the form is definite, A C > B^2, the curve shrinks to a point; otherwise it is a saddle,
    where two branches reconnect. No second derivative by x is needed to tell them apart: -h A is the direction of p in
    which pairs of solutions appear.
    """
    speed = curve.tangents[index, [X, P]]
    if np.max(np.abs(speed)) < _STILL:
        return SpecialPoint.CUSP
    bends = np.sign(curve.tangents[index + 1, P] - curve.tangents[index - 1, P])
    definite = bends * _multiplicity_grows(problem, curve.points[index]) > 0.0
    return SpecialPoint.ISOLA if definite else SpecialPoint.MERGER
