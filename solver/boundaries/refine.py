"""More points of a traced curve, solved and not interpolated: a boundary stays exact at any magnification."""

import numpy as np

from solver.continuation.continuation import Continuation, Curve, Problem
from solver.continuation.curve_point import point_size, state_at
from solver.continuation.setup import SETUP, STRAND
from solver.kernels import types
from solver.kernels.compile import MATRIX, kernel
from solver.kernels.linear import copy_into

__all__ = ["refined"]

_I = types.int64


@kernel(_I(SETUP, STRAND, types.int64[::1], MATRIX))
def _refined(setup, strand, parts, result):
    """Fill `result` with the points and parts[i] - 1 more after point i; -1 - i if one of those cannot be found."""
    n, points, tangents, arclength = setup.unknowns, strand.points, strand.tangents, strand.arclength
    size = point_size(setup)
    left, right, point = np.zeros(size), np.zeros(size), np.zeros(size)
    count = 0
    for i in range(points.shape[0] - 1):
        copy_into(result[count], points[i])
        count += 1
        for j in range(n + 1):
            left[j], right[j] = points[i, j], points[i + 1, j]
            left[n + 1 + j], right[n + 1 + j] = tangents[i, j], tangents[i + 1, j]
        for k in range(1, parts[i]):
            if state_at(setup, left, right, arclength[i + 1] - arclength[i], k / parts[i], point) < 0:
                return -1 - i
            copy_into(result[count], point)
            count += 1
    copy_into(result[count], points[-1])
    return count + 1


def refined(problem: Problem, curve: Curve, parts: np.ndarray, continuation: Continuation) -> np.ndarray:
    """Points of a curve with every step divided.

    Parameters
    ----------
    problem, curve
        The curve of k points, and the problem that it was traced for.
    parts : (k - 1,) int array
        Into how many pieces each step is divided, >= 1.
    continuation : Continuation
        Whose corrector is used.

    Returns
    -------
    (1 + sum of parts, n + 1) array
        y in order along the curve.

    Raises
    ------
    ArithmeticError
        If the corrector fails between two points of the curve.
    """
    result = np.empty((1 + int(np.sum(parts)), problem.unknowns + 1))
    count = _refined(
        problem.setup(continuation.corrector), curve.strand, np.ascontiguousarray(parts, dtype=np.int64), result
    )
    if count < 0:
        raise ArithmeticError(f"the corrector fails after point {-1 - count} of the curve")
    return result
