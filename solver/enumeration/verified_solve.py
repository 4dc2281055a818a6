"""Linear systems of intervals, solved with a proven bound of the error.

With an approximate inverse R of the middle of Z and x = R b in floats, Z x* = b has, for every Z and b within the
intervals,

    x* - x = R (b - Z x) + E (x* - x),    E = I - R Z

so that, with the largest row sum alpha of |E| below 1 (which also proves that Z is regular), |x* - x| is at most
|R (b - Z x)| + |E| max|R (b - Z x)|/(1 - alpha) (S. M. Rump, Acta Numerica 19, 2010, section 10). All of it is
evaluated in interval arithmetic; only R and x are floats, which may be anything.

A complex interval is four numbers: real part low and high, imaginary part low and high.
"""

import numpy as np

from solver.enumeration.interval import COMPLEX, above, complex_add, complex_multiply, complex_subtract, exact, length
from solver.kernels import types
from solver.kernels.compile import ARRAY, kernel
from solver.kernels.linear import eliminate_rows

__all__ = ["INTERVALS", "product", "solve_enclosed"]

#: Matrices and vectors of complex intervals, (.., .., 4).
INTERVALS = types.float64[:, :, ::1]

_F, _I, _C = types.float64, types.int64, types.complex128


@kernel(COMPLEX(ARRAY), inline=True)
def _read(four):
    return (four[0], four[1]), (four[2], four[3])


@kernel(COMPLEX(_C), inline=True)
def _exactly(z):
    return exact(z.real), exact(z.imag)


@kernel(_F(COMPLEX), inline=True)
def _size(z):
    """Upper bound of |z|."""
    return length(z[0], z[1])[1]


@kernel(types.boolean(INTERVALS, INTERVALS), inner=True)
def solve_enclosed(matrix, rights):
    """Replace right-hand sides by enclosures of their solutions; False, and nothing is known, if none was proven.

    Parameters
    ----------
    matrix : (n, n, 4) array
    rights : (k, n, 4) array
        A right-hand side per row on entry, its solution on return.
    """
    n, zero = matrix.shape[0], ((0.0, 0.0), (0.0, 0.0))
    middle, inverse = np.empty((n, n), np.complex128), np.zeros((n, n), np.complex128)
    for i in range(n):
        for j in range(n):
            z = _read(matrix[i, j])
            middle[i, j] = complex(0.5 * (z[0][0] + z[0][1]), 0.5 * (z[1][0] + z[1][1]))
        inverse[i, i] = 1.0 + 0j
    # Row j is the solution for unit vector j: the transposed inverse.
    if eliminate_rows(middle, inverse) == 0.0:
        return False
    rows, largest = np.zeros(n), 0.0
    for i in range(n):
        for j in range(n):
            total = _exactly(1.0 + 0j) if i == j else zero
            for k in range(n):
                total = complex_subtract(total, complex_multiply(_exactly(inverse[k, i]), _read(matrix[k, j])))
            rows[i] = above(rows[i] + _size(total))
        largest = rows[i] if not rows[i] <= largest else largest
    if not largest < 0.5:
        return False
    x, residual, misses = np.empty(n, np.complex128), np.empty((n, 4)), np.empty((n, 4))
    for right in range(rights.shape[0]):
        b = rights[right]
        for i in range(n):
            x[i] = 0j
            for k in range(n):
                z = _read(b[k])
                x[i] += inverse[k, i] * complex(0.5 * (z[0][0] + z[0][1]), 0.5 * (z[1][0] + z[1][1]))
        for i in range(n):
            total = _read(b[i])
            for k in range(n):
                total = complex_subtract(total, complex_multiply(_read(matrix[i, k]), _exactly(x[k])))
            (residual[i, 0], residual[i, 1]), (residual[i, 2], residual[i, 3]) = total
        most = 0.0
        for i in range(n):
            total = zero
            for k in range(n):
                total = complex_add(total, complex_multiply(_exactly(inverse[k, i]), _read(residual[k])))
            (misses[i, 0], misses[i, 1]), (misses[i, 2], misses[i, 3]) = total
            most = max(most, _size(total))
        # 1/(1 - alpha) is at most 2.
        for i in range(n):
            radius = above(2.0 * above(rows[i] * most))
            spread = (-radius, radius), (-radius, radius)
            total = complex_add(_exactly(x[i]), complex_add(_read(misses[i]), spread))
            (b[i, 0], b[i, 1]), (b[i, 2], b[i, 3]) = total
    return True


@kernel(COMPLEX(ARRAY, types.float64[:, ::1]), inner=True)
def product(weights, vector):
    """Inner product of exact real weights (n,) and a vector (n, 4) of complex intervals."""
    total = (0.0, 0.0), (0.0, 0.0)
    for i in range(weights.shape[0]):
        if weights[i] != 0.0:
            weight = exact(weights[i]), (0.0, 0.0)
            total = complex_add(total, complex_multiply(weight, _read(vector[i])))
    return total
