"""Gaussian elimination for the small dense systems of the inner loop.

LAPACK through numba costs about 1 us per 4 x 4 solve, three times what the whole balance costs; this one is 0.1 us.
"""

from numba import types

from solver.compiled import ARRAY, MATRIX, kernel

__all__ = ["dot", "eliminate"]


@kernel(types.float64(ARRAY, ARRAY), inline=True)
def dot(left, right):
    """Inner product of two short vectors; a call of BLAS would cost more than the sum."""
    total = 0.0
    for i in range(left.shape[0]):
        total += left[i] * right[i]
    return total


@kernel(types.float64(MATRIX, ARRAY))
def eliminate(matrix, right):
    """Solve matrix @ x = right in place by elimination with partial pivoting.

    Parameters
    ----------
    matrix : (n, n) array
        Overwritten.
    right : (n,) array
        Right-hand side on entry, the solution on return (unchanged in meaning where the determinant is 0).

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
            right[k], right[pivot] = right[pivot], right[k]
            determinant = -determinant
        determinant *= matrix[k, k]
        inverse = 1.0 / matrix[k, k]
        for i in range(k + 1, n):
            factor = matrix[i, k] * inverse
            if factor != 0.0:
                for j in range(k + 1, n):
                    matrix[i, j] -= factor * matrix[k, j]
                right[i] -= factor * right[k]
    for k in range(n - 1, -1, -1):
        total = right[k]
        for j in range(k + 1, n):
            total -= matrix[k, j] * right[j]
        right[k] = total / matrix[k, k]
    return determinant
