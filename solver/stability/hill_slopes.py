"""The determinant of Hill's matrix over a window, and its gradient.

The matrix depends on the motion through the angles of contact alone. A contact that ends (sigma = 1) or begins (-1) at
theta_c changes chi_m by sigma exp(-i m theta_c)/(2 pi) per radian, hence the matrix M by a matrix of rank one, and

    d log det M = tr(M^-1 dM),    d theta_c = (d level - d lambda)/lambda'(theta_c)

which is infinite where the motion grazes a flank. Names are those of `solver.stability.hill_determinant`.
"""

import math

import numpy as np

from solver.contact.spectrum import COMPLEX, displacement
from solver.harmonic.contact_terms import coefficient, modulated
from solver.harmonic.impedance import base_frequency, impedance, stiffness_phasor
from solver.harmonic.layout import BACK, FRONT, PERIOD, STIFFNESSES
from solver.harmonic.perturbation import COMPLEX_MATRIX
from solver.kernels import types
from solver.kernels.compile import ARRAY, kernel
from solver.stability.hill_determinant import (
    HILL,
    LINEAR,
    Hill,
    contact_matrices,
    fill_matrix,
    linear_numbers,
    linear_terms,
    magnitude,
    motion_spectra,
    spectrum_sizes,
)

__all__ = ["determinant_slopes"]

_I, _F, _C, _B = types.int64, types.float64, types.complex128, types.boolean
_COMPLEX = np.complex128

# Stands for a pivot of 0, which a determinant may well have: what it multiplies afterwards cancels it.
_NO_PIVOT = 1e-150


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
            if magnitude(matrix[i, k]) > magnitude(matrix[pivot, k]):
                pivot = i
        if pivot != k:
            for j in range(n):
                matrix[k, j], matrix[pivot, j] = matrix[pivot, j], matrix[k, j]
                inverse[k, j], inverse[pivot, j] = inverse[pivot, j], inverse[k, j]
            product = -product
        if magnitude(matrix[k, k]) < _NO_PIVOT:
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


@kernel(_C(HILL, ARRAY, _C, _C, COMPLEX_MATRIX, COMPLEX_MATRIX), inner=True)
def _explicit(hill, along, z, d_z, d_varied, inverse):
    """d log of the scaled determinant while the angles of contact stand still, the axis moving by 1 and z by d_z."""
    size = inverse.shape[0]
    omega, d_omega = base_frequency(hill.theta, along, 0.0)
    total = 0j
    for i in range(size):
        at = z + (i - hill.harmonics)
        (D, A, B, _), (d_D, d_A, d_B, _) = impedance(
            hill.theta, along, 0.0, 1j * at * omega, 1j * (d_z * omega + at * d_omega), -1
        )
        row = inverse[i, i] * d_D
        for j in range(size):
            row += inverse[j, i] * (d_A * hill.contact[i, j] + d_B * hill.varied[i, j] + B * d_varied[i, j])
        # The inverse is that of rows already divided by R_k.
        total += (row - _growth(D, d_D) - _growth(A, d_A)) / (abs(D) + abs(A))
    return total


@kernel(types.void(ARRAY, ARRAY, COMPLEX, _I, _B, COMPLEX_MATRIX), inner=True)
def _varied_slope(theta, along, chi, size_psi, truncated, slope):
    """Fill the derivative of `contact_matrices`' second matrix along an axis, the angles of contact standing still."""
    size, period = slope.shape[0], int(theta[PERIOD])
    product, change = np.empty(size_psi, _COMPLEX), np.empty(size_psi, _COMPLEX)
    modulated(theta, along, 0.0, chi, product, change)
    for i in range(size):
        for j in range(size):
            slope[i, j] = 0j if truncated else coefficient(change, i - j)
    if truncated:
        for l in range(1, int(theta[STIFFNESSES]) + 1):
            d_S = 0.5 * stiffness_phasor(theta, along, 0.0, l)[1]
            shift = l * period
            for i in range(size):
                for j in range(size):
                    if i - shift >= 0:
                        slope[i, j] += d_S * coefficient(chi, i - shift - j)
                    if i + shift < size:
                        slope[i, j] += d_S.conjugate() * coefficient(chi, i + shift - j)


@kernel(types.void(ARRAY, ARRAY, _C, _B, COMPLEX_MATRIX), inner=True)
def _contact_change(theta, still, turn, truncated, pulse):
    """Fill exp(-i k theta_c) and what the stiffness makes of it, rows of `pulse` (2, size); turn = exp(i theta_c)."""
    size, period = pulse.shape[1], int(theta[PERIOD])
    power = 1.0 + 0j
    for i in range(size):
        pulse[0, i] = power
        power *= turn.conjugate()
    pulse[1, :] = 0.0
    for l in range(1, int(theta[STIFFNESSES]) + 1):
        S, shift = stiffness_phasor(theta, still, 0.0, l)[0], l * period
        modulation = (S * turn**shift).real
        for i in range(size):
            if not truncated:
                pulse[1, i] += modulation * pulse[0, i]
                continue
            if i - shift >= 0:
                pulse[1, i] += 0.5 * S * pulse[0, i - shift]
            if i + shift < size:
                pulse[1, i] += 0.5 * S.conjugate() * pulse[0, i + shift]


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
    n, harmonics = u.shape[0], u.shape[0] // 2
    size = 2 * harmonics + 1 - window
    longest, long = spectrum_sizes(theta, harmonics)
    chi, psi = np.empty(longest, _COMPLEX), np.empty(long, _COMPLEX)
    angles, zones = np.empty(2 * n + 8), np.empty(2 * n + 8, np.int64)
    count = motion_spectra(theta, along_x, u, 0.0, chi, psi, angles, zones)
    square = np.empty((5, size, size), _COMPLEX)
    contact, varied, matrix, inverse, d_varied = square[0], square[1], square[2], square[3], square[4]
    still, numbers = np.zeros(theta.shape[0]), np.empty(LINEAR)
    contact_matrices(theta, still, 0.0, chi, psi, truncated, contact, varied)
    linear_numbers(theta, still, 0.0, numbers)
    omega, z = base_frequency(theta, still, 0.0)[0], complex(share, 0.0)
    hill = Hill(theta, still, 0.0, omega, harmonics, numbers, contact, varied)
    fill_matrix(hill, z, matrix)
    value = _inverse(matrix, inverse)
    gradient[:n] = 0.0
    d_varied[:] = 0.0
    gradient[n] = _explicit(hill, still, z, 1.0 + 0j, d_varied, inverse)
    _varied_slope(theta, along_x, chi, long, truncated, d_varied)
    gradient[n + 1] = _explicit(hill, along_x, z, 0j, d_varied, inverse)
    _varied_slope(theta, along_p, chi, long, truncated, d_varied)
    gradient[n + 2] = _explicit(hill, along_p, z, 0j, d_varied, inverse)
    if count > 0:
        pair, pulse = np.empty((2, size), _COMPLEX), np.empty((2, size), _COMPLEX)
        for i in range(size):
            D, A, B, _ = linear_terms(theta, still, 0.0, numbers, 1j * (z + (i - harmonics)) * omega)
            scale = 1.0 / (abs(D) + abs(A))
            pair[0, i], pair[1, i] = A * scale, B * scale
        for c in range(count):
            before, after = zones[c - 1 if c > 0 else count - 1], zones[c]
            sigma = abs(before) - abs(after)
            if sigma == 0:
                continue
            turn, total = complex(math.cos(angles[c]), math.sin(angles[c])), 0j
            _contact_change(theta, still, turn, truncated, pulse)
            for i in range(size):
                row = 0j
                for j in range(size):
                    row += inverse[j, i] * pulse[0, j].conjugate()
                total += row * (pair[0, i] * pulse[0, i] + pair[1, i] * pulse[1, i])
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
