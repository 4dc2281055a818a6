"""Where multipliers pass the unit circle on a branch, between places whose test functions are known.

What two neighbouring places bracket is located by regula falsi, bisected where that is slow: next to a grazing the
functions have square-root corners. A pair may leave the circle and meet on the real axis within one step, and one of
the two come back through +1 or -1: next to where a real multiplier passes, the others tell.
"""

import math
from typing import NamedTuple

import numpy as np

from solver.continuation.curve_point import point_size, state_at
from solver.continuation.setup import SETUP
from solver.continuation.solution_curve import Event
from solver.kernels import types
from solver.kernels.compile import ARRAY, FLAGS, MATRIX, kernel
from solver.kernels.linear import copy_into
from solver.stability.monodromy import ROOM, Room, monodromy_at
from solver.stability.multipliers import (
    DOUBLING,
    GAP,
    LARGEST,
    OUTSIDE,
    RIVAL,
    TESTS,
    UNIT,
    eigenvalues,
    spectral_tests,
)

__all__ = ["FOUND", "INDICES", "ON_CIRCLE", "UNKNOWN", "WATCH", "Found", "Watch", "look", "search"]

_I, _F, _B = types.int64, types.float64, types.boolean
INDICES = types.int64[::1]
_DOUBLING, _TORUS, _UNIT = int(Event.PERIOD_DOUBLING), int(Event.NEIMARK_SACKER), int(Event.UNIT_MULTIPLIER)

# Looks that the location of one event may take, and places that are kept of one step.
_LOOKS, _MOST_PLACES = 80, 24
# A multiplier that passes +1 is followed where one beyond is at least this many times as far from there as one inside:
# else it is the former that comes back. How far beside, as a share of the step, the others are looked at.
_CLOSE, _BESIDE = 0.5, 1e-6
# An event is located when its function has fallen to this share of what it was, or in so short a stretch of arc.
_ROUNDING, _NARROW = 1e-13, 1e-12
# Events of one kind whose motions and axis values are this close, as a share, are one.
_SAME = 1e-8
#: A pair whose modulus is this close to 1 on both sides is on the circle, as of undamped systems, and passes nothing.
ON_CIRCLE = 1e-8
# At a Neimark-Sacker point the pair nearest to the circle lies on it; if not, a real multiplier was what passed it.
_PASSED = 1e-5
# The cubic between two points tells to some share of the arc where on the branch a motion of the raster lies: where its
# test functions are not those of the branch there, these shares further outward.
_ASIDE = (0.0, 1e-4, 1e-3, 1e-2)


class Watch(NamedTuple):
    """What test functions are computed with: packed parameters of the system, and room for its matrices."""

    parameters: np.ndarray
    parameter_slope: np.ndarray
    room: Room


class Found(NamedTuple):
    """Bifurcations found: behind which point of the branch, at which fraction of the arc, kind, and point array; and
    how many were found, how many were not located, and how many points had no multipliers."""

    after: np.ndarray
    fractions: np.ndarray
    kinds: np.ndarray
    points: np.ndarray
    counts: np.ndarray


WATCH = types.NamedTuple((ARRAY, ARRAY, ROOM), Watch)
FOUND = types.NamedTuple((INDICES, ARRAY, FLAGS, MATRIX, INDICES), Found)
LOCATED, MISSED, UNKNOWN = range(3)


@kernel(types.void(WATCH, ARRAY, ARRAY), inner=True)
def look(watch, y, tests):
    """Fill in the test functions at y = (u, p).

    Parameters
    ----------
    watch : Watch
        What is looked with.
    y : (n + 1,) array
        (u, p).
    tests : (TESTS,) array
        Filled.
    """
    n = y.shape[0] - 1
    room = monodromy_at(watch.parameters, watch.parameter_slope, y[:n], y[n], watch.room)
    eigenvalues(room.matrix, room.multipliers[0], room.multipliers[1])
    spectral_tests(room.multipliers[0], room.multipliers[1], tests)


@kernel(_F(_I, ARRAY, _F), inline=True)
def _value(kind, tests, level):
    """The function of one kind that changes sign at the event; for pairs, where OUTSIDE rises above `level`."""
    if kind != _TORUS:
        return tests[DOUBLING if kind == _DOUBLING else UNIT]
    size = min(abs(tests[GAP]), 1.0)
    return size if tests[OUTSIDE] > level else -size


@kernel(_F(SETUP, WATCH, ARRAY, ARRAY, _F, _I, _F, ARRAY, MATRIX, ARRAY, ARRAY), inner=True)
def _pinpoint(setup, watch, left, right, arc, kind, level, bracket, at_ends, tests, point):
    """Locate an event between two fractions of a piece of the branch.

    Parameters
    ----------
    setup, watch
    left, right : point arrays
        Ends of the piece.
    arc : float
        Its length.
    kind : int
    level : float
        As for `_value`.
    bracket : (2,) array
        The two fractions; narrowed.
    at_ends : (2, TESTS) array
        Test functions there; replaced by those at the narrowed bracket.
    tests, found
        Filled with the test functions and the point array at the event.

    Returns
    -------
    float
        Its fraction; -1 if it cannot be located.
    """
    g_low, g_high = _value(kind, at_ends[0], level), _value(kind, at_ends[1], level)
    reference, side, width = max(abs(g_low), abs(g_high)), 0, bracket[1] - bracket[0]
    for attempt in range(_LOOKS):
        low, high = bracket[0], bracket[1]
        x = (low * g_high - high * g_low) / (g_high - g_low)
        margin = 1e-3 * (high - low)
        x = min(max(x, low + margin), high - margin)
        # Three looks must halve the bracket.
        if not math.isfinite(x) or (attempt % 3 == 2 and high - low > 0.5 * width):
            x = 0.5 * (low + high)
        if attempt % 3 == 2:
            width = high - low
        if state_at(setup, left, right, arc, x, point) < 0:
            return -1.0
        look(watch, point[: setup.unknowns + 1], tests)
        if math.isnan(tests[LARGEST]):
            return -1.0
        g = _value(kind, tests, level)
        if abs(g) <= _ROUNDING * reference or (high - low) * arc <= _NARROW:
            return x
        if g * g_high < 0.0:
            bracket[0], g_low = x, g
            for i in range(TESTS):
                at_ends[0, i] = tests[i]
            if side == -1:
                g_high *= 0.5
            side = -1
        else:
            bracket[1], g_high = x, g
            for i in range(TESTS):
                at_ends[1, i] = tests[i]
            if side == 1:
                g_low *= 0.5
            side = 1
    return -1.0


@kernel(types.void(FOUND, _I, _F, _I, ARRAY, _I), inner=True)
def _record(found, after, fraction, kind, point, size):
    """Keep one event at the first `size` numbers of `point`, once, or count it as missed where there is no more room.

    Next to it rounding decides the signs of test functions: it may be bracketed twice.
    """
    count = found.counts[LOCATED]
    for k in range(count):
        apart = 0.0
        for j in range(size):
            apart = max(apart, abs(found.points[k, j] - point[j]) / (1.0 + abs(point[j])))
        if found.kinds[k] == kind and apart <= _SAME:
            return
    if count == found.after.shape[0]:
        found.counts[MISSED] += 1
        return
    found.after[count], found.fractions[count], found.kinds[count] = after, fraction, kind
    for j in range(point.shape[0]):
        found.points[count, j] = point[j]
    found.counts[LOCATED] += 1


@kernel(_F(SETUP, WATCH, ARRAY, ARRAY, _F, _F, _F, ARRAY, ARRAY, ARRAY), inner=True)
def _end_on_branch(setup, watch, left, right, arc, x, sense, expected, tests, point):
    """Where, from fraction x on in one sense, the branch's own test functions have the signs of those expected.

    Fills `tests` with them; x and what was expected where they are nowhere near.
    """
    for aside in _ASIDE:
        position = min(max(x + sense * aside, 0.0), 1.0)
        # At the points of the branch they are its own.
        if position in (0.0, 1.0) and position == x:
            break
        if state_at(setup, left, right, arc, position, point) < 0:
            break
        look(watch, point[: setup.unknowns + 1], tests)
        if tests[OUTSIDE] == expected[OUTSIDE] and tests[DOUBLING] * expected[DOUBLING] > 0.0:
            return position
    copy_into(tests, expected)
    return x


@kernel(_I(ARRAY, ARRAY, _F, _F, _F), inner=True)
def _bracketed(before, behind, pairs, doublings, units):
    """What two places with these test functions bracket, beside what is located between them already: 0 if nothing."""
    # What lies on the circle on both sides, as in undamped systems, passes nothing, nor where it has met on the real
    # axis on one of them: on which side of the circle it was is rounding's.
    near, far = min(abs(before[GAP]), abs(behind[GAP])), max(abs(before[GAP]), abs(behind[GAP]))
    if (near if math.isinf(far) else far) > ON_CIRCLE and abs(before[OUTSIDE] - behind[OUTSIDE]) > 2.0 * pairs:
        return _TORUS
    if doublings == 0.0 and before[DOUBLING] * behind[DOUBLING] < 0.0:
        return _DOUBLING
    if units == 0.0 and before[UNIT] * behind[UNIT] < 0.0 and max(before[RIVAL], behind[RIVAL]) > _CLOSE:
        return _UNIT
    return 0


@kernel(_I(ARRAY, MATRIX, MATRIX, _I, _I, _F, ARRAY, _I), inner=True)
def _insert(positions, at_positions, done, count, k, x, tests, later):
    """Put one more place before place k; what is located there lies behind the new one if `later` is 1, else before.

    Returns the number of places.
    """
    for i in range(count, k, -1):
        positions[i] = positions[i - 1]
        copy_into(at_positions[i], at_positions[i - 1])
        copy_into(done[i], done[i - 1])
    positions[k] = x
    copy_into(at_positions[k], tests)
    for j in range(3):
        done[k + later, j], done[k + 1 - later, j] = done[k + 1, j], 0.0
    return count + 1


@kernel(_F(SETUP, WATCH, FOUND, _I, ARRAY, ARRAY, _F, _F, _F, ARRAY, ARRAY), inner=True)
def search(setup, watch, found, after, left, right, arc, low, high, at_low, at_high):
    """Locate all events between two neighbouring fractions of a piece whose test functions are known.

    Returns the fraction up to which it looked, which may be a little more.

    Parameters
    ----------
    setup : Setup
    watch : Watch
    found : Found
        Grows.
    after : int
        Point of the branch behind which the step lies.
    left, right : point arrays
        Ends of the step.
    arc : float
        Its length in scaled unknowns.
    low, high : float
        Fractions of the step between which events are looked for.
    at_low, at_high : (TESTS,) arrays
        Test functions there.
    """
    if _bracketed(at_low, at_high, 0, 0, 0) == 0:
        return high
    bracket, at_ends = np.empty(2), np.empty((2, TESTS))
    tests, point = np.empty(TESTS), np.empty(point_size(setup))
    # Places in order, and what is located between each and the one before: pairs, and multipliers at -1 and at +1.
    positions, at_positions, done = np.empty(_MOST_PLACES), np.empty((_MOST_PLACES, TESTS)), np.zeros((_MOST_PLACES, 3))
    for end in range(2):
        expected, x, sense = (at_low, low, -1.0) if end == 0 else (at_high, high, 1.0)
        positions[end] = _end_on_branch(setup, watch, left, right, arc, x, sense, expected, at_positions[end], point)
    high, count, k = positions[1], 2, 1
    while k < count:
        kind = _bracketed(at_positions[k - 1], at_positions[k], done[k, 0], done[k, 1], done[k, 2])
        if kind == 0 or count + 2 > _MOST_PLACES:
            k += 1
            continue
        level = min(at_positions[k - 1, OUTSIDE], at_positions[k, OUTSIDE]) + 2.0 * done[k, 0]
        done[k, 0 if kind == _TORUS else 1 if kind == _DOUBLING else 2] += 1.0
        for end in range(2):
            bracket[end] = positions[k - 1 + end]
            copy_into(at_ends[end], at_positions[k - 1 + end])
        x = _pinpoint(setup, watch, left, right, arc, kind, level, bracket, at_ends, tests, point)
        if x < 0.0:
            found.counts[MISSED] += kind != _UNIT
        elif kind == _DOUBLING or (kind == _TORUS and abs(tests[GAP]) <= _PASSED):
            _record(found, after, x, kind, point, setup.unknowns + 1)
        if kind == _TORUS:
            # Both ends of the bracket are places to look at. Of two real multipliers that passed one after the other
            # the second one is what was found here.
            if bracket[0] > positions[k - 1]:
                count = _insert(positions, at_positions, done, count, k, bracket[0], at_ends[0], 1)
            inner = k + 1 if bracket[0] == positions[k] else k
            if bracket[1] < positions[inner]:
                count = _insert(positions, at_positions, done, count, inner, bracket[1], at_ends[1], 0)
        elif x >= 0.0:
            # Next to where it passes, on the side with an even number of real ones beyond, the others tell whether a
            # pair has passed the circle within the step as well: what it does to OUTSIDE that one has undone.
            side = 0 if at_ends[0, DOUBLING if kind == _DOUBLING else UNIT] > 0.0 else 1
            beside = x + (2.0 * side - 1.0) * _BESIDE * (positions[k] - positions[k - 1])
            if (beside - bracket[side]) * (2.0 * side - 1.0) >= 0.0:
                beside = bracket[side]
                copy_into(tests, at_ends[side])
            elif state_at(setup, left, right, arc, beside, point) < 0:
                continue
            else:
                look(watch, point[: setup.unknowns + 1], tests)
            if abs(tests[OUTSIDE] - at_positions[k - 1 + side, OUTSIDE]) > 1.0:
                count = _insert(positions, at_positions, done, count, k, beside, tests, 1 - side)
    return high
