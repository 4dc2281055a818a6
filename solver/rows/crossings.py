"""Where a curve meets given values of the swept parameter, and which known solutions these places are.

Between two neighbouring points of a curve p is monotone, so every grid value between them is met exactly once, by a
solution of the stability that this piece of curve has. The cubic through both points tells where, to a small share of
the arc between them. If exactly one known solution of that stability lies there and no other one near, the curve passes
through it. Otherwise, and where not all solutions are known, the place is solved for (`solver.continuation.on_curve`)
and compared to rounding.
"""

from typing import NamedTuple

import numpy as np

from solver.continuation.continuation import Curve, Event
from solver.continuation.curve_point import point_size
from solver.continuation.hermite import cubic, cubic_slope, cubic_value
from solver.continuation.on_curve import meet
from solver.continuation.setup import SETUP, STRAND, Strand
from solver.kernels import types
from solver.kernels.brackets import first_above, first_not_below
from solver.kernels.compile import ARRAY, FLAGS, MATRIX, kernel
from solver.kernels.linear import copy_into
from solver.rows.span import RowSpan

__all__ = ["Crossings", "Known", "crossings", "nothing_known"]

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
def _cubic_place(left, right, leave, arrive, scale, arc, level, place):
    """Fill `place` (n,) with the unknowns at p = level of the cubic through two points (n + 1,) with tangents."""
    n = place.shape[0]
    start, end = left[n], right[n]
    off, on = arc * leave[n] * scale[n], arc * arrive[n] * scale[n]
    a, b = cubic(start, end, off, on)
    low, high = 0.0, 1.0
    x = (level - start) / (end - start)
    # Newton's method in a bracket: p is monotone between the ends, next to a fold only just.
    for _ in range(40):
        ahead = cubic_value(a, b, off, start, x) - level
        if (ahead < 0.0) == (start < end):
            low = x
        else:
            high = x
        moved = x - ahead / cubic_slope(a, b, off, x)
        if not low < moved < high:
            moved = 0.5 * (low + high)
        step, x = abs(moved - x), moved
        if step < 1e-7:
            break
    for j in range(n):
        off, on = arc * leave[j] * scale[j], arc * arrive[j] * scale[j]
        a, b = cubic(left[j], right[j], off, on)
        place[j] = cubic_value(a, b, off, left[j], x)


@kernel(_I(SETUP, STRAND, types.boolean, ARRAY, _CUBE, _CODES, FLAGS, _CODES, types.int64[::1], MATRIX, FLAGS))
def _crossings(setup, strand, closed, grid, known, known_stable, complete, on_curve, columns, unknowns, stabilities):
    """Mark the known solutions that the curve passes in `on_curve` (X, S); fill the last three with all other places.

    Their number, or one more than there is room for.
    """
    n, scale, points, tangents = setup.unknowns, setup.scale, strand.points, strand.tangents
    arclength, stable, events = strand.arclength, strand.stable, strand.event
    size = point_size(setup)
    left, right, found, place = np.zeros(size), np.zeros(size), np.zeros(size), np.empty(n)
    count, capacity = 0, columns.shape[0]
    for i in range(-1, points.shape[0] - 1):
        before, after = points[max(i, 0), n], points[i + 1, n]
        # A value belongs to the piece that arrives at it; the first point belongs to no piece, unless the curve is
        # closed.
        if i < 0 and closed:
            continue
        low, high = first_not_below(grid, min(before, after)), first_above(grid, max(before, after))
        filled = False
        for k in range(low, high):
            if i >= 0 and grid[k] == before:
                continue
            if grid[k] == after:
                piece, reached = stable[i + 1], True
                copy_into(found[:n], points[i + 1])
            else:
                arc = arclength[i + 1] - arclength[i]
                piece = stable[i] if events[i] != _FOLD else stable[i + 1]
                if complete[k]:
                    _cubic_place(points[i], points[i + 1], tangents[i], tangents[i + 1], scale, arc, grid[k], place)
                    index, least, second = _nearest(place, known[k], known_stable[k], scale, np.int64(piece))
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
                reached = meet(setup, left, right, arc, grid[k], found)
            if reached:
                index, least, second = _nearest(found, known[k], known_stable[k], scale, np.int64(-1))
                if least <= _SAME:
                    on_curve[k, index] = 1
                    continue
            if count == capacity:
                return capacity + 1
            for j in range(n):
                unknowns[count, j] = found[j] if reached else np.nan
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


def nothing_known(columns: int, unknowns: int) -> Known:
    """No solutions at so many grid values."""
    return Known(np.empty((columns, 0, unknowns)), np.empty((columns, 0), np.int8), np.zeros(columns, np.int8))


class Crossings(NamedTuple):
    """Where a curve meets grid values.

    Parameters
    ----------
    on_curve : (X, S) bool array
        The known solutions that it passes through.
    column : (k,) int array
        Grid values at which it passes through something else, in order along the curve.
    unknowns : (k, n) array
    stable : (k,) int8 array
    unreached : (m,) int array
        Grid values that it passes but at which nothing could be solved for.
    """

    on_curve: np.ndarray
    column: np.ndarray
    unknowns: np.ndarray
    stable: np.ndarray
    unreached: np.ndarray


def crossings(span: RowSpan, curve: Curve, grid: np.ndarray, known: Known | None = None) -> Crossings:
    """Where one curve of a row meets grid values.

    Parameters
    ----------
    span : RowSpan
    curve : Curve
        As traced for its problem.
    grid : (X,) array
        Ascending.
    known : Known, optional

    Returns
    -------
    Crossings
    """
    n, setup = span.problem.unknowns, span.problem.setup(span.continuation.corrector)
    strand = Strand(curve.points, curve.tangents, curve.arclength, curve.stable, curve.event)
    known = known or nothing_known(grid.size, n)
    capacity = 16 + (0 if np.all(known.complete) else 2 * grid.size)
    while True:
        on_curve = np.zeros(known.stable.shape, np.int8)
        columns, unknowns, stable = np.empty(capacity, np.int64), np.empty((capacity, n)), np.empty(capacity, np.int8)
        count = _crossings(setup, strand, curve.closed, grid, *known, on_curve, columns, unknowns, stable)
        if count <= capacity:
            break
        capacity *= 2
    columns, unknowns, stable = columns[:count], unknowns[:count], stable[:count]
    reached = stable != _UNREACHED
    return Crossings(on_curve.view(bool), columns[reached], unknowns[reached], stable[reached], columns[~reached])
