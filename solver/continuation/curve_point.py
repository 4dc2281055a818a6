"""Points of a solution curve: correcting onto it, between two known points, and where a function along it vanishes.

A `point` is one array that holds everything known about a place on the curve (n unknowns, m test functions):

    y (n + 1) | unit tangent, scaled (n + 1) | test functions (m) | their derivatives along the arc (m) | determinant

The determinant is that of the scaled Jacobian bordered by a vector near the tangent; with the tangent's last component
it gives the sign of det dE/du.
"""

import math

import numpy as np

from solver.continuation.correctors import bordered
from solver.continuation.hermite import cubic, cubic_slope, cubic_value
from solver.continuation.setup import SETUP
from solver.kernels import types
from solver.kernels.compile import ARRAY, kernel
from solver.kernels.linear import dot, eliminate_rows

__all__ = [
    "angle_between",
    "correct_onto_curve",
    "locate",
    "observe_from",
    "orient",
    "point_size",
    "scaled_distance",
    "snap_to_level",
    "state_at",
]

_I, _F = types.int64, types.float64


@kernel(_I(SETUP), inline=True)
def point_size(setup):
    """Length of a point array."""
    return 2 * (setup.unknowns + 1) + 2 * setup.test_count + 1


@kernel(_F(ARRAY, ARRAY, ARRAY), inline=True)
def scaled_distance(left, right, scale):
    """Distance of two points' y in scaled unknowns.

    Parameters
    ----------
    left, right : (n + 1,) arrays
        Or point arrays, which begin with y.
    scale : (n + 1,) array
        Typical size of every unknown and of p.
    """
    total = 0.0
    for j in range(scale.shape[0]):
        total += ((left[j] - right[j]) / scale[j]) ** 2
    return math.sqrt(total)


@kernel(_F(SETUP, ARRAY, ARRAY), inline=True)
def angle_between(setup, left, right):
    """Angle between the tangents of two points.

    Parameters
    ----------
    setup : Setup
    left, right : point arrays
    """
    n = setup.unknowns
    return math.acos(min(max(dot(left[n + 1 : 2 * n + 2], right[n + 1 : 2 * n + 2]), -1.0), 1.0))


@kernel(types.boolean(SETUP, ARRAY, ARRAY), inner=True)
def orient(setup, point, border):
    """Fill in tangent (on the side of `border`) and determinant at the point's y; False if the Jacobian is singular.

    The Jacobian is at hand, so y gets one more Newton correction across `border` on the way: whatever corrector brought
    it here, what is left of its error is squared.

    Parameters
    ----------
    setup : Setup
    point : point array
        At a solution; its tangent and determinant are filled.
    border : (n + 1,) array
        To which side the tangent points, in scaled unknowns.
    """
    n = setup.unknowns
    y, tangent = point[: n + 1], point[n + 1 : 2 * n + 2]
    jacobian, matrix = setup.work[0:n], setup.work[n : 2 * n + 1]
    residual, rights = setup.work[2 * n + 1][:n], setup.work[2 * n + 2 : 2 * n + 4]
    bordered(
        setup.residual_and_jacobian,
        setup.parameters,
        setup.parameter_slope,
        setup.scale,
        y,
        border,
        jacobian,
        residual,
        matrix,
    )
    for j in range(n):
        rights[0, j], rights[1, j] = 0.0, -residual[j]
    rights[0, n], rights[1, n] = 1.0, 0.0
    determinant = eliminate_rows(matrix, rights)
    length = 0.0
    for j in range(n + 1):
        length += rights[0, j] * rights[0, j]
    if determinant == 0.0 or length == 0.0 or not math.isfinite(length):
        return False
    length = math.sqrt(length)
    for j in range(n + 1):
        tangent[j] = rights[0, j] / length
        y[j] += rights[1, j] * setup.scale[j]
    point[-1] = determinant
    return True


@kernel(types.void(SETUP, ARRAY), inner=True)
def observe_from(setup, point):
    """Fill in test functions and slopes from the point's y and tangent."""
    n, m = setup.unknowns, setup.test_count
    y, tangent = point[: n + 1], point[n + 1 : 2 * n + 2]
    values, slopes = point[2 * n + 2 : 2 * n + 2 + m], point[2 * n + 2 + m : 2 * n + 2 + 2 * m]
    setup.test_functions(setup.parameters, setup.parameter_slope, y, values, setup.gradient)
    for i in range(m):
        total = 0.0
        for j in range(n + 1):
            total += setup.gradient[i, j] * setup.scale[j] * tangent[j]
        slopes[i] = total


@kernel(_I(SETUP, ARRAY, ARRAY), inner=True)
def correct_onto_curve(setup, point, normal):
    """Correct the predicted y of `point` on the hyperplane across `normal`; fill in tangent and determinant.

    The test functions's part of the point is left to `observe_from`. Returns the corrector's iterations, or -1.

    Parameters
    ----------
    setup : Setup
    point : array
        Begins with y, which is corrected.
    normal : (n + 1,) array
        Across the hyperplane, in scaled unknowns.
    """
    iterations = setup.corrector(
        setup.residual_and_jacobian,
        setup.parameters,
        setup.parameter_slope,
        setup.scale,
        point[: setup.unknowns + 1],
        normal,
        setup.tolerance,
        setup.limit,
        setup.work,
    )
    if iterations < 0 or not orient(setup, point, normal):
        return -1
    return iterations


@kernel(_I(SETUP, ARRAY, ARRAY, _F, _F, ARRAY), inner=True, shared=True)
def state_at(setup, left, right, arc, x, point):
    """The point at fraction x of the way from `left` to `right`, guided by the cubic through both ends and tangents.

    Parameters
    ----------
    setup : Setup
    left, right : point arrays
        Ends of the step.
    arc : float
        Its length in scaled unknowns.
    x : float
        Fraction of it, from 0 to 1.
    point : point array
        Filled.
    """
    n = setup.unknowns
    normal = np.empty(n + 1)
    for j in range(n + 1):
        start, end = left[j] / setup.scale[j], right[j] / setup.scale[j]
        leave, arrive = arc * left[n + 1 + j], arc * right[n + 1 + j]
        a, b = cubic(start, end, leave, arrive)
        point[j] = setup.scale[j] * cubic_value(a, b, leave, start, x)
        normal[j] = cubic_slope(a, b, leave, x)
    size = math.sqrt(dot(normal, normal))
    for j in range(n + 1):
        normal[j] /= size
    iterations = correct_onto_curve(setup, point, normal)
    if iterations >= 0:
        observe_from(setup, point)
    return iterations


@kernel(_F(SETUP, ARRAY, ARRAY, _F, _I, ARRAY, _F, ARRAY), inner=True)
def locate(setup, left, right, arc, slot, factors, level, point):
    """Find where a linear function of the point array equals `level` between two points of the curve.

    Parameters
    ----------
    setup : Setup
    left, right : point arrays
        Between which the function crosses the level.
    arc : float
        Length of curve between them.
    slot : int
        Index into the point array whose entry is the function, or -1 for the projection on `factors`.
    factors : (n + 1,) array
        With slot -1 the function is factors . y.
    level : float
        What the function shall equal.
    point : point array
        Filled with the place found.

    Returns
    -------
    float
        The fraction of the arc at which it was found; -1 if the corrector failed or the function jumps.
    """
    n = setup.unknowns
    if slot >= 0:
        g_low, g_high = left[slot] - level, right[slot] - level
    else:
        g_low, g_high = dot(factors, left[: n + 1]) - level, dot(factors, right[: n + 1]) - level
    low, high, side = 0.0, 1.0, 0
    reference = max(abs(g_low), abs(g_high))
    x, g = 0.0, reference
    for _ in range(80):
        # Illinois variant of regula falsi, kept off the ends of the bracket so that a nearly exact end cannot stall it.
        x = (low * g_high - high * g_low) / (g_high - g_low)
        margin = 1e-3 * (high - low)
        x = min(max(x, low + margin), high - margin)
        if state_at(setup, left, right, arc, x, point) < 0:
            return -1.0
        g = (point[slot] if slot >= 0 else dot(factors, point[: n + 1])) - level
        # Steps round a corner may be shorter than what rounding leaves of a place on them.
        if abs(g) <= 1e-14 * reference or ((high - low) * arc <= 1e-13 and high - low <= 1e-4):
            break
        if g * g_high < 0.0:
            low, g_low = x, g
            if side == -1:
                g_high *= 0.5
            side = -1
        else:
            high, g_high = x, g
            if side == 1:
                g_low *= 0.5
            side = 1
    return x if abs(g) <= 1e-3 * reference else -1.0


@kernel(types.void(SETUP, ARRAY, _I, _F), inner=True)
def snap_to_level(setup, point, slot, level):
    """Move a point that lies within rounding of y[slot] = level onto it, unless the curve is tangent to that plane.

    Parameters
    ----------
    setup : Setup
    point : point array
        Whose y is overwritten in one component.
    slot : int
        Of that component.
    level : float
        Its value.
    """
    n = setup.unknowns
    normal, snapped = np.zeros(n + 1), point.copy()
    normal[slot] = 1.0
    snapped[slot] = level
    if correct_onto_curve(setup, snapped, normal) > 0:
        moved, sense = 0.0, 0.0
        for j in range(n + 1):
            moved = max(moved, abs((snapped[j] - point[j]) / setup.scale[j]))
            sense += snapped[n + 1 + j] * point[n + 1 + j]
        if moved < 1e-6:
            sign = 1.0 if sense >= 0.0 else -1.0
            for j in range(n + 1):
                point[j] = snapped[j]
                point[n + 1 + j] = sign * snapped[n + 1 + j]
            point[-1] = sign * snapped[-1]
            observe_from(setup, point)
    point[slot] = level
