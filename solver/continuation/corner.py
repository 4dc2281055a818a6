"""Round the corner of a curve where a contact begins or ends, however stiff the contact is.

Where an extremum of lambda touches a flank, the force of the new contact grows like d^(3/2) with its depth d, and the
Jacobian like k d^(1/2). The tangent is continuous, but turns within a stretch of length k^-2, which for a stiff contact
is far below any step. On the side of the contact the curve is analytic in sigma = d^(1/2), however:

    y = y_0 + a sigma^2 + b sigma^3 + ...

So the grazing itself is solved for (E = 0 and margin = 0, which is regular however stiff the contact is), then a point
beyond it that this cubic fits, and then points in between, placed by their depth instead of their arc: on planes of
constant depth the stiff part of the force is given. (Grazing of piecewise-smooth systems: di Bernardo, Budd, Champneys
and Kowalczyk, Piecewise-smooth Dynamical Systems, 2008.)
"""

import math

import numpy as np

from solver.continuation.correctors import advance, bordered
from solver.continuation.curve_point import angle_between, correct_onto_curve, observe_from, orient, scaled_distance
from solver.continuation.hermite import cubic, cubic_slope, cubic_value
from solver.continuation.setup import ANGLE, CONTACT_ROW, FLANK, LIMITS, MARGIN, SENSE, SETUP
from solver.continuation.solution_curve import Event
from solver.continuation.step_checks import BRANCH_POINT_STEP
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import copy_into, dot, eliminate

__all__ = ["CORNER_ROOM", "round_corner"]

_I, _F, _B = types.int64, types.float64, types.boolean
_INTS = types.int64[::1]
_FOLD, _BRANCH_POINT = int(Event.FOLD), int(Event.BRANCH_POINT)

#: Points that a corner may take.
CORNER_ROOM = 128

# How far from the last point, in steps that were refused, a grazing may lie to be held for the cause.
_REACH = 50.0
# Depths whose root is smaller than this are lost in rounding.
_SHALLOWEST = 1e-7
_MOST_ITERATIONS = 20
# Extrema of a motion, against both flanks.
_MOST_CONTACTS = 512
# What the corrector leaves of the margin of a grazing.
_TOUCHING = 1e-11
# How well place and tangent of a point must agree on the cubic, to be known for one of this curve.
_AGREEMENT = 0.1
# Of a point between two others: how far it may lie from their cubic, and what correcting it once more may move it by,
# as shares of its distance from them.
_STRAY, _NOISE = 0.3, 0.01
# Steps shorter than this may bend more sharply than usual where rounding allows no point in between, and a fold on them
# is where the cubic has it.
_FINE = 1e-8


@kernel(_I(SETUP, ARRAY, _F, _F, _F, MATRIX), inner=True)
def _nearest_row(setup, y, angle, flank, sense, rows):
    """Row of the extremum of a kind at a motion y that lies nearest to an angle; -1 if there is none."""
    best, least = -1, math.inf
    for k in range(setup.contacts(setup.parameters, setup.parameter_slope, y, rows)):
        if rows[k, FLANK] == flank and rows[k, SENSE] == sense:
            distance = abs(rows[k, ANGLE] - angle) % (2.0 * math.pi)
            distance = min(distance, 2.0 * math.pi - distance)
            if distance < least:
                best, least = k, distance
    return best


@kernel(_B(SETUP, ARRAY, _F, ARRAY, MATRIX, ARRAY, ARRAY), inner=True)
def _find_grazing(setup, here, distance, row, rows, corner, normal):
    """Solve E = 0, margin = 0 for y of `corner`, from `distance` along the tangent; `normal` points deeper."""
    n, scale = setup.unknowns, setup.scale
    y, angle = corner[: n + 1], row[ANGLE]
    jacobian, matrix = setup.work[0:n], setup.work[n : 2 * n + 1]
    residual, step = setup.work[2 * n + 1][:n], setup.work[2 * n + 2]
    for j in range(n + 1):
        y[j] = here[j] + distance * here[n + 1 + j] * scale[j]
    for _ in range(_MOST_ITERATIONS):
        k = _nearest_row(setup, y, angle, row[FLANK], row[SENSE], rows)
        if k < 0:
            return False
        angle = rows[k, ANGLE]
        for j in range(n + 1):
            normal[j] = rows[k, CONTACT_ROW + j] * scale[j]
        bordered(
            setup.residual_and_jacobian,
            setup.parameters,
            setup.parameter_slope,
            scale,
            y,
            normal,
            jacobian,
            residual,
            matrix,
        )
        for i in range(n):
            step[i] = -residual[i]
        step[n] = -rows[k, MARGIN]
        if eliminate(matrix, step) == 0.0:
            return False
        length = advance(y, scale, step)
        if not math.isfinite(length):
            return False
        # The margin is all but linear, and with it the rest: what is left is the square of this.
        if length <= 1e-8:
            size = row[SENSE] * math.sqrt(dot(normal, normal))
            for j in range(n + 1):
                normal[j] /= size
            return True
    return False


@kernel(_F(SETUP, ARRAY, ARRAY, ARRAY), inline=True)
def _depth(setup, corner, normal, point):
    """How deep beyond the grazing a point lies, along the scaled normal."""
    total = 0.0
    for j in range(setup.unknowns + 1):
        total += normal[j] * (point[j] - corner[j]) / setup.scale[j]
    return total


@kernel(types.void(SETUP, ARRAY, ARRAY, ARRAY, _F, _F, _F, ARRAY, ARRAY), inner=True)
def _cubic_point(setup, normal, left, right, first, last, x, y, tangent):
    """Fill y and an unscaled tangent at fraction x between two points at the roots of depth `first` and `last`."""
    n, scale = setup.unknowns, setup.scale
    # dy/d sigma = 2 sigma dy/dd, of which d = normal . y/scale.
    leaving = 2.0 * first * (last - first) / dot(normal, left[n + 1 : 2 * n + 2])
    arriving = 2.0 * last * (last - first) / dot(normal, right[n + 1 : 2 * n + 2])
    for j in range(n + 1):
        leave, arrive = leaving * left[n + 1 + j] * scale[j], arriving * right[n + 1 + j] * scale[j]
        a, b = cubic(left[j], right[j], leave, arrive)
        y[j], tangent[j] = cubic_value(a, b, leave, left[j], x), cubic_slope(a, b, leave, x) / scale[j]


@kernel(_F(SETUP, ARRAY, ARRAY), inner=True)
def _placed(setup, normal, point):
    """Correct the predicted y of a point on its plane of constant depth; what is left of the error, -1 if it fails."""
    n = setup.unknowns
    if correct_onto_curve(setup, point, normal) < 0:
        return -1.0
    # This makes the determinant that of the tangent's own border, too.
    before = point[: n + 1].copy()
    if not orient(setup, point, point[n + 1 : 2 * n + 2].copy()):
        return -1.0
    observe_from(setup, point)
    return scaled_distance(point, before, setup.scale)


@kernel(_B(SETUP, ARRAY, ARRAY, ARRAY), inner=True)
def _agrees(setup, corner, normal, point):
    """Whether the tangent of a point is that of y_0 + a sigma^2 + b sigma^3, with a of the grazing, b of the place."""
    n, scale = setup.unknowns, setup.scale
    depth = _depth(setup, corner, normal, point)
    at_corner, at_point = dot(normal, corner[n + 1 : 2 * n + 2]), dot(normal, point[n + 1 : 2 * n + 2])
    gap, size = 0.0, 0.0
    for j in range(n + 1):
        value = 3.0 * (point[j] - corner[j]) / scale[j] - depth * corner[n + 1 + j] / at_corner
        slope = 2.0 * depth * point[n + 1 + j] / at_point
        gap, size = gap + (value - slope) ** 2, size + slope * slope
    return depth > 0.0 and gap <= _AGREEMENT**2 * size


@kernel(_F(SETUP, ARRAY, ARRAY, _F, _F, ARRAY), inner=True)
def _find_beyond(setup, corner, normal, least, most, point):
    """Find a point beyond a corner, as deep as the cubic holds; the root of its depth, 0 if there is none."""
    n, scale = setup.unknowns, setup.scale
    along = dot(normal, corner[n + 1 : 2 * n + 2])
    sigma = most
    while sigma > least:
        for j in range(n + 1):
            point[j] = corner[j] + sigma * sigma * corner[n + 1 + j] * scale[j] / along
        if _placed(setup, normal, point) >= 0.0 and _agrees(setup, corner, normal, point):
            return math.sqrt(_depth(setup, corner, normal, point))
        sigma *= 0.5
    return 0.0


@kernel(_B(SETUP, ARRAY, ARRAY), inline=True)
def _flips(setup, left, right):
    """Whether another branch crosses between two points that are too far apart to take that for granted."""
    distance = scaled_distance(left, right, setup.scale)
    return (left[-1] < 0.0) != (right[-1] < 0.0) and distance > BRANCH_POINT_STEP


@kernel(types.void(MATRIX, ARRAY, _INTS, _I, _I), inner=True)
def _make_room(points, sigmas, kinds, count, at):
    """Move up the points from one place on."""
    for i in range(count, at, -1):
        copy_into(points[i], points[i - 1])
        sigmas[i], kinds[i] = sigmas[i - 1], kinds[i - 1]


@kernel(_I(SETUP, LIMITS, ARRAY, MATRIX, ARRAY, _INTS), inner=True)
def _fill(setup, limits, normal, points, sigmas, kinds):
    """Insert points between the first two until the tangent turns by no more than allowed: their number, or 0."""
    n, scale, count, k = setup.unknowns, setup.scale, 2, 0
    point, tangent = np.zeros(points.shape[1]), np.empty(n + 1)
    while k < count - 1:
        left, right = points[k], points[k + 1]
        if angle_between(setup, left, right) <= limits.angle and not _flips(setup, left, right):
            k += 1
            continue
        if count == points.shape[0]:
            return 0
        _cubic_point(setup, normal, left, right, sigmas[k], sigmas[k + 1], 0.5, point[: n + 1], tangent)
        predicted = point[: n + 1].copy()
        noise = _placed(setup, normal, point)
        distance = min(scaled_distance(left, point, scale), scaled_distance(point, right, scale))
        if not (0.0 <= noise <= _NOISE * distance and scaled_distance(point, predicted, scale) <= _STRAY * distance):
            if scaled_distance(left, right, scale) > _FINE:
                return 0
            k += 1
            continue
        _make_room(points, sigmas, kinds, count, k + 1)
        copy_into(points[k + 1], point)
        sigmas[k + 1], kinds[k + 1] = 0.5 * (sigmas[k] + sigmas[k + 1]), 0
        count += 1
    return count


@kernel(_I(SETUP, ARRAY, MATRIX, ARRAY, _INTS, _I), inner=True)
def _add_folds(setup, normal, points, sigmas, kinds, count):
    """Insert the folds on steps so short that the cubic is all one can know of them; the new number of points."""
    n, k = setup.unknowns, 0
    y, tangent = np.empty(n + 1), np.empty(n + 1)
    while k < count - 1 and count < points.shape[0]:
        left, right = points[k], points[k + 1]
        k += 1
        if left[2 * n + 1] * right[2 * n + 1] >= 0.0 or scaled_distance(left, right, setup.scale) > _FINE:
            continue
        low, high = 0.0, 1.0
        for _ in range(50):
            x = 0.5 * (low + high)
            _cubic_point(setup, normal, left, right, sigmas[k - 1], sigmas[k], x, y, tangent)
            if tangent[n] * right[2 * n + 1] < 0.0:
                low = x
            else:
                high = x
        _make_room(points, sigmas, kinds, count, k)
        tangent[n] = 0.0
        size, fold = math.sqrt(dot(tangent, tangent)), points[k]
        for j in range(n + 1):
            fold[j], fold[n + 1 + j] = y[j], tangent[j] / size
        fold[-1] = left[-1]
        observe_from(setup, fold)
        kinds[k], count, k = _FOLD, count + 1, k + 1
    return count


@kernel(types.void(SETUP, ARRAY), inner=True)
def _turn_round(setup, point):
    """Let the tangent of a point head the other way."""
    n, m = setup.unknowns, setup.test_count
    for j in range(n + 1, 2 * n + 2):
        point[j] = -point[j]
    for i in range(2 * n + 2 + m, 2 * n + 2 + 2 * m):
        point[i] = -point[i]
    point[-1] = -point[-1]


@kernel(types.void(SETUP, ARRAY), inner=True)
def _clear(setup, corner):
    """Set what vanishes at a grazing to 0 exactly: nothing where only a local extremum touches, perhaps two flanks."""
    values = 2 * setup.unknowns + 2
    for i in range(1, setup.test_count):
        if abs(corner[values + i]) <= _TOUCHING * setup.scale[0]:
            corner[values + i] = 0.0


@kernel(_I(SETUP, MATRIX, ARRAY, _INTS, _I, _I), inner=True)
def _mark_grazings(setup, points, sigmas, kinds, count, at):
    """Note the event at the grazing, at a point more for each further one; the new number of points."""
    values, marked = 2 * setup.unknowns + 2, 0
    for i in range(1, setup.test_count):
        if points[at, values + i] == 0.0 and count < points.shape[0]:
            if marked > 0:
                _make_room(points, sigmas, kinds, count, at)
                count += 1
            kinds[at] = _FOLD + i
            marked += 1
    return count


@kernel(_B(SETUP, LIMITS, ARRAY, ARRAY), inner=True)
def _leads_to(setup, limits, here, corner):
    """Whether the curve leads smoothly from a point without contact to the grazing."""
    n, ahead = setup.unknowns, 0.0
    for j in range(n + 1):
        ahead += (corner[j] - here[j]) / setup.scale[j] * here[n + 1 + j]
    straight = ahead >= scaled_distance(corner, here, setup.scale) * math.cos(limits.angle)
    return straight and angle_between(setup, here, corner) <= limits.angle and not _flips(setup, here, corner)


@kernel(_I(SETUP, LIMITS, ARRAY, _F, ARRAY, MATRIX, MATRIX, _INTS), inner=True)
def _round_one(setup, limits, here, step, row, rows, points, kinds):
    """As `round_corner`, for the grazing of one extremum."""
    n, size = setup.unknowns, here.shape[0]
    slope = 0.0
    for j in range(n + 1):
        slope += row[CONTACT_ROW + j] * setup.scale[j] * here[n + 1 + j]
    touching, deepening = row[SENSE] * row[MARGIN] >= 0.0, row[SENSE] * slope > 0.0
    if slope == 0.0 or abs(row[MARGIN]) > _REACH * step * abs(slope) or not (deepening or touching):
        return 0
    corner, normal = np.zeros(size), np.empty(n + 1)
    if not _find_grazing(setup, here, -row[MARGIN] / slope, row, rows, corner, normal):
        return 0
    if scaled_distance(corner, here, setup.scale) > _REACH * step or not orient(setup, corner, normal):
        return 0
    if not orient(setup, corner, corner[n + 1 : 2 * n + 2].copy()):
        return 0
    observe_from(setup, corner)
    _clear(setup, corner)
    sigmas = np.zeros(CORNER_ROOM)

    # What lies in the contact is found from the grazing outwards, with tangents that head there.
    first, beyond = corner, here.copy()
    sigma = math.sqrt(max(_depth(setup, corner, normal, here), 0.0))
    if not deepening:
        _turn_round(setup, beyond)
        sigmas[1] = sigma if _agrees(setup, corner, normal, beyond) else 0.0
    else:
        if touching and sigma > 0.0:
            first, sigmas[0] = here, sigma
        most = max(math.sqrt(step * dot(normal, corner[n + 1 : 2 * n + 2])), 8.0 * sigma)
        sigmas[1] = _find_beyond(setup, corner, normal, max(1.1 * sigma, _SHALLOWEST), most, beyond)
    if sigmas[1] == 0.0 or (not touching and not _leads_to(setup, limits, here, corner)):
        return 0
    copy_into(points[0], first)
    copy_into(points[1], beyond)
    kinds[0], kinds[1] = 0, 0
    count = _fill(setup, limits, normal, points, sigmas, kinds)
    if count == 0:
        return 0
    count = _add_folds(setup, normal, points, sigmas, kinds, count)
    if not deepening:
        # Out of the contact: the other way round.
        for k in range(count // 2):
            kinds[k], kinds[count - 1 - k] = kinds[count - 1 - k], kinds[k]
            for j in range(size):
                points[k, j], points[count - 1 - k, j] = points[count - 1 - k, j], points[k, j]
        for k in range(count):
            _turn_round(setup, points[k])
        count = _mark_grazings(setup, points, sigmas, kinds, count, count - 1)
    if not touching:
        count = _mark_grazings(setup, points, sigmas, kinds, count, 0)
    else:
        # The first point is the one that is here already.
        count -= 1
        for k in range(count):
            copy_into(points[k], points[k + 1])
            kinds[k] = kinds[k + 1]
    negative = here[-1] < 0.0
    for k in range(count):
        if (points[k, size - 1] < 0.0) != negative and kinds[k] == 0:
            kinds[k], negative = _BRANCH_POINT, not negative
    return count


@kernel(_I(SETUP, LIMITS, ARRAY, _F, MATRIX, _INTS), inner=True)
def round_corner(setup, limits, here, step, points, kinds):
    """Points that lead round the corner next to a point of the curve, where steps are refused for no other reason.

    Parameters
    ----------
    setup, limits
    here : point array
    step : float
        The step that was refused last.
    points : (CORNER_ROOM, size) array
        Filled with the points that follow `here` in order.
    kinds : (CORNER_ROOM,) int array
        Filled with the `Event` of each: a grazing's at the corner.

    Returns
    -------
    int
        Number of points, 0 if no grazing is near or the corner was not passed.
    """
    n = setup.unknowns
    rows, others = np.empty((_MOST_CONTACTS, CONTACT_ROW + n + 1)), np.empty((_MOST_CONTACTS, CONTACT_ROW + n + 1))
    total = setup.contacts(setup.parameters, setup.parameter_slope, here[: n + 1], rows)
    for _ in range(total):
        nearest = -1
        for k in range(total):
            if math.isfinite(rows[k, MARGIN]) and (nearest < 0 or abs(rows[k, MARGIN]) < abs(rows[nearest, MARGIN])):
                nearest = k
        if nearest < 0:
            return 0
        count = _round_one(setup, limits, here, step, rows[nearest], others, points, kinds)
        if count > 0:
            return count
        rows[nearest, MARGIN] = math.inf
    return 0
