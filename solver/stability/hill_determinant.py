"""The determinant of Hill's matrix, condensed to the contact coordinate, and its gradient.

With z = s/(i Omega/nu) an exponent in units of the base frequency, the matrix of `solver.harmonic.perturbation` over the
harmonics k of one *window* is singular at the exponents of a motion. Two windows keep the spectrum's symmetry:

    whole  k = -H ... H      about z = 0:    real there, zero at folds
    half   k = -H ... H - 1  about z = 1/2:  real there, zero at period doublings; they are the subharmonics of order H

An exponent is sought in the window whose centre is nearer: in the other one its harmonics are cut off lopsidedly, which
splits a negative multiplier into a pair. Rows are divided by R_k = |D_k| + |A_k|, so that the determinant is of order one.

The matrix depends on the motion through the angles of contact alone. A contact that ends (sigma = 1) or begins (-1) at
theta_c changes chi_m by sigma exp(-i m theta_c)/(2 pi) per radian, hence the matrix M by a matrix of rank one, and

    d log det M = tr(M^-1 dM),    d theta_c = (d level - d lambda)/lambda'(theta_c)

which is infinite where the motion grazes a flank.
"""

import math

import numpy as np
from numba import types

from solver.compiled import ARRAY, kernel
from solver.condensation import K_SUPPORT, SIZE, XI_SUPPORT
from solver.harmonic.contact_spectrum import COMPLEX, contact_arcs, contact_spectrum, displacement
from solver.harmonic.contact_terms import coefficient, modulated
from solver.harmonic.impedance import base_frequency, impedance, stiffness_phasor
from solver.harmonic.layout import BACK, FRONT, GEAR, KIND, PAIRS, PERIOD, STIFFNESSES
from solver.harmonic.perturbation import COMPLEX_MATRIX

__all__ = [
    "HALF", "WHOLE", "determinant", "determinant_slopes", "fill_matrix", "motion_spectra", "pole_phase", "spectrum_sizes",
]  # fmt: skip

_I, _F, _C, _B = types.int64, types.float64, types.complex128, types.boolean
_ANGLES, _ZONES = ARRAY, types.int64[::1]
_COMPLEX = np.complex128

#: The windows: by how much the number of harmonics falls short of 2 H + 1.
WHOLE, HALF = 0, 1

# Stands for a pivot of 0, which a determinant may well have: what it multiplies afterwards cancels it.
_NO_PIVOT = 1e-150


@kernel(types.UniTuple(_I, 2)(ARRAY, _I), inline=True)
def spectrum_sizes(theta, harmonics):
    """Lengths of chi and psi that the matrices of a motion of so many harmonics need."""
    return 2 * harmonics + 1 + int(theta[STIFFNESSES]) * int(theta[PERIOD]), 2 * harmonics + 1


@kernel(_I(ARRAY, ARRAY, ARRAY, _F, COMPLEX, COMPLEX, _ANGLES, _ZONES), inner=True)
def motion_spectra(theta, direction, u, p, chi, psi, angles, zones):
    """Fill chi, psi, angles and zones (`solver.harmonic.contact_spectrum`) of a motion u; the number of angles."""
    front, back = theta[FRONT] + p * direction[FRONT], theta[BACK] + p * direction[BACK]
    count = contact_arcs(u, front, back, angles, zones)
    rest = np.empty((2, chi.shape[0]), _COMPLEX)
    contact_spectrum(count, angles, zones, chi, rest[0], rest[1])
    modulated(theta, direction, p, chi, psi, rest[0][: psi.shape[0]])
    return count


@kernel(_C(ARRAY, ARRAY, _F, COMPLEX, _I, _I, _I), inline=True)
def _truncated_psi(theta, direction, p, chi, i, j, size):
    """What psi_(i - j) is when the force is truncated to the window before the stiffness multiplies it."""
    total = 0j
    for l in range(1, int(theta[STIFFNESSES]) + 1):
        S = 0.5 * stiffness_phasor(theta, direction, p, l)[0]
        shift = l * int(theta[PERIOD])
        if i - shift >= 0:
            total += S * coefficient(chi, i - shift - j)
        if i + shift < size:
            total += S.conjugate() * coefficient(chi, i + shift - j)
    return total


@kernel(types.void(ARRAY, ARRAY, _F, _C, _I, COMPLEX, COMPLEX, _B, COMPLEX_MATRIX), inner=True)
def fill_matrix(theta, direction, p, z, harmonics, chi, psi, truncated, matrix):
    """Hill's matrix over a window, its rows divided by R_k.

    Parameters
    ----------
    theta, direction : arrays
        Of `solver.harmonic.layout.packed`.
    p : float
        Axis value.
    z : complex
        Exponent in units of i times the base frequency.
    harmonics : int
        H of the module, in multiples of the base frequency.
    chi, psi : complex arrays
        Of `motion_spectra`.
    truncated : bool
        Whether the force is truncated before the stiffness multiplies it: the describing function.
    matrix : (size, size) complex array
        Filled; size is 2 H + 1 for the whole window and 2 H for the half one.
    """
    size = matrix.shape[0]
    omega = base_frequency(theta, direction, p)[0]
    for i in range(size):
        D, A, B, _ = impedance(theta, direction, p, 1j * (z + i - harmonics) * omega, 0j, -1)[0]
        inverse = 1.0 / (abs(D) + abs(A))
        A, B = A * inverse, B * inverse
        for j in range(size):
            varied = _truncated_psi(theta, direction, p, chi, i, j, size) if truncated else coefficient(psi, i - j)
            matrix[i, j] = A * coefficient(chi, i - j) + B * varied
        matrix[i, i] += D * inverse


@kernel(_F(_C), inline=True)
def _size(value):
    return abs(value.real) + abs(value.imag)


@kernel(_C(COMPLEX_MATRIX), inner=True)
def determinant(matrix):
    """Determinant of a complex matrix, which is overwritten."""
    n = matrix.shape[0]
    product = 1.0 + 0j
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if _size(matrix[i, k]) > _size(matrix[pivot, k]):
                pivot = i
        if matrix[pivot, k] == 0.0:
            return 0j
        if pivot != k:
            for j in range(k, n):
                matrix[k, j], matrix[pivot, j] = matrix[pivot, j], matrix[k, j]
            product = -product
        product *= matrix[k, k]
        inverse = 1.0 / matrix[k, k]
        for i in range(k + 1, n):
            factor = matrix[i, k] * inverse
            for j in range(k + 1, n):
                matrix[i, j] -= factor * matrix[k, j]
    return product


@kernel(_C(ARRAY, ARRAY, _F, _C, _I, _I), inner=True)
def pole_phase(theta, direction, p, z, harmonics, size):
    """The unit complex number that takes the poles of the determinant away from its phase: product of Z_j(s_k)/|Z_j(s_k)|.

    The supports resonate within their damping ratio of the imaginary axis. A `ContactSystem` keeps its poles.
    """
    product = 1.0 + 0j
    if theta[KIND] != GEAR:
        return product
    omega = base_frequency(theta, direction, p)[0]
    start = PAIRS + 2 * int(theta[STIFFNESSES])
    model, along = theta[start : start + SIZE], direction[start : start + SIZE]
    xi, k = math.nan, math.nan
    for j in range(6):
        xi_j, k_j = model[XI_SUPPORT + j] + p * along[XI_SUPPORT + j], model[K_SUPPORT + j] + p * along[K_SUPPORT + j]
        if xi_j == xi and k_j == k:
            continue
        xi, k = xi_j, k_j
        for i in range(size):
            s = 1j * (z + i - harmonics) * omega
            stiffness = k + 2.0 * xi * s + s * s
            length = abs(stiffness)
            if length > 0.0:
                product *= complex(stiffness.real / length, stiffness.imag / length)
    return product


@kernel(_C(COMPLEX_MATRIX, COMPLEX_MATRIX), inner=True)
def _inverse(matrix, inverse):
    """Fill the inverse of a matrix, which is overwritten; its determinant, never 0."""
    n = matrix.shape[0]
    product = 1.0 + 0j
    for i in range(n):
        for j in range(n):
            inverse[i, j] = 1.0 + 0j if i == j else 0j
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if _size(matrix[i, k]) > _size(matrix[pivot, k]):
                pivot = i
        if pivot != k:
            for j in range(n):
                matrix[k, j], matrix[pivot, j] = matrix[pivot, j], matrix[k, j]
                inverse[k, j], inverse[pivot, j] = inverse[pivot, j], inverse[k, j]
            product = -product
        if _size(matrix[k, k]) < _NO_PIVOT:
            matrix[k, k] = _NO_PIVOT + 0j
        product *= matrix[k, k]
        reciprocal = 1.0 / matrix[k, k]
        for j in range(n):
            matrix[k, j] *= reciprocal
            inverse[k, j] *= reciprocal
        for i in range(n):
            factor = matrix[i, k]
            if i != k and factor != 0.0:
                for j in range(n):
                    matrix[i, j] -= factor * matrix[k, j]
                    inverse[i, j] -= factor * inverse[k, j]
    return product


@kernel(_F(_C, _C), inline=True)
def _growth(value, slope):
    """Derivative of |value|; 0 where it has none."""
    size = abs(value)
    return (value.real * slope.real + value.imag * slope.imag) / size if size > 0.0 else 0.0


@kernel(_C(ARRAY, ARRAY, _C, _C, _I, COMPLEX, COMPLEX, _B, COMPLEX_MATRIX), inner=True)
def _explicit(theta, along, z, d_z, harmonics, chi, psi, truncated, inverse):
    """d log of the scaled determinant while the angles of contact stand still, the axis moving by 1 and z by d_z."""
    size, period = inverse.shape[0], int(theta[PERIOD])
    omega, d_omega = base_frequency(theta, along, 0.0)
    changed = np.empty((2, psi.shape[0]), _COMPLEX)
    # With the direction of the axis, `modulated` gives s chi and what the change of s adds.
    modulated(theta, along, 0.0, chi, changed[0], changed[1])
    total = 0j
    for i in range(size):
        at = z + i - harmonics
        (D, A, B, _), (d_D, d_A, d_B, _) = impedance(
            theta, along, 0.0, 1j * at * omega, 1j * (d_z * omega + at * d_omega), -1
        )
        scale = abs(D) + abs(A)
        row = inverse[i, i] * d_D
        for j in range(size):
            if truncated:
                varied, d_varied = _truncated_psi(theta, along, 0.0, chi, i, j, size), 0j
                for l in range(1, int(theta[STIFFNESSES]) + 1):
                    d_S = 0.5 * stiffness_phasor(theta, along, 0.0, l)[1]
                    if i - l * period >= 0:
                        d_varied += d_S * coefficient(chi, i - l * period - j)
                    if i + l * period < size:
                        d_varied += d_S.conjugate() * coefficient(chi, i + l * period - j)
            else:
                varied, d_varied = coefficient(psi, i - j), coefficient(changed[1], i - j)
            row += inverse[j, i] * (d_A * coefficient(chi, i - j) + d_B * varied + B * d_varied)
        total += (row - _growth(D, d_D) - _growth(A, d_A)) / scale
    return total


@kernel(_C(ARRAY, ARRAY, ARRAY, ARRAY, _F, _I, _B, COMPLEX), inner=True)
def determinant_slopes(theta, along_x, along_p, u, share, window, truncated, gradient):
    """Determinant over a window at an imaginary exponent z = share, and its gradient.

    Parameters
    ----------
    theta : array
        Of `solver.harmonic.layout.packed`, with both axes at their values.
    along_x, along_p : arrays
        What either axis adds to it.
    u : (n,) array
        The motion.
    share : float
        Imaginary part of the exponent over the base frequency.
    window : {WHOLE, HALF}
    truncated : bool
        As for `fill_matrix`.
    gradient : (n + 3,) complex array
        Filled with the derivatives by u, share, x and p.
    """
    n, period = u.shape[0], int(theta[PERIOD])
    harmonics = n // 2
    size = 2 * harmonics + 1 - window
    longest, long = spectrum_sizes(theta, harmonics)
    chi, psi = np.empty(longest, _COMPLEX), np.empty(long, _COMPLEX)
    angles, zones = np.empty(2 * n + 8), np.empty(2 * n + 8, np.int64)
    count = motion_spectra(theta, along_x, u, 0.0, chi, psi, angles, zones)
    matrix, inverse = np.empty((size, size), _COMPLEX), np.empty((size, size), _COMPLEX)
    z = complex(share, 0.0)
    fill_matrix(theta, along_x, 0.0, z, harmonics, chi, psi, truncated, matrix)
    value = _inverse(matrix, inverse)
    still = np.zeros(theta.shape[0])
    # `_explicit` divides its rows by R_k, the inverse is that of rows already divided.
    gradient[:n] = 0.0
    gradient[n] = _explicit(theta, still, z, 1.0 + 0j, harmonics, chi, psi, truncated, inverse)
    gradient[n + 1] = _explicit(theta, along_x, z, 0j, harmonics, chi, psi, truncated, inverse)
    gradient[n + 2] = _explicit(theta, along_p, z, 0j, harmonics, chi, psi, truncated, inverse)
    if count > 0:
        omega = base_frequency(theta, still, 0.0)[0]
        pair = np.empty((2, size), _COMPLEX)
        for i in range(size):
            D, A, B, _ = impedance(theta, still, 0.0, 1j * (z + i - harmonics) * omega, 0j, -1)[0]
            scale = 1.0 / (abs(D) + abs(A))
            pair[0, i], pair[1, i] = A * scale, B * scale
        for c in range(count):
            before, after = zones[c - 1 if c > 0 else count - 1], zones[c]
            sigma = abs(before) - abs(after)
            if sigma == 0:
                continue
            turn, total = complex(math.cos(angles[c]), math.sin(angles[c])), 0j
            modulation = 0.0
            for l in range(1, int(theta[STIFFNESSES]) + 1):
                modulation += (stiffness_phasor(theta, still, 0.0, l)[0] * turn ** (l * period)).real
            for i in range(size):
                back = turn.conjugate() ** i
                varied = modulation * back
                if truncated:
                    varied = 0j
                    for l in range(1, int(theta[STIFFNESSES]) + 1):
                        S = 0.5 * stiffness_phasor(theta, still, 0.0, l)[0]
                        if i - l * period >= 0:
                            varied += S * turn.conjugate() ** (i - l * period)
                        if i + l * period < size:
                            varied += S.conjugate() * turn.conjugate() ** (i + l * period)
                row, ahead = 0j, 1.0 + 0j
                for j in range(size):
                    row += inverse[j, i] * ahead
                    ahead *= turn
                total += row * (pair[0, i] * back + pair[1, i] * varied)
            # Front contact is left and entered at the front gap, back contact at minus the back gap.
            slot, sense = (FRONT, 1.0) if before + after == 1 else (BACK, -1.0)
            total *= sigma / (2.0 * math.pi * displacement(u, angles[c])[1])
            gradient[0] -= total
            power = 1.0 + 0j
            for k in range(1, harmonics + 1):
                power *= turn
                gradient[2 * k - 1] -= total * power.real
                gradient[2 * k] -= total * power.imag
            gradient[n + 1] += total * sense * along_x[slot]
            gradient[n + 2] += total * sense * along_p[slot]
    for j in range(n + 3):
        gradient[j] *= value
    return value
