"""Whether a step of continuation may be taken: it may not leave the curve, nor hide a pair of events."""

import math

from solver.continuation.hermite import cubic, cubic_slope, cubic_value
from solver.continuation.setup import LIMITS, SETUP
from solver.continuation.solution_curve import Outcome
from solver.kernels import types
from solver.kernels.compile import ARRAY, kernel

__all__ = ["BRANCH_POINT_STEP", "LEAST", "is_level", "judge", "limited"]

_I, _F = types.int64, types.float64
_ACCEPTED, _TURNED, _STRAYED = int(Outcome.ACCEPTED), int(Outcome.TURNED), int(Outcome.STRAYED)
_FLIPPED, _HIDES_A_PAIR = int(Outcome.FLIPPED), int(Outcome.HIDES_A_PAIR)

#: Steps shorter than this many smallest ones are not examined for pairs of events: something has to be taken at last.
LEAST = 100.0

# The cubic through two points is not the curve. Where it comes closer to a pair of events than this share of its nearer
# end, the step is refused, until the ends themselves show whether there is one.
_CLEARANCE = 0.5

# Tangents that have less of p than this at both ends of a step run at constant p, as piecewise linear systems do over
# whole stretches; the sign of what is left is rounding's.
_LEVEL = 1e-12

#: A sign change of the bordered determinant is taken for a jump until the step is this small, then for a branch point.
BRANCH_POINT_STEP = 1e-4


@kernel(types.boolean(_F, _F, _F, _F), inline=True)
def _turns_twice(left, right, leave, arrive):
    """Does the cubic with these ends and slopes turn round inside, or nearly, although it leaves and arrives alike?"""
    a, b = cubic(left, right, leave, arrive)
    if leave * arrive <= 0.0 or a == 0.0:
        return False
    x = -b / (3.0 * a)
    slope = cubic_slope(a, b, leave, x) * math.copysign(1.0, leave)
    return 0.0 < x < 1.0 and slope < _CLEARANCE * min(abs(leave), abs(arrive))


@kernel(types.boolean(_F, _F, _F, _F), inner=True)
def _touches_zero(left, right, leave, arrive):
    """Does the cubic reach zero inside, or nearly, although both its ends lie on the same side of it?"""
    if left * right <= 0.0 or leave * left >= 0.0 or arrive * right <= 0.0:
        return False
    # One extremum towards zero: bisect the derivative, which changes sign once between the ends.
    a, b = cubic(left, right, leave, arrive)
    low, high = 0.0, 1.0
    for _ in range(30):
        x = 0.5 * (low + high)
        if cubic_slope(a, b, leave, x) * left < 0.0:
            low = x
        else:
            high = x
    lowest = cubic_value(a, b, leave, left, low) * math.copysign(1.0, left)
    return lowest < _CLEARANCE * min(abs(left), abs(right))


@kernel(types.boolean(SETUP, ARRAY, ARRAY), inline=True)
def is_level(setup, left, right):
    """Whether the curve runs at constant p between two points, to rounding.

    Parameters
    ----------
    setup : Setup
    left, right : point arrays
        Ends of the step.
    """
    slot = 2 * setup.unknowns + 1
    return abs(left[slot]) < _LEVEL and abs(right[slot]) < _LEVEL


@kernel(types.boolean(SETUP, LIMITS, ARRAY, ARRAY, _F), inner=True)
def _hides_a_pair(setup, limits, left, right, arc):
    """Would the curve between two points fold twice, or reach a grazing or a border of the box and come back?"""
    n, m = setup.unknowns, setup.test_count
    p = setup.scale[n]
    if not is_level(setup, left, right) and _turns_twice(
        left[n] / p, right[n] / p, arc * left[2 * n + 1], arc * right[2 * n + 1]
    ):
        return True
    for j in range(n + 1):
        leave, arrive = arc * left[n + 1 + j] * setup.scale[j], arc * right[n + 1 + j] * setup.scale[j]
        for level in (limits.low[j], limits.high[j]):
            if math.isfinite(level) and _touches_zero(left[j] - level, right[j] - level, leave, arrive):
                return True
    values, slopes = 2 * n + 2, 2 * n + 2 + m
    for i in range(1, m):
        if _touches_zero(left[values + i], right[values + i], arc * left[slopes + i], arc * right[slopes + i]):
            return True
    return False


@kernel(_I(SETUP, LIMITS, ARRAY, ARRAY, _F, _F, _F, _F), inner=True)
def judge(setup, limits, left, right, step, error, angle, arc):
    """Whether a corrected step may be taken, before anything is located on it: its `Outcome`.

    `error` is the distance of the corrected from the predicted point, `angle` that between the tangents.

    Parameters
    ----------
    setup : Setup
    limits : Limits
    left, right : point arrays
        Ends of the step.
    step : float
        Its length as tried, in scaled unknowns.
    error : float
        Distance of the corrected from the predicted point.
    angle : float
        Between the tangents, rad.
    arc : float
        Length of the step as taken.
    """
    if angle > limits.angle:
        return _TURNED
    if error > limits.distance * step:
        return _STRAYED
    if (left[-1] < 0.0) != (right[-1] < 0.0) and step > BRANCH_POINT_STEP:
        return _FLIPPED
    if step > LEAST * limits.smallest and _hides_a_pair(setup, limits, left, right, arc):
        return _HIDES_A_PAIR
    return _ACCEPTED


@kernel(_F(SETUP, LIMITS, ARRAY, _F), inline=True)
def limited(setup, limits, point, step):
    """The step within its bounds: absolute, per cent of the unknowns' size, and per move of p.

    Parameters
    ----------
    setup : Setup
    limits : Limits
    point : point array
        Where the step begins.
    step : float
        As it is wished for, in scaled unknowns.
    """
    n = setup.unknowns
    size = 0.0
    for j in range(n):
        size = max(size, abs(point[j] / setup.scale[j]))
    step = min(step, max(limits.largest, limits.growth * size))
    speed = abs(point[2 * n + 1]) * setup.scale[n]
    return min(step, limits.parameter / speed) if speed > 0.0 else step
