"""What lies on an accepted step: its fold and grazings in order of arc, and the end of the branch."""

import numpy as np

from solver.continuation.curve_point import locate, scaled_distance, snap_to_level
from solver.continuation.setup import LIMITS, SETUP
from solver.continuation.solution_curve import EndReason, Event
from solver.continuation.step_checks import LEAST, is_level
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import copy_into, dot

__all__ = ["find_end", "find_events"]

_I, _F, _B = types.int64, types.float64, types.boolean
_FOLD = int(Event.FOLD)
_RANGE_LEFT, _CLOSED, _CEILING = map(int, (EndReason.RANGE_LEFT, EndReason.CLOSED, EndReason.AMPLITUDE_CEILING))


@kernel(_I(SETUP, _I), inline=True)
def _slot_of(setup, event):
    """Where in a point array the function stands that vanishes at a fold or grazing."""
    n = setup.unknowns
    return 2 * n + 1 if event == _FOLD else 2 * n + 2 + event - _FOLD


@kernel(_B(SETUP, ARRAY, MATRIX, types.int64[::1], _I), inner=True)
def _contradicts(setup, left, event_points, kinds, count):
    """Do the points of `count` located events, in order, show signs that the located events do not explain?"""
    for event in range(_FOLD, _FOLD + setup.test_count):
        slot = _slot_of(setup, event)
        sign = left[slot]
        for k in range(count):
            if kinds[k] == event:
                sign = -sign
            elif event_points[k, slot] * sign < 0.0:
                return True
    return False


@kernel(_I(SETUP, LIMITS, ARRAY, ARRAY, _F, _I, MATRIX, ARRAY, types.int64[::1]), inner=True)
def find_events(setup, limits, left, right, arc, event, event_points, fractions, kinds):
    """Locate the fold and the grazings between two points, in order of arc.

    Their number; -1 if one was not found, or if (in longer steps) a pair of another kind lies around it. What
    vanishes at the right point exactly is left out if that has a known `event`, which is recorded with it.

    Parameters
    ----------
    setup : Setup
    limits : Limits
    left, right : point arrays
        Ends of the step.
    arc : float
        Its length in scaled unknowns.
    event : int
        `Event` of the right point; 0 if it is none.
    event_points : (k, size) array
        Filled with point arrays.
    fractions, kinds : (k,) arrays
        Filled: where along the step, and `Event`.
    """
    n = setup.unknowns
    count = 0
    for kind in range(_FOLD, _FOLD + setup.test_count):
        slot = _slot_of(setup, kind)
        if left[slot] == 0.0 or left[slot] * right[slot] > 0.0 or (right[slot] == 0.0 and event != 0):
            continue
        if kind == _FOLD and is_level(setup, left, right):
            continue
        fraction = locate(setup, left, right, arc, slot, left[: n + 1], 0.0, event_points[count])
        if fraction < 0.0:
            return -1
        kinds[count], fractions[count] = kind, fraction
        k = count
        while k > 0 and fractions[k - 1] > fractions[k]:
            fractions[k - 1], fractions[k] = fractions[k], fractions[k - 1]
            kinds[k - 1], kinds[k] = kinds[k], kinds[k - 1]
            for j in range(event_points.shape[1]):
                event_points[k - 1, j], event_points[k, j] = event_points[k, j], event_points[k - 1, j]
            k -= 1
        count += 1
    # A curve bends sharply where it grazes, and may fold twice there between two points that look harmless.
    if arc > LEAST * limits.smallest and _contradicts(setup, left, event_points, kinds, count):
        return -1
    return count


@kernel(_B(ARRAY, ARRAY, ARRAY), inline=True)
def _inside(y, low, high):
    """Whether y lies in the box; its borders belong to it."""
    for j in range(low.shape[0]):  # noqa: SIM110 (kernels have no generators)
        if not low[j] <= y[j] <= high[j]:
            return False
    return True


@kernel(_B(ARRAY, ARRAY, ARRAY), inline=True)
def _same_point(left, right, scale):
    """Whether two points are one, to what the corrector leaves."""
    for j in range(scale.shape[0]):  # noqa: SIM110 (kernels have no generators)
        if not abs((left[j] - right[j]) / scale[j]) <= 1e-6:
            return False
    return True


@kernel(types.Tuple((_I, _F))(SETUP, LIMITS, ARRAY, ARRAY, _F, ARRAY, _B, ARRAY), inner=True)
def find_end(setup, limits, left, right, arc, home, away, end):
    """Does the curve end between two points? Reason (0 no, -1 not located) and fraction; `end` is the last point.

    `home` is the first point of the curve, which may close there once it has been `away`.

    Parameters
    ----------
    setup : Setup
    limits : Limits
    left, right : point arrays
        Ends of the step.
    arc : float
        Its length in scaled unknowns.
    home : point array
        First point of the curve.
    away : bool
        Whether the curve has been far from it.
    end : point array
        Filled.
    """
    n, low, high = setup.unknowns, limits.low, limits.high
    reason, fraction = 0, 2.0
    near_home = away and scaled_distance(right, home, setup.scale) <= 2.0 * arc
    if _inside(right, low, high) and right[2 * n + 2] <= limits.ceiling and not near_home:
        return reason, fraction
    plane, trial = np.empty(n + 1), np.empty(end.shape[0])
    for j in range(n + 1):
        plane[j] = home[n + 1 + j] / setup.scale[j]
    # One candidate for every component of y that leaves the box, then the return to the start, then the ceiling.
    for candidate in range(n + 3):
        slot, level, kind = -1, 0.0, _RANGE_LEFT
        if candidate <= n:
            if low[candidate] <= right[candidate] <= high[candidate]:
                continue
            slot, level = candidate, high[candidate] if right[candidate] > high[candidate] else low[candidate]
        elif candidate == n + 1:
            kind, level = _CLOSED, dot(plane, home[: n + 1])
            before, after = dot(plane, left[: n + 1]) - level, dot(plane, right[: n + 1]) - level
            if not near_home or before >= 0.0 or after < 0.0:
                continue
        else:
            if right[2 * n + 2] <= limits.ceiling:
                continue
            kind, slot, level = _CEILING, 2 * n + 2, limits.ceiling
        at = locate(setup, left, right, arc, slot, plane, level, trial)
        if at < 0.0:
            return -1, 0.0
        if kind == _CLOSED and not _same_point(trial, home, setup.scale):
            continue
        if at < fraction:
            reason, fraction = kind, at
            copy_into(end, trial)
            if kind == _RANGE_LEFT:
                snap_to_level(setup, end, slot, level)
            elif kind == _CLOSED:
                copy_into(end, home)
    return reason, fraction
