"""Where curves meet given values of the swept parameter, solved and not interpolated, and what known solution that is.

Between two neighbouring points of a curve p is monotone, so every grid value between them is met exactly once, by a
solution of the stability that this piece of curve has. The cubic through both points tells where, to a small share of
the arc between them. Where all solutions are known and exactly one of that stability lies there, no other one near, the
curve passes through it. Otherwise the place is corrected at fixed p; if that does not stay on its piece of curve (close
to a fold), it is located along the curve. What is found is compared with the known solutions to rounding.
"""

from typing import NamedTuple

import numpy as np

from solver.continuation.continuation import Continuation
from solver.continuation.curve_point import correct_onto_curve, locate, point_size, scaled_distance, snap_to_level
from solver.continuation.hermite import cubic, cubic_value, fraction_at
from solver.continuation.problem import Problem
from solver.continuation.setup import SETUP, STRAND
from solver.continuation.solution_curve import Curve, Event
from solver.kernels import types
from solver.kernels.brackets import first_above, first_not_below
from solver.kernels.compile import ARRAY, FLAGS, MATRIX, kernel
from solver.kernels.linear import copy_into

__all__ = ["Crossings", "Known", "curve_crossings"]

_I, _F = types.int64, types.float64
_FOLD = int(Event.FOLD)
_CUBE, _CODES = types.float64[:, :, ::1], types.int8[:, ::1]

# The cubic errs by less than the first share of the arc (a step turns by 0.12 rad as a rule, and then it is off by
# 1e-5 of it); another solution within the second share calls for solving.
_NEAR, _APART = 0.01, 0.05
# Continuation and enumeration know a solution to about 1e-12 of its scale, except next to a fold.
_SAME = 1e-6
# What is noted instead of stability where a place could not be solved for.
_UNREACHED = -1


@kernel(types.Tuple((_I, _F, _F))(ARRAY, MATRIX, FLAGS, ARRAY, _I), inner=True)
def _nearest(point, solutions, stable, scale, wanted):
    """The solution nearest to a point, among those of one stability (any if `wanted` is -1): index, distance, next."""
    index, least, second = -1, np.inf, np.inf
    for s in range(solutions.shape[0]):
        if stable[s] < 0 or (wanted >= 0 and stable[s] != wanted):
            continue
        distance = 0.0
        for j in range(solutions.shape[1]):
            distance = max(distance, abs(solutions[s, j] - point[j]) / scale[j])
        if distance < least:
            index, least, second = s, distance, least
        elif distance < second:
            second = distance
    return index, least, second


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, ARRAY, _F, _F, ARRAY), inner=True)
def _estimated(left, right, leave, arrive, scale, arc, level, estimate):
    """Fill `estimate` (n,) with the unknowns at p = level of the cubic through two points (n + 1,) with tangents."""
    n = estimate.shape[0]
    x = fraction_at(left[n], right[n], arc * leave[n] * scale[n], arc * arrive[n] * scale[n], level, 1e-7)
    for j in range(n):
        off, on = arc * leave[j] * scale[j], arc * arrive[j] * scale[j]
        a, b = cubic(left[j], right[j], off, on)
        estimate[j] = cubic_value(a, b, off, left[j], x)


@kernel(types.boolean(SETUP, ARRAY, ARRAY, _F, _F, ARRAY), inner=True)
def _meet(setup, left, right, arc, level, point):
    """Fill `point` with the point between two points at p = level; False if it cannot be found."""
    n, scale = setup.unknowns, setup.scale
    start, end = left[n], right[n]
    leave, arrive = arc * left[2 * n + 1] * scale[n], arc * right[2 * n + 1] * scale[n]
    a, b = cubic(start, end, leave, arrive)
    low, high = 0.0, 1.0
    for _ in range(40):
        x = 0.5 * (low + high)
        if (cubic_value(a, b, leave, start, x) < level) == (start < end):
            low = x
        else:
            high = x
    seed, normal = np.empty(n + 1), np.zeros(n + 1)
    for j in range(n):
        leave, arrive = arc * left[n + 1 + j] * scale[j], arc * right[n + 1 + j] * scale[j]
        a, b = cubic(left[j], right[j], leave, arrive)
        seed[j] = cubic_value(a, b, leave, left[j], low)
    seed[n], normal[n] = level, 1.0
    copy_into(point[: n + 1], seed)
    sense = 1.0 if end > start else -1.0
    regular = left if abs(left[2 * n + 1]) > abs(right[2 * n + 1]) else right
    if (
        correct_onto_curve(setup, point, normal) > 0
        and scaled_distance(point, seed, scale) <= 0.1 * arc
        # Both sides of a fold meet this p; the determinant tells which one this is.
        and point[-1] * point[2 * n + 1] * regular[-1] * sense > 0.0
    ):
        point[n] = level
        return True
    if locate(setup, left, right, arc, n, normal, level, point) < 0.0:
        return False
    snap_to_level(setup, point, n, level)
    return True


@kernel(_I(SETUP, STRAND, types.boolean, ARRAY, _CUBE, _CODES, FLAGS, _CODES, types.int64[::1], MATRIX, FLAGS))
def _crossings(setup, strand, closed, grid, known, known_stable, complete, on_curve, columns, unknowns, stabilities):
    """Mark the known solutions that the curve passes in `on_curve` (X, S); fill the last three with all other places.

    Their number, or one more than there is room for.
    """
    n, scale, points, tangents = setup.unknowns, setup.scale, strand.points, strand.tangents
    arclength, stable, events = strand.arclength, strand.stable, strand.event
    size = point_size(setup)
    left, right, point, estimate = np.zeros(size), np.zeros(size), np.zeros(size), np.empty(n)
    count, capacity = 0, columns.shape[0]
    for i in range(-1, points.shape[0] - 1):
        before, after = points[max(i, 0), n], points[i + 1, n]
        # A value belongs to the piece that arrives at it; the first point belongs to no piece, unless the curve is
        # closed.
        if i < 0 and closed:
            continue
        low, high = first_not_below(grid, min(before, after)), first_above(grid, max(before, after))
        filled = False
        for offset in range(high - low):
            # In the order in which the curve passes them.
            k = low + offset if after > before else high - 1 - offset
            if i >= 0 and grid[k] == before:
                continue
            if grid[k] == after:
                piece, reached = stable[i + 1], True
                copy_into(point[:n], points[i + 1])
            else:
                arc = arclength[i + 1] - arclength[i]
                piece = stable[i] if events[i] != _FOLD else stable[i + 1]
                if complete[k]:
                    _estimated(points[i], points[i + 1], tangents[i], tangents[i + 1], scale, arc, grid[k], estimate)
                    index, least, second = _nearest(estimate, known[k], known_stable[k], scale, np.int64(piece))
                    if least <= _NEAR * arc and second >= _APART * arc:
                        on_curve[k, index] = 1
                        continue
                if not filled:
                    for j in range(n + 1):
                        left[j], right[j] = points[i, j], points[i + 1, j]
                        left[n + 1 + j], right[n + 1 + j] = tangents[i, j], tangents[i + 1, j]
                    # The sign of the determinant is that of stability times the sense in which p moves.
                    sense = 1.0 if after > before else -1.0
                    left[-1] = right[-1] = sense if piece == 1 else -sense
                    filled = True
                reached = _meet(setup, left, right, arc, grid[k], point)
            if reached:
                index, least, second = _nearest(point, known[k], known_stable[k], scale, np.int64(-1))
                if least <= _SAME:
                    on_curve[k, index] = 1
                    continue
            if count == capacity:
                return capacity + 1
            for j in range(n):
                unknowns[count, j] = point[j] if reached else np.nan
            columns[count], stabilities[count] = k, piece if reached else _UNREACHED
            count += 1
    return count


class Known(NamedTuple):
    """Solutions that are known at grid values, S at most at one.

    Parameters
    ----------
    motions : (X, S, n) array
    stable : (X, S) int8 array
        Static stability; -1 beyond the number of solutions.
    complete : (X,) int8 array
        1 where these are proven to be all.
    """

    motions: np.ndarray
    stable: np.ndarray
    complete: np.ndarray


class Crossings(NamedTuple):
    """Where a curve meets grid values.

    Parameters
    ----------
    column : (k,) int array
        Grid values at which it passes through what is not known, in order along the curve.
    unknowns : (k, n) array
    stable : (k,) int8 array
    unreached : (m,) int array
        Grid values that it passes but at which nothing could be solved for.
    on_curve : (X, S) bool array
        The known solutions that it passes through.
    """

    column: np.ndarray
    unknowns: np.ndarray
    stable: np.ndarray
    unreached: np.ndarray
    on_curve: np.ndarray


def curve_crossings(
    problem: Problem, curve: Curve, grid, continuation: Continuation, known: Known | None = None
) -> Crossings:
    """Where one curve meets grid values.

    Parameters
    ----------
    problem : Problem
    curve : Curve
        As traced for that problem.
    grid : (X,) array
        Ascending.
    continuation : Continuation
        Whose corrector is used.
    known : Known, optional

    Returns
    -------
    Crossings
    """
    n, setup, grid = problem.unknowns, problem.setup(continuation.corrector), np.array(grid, dtype=float)
    if known is None:
        nothing = np.empty((grid.size, 0, n)), np.empty((grid.size, 0), np.int8), np.zeros(grid.size, np.int8)
        known = Known(*nothing)
    capacity = 16 + (0 if np.all(known.complete) else 2 * grid.size)
    while True:
        on_curve = np.zeros(known.stable.shape, np.int8)
        columns, unknowns, stable = np.empty(capacity, np.int64), np.empty((capacity, n)), np.empty(capacity, np.int8)
        count = _crossings(setup, curve.strand, curve.closed, grid, *known, on_curve, columns, unknowns, stable)
        if count <= capacity:
            break
        capacity *= 2
    columns, unknowns, stable = columns[:count], unknowns[:count], stable[:count]
    reached = stable != _UNREACHED
    return Crossings(columns[reached], unknowns[reached], stable[reached], columns[~reached], on_curve.view(bool))
