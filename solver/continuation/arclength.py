"""The compiled loop of pseudo-arc-length continuation; `solver.continuation.continuation` says what it promises."""

import math

import numpy as np

from solver.continuation.corner import CORNER_ROOM, round_corner
from solver.continuation.curve_point import (
    angle_between,
    correct_onto_curve,
    observe_from,
    orient,
    point_size,
    scaled_distance,
)
from solver.continuation.located import find_end, find_events
from solver.continuation.setup import LIMITS, SETUP, STRAND
from solver.continuation.solution_curve import EndReason, Event, Outcome
from solver.continuation.step_checks import judge, limited
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import copy_into, dot

__all__ = ["ITERATIONS", "OUTCOME", "PLACE", "POINTS", "STEP", "STRAY", "TURN", "trace"]

_I, _F, _B = types.int64, types.float64, types.boolean
_RANGE_LEFT, _STEP_TOO_SMALL = int(EndReason.RANGE_LEFT), int(EndReason.STEP_TOO_SMALL)
_ITERATION_LIMIT, _NO_SOLUTION = int(EndReason.ITERATION_LIMIT), int(EndReason.NO_SOLUTION)
_NO_TANGENT = int(EndReason.NO_TANGENT)
_FOLD, _BRANCH_POINT = int(Event.FOLD), int(Event.BRANCH_POINT)
_ACCEPTED, _NOT_CORRECTED = int(Outcome.ACCEPTED), int(Outcome.NOT_CORRECTED)
_NOT_LOCATED, _ROUND_A_CORNER = int(Outcome.NOT_LOCATED), int(Outcome.ROUND_A_CORNER)

# Columns of a step's row in a log; the place tried follows them.
OUTCOME, STEP, ITERATIONS, STRAY, TURN, POINTS, PLACE = range(7)

# How often the corrector may begin anew, where it stopped, with a start that is no solution.
_TRIES = 4

# Steps below this are refused for a corner of the curve, where there is one. What correcting their points once more may
# move them by, as a share of the step.
_CORNER_STEP, _SETTLED = 1e-3, 0.01


@kernel(_B(SETUP, STRAND, _I, ARRAY, _I, _F), inner=True)
def _record(setup, strand, count, point, event, arc):
    """Write one point of the branch; False if there is no room."""
    if count >= strand.points.shape[0]:
        return False
    n = setup.unknowns
    for j in range(n + 1):
        strand.points[count, j], strand.tangents[count, j] = point[j], point[n + 1 + j]
    strand.arclength[count], strand.event[count] = arc, event
    along = point[2 * n + 1]
    strand.stable[count] = 1 if event != _FOLD and along != 0.0 and (along < 0.0) == (point[-1] < 0.0) else 0
    return True


@kernel(types.void(MATRIX, _I, _I, _F, _I, _F, _F, _I, ARRAY), inner=True)
def _note(log, attempt, outcome, step, iterations, error, angle, count, y):
    """Write one step into the log, as long as there is room."""
    if attempt < log.shape[0]:
        log[attempt, OUTCOME], log[attempt, STEP], log[attempt, ITERATIONS] = outcome, step, iterations
        log[attempt, STRAY], log[attempt, TURN], log[attempt, POINTS] = error, angle, count
        copy_into(log[attempt, PLACE:], y)


@kernel(_B(SETUP, ARRAY), inner=True)
def _solves(setup, point):
    """Whether the equations hold at the point's y, against what moving y by its scale would do to them."""
    n = setup.unknowns
    jacobian, residual = setup.work[0:n], setup.work[2 * n + 1][:n]
    setup.residual_and_jacobian(setup.parameters, setup.parameter_slope, point[: n + 1], residual, jacobian)
    for i in range(n):
        size = 0.0
        for j in range(n + 1):
            size += abs(jacobian[i, j]) * setup.scale[j]
        if not abs(residual[i]) <= setup.tolerance * size:
            return False
    return True


@kernel(_B(SETUP, ARRAY, ARRAY), inner=True)
def _orient_steeply(setup, point, heading):
    """`orient` by the component of y that the curve runs along best, on the side of `heading`: at a fold not by p."""
    n = setup.unknowns
    best, most = -1, 0.0
    trial, border = np.zeros(point.shape[0]), np.zeros(n + 1)
    for j in range(n + 1):
        copy_into(trial, point)
        border[j] = 1.0
        if orient(setup, trial, border) and abs(trial[-1]) > most:
            best, most = j, abs(trial[-1])
        border[j] = 0.0
    if best < 0:
        return False
    border[best] = 1.0
    orient(setup, point, border)
    side = dot(point[n + 1 : 2 * n + 2], heading)
    # Exactly on a fold neither side has more of p than the other; opposite headings take opposite ones all the same.
    if side < 0.0 or (side == 0.0 and heading[n] < 0.0):
        for j in range(n + 1, 2 * n + 2):
            point[j] = -point[j]
    return True


@kernel(_I(SETUP, ARRAY, ARRAY), inner=True)
def _begin(setup, here, heading):
    """Make the start a point of the curve with a tangent on the side of `heading`; an end reason, 0 if it is one."""
    n = setup.unknowns
    start = here.copy()
    if not orient(setup, here, heading) or not scaled_distance(here, start, setup.scale) <= setup.tolerance:
        copy_into(here, start)
        if _solves(setup, here):
            if not _orient_steeply(setup, here, heading):
                return _NO_TANGENT
        else:
            iterations = -1
            for _ in range(_TRIES):
                if iterations < 0:
                    iterations = correct_onto_curve(setup, here, heading)
            if iterations < 0:
                return _NO_SOLUTION
    # The second call makes the determinant that of the tangent's own border, comparable with those that follow.
    return 0 if orient(setup, here, here[n + 1 : 2 * n + 2].copy()) else _NO_TANGENT


@kernel(
    types.UniTuple(_I, 2)(SETUP, LIMITS, ARRAY, ARRAY, ARRAY, _F, _I, _I, _F, STRAND, MATRIX, ARRAY, types.int64[::1]),
    inner=True,
)
def _take(setup, limits, home, here, there, arc, event, count, travelled, strand, event_points, fractions, kinds):
    """Write what lies on a step, and its last point: points then written (perhaps more than fit), and end reason.

    The reason is 0 where the curve goes on, -1 where something was not located and nothing was written. `event` is that
    of the last point; what vanishes there exactly is not looked for. The last row of `event_points` is its end.
    """
    last = event_points[event_points.shape[0] - 1]
    reason, end = find_end(setup, limits, here, there, arc, home, count > 3, last)
    located = find_events(setup, limits, here, there, arc, event, event_points, fractions, kinds) if reason >= 0 else -1
    if located < 0:
        return count, -1
    for i in range(located):
        if fractions[i] < end:
            _record(setup, strand, count, event_points[i], kinds[i], travelled + fractions[i] * arc)
            count += 1
    if reason > 0:
        _record(setup, strand, count, last, event if event == _BRANCH_POINT else 0, travelled + end * arc)
    else:
        _record(setup, strand, count, there, event, travelled + arc)
    return count + 1, reason


@kernel(types.UniTuple(_I, 3)(SETUP, LIMITS, ARRAY, ARRAY, STRAND, MATRIX))
def trace(setup, limits, start, heading, strand, log):
    """Follow the curve from `start` (n + 1,) to the side that `heading` (n + 1,) points to until it ends.

    It ends where it leaves the box of `limits`; at once if `start` lies on its border and the curve heads out. Fills
    `strand` as far as there is room, and a row of `log` (any number, PLACE + n + 1) for every step that was tried.

    Parameters
    ----------
    setup : Setup
    limits : Limits
    start, heading : (n + 1,) arrays
        Where the curve begins, and the side to which it is followed.
    strand : Strand
        Filled with points.
    log : (k, PLACE + n + 1) array
        Filled with a row for every step that was tried.

    Returns
    -------
    count, reason, refused : int
        Points written, end reason (`EndReason`) and steps refused.
    """
    n, scale, room = setup.unknowns, setup.scale, strand.points.shape[0]
    size = point_size(setup)
    here, there, again, guess = np.zeros(size), np.zeros(size), np.zeros(size), np.zeros(n + 1)
    event_points, fractions = np.zeros((setup.test_count + 1, size)), np.empty(setup.test_count)
    kinds = np.empty(setup.test_count, np.int64)
    corner, corner_kinds = np.empty((0, size)), np.empty(CORNER_ROOM, np.int64)

    copy_into(here[: n + 1], start)
    reason = _begin(setup, here, heading)
    if reason > 0:
        return 0, reason, 0
    for j in range(n + 1):
        # What starts on the border of the box stays there, whatever the last correction does.
        if start[j] == limits.low[j] or start[j] == limits.high[j]:
            here[j] = start[j]
    observe_from(setup, here)
    home = here.copy()
    _record(setup, strand, 0, here, 0, 0.0)
    for j in range(n + 1):
        if (here[j] == limits.low[j] and here[n + 1 + j] < 0.0) or (
            here[j] == limits.high[j] and here[n + 1 + j] > 0.0
        ):
            return 1, _RANGE_LEFT, 0
    count, refused, attempts, travelled = 1, 0, 0, 0.0
    step, looked_for_corner = limits.first, False

    while True:
        step = limited(setup, limits, here, step)
        if step < limits.smallest:
            return count, _STEP_TOO_SMALL, refused
        tangent = here[n + 1 : 2 * n + 2]
        for j in range(n + 1):
            guess[j] = here[j] + step * tangent[j] * scale[j]
            there[j] = guess[j]
        iterations = correct_onto_curve(setup, there, tangent)
        outcome, error, angle, arc, reason = _NOT_CORRECTED, math.nan, math.nan, 0.0, 0
        if iterations >= 0 and step < _CORNER_STEP:
            # Next to a corner the corrector may end on the wrong side of it, within its tolerance.
            copy_into(again, there)
            if not orient(setup, again, tangent) or scaled_distance(again, there, scale) > _SETTLED * step:
                iterations = -1
        if iterations >= 0:
            observe_from(setup, there)
            error, arc = scaled_distance(there, guess, scale), scaled_distance(there, here, scale)
            angle = angle_between(setup, here, there)
            arc *= 1.0 + angle * angle / 24.0
            outcome = judge(setup, limits, here, there, step, error, angle, arc)
        if outcome == _ACCEPTED:
            event = _BRANCH_POINT if (here[-1] < 0.0) != (there[-1] < 0.0) else 0
            count, reason = _take(
                setup, limits, home, here, there, arc, event, count, travelled, strand, event_points, fractions, kinds
            )
            outcome = _ACCEPTED if reason >= 0 else _NOT_LOCATED
        final = event_points[setup.test_count] if reason > 0 else there
        _note(log, attempts, outcome, step, iterations, error, angle, count, final[: n + 1])
        attempts += 1
        if outcome == _ACCEPTED:
            if count > room:
                return room, _ITERATION_LIMIT, refused
            if reason > 0:
                return count, reason, refused
            copy_into(here, there)
            travelled += arc
            looked_for_corner = False
            # Aim at a third of the largest angle, and at no more than three corrections.
            factor = min(max(limits.angle / (3.0 * max(angle, 1e-9)), 0.5), 2.0)
            step *= min(factor, 3.0 / iterations) if iterations > 3 else factor
            continue

        refused += 1
        step *= 0.5
        if step >= _CORNER_STEP or looked_for_corner:
            continue
        looked_for_corner = True
        if corner.shape[0] == 0:
            corner = np.zeros((CORNER_ROOM, size))
        for k in range(round_corner(setup, limits, here, step, corner, corner_kinds)):
            copy_into(there, corner[k])
            angle, arc = angle_between(setup, here, there), scaled_distance(there, here, scale)
            arc *= 1.0 + angle * angle / 24.0
            count, reason = _take(
                setup,
                limits,
                home,
                here,
                there,
                arc,
                corner_kinds[k],
                count,
                travelled,
                strand,
                event_points,
                fractions,
                kinds,
            )
            final, outcome = event_points[setup.test_count] if reason > 0 else there, _ROUND_A_CORNER
            if reason < 0:
                outcome = _NOT_LOCATED
            _note(log, attempts, outcome, arc, 0, math.nan, angle, count, final[: n + 1])
            attempts += 1
            if reason < 0:
                refused += 1
                break
            if count > room:
                return room, _ITERATION_LIMIT, refused
            if reason > 0:
                return count, reason, refused
            copy_into(here, there)
            travelled += arc
            looked_for_corner = False
            step = max(arc, 2.0 * limits.smallest)
