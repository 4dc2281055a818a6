"""The compiled loop of pseudo-arc-length continuation; `solver.continuation.continuation` says what it promises."""

import math

import numpy as np

from solver.continuation.curve_point import SETUP, Setup, land, locate, observe_from, orient, point_size
from solver.kernels import types
from solver.kernels.compile import ARRAY, BALANCE, CORRECTOR, FLAGS, MATRIX, MONITOR, kernel
from solver.kernels.linear import dot, put

__all__ = ["pin", "scaled_distance", "trace"]

_I, _F = types.int64, types.float64

# Slots of the settings array.
FIRST, LARGEST, SMALLEST, ANGLE, DISTANCE, PARAMETER, GROWTH, CEILING = range(8)

# End reasons and events, as numbered by `EndReason` and `Event`.
RANGE_LEFT, CLOSED, AMPLITUDE_CEILING, STEP_TOO_SMALL, ITERATION_LIMIT = range(1, 6)
FOLD, BRANCH_POINT = 1, 6

# What became of a step, as numbered by `Outcome`, and the columns of its row in a diary; the place tried follows them.
ACCEPTED, NOT_CORRECTED, TURNED, STRAYED, FLIPPED, HIDES_A_PAIR, NOT_LOCATED = range(7)
OUTCOME, STEP, ITERATIONS, STRAY, TURN, POINTS, PLACE = range(7)

# The cubic through two points is not the curve. Where it comes closer to a pair of events than this share of its nearer
# end, the step is refused, until the ends themselves show whether there is one.
_CLEARANCE = 0.5

# Tangents that have less of p than this at both ends of a step run at constant p, as piecewise linear systems do over
# whole stretches; the sign of what is left is rounding's.
_LEVEL = 1e-12

# A sign change of the bordered determinant is taken for a jump until the step is this small, then for a branch point.
_BRANCH_POINT_STEP = 1e-4


@kernel(types.boolean(_F, _F, _F, _F), inline=True)
def _turns_twice(left, right, leave, arrive):
    """Does the cubic with these ends and slopes turn round inside, or nearly, although it leaves and arrives alike?"""
    a = 3.0 * (2.0 * (left - right) + leave + arrive)
    b = 2.0 * (3.0 * (right - left) - 2.0 * leave - arrive)
    if leave * arrive <= 0.0 or a == 0.0:
        return False
    x = -0.5 * b / a
    slope = ((a * x + b) * x + leave) * math.copysign(1.0, leave)
    return 0.0 < x < 1.0 and slope < _CLEARANCE * min(abs(leave), abs(arrive))


@kernel(types.boolean(_F, _F, _F, _F), inline=True)
def _touches_zero(left, right, leave, arrive):
    """Does the cubic reach zero inside, or nearly, although both its ends lie on the same side of it?"""
    if left * right <= 0.0 or leave * left >= 0.0 or arrive * right <= 0.0:
        return False
    # One extremum towards zero: bisect the derivative, which changes sign once between the ends.
    a = 3.0 * (2.0 * (left - right) + leave + arrive)
    b = 2.0 * (3.0 * (right - left) - 2.0 * leave - arrive)
    low, high = 0.0, 1.0
    for _ in range(30):
        x = 0.5 * (low + high)
        if ((a * x + b) * x + leave) * left < 0.0:
            low = x
        else:
            high = x
    lowest = (((a * low / 3.0 + b / 2.0) * low + leave) * low + left) * math.copysign(1.0, left)
    return lowest < _CLEARANCE * min(abs(left), abs(right))


@kernel(_F(ARRAY, ARRAY, ARRAY), inline=True)
def scaled_distance(left, right, scale):
    """Distance of two points' y in scaled unknowns."""
    total = 0.0
    for j in range(scale.shape[0]):
        total += ((left[j] - right[j]) / scale[j]) ** 2
    return math.sqrt(total)


@kernel(types.boolean(ARRAY, ARRAY, ARRAY), inline=True)
def _coincide(left, right, scale):
    """Whether two points' y are the same up to what corrections leave."""
    furthest = 0.0
    for j in range(scale.shape[0]):
        furthest = max(furthest, abs((left[j] - right[j]) / scale[j]))
    return furthest < 1e-6


@kernel(types.boolean(ARRAY, ARRAY, ARRAY), inline=True)
def _inside(y, low, high):
    """Whether y lies in the box; its borders belong to it."""
    for j in range(low.shape[0]):  # noqa: SIM110 (kernels have no generators)
        if not low[j] <= y[j] <= high[j]:
            return False
    return True


@kernel(types.boolean(SETUP, ARRAY, ARRAY), inline=True)
def _level(setup, left, right):
    """Whether the curve runs at constant p between two points, to rounding."""
    slot = 2 * setup.unknowns + 1
    return abs(left[slot]) < _LEVEL and abs(right[slot]) < _LEVEL


@kernel(types.boolean(SETUP, ARRAY, ARRAY, _F, ARRAY, ARRAY), inner=True)
def _hides_a_pair(setup, left, right, arc, low, high):
    """Would the curve between two points fold twice, or reach a grazing or a border of the box and come back?"""
    n, m = setup.unknowns, setup.monitors
    p = setup.scale[n]
    if not _level(setup, left, right) and _turns_twice(
        left[n] / p, right[n] / p, arc * left[2 * n + 1], arc * right[2 * n + 1]
    ):
        return True
    for j in range(n + 1):
        leave, arrive = arc * left[n + 1 + j] * setup.scale[j], arc * right[n + 1 + j] * setup.scale[j]
        if math.isfinite(low[j]) and _touches_zero(left[j] - low[j], right[j] - low[j], leave, arrive):
            return True
        if math.isfinite(high[j]) and _touches_zero(left[j] - high[j], right[j] - high[j], leave, arrive):
            return True
    values, slopes = 2 * n + 2, 2 * n + 2 + m
    for i in range(1, m):
        if _touches_zero(left[values + i], right[values + i], arc * left[slopes + i], arc * right[slopes + i]):
            return True
    return False


@kernel(types.boolean(SETUP, ARRAY, MATRIX, types.int64[::1], _I), inner=True)
def _contradicts(setup, left, found, kinds, count):
    """Do the points of `count` located events, in order, show signs that the located events do not explain?"""
    n, m = setup.unknowns, setup.monitors
    for event in range(FOLD, FOLD + m):
        slot = 2 * n + 1 if event == FOLD else 2 * n + 2 + event - FOLD
        sign = left[slot]
        for k in range(count):
            if kinds[k] == event:
                sign = -sign
            elif found[k, slot] * sign < 0.0:
                return True
    return False


@kernel(_I(SETUP, ARRAY, ARRAY, _F, _F, MATRIX, ARRAY, types.int64[::1]), inner=True)
def _find_events(setup, left, right, arc, least, found, fractions, kinds):
    """Locate the fold and the grazings between two points, in order of arc.

    Their number; -1 if one was not found, or if (in steps longer than `least`) a pair of another kind lies around it.
    """
    n, m = setup.unknowns, setup.monitors
    count = 0
    for event in range(FOLD, FOLD + m):
        slot = 2 * n + 1 if event == FOLD else 2 * n + 2 + event - FOLD
        if left[slot] == 0.0 or left[slot] * right[slot] > 0.0 or (event == FOLD and _level(setup, left, right)):
            continue
        fraction = locate(setup, left, right, arc, slot, left[: n + 1], 0.0, found[count])
        if fraction < 0.0:
            return -1
        kinds[count], fractions[count] = event, fraction
        k = count
        while k > 0 and fractions[k - 1] > fractions[k]:
            fractions[k - 1], fractions[k] = fractions[k], fractions[k - 1]
            kinds[k - 1], kinds[k] = kinds[k], kinds[k - 1]
            for j in range(found.shape[1]):
                found[k - 1, j], found[k, j] = found[k, j], found[k - 1, j]
            k -= 1
        count += 1
    # A curve bends sharply where it grazes, and may fold twice there between two points that look harmless.
    if arc > least and _contradicts(setup, left, found, kinds, count):
        return -1
    return count


@kernel(types.void(SETUP, ARRAY, _I, _F), inner=True)
def pin(setup, point, slot, level):
    """Move a point that lies within rounding of y[slot] = level onto it, unless the curve is tangent to that plane."""
    n = setup.unknowns
    normal, pinned = np.zeros(n + 1), point.copy()
    normal[slot] = 1.0
    pinned[slot] = level
    if land(setup, pinned, normal) > 0 and _coincide(pinned, point, setup.scale):
        sign = 1.0 if dot(pinned[n + 1 : 2 * n + 2], point[n + 1 : 2 * n + 2]) >= 0.0 else -1.0
        for j in range(n + 1):
            point[j] = pinned[j]
            point[n + 1 + j] = sign * pinned[n + 1 + j]
        point[-1] = sign * pinned[-1]
        observe_from(setup, point)
    point[slot] = level


@kernel(types.Tuple((_I, _F))(SETUP, ARRAY, ARRAY, _F, _F, ARRAY, ARRAY, ARRAY, types.boolean, ARRAY), inner=True)
def _find_end(setup, left, right, arc, ceiling, low, high, home, away, found):
    """Does the curve end between two points? Reason (0 no, -1 not located) and fraction; `found` is the last point."""
    n = setup.unknowns
    reason, fraction = 0, 2.0
    near_home = away and scaled_distance(right, home, setup.scale) <= 2.0 * arc
    if _inside(right, low, high) and right[2 * n + 2] <= ceiling and not near_home:
        return reason, fraction
    plane, trial = home[n + 1 : 2 * n + 2] / setup.scale, found.copy()
    # One candidate for every component of y that leaves the box, then the return to the start, then the ceiling.
    for candidate in range(n + 3):
        slot, level, kind = -1, 0.0, RANGE_LEFT
        if candidate <= n:
            if low[candidate] <= right[candidate] <= high[candidate]:
                continue
            slot, level = candidate, high[candidate] if right[candidate] > high[candidate] else low[candidate]
        elif candidate == n + 1:
            kind, level = CLOSED, dot(plane, home[: n + 1])
            before, after = dot(plane, left[: n + 1]) - level, dot(plane, right[: n + 1]) - level
            if not near_home or before >= 0.0 or after < 0.0:
                continue
        else:
            if right[2 * n + 2] <= ceiling:
                continue
            kind, slot, level = AMPLITUDE_CEILING, 2 * n + 2, ceiling
        place = locate(setup, left, right, arc, slot, plane, level, trial)
        if place < 0.0:
            return -1, 0.0
        if kind == CLOSED and not _coincide(trial, home, setup.scale):
            continue
        if place < fraction:
            reason, fraction = kind, place
            put(found, trial)
            if kind == RANGE_LEFT:
                pin(setup, found, slot, level)
            elif kind == CLOSED:
                put(found, home)
    return reason, fraction


@kernel(types.boolean(SETUP, ARRAY, _I, _F, _I, MATRIX, MATRIX, ARRAY, FLAGS, FLAGS), inner=True)
def _record(setup, point, event, arc, count, points, tangents, arclength, stable, events):
    """Write one point of the branch; False if there is no room."""
    if count >= points.shape[0]:
        return False
    n = setup.unknowns
    put(points[count], point)
    put(tangents[count], point[n + 1 :])
    arclength[count], events[count] = arc, event
    stable[count] = 1 if event != FOLD and point[2 * n + 1] * point[-1] > 0.0 else 0
    return True


@kernel(_F(SETUP, ARRAY, ARRAY, _F), inline=True)
def _limited(setup, settings, point, step):
    """The step within its bounds: absolute, per cent of the unknowns' size, and per move of p."""
    n = setup.unknowns
    size = 0.0
    for j in range(n):
        size = max(size, abs(point[j] / setup.scale[j]))
    step = min(step, max(settings[LARGEST], settings[GROWTH] * size))
    speed = abs(point[2 * n + 1]) * setup.scale[n]
    return min(step, settings[PARAMETER] / speed) if speed > 0.0 else step


@kernel(_I(SETUP, ARRAY, _F, _F, _F, _F, types.boolean, _F, ARRAY, ARRAY, ARRAY, ARRAY), inner=True)
def _judged(setup, settings, step, error, angle, arc, flips, least, here, there, low, high):
    """Whether a corrected step may be taken, before anything is located on it."""
    if angle > settings[ANGLE]:
        return TURNED
    if error > settings[DISTANCE] * step:
        return STRAYED
    if flips and step > _BRANCH_POINT_STEP:
        return FLIPPED
    if step > least and _hides_a_pair(setup, here, there, arc, low, high):
        return HIDES_A_PAIR
    return ACCEPTED


@kernel(types.void(MATRIX, _I, _I, _F, _I, _F, _F, _I, ARRAY), inner=True)
def _note(diary, attempt, outcome, step, iterations, error, angle, count, y):
    """Write one step into the diary, as long as there is room."""
    if attempt < diary.shape[0]:
        diary[attempt, OUTCOME], diary[attempt, STEP], diary[attempt, ITERATIONS] = outcome, step, iterations
        diary[attempt, STRAY], diary[attempt, TURN], diary[attempt, POINTS] = error, angle, count
        put(diary[attempt, PLACE:], y)


@kernel(
    types.UniTuple(_I, 3)(
        CORRECTOR,
        _F,
        _I,
        BALANCE,
        MONITOR,
        ARRAY,
        ARRAY,
        ARRAY,
        _I,
        ARRAY,
        ARRAY,
        ARRAY,
        ARRAY,
        ARRAY,
        MATRIX,
        MATRIX,
        ARRAY,
        FLAGS,
        FLAGS,
        MATRIX,
    )
)
def trace(
    corrector,
    tolerance,
    limit,
    balance,
    monitor,
    theta,
    direction,
    scale,
    monitors,
    start,
    heading,
    settings,
    low,
    high,
    points,
    tangents,
    arclength,
    stable,
    events,
    diary,
):
    """Follow the curve from `start` (n + 1,) to the side that `heading` (n + 1,) points to until it ends.

    It ends where it leaves the box from `low` to `high` (n + 1,), infinite where a component is free; at once if
    `start` lies on its border and the curve heads out. Fills points and tangents (capacity, n + 1), arclength, stable
    and events (capacity,), and a row of `diary` (any number, PLACE + n + 1) for every step that was tried.

    Returns
    -------
    count, reason, refused : int
        Points written, end reason (`EndReason`) and steps refused.
    """
    n = start.shape[0] - 1
    setup = Setup(
        corrector,
        tolerance,
        limit,
        balance,
        monitor,
        theta,
        direction,
        scale,
        n,
        monitors,
        np.empty((3 * n + 6, n + 1)),
        np.empty((monitors, n + 1)),
    )
    size = point_size(setup)
    here, there, last, guess = np.zeros(size), np.zeros(size), np.zeros(size), np.zeros(n + 1)
    found, fractions, kinds = np.zeros((monitors, size)), np.empty(monitors), np.empty(monitors, np.int64)

    put(here[: n + 1], start)
    # The second call makes the determinant that of the tangent's own border, comparable with those that follow.
    if not orient(setup, here, heading) or not orient(setup, here, here[n + 1 : 2 * n + 2].copy()):
        return 0, STEP_TOO_SMALL, 0
    for j in range(n + 1):
        # What starts on the border of the box stays there, whatever the last correction does.
        if start[j] == low[j] or start[j] == high[j]:
            here[j] = start[j]
    observe_from(setup, here)
    home = here.copy()
    _record(setup, here, 0, 0.0, 0, points, tangents, arclength, stable, events)
    for j in range(n + 1):
        if (here[j] == low[j] and here[n + 1 + j] < 0.0) or (here[j] == high[j] and here[n + 1 + j] > 0.0):
            return 1, RANGE_LEFT, 0
    count, refused, attempts, travelled = 1, 0, 0, 0.0
    step, least = settings[FIRST], 100.0 * settings[SMALLEST]

    while True:
        step = _limited(setup, settings, here, step)
        if step < settings[SMALLEST]:
            return count, STEP_TOO_SMALL, refused
        tangent, tangent_there = here[n + 1 : 2 * n + 2], there[n + 1 : 2 * n + 2]
        for j in range(n + 1):
            guess[j] = here[j] + step * tangent[j] * scale[j]
            there[j] = guess[j]
        iterations = land(setup, there, tangent)
        outcome, error, angle, arc, flips = NOT_CORRECTED, math.nan, math.nan, 0.0, False
        if iterations >= 0:
            error, chord = scaled_distance(there, guess, scale), scaled_distance(there, here, scale)
            angle = math.acos(min(max(dot(tangent, tangent_there), -1.0), 1.0))
            arc = chord * (1.0 + angle * angle / 24.0)
            flips = here[-1] * there[-1] < 0.0
            outcome = _judged(setup, settings, step, error, angle, arc, flips, least, here, there, low, high)
        reason, end, located = 0, 2.0, 0
        if outcome == ACCEPTED:
            reason, end = _find_end(setup, here, there, arc, settings[CEILING], low, high, home, count > 3, last)
            located = _find_events(setup, here, there, arc, least, found, fractions, kinds) if reason >= 0 else -1
            outcome = ACCEPTED if located >= 0 else NOT_LOCATED
        attempts += 1
        if outcome != ACCEPTED:
            _note(diary, attempts - 1, outcome, step, iterations, error, angle, count, there[: n + 1])
            refused += 1
            step *= 0.5
            continue

        room = True
        for i in range(located):
            if fractions[i] < end:
                place = travelled + fractions[i] * arc
                room = room and _record(
                    setup, found[i], kinds[i], place, count, points, tangents, arclength, stable, events
                )
                count += 1
        final, travelled = (last, travelled + end * arc) if reason > 0 else (there, travelled + arc)
        event = BRANCH_POINT if flips else 0
        room = room and _record(setup, final, event, travelled, count, points, tangents, arclength, stable, events)
        count += 1
        _note(diary, attempts - 1, ACCEPTED, step, iterations, error, angle, count, final[: n + 1])
        if not room:
            return min(count, points.shape[0]), ITERATION_LIMIT, refused
        if reason > 0:
            return count, reason, refused

        put(here, there)
        # Aim at a third of the largest angle, and at no more than three corrections.
        factor = min(max(settings[ANGLE] / (3.0 * max(angle, 1e-9)), 0.5), 2.0)
        step *= min(factor, 3.0 / iterations) if iterations > 3 else factor
