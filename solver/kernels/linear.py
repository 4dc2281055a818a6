"""Gaussian elimination for the small dense systems of the inner loop.

LAPACK through numba costs about 1 us per 4 x 4 solve, three times what the whole balance costs; this one is 0.1 us.
"""

from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel

__all__ = ["copy_into", "dot", "eliminate", "eliminate_rows"]

COMPLEX_MATRIX = types.complex128[:, ::1]


@kernel(types.float64(ARRAY, ARRAY), inline=True)
def dot(left, right):
    """Inner product of two short vectors; a call of BLAS would cost more than the sum."""
    total = 0.0
    for i in range(left.shape[0]):
        total += left[i] * right[i]
    return total


@kernel(types.void(ARRAY, ARRAY), inline=True)
def copy_into(target, source):
    """Copy as much of `source` as `target` holds; a slice assignment takes numba seconds to compile."""
    for i in range(target.shape[0]):
        target[i] = source[i]


@kernel(types.float64(MATRIX, MATRIX), types.complex128(COMPLEX_MATRIX, COMPLEX_MATRIX), inner=True, shared=True)
def eliminate_rows(matrix, rights):
    """Solve matrix @ x = right in place for several right-hand sides, by elimination with partial pivoting.

    Parameters
    ----------
    matrix : (n, n) array
        Overwritten.
    rights : (k, n) array
        A right-hand side per row on entry, its solution on return (unchanged in meaning where the determinant is 0).

    Returns
    -------
    float
        The determinant; 0 if the matrix is singular to working precision, nan if it holds one.
    """
    n = matrix.shape[0]
    determinant = 1.0
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(matrix[i, k]) > abs(matrix[pivot, k]):
                pivot = i
        if matrix[pivot, k] == 0.0:
            return 0.0
        if pivot != k:
            for j in range(k, n):
                matrix[k, j], matrix[pivot, j] = matrix[pivot, j], matrix[k, j]
            for row in range(rights.shape[0]):
                rights[row, k], rights[row, pivot] = rights[row, pivot], rights[row, k]
            determinant = -determinant
        determinant *= matrix[k, k]
        inverse = 1.0 / matrix[k, k]
        for i in range(k + 1, n):
            factor = matrix[i, k] * inverse
            if factor != 0.0:
                for j in range(k + 1, n):
                    matrix[i, j] -= factor * matrix[k, j]
                for row in range(rights.shape[0]):
                    rights[row, i] -= factor * rights[row, k]
    for row in range(rights.shape[0]):
        for k in range(n - 1, -1, -1):
            total = rights[row, k]
            for j in range(k + 1, n):
                total -= matrix[k, j] * rights[row, j]
            rights[row, k] = total / matrix[k, k]
    return determinant


@kernel(types.float64(MATRIX, ARRAY), inner=True)
def eliminate(matrix, right):
    """`eliminate_rows` for one right-hand side, an (n,) array."""
    return eliminate_rows(matrix, right.reshape((1, right.shape[0])))
