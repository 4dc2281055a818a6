"""Floquet multipliers of a monodromy matrix, and what kernels ask of them.

The matrices are small (4 x 4 with all supports alike, at most 14 x 14), where a call of LAPACK costs more than the
eigenvalues: the matrix is brought to Hessenberg form by reflections and its eigenvalues are split off by the QR method
with Francis' double shift (J. G. F. Francis, The Computer Journal 4 (1961) 265-271 and (1962) 332-345; G. H. Golub, C.
F. Van Loan, Matrix Computations, sections 7.4 and 7.5).
"""

import math

import numpy as np

from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.stability.instability import BEYOND_MINUS_ONE, BEYOND_ONE, NEAR_CIRCLE, NOT_FINITE, PAIR_OUTSIDE

__all__ = [
    "DOUBLING",
    "GAP",
    "LARGEST",
    "OUTSIDE",
    "RIVAL",
    "TESTS",
    "UNIT",
    "eigenvalues",
    "spectral_tests",
    "where_multipliers_lie",
]

_I, _F, _B = types.int64, types.float64, types.boolean

# Iterations for one eigenvalue or pair; two or three are usual. After every tenth the shift is an exceptional one.
_MOST_ITERATIONS = 60
_EPSILON = 2.0**-52

#: A multiplier this close to the real axis, as a share of its size, is real.
_REAL = 1e-8

#: Slots of `spectral_tests`, and their number.
LARGEST, DOUBLING, OUTSIDE, GAP, UNIT, RIVAL = range(6)
TESTS = 6


@kernel(types.void(MATRIX, _I), inner=True)
def hessenberg(a, n):
    """Bring a (n, n) to upper Hessenberg form by reflections."""
    v = np.empty(n)
    for k in range(n - 2):
        size = 0.0
        for i in range(k + 2, n):
            size = max(size, abs(a[i, k]))
        if size == 0.0:
            continue
        size = max(size, abs(a[k + 1, k]))
        length = 0.0
        for i in range(k + 1, n):
            v[i] = a[i, k] / size
            length += v[i] * v[i]
        length = math.copysign(math.sqrt(length), v[k + 1])
        v[k + 1] += length
        weight = 1.0 / (length * v[k + 1])
        a[k + 1, k] = -length * size
        for i in range(k + 2, n):
            a[i, k] = 0.0
        for j in range(k + 1, n):
            total = 0.0
            for i in range(k + 1, n):
                total += v[i] * a[i, j]
            total *= weight
            for i in range(k + 1, n):
                a[i, j] -= total * v[i]
        for i in range(n):
            total = 0.0
            for j in range(k + 1, n):
                total += a[i, j] * v[j]
            total *= weight
            for j in range(k + 1, n):
                a[i, j] -= total * v[j]


@kernel(types.void(MATRIX, _I, _I, _B), inner=True)
def _francis_step(a, low, high, exceptional):
    """One double-shift QR step on rows and columns low ... high of a Hessenberg matrix, three of them or more."""
    corner, above = a[high, high], a[high - 1, high - 1]
    trace = corner + above
    determinant = corner * above - a[high, high - 1] * a[high - 1, high]
    if exceptional:
        size = abs(a[high, high - 1]) + abs(a[high - 1, high - 2])
        trace, determinant = 1.5 * size + 2.0 * corner, (corner + 0.75 * size) ** 2 + 0.5 * size * size
    first = a[low, low]
    x = first * (first - trace) + a[low, low + 1] * a[low + 1, low] + determinant
    y = a[low + 1, low] * (first + a[low + 1, low + 1] - trace)
    z = a[low + 1, low] * a[low + 2, low + 1]
    for k in range(low, high):
        last = k + 2 if k + 2 <= high else high
        if last == k + 1:
            z = 0.0
        size = max(abs(x), abs(y), abs(z))
        if size > 0.0:
            x, y, z = x / size, y / size, z / size
            length = math.copysign(math.sqrt(x * x + y * y + z * z), x)
            # Reflection 1 - (u u^T)/(length (x + length)), u = (x + length, y, z).
            u = x + length
            ratio_y, ratio_z, weight = y / u, z / u, u / length
            for j in range(k - 1 if k > low else low, high + 1):
                total = a[k, j] + ratio_y * a[k + 1, j]
                if last == k + 2:
                    total += ratio_z * a[k + 2, j]
                total *= weight
                a[k, j] -= total
                a[k + 1, j] -= total * ratio_y
                if last == k + 2:
                    a[k + 2, j] -= total * ratio_z
            for i in range(low, min(k + 3, high) + 1):
                total = a[i, k] + ratio_y * a[i, k + 1]
                if last == k + 2:
                    total += ratio_z * a[i, k + 2]
                total *= weight
                a[i, k] -= total
                a[i, k + 1] -= total * ratio_y
                if last == k + 2:
                    a[i, k + 2] -= total * ratio_z
        if k > low:
            a[k + 1, k - 1] = 0.0
            if last == k + 2:
                a[k + 2, k - 1] = 0.0
        if k < high - 1:
            x, y = a[k + 1, k], a[k + 2, k]
            z = a[k + 3, k] if k + 3 <= high else 0.0


@kernel(_B(MATRIX, ARRAY, ARRAY), inner=True, shared=True)
def eigenvalues(matrix, real, imaginary):
    """Eigenvalues of a real matrix.

    Parameters
    ----------
    matrix : (n, n) array
        Overwritten.
    real, imaginary : (n,) arrays
        Filled; conjugates side by side, the one above the axis first.

    Returns
    -------
    bool
        False, and nan in both arrays, where the matrix is not finite or the iteration does not settle.
    """
    n = matrix.shape[0]
    size = 0.0
    for i in range(n):
        for j in range(n):
            size += abs(matrix[i, j])
    settles = math.isfinite(size)
    if settles:
        hessenberg(matrix, n)
    high, iterations = n - 1, 0
    while settles and high >= 0:
        low = high
        while low > 0:
            beside = abs(matrix[low, low]) + abs(matrix[low - 1, low - 1])
            if abs(matrix[low, low - 1]) <= _EPSILON * (beside if beside > 0.0 else size):
                break
            low -= 1
        if low == high:
            real[high], imaginary[high] = matrix[high, high], 0.0
            high, iterations = high - 1, 0
        elif low == high - 1:
            corner = matrix[high, high]
            half = 0.5 * (matrix[low, low] - corner)
            product = matrix[low, high] * matrix[high, low]
            square = half * half + product
            root = math.sqrt(abs(square))
            if square >= 0.0:
                root = half + math.copysign(root, half)
                real[low] = corner + root
                real[high] = corner - product / root if root != 0.0 else corner
                imaginary[low], imaginary[high] = 0.0, 0.0
            else:
                real[low], real[high] = corner + half, corner + half
                imaginary[low], imaginary[high] = root, -root
            high, iterations = high - 2, 0
        else:
            iterations += 1
            settles = iterations <= _MOST_ITERATIONS
            _francis_step(matrix, low, high, iterations % 10 == 0)
    if not settles:
        for i in range(n):
            real[i], imaginary[i] = math.nan, math.nan
    return settles


@kernel(_I(ARRAY, ARRAY, _F), inner=True)
def where_multipliers_lie(real, imaginary, tolerance):
    """Bits of `solver.stability.instability`; a multiplier within the tolerance of the unit circle is nothing else.

    Two real multipliers beyond +1 are a pair that has met there, and count as one outside.

    Parameters
    ----------
    real, imaginary : (k,) arrays
        Of the multipliers.
    tolerance : float
        How close to the unit circle is undecided.
    """
    bits, above = 0, 0
    for i in range(real.shape[0]):
        x, y = real[i], imaginary[i]
        modulus = math.hypot(x, y)
        if not math.isfinite(modulus):
            bits |= NOT_FINITE
        elif abs(modulus - 1.0) <= tolerance:
            bits |= NEAR_CIRCLE
        elif modulus > 1.0:
            if abs(y) > _REAL * modulus:
                bits |= PAIR_OUTSIDE
            elif x > 0.0:
                above += 1
            else:
                bits |= BEYOND_MINUS_ONE
    if above % 2 == 1:
        bits |= BEYOND_ONE
    if above > 1:
        bits |= PAIR_OUTSIDE
    return bits


@kernel(types.void(ARRAY, ARRAY, ARRAY), inner=True)
def spectral_tests(real, imaginary, tests):
    """Test functions of the multipliers of one motion, continuous along a branch but OUTSIDE.

    Parameters
    ----------
    real, imaginary : (m,) arrays
    tests : (TESTS,) array
        LARGEST, the largest modulus. DOUBLING, det(M + I): it changes sign where a real multiplier passes -1. OUTSIDE,
        the number of multipliers outside the unit circle, less one if an odd number lies beyond -1 and less one if an
        odd number lies beyond +1: it changes by 2 where a complex pair passes the circle, and not where two multipliers
        meet outside and leave the real axis. GAP, modulus less 1 of that complex multiplier which is nearest to the
        circle, infinite where there is none. UNIT, det(M - I): it changes sign where a real multiplier passes +1.
        RIVAL, the distance from +1 of the nearest real multiplier beyond over that of the nearest one inside; 0 where
        there are not both. All are nan where a multiplier is.
    """
    largest, product, outside, below, above, gap = 0.0, 1.0, 0, 0, 0, math.inf
    unit, beyond, inside = 1.0, math.inf, math.inf
    for i in range(real.shape[0]):
        x, y = real[i], imaginary[i]
        modulus = math.hypot(x, y)
        largest = max(largest, modulus)
        if y > 0.0:
            # Of a pair, both at once.
            product *= (1.0 + x) * (1.0 + x) + y * y
            unit *= (1.0 - x) * (1.0 - x) + y * y
        elif y == 0.0:
            product *= 1.0 + x
            unit *= x - 1.0
            if x > 1.0:
                beyond = min(beyond, x - 1.0)
            elif x > 0.0:
                inside = min(inside, 1.0 - x)
        if y != 0.0 and abs(modulus - 1.0) < abs(gap):
            gap = modulus - 1.0
        if modulus > 1.0:
            outside += 1
            if y == 0.0:
                below += x < 0.0
                above += x > 0.0
        if math.isnan(modulus):
            largest, product, gap, unit, beyond = math.nan, math.nan, math.nan, math.nan, math.nan
            break
    tests[LARGEST], tests[DOUBLING], tests[GAP], tests[UNIT] = largest, product, gap, unit
    tests[RIVAL] = beyond / inside if inside > 0.0 and not math.isinf(beyond) else 0.0
    tests[OUTSIDE] = outside - below % 2 - above % 2 if not math.isnan(largest) else math.nan
