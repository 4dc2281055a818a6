"""Where curves meet given values of the swept parameter: the raster, solved and not interpolated.

Between two neighbouring points of a curve p is monotone, so every grid value between them is met exactly once. It is
seeded by the cubic through both points and corrected at fixed p; if that does not stay on its piece of curve (close to
a fold), it is located along the curve instead.
"""

import numpy as np

from solver.continuation.continuation import Continuation
from solver.continuation.curve_point import correct_onto_curve, locate, point_size, scaled_distance, snap_to_level
from solver.continuation.hermite import cubic, cubic_value
from solver.continuation.problem import Problem
from solver.continuation.setup import SETUP, STRAND, Strand
from solver.continuation.solution_curve import Curve, Event
from solver.kernels import types
from solver.kernels.compile import ARRAY, FLAGS, MATRIX, kernel
from solver.kernels.linear import copy_into

__all__ = ["curve_crossings", "meet"]

_I, _F = types.int64, types.float64
_FOLD = int(Event.FOLD)


@kernel(_I(ARRAY, _F), inner=True)
def _first_from(grid, value):
    """Index of the first entry of an increasing grid that is not below a value."""
    low, high = 0, grid.shape[0]
    while low < high:
        middle = (low + high) // 2
        if grid[middle] < value:
            low = middle + 1
        else:
            high = middle
    return low


@kernel(types.boolean(SETUP, ARRAY, ARRAY, _F, _F, ARRAY), inner=True)
def meet(setup, left, right, arc, level, found):
    """Fill `found` with the point between two points at p = level; False if it cannot be found."""
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
    copy_into(found[: n + 1], seed)
    sense = 1.0 if end > start else -1.0
    regular = left if abs(left[2 * n + 1]) > abs(right[2 * n + 1]) else right
    if (
        correct_onto_curve(setup, found, normal) > 0
        and scaled_distance(found, seed, scale) <= 0.1 * arc
        # Both sides of a fold meet this p; the determinant tells which one this is.
        and found[-1] * found[2 * n + 1] * regular[-1] * sense > 0.0
    ):
        found[n] = level
        return True
    if locate(setup, left, right, arc, n, normal, level, found) < 0.0:
        return False
    snap_to_level(setup, found, n, level)
    return True


@kernel(_I(SETUP, STRAND, types.boolean, ARRAY, types.int64[::1], MATRIX, FLAGS))
def _crossings(setup, strand, closed, grid, columns, unknowns, stabilities):
    """Fill columns, unknowns and stabilities; their number, -1 - i if column i failed, or the capacity if too small."""
    n, points, tangents = setup.unknowns, strand.points, strand.tangents
    size = point_size(setup)
    left, right, found = np.zeros(size), np.zeros(size), np.zeros(size)
    count, capacity = 0, columns.shape[0]
    for i in range(-1, points.shape[0] - 1):
        before, after = points[max(i, 0), n], points[i + 1, n]
        # A value belongs to the piece that arrives at it; the first point belongs to no piece, unless the curve is
        # closed.
        if i < 0 and closed:
            continue
        low, high = _first_from(grid, min(before, after)), _first_from(grid, max(before, after))
        while high < grid.shape[0] and grid[high] <= max(before, after):
            high += 1
        filled = False
        for offset in range(high - low):
            # In the order in which the curve passes them.
            k = low + offset if after > before else high - 1 - offset
            if i >= 0 and grid[k] == before:
                continue
            if count == capacity:
                return capacity + 1
            if grid[k] == after:
                copy_into(unknowns[count], points[i + 1])
                columns[count], stabilities[count] = k, strand.stable[i + 1]
                count += 1
                continue
            if not filled:
                for j in range(n + 1):
                    left[j], right[j] = points[i, j], points[i + 1, j]
                    left[n + 1 + j], right[n + 1 + j] = tangents[i, j], tangents[i + 1, j]
                # The sign of the determinant is that of stability times the sense in which p moves.
                sense = 1.0 if after > before else -1.0
                piece = strand.stable[i] if strand.event[i] != _FOLD else strand.stable[i + 1]
                left[-1] = right[-1] = sense if piece == 1 else -sense
                filled = True
            if not meet(setup, left, right, strand.arclength[i + 1] - strand.arclength[i], grid[k], found):
                return -1 - k
            copy_into(unknowns[count], found)
            columns[count], stabilities[count] = k, piece
            count += 1
    return count


def curve_crossings(problem: Problem, curve: Curve, grid: np.ndarray, continuation: Continuation):
    """All solutions of one curve at given values of the swept parameter.

    Parameters
    ----------
    problem : Problem
    curve : Curve
        As traced for that problem.
    grid : (columns,) array
        Ascending.
    continuation : Continuation
        Whose corrector is used.

    Returns
    -------
    column : (k,) int array
        Which grid value each solution belongs to, in order along the curve.
    unknowns : (k, n) array
    stable : (k,) int8 array

    Raises
    ------
    ArithmeticError
        If the corrector cannot reach a grid value that the curve passes.
    """
    n, grid = problem.unknowns, np.array(grid, dtype=float)
    setup = problem.setup(continuation.corrector)
    strand = Strand(curve.points, curve.tangents, curve.arclength, curve.stable, curve.event)
    capacity = 4 * grid.size + 16
    while True:
        columns, unknowns = np.empty(capacity, np.int64), np.empty((capacity, n))
        stable = np.empty(capacity, np.int8)
        count = _crossings(setup, strand, curve.closed, grid, columns, unknowns, stable)
        if count < 0:
            raise ArithmeticError(f"the curve passes {grid[-1 - count]!r}, but the corrector does not converge there")
        if count <= capacity:
            return columns[:count], unknowns[:count], stable[:count]
        capacity *= 2
