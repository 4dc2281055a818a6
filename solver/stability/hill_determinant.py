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
from collections import namedtuple

import numpy as np
from numba import types

from solver.compiled import ARRAY, kernel
from solver.condensation import (
    CONE,
    K_SUPPORT,
    KAPPA,
    PRESSURE,
    SIGMA,
    SIZE,
    VARIATION_R,
    VARIATION_T,
    XI_MESH,
    XI_SUPPORT,
    XI_TRANSLATION,
    rotation_coupling,
)
from solver.harmonic.contact_spectrum import COMPLEX, contact_arcs, contact_spectrum, displacement
from solver.harmonic.contact_terms import coefficient, modulated
from solver.harmonic.impedance import base_frequency, impedance, stiffness_phasor
from solver.harmonic.layout import BACK, FRONT, GEAR, KIND, PAIRS, PERIOD, STIFFNESSES
from solver.harmonic.perturbation import COMPLEX_MATRIX

__all__ = [
    "HALF", "HILL", "WHOLE", "determinant", "determinant_slopes", "fill_matrix", "hill_of",
]  # fmt: skip

_I, _F, _C, _B = types.int64, types.float64, types.complex128, types.boolean
_ANGLES, _ZONES = ARRAY, types.int64[::1]
_COMPLEX = np.complex128

#: What the matrices of one motion over one window have in common; see `hill_of`.
Hill = namedtuple("Hill", "theta direction p omega harmonics numbers contact varied")
HILL = types.NamedTuple((ARRAY, ARRAY, _F, _F, _I, ARRAY, COMPLEX_MATRIX, COMPLEX_MATRIX), Hill)
LINEAR = 5 + 4 * 6

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


@kernel(types.void(ARRAY, ARRAY, _F, COMPLEX, COMPLEX, _B, COMPLEX_MATRIX, COMPLEX_MATRIX), inner=True)
def contact_matrices(theta, direction, p, chi, psi, truncated, contact, varied):
    """Fill what A_k and B_k multiply in a window: `contact` with chi_(k-m), `varied` with psi_(k-m).

    With the describing function the force is truncated to the window before the stiffness multiplies it (`truncated`).
    """
    size, period = contact.shape[0], int(theta[PERIOD])
    for i in range(size):
        for j in range(size):
            contact[i, j] = coefficient(chi, i - j)
            varied[i, j] = 0j if truncated else coefficient(psi, i - j)
    if truncated:
        for l in range(1, int(theta[STIFFNESSES]) + 1):
            S = 0.5 * stiffness_phasor(theta, direction, p, l)[0]
            if S == 0.0:
                continue
            shift = l * period
            for i in range(size):
                for j in range(size):
                    if i - shift >= 0:
                        varied[i, j] += S * contact[i - shift, j]
                    if i + shift < size:
                        varied[i, j] += S.conjugate() * contact[i + shift, j]


@kernel(types.void(ARRAY, ARRAY, _F, ARRAY), inner=True)
def linear_numbers(theta, direction, p, numbers):
    """Fill `numbers` (LINEAR,) with what `_linear_terms` needs of a gear pair, its supports of equal (xi_j, k_j) merged.

    They are c xi_h, c, c eps_r, eps_t and the number of kinds, then sum d_j^2 kappa_g, sum d_j^2 xi_hg, xi and k of each.
    """
    if theta[KIND] != GEAR:
        return
    start = PAIRS + 2 * int(theta[STIFFNESSES])
    model = theta[start : start + SIZE] + p * direction[start : start + SIZE]
    c, _ = rotation_coupling(theta[start : start + SIZE], direction[start : start + SIZE], p)
    numbers[0], numbers[1], numbers[2], numbers[3] = c * model[XI_MESH], c, c * model[VARIATION_R], model[VARIATION_T]
    cone, pressure = math.radians(model[CONE]), math.radians(model[PRESSURE])
    radial, axial, along = math.cos(cone) * math.sin(pressure), math.sin(cone) * math.sin(pressure), math.cos(pressure)
    kinds = 0
    for j in range(6):
        part = radial if j % 3 == 0 else (axial if j % 3 == 1 else along)
        weight, xi, k = model[SIGMA] * part * part, model[XI_SUPPORT + j], model[K_SUPPORT + j]
        kind = 0
        while kind < kinds and (numbers[7 + 4 * kind] != xi or numbers[8 + 4 * kind] != k):
            kind += 1
        slot = 5 + 4 * kind
        if kind == kinds:
            kinds += 1
            numbers[slot], numbers[slot + 1], numbers[slot + 2], numbers[slot + 3] = 0.0, 0.0, xi, k
        numbers[slot] += weight * model[KAPPA + j // 3]
        numbers[slot + 1] += weight * model[XI_TRANSLATION + j // 3]
    numbers[4] = kinds


@kernel(types.UniTuple(_C, 4)(ARRAY, ARRAY, _F, ARRAY, _C), inner=True)
def _linear_terms(theta, direction, p, numbers, s):
    """D, A and B of `solver.harmonic.impedance` at one complex frequency, and the phase of their common denominator.

    The supports resonate within their damping ratio of the imaginary axis, where the determinant has poles; times that
    phase it is one of an entire function. A `ContactSystem` keeps its poles.
    """
    if theta[KIND] != GEAR:
        D, A, B, _ = impedance(theta, direction, p, s, 0j, -1)[0]
        return D, A, B, 1.0 + 0j
    square = s * s
    T, U, phase = 0j, 0j, 1.0 + 0j
    for kind in range(int(numbers[4])):
        slot = 5 + 4 * kind
        Z = numbers[slot + 3] + 2.0 * numbers[slot + 2] * s + square
        size = Z.real * Z.real + Z.imag * Z.imag
        inverse = 1.0 / size if size > 0.0 else math.inf
        receptance = complex(Z.real * inverse, -Z.imag * inverse)
        T += numbers[slot] * receptance
        U += numbers[slot + 1] * receptance
        length = math.sqrt(inverse)
        phase *= complex(Z.real * length, Z.imag * length)
    T, U = -square * T, -square * U
    return square + 2.0 * s * (numbers[0] - U), numbers[1] - T, numbers[2] - T * numbers[3], phase


@kernel(_C(HILL, _C, COMPLEX_MATRIX), inner=True)
def fill_matrix(hill, z, matrix):
    """Fill the matrix over a window, its rows divided by R_k, for one exponent z; the phase of its poles (see below).

    The determinant times the number returned has the phase of an entire function (gear pairs).
    """
    size, phase = matrix.shape[0], 1.0 + 0j
    for i in range(size):
        s = 1j * (z + (i - hill.harmonics)) * hill.omega
        D, A, B, pole = _linear_terms(hill.theta, hill.direction, hill.p, hill.numbers, s)
        phase *= pole
        inverse = 1.0 / (abs(D) + abs(A))
        A, B = A * inverse, B * inverse
        for j in range(size):
            matrix[i, j] = A * hill.contact[i, j] + B * hill.varied[i, j]
        matrix[i, i] += D * inverse
    return phase


@kernel(HILL(ARRAY, ARRAY, ARRAY, _F, _I, _B), inner=True)
def hill_of(theta, direction, u, p, window, truncated):
    """What the matrices over a window of a motion u have in common, at all exponents.

    Parameters
    ----------
    theta, direction : arrays
        Of `solver.harmonic.layout.packed`.
    u : (n,) array
    p : float
        Axis value.
    window : {WHOLE, HALF}
    truncated : bool
        Whether the force is truncated before the stiffness multiplies it: the describing function.

    Returns
    -------
    Hill
    """
    n = u.shape[0]
    longest, long = spectrum_sizes(theta, n // 2)
    chi, psi = np.empty(longest, _COMPLEX), np.empty(long, _COMPLEX)
    angles, zones = np.empty(2 * n + 8), np.empty(2 * n + 8, np.int64)
    motion_spectra(theta, direction, u, p, chi, psi, angles, zones)
    contact, varied = np.empty((n - window, n - window), _COMPLEX), np.empty((n - window, n - window), _COMPLEX)
    contact_matrices(theta, direction, p, chi, psi, truncated, contact, varied)
    numbers = np.empty(LINEAR)
    linear_numbers(theta, direction, p, numbers)
    return Hill(theta, direction, p, base_frequency(theta, direction, p)[0], n // 2, numbers, contact, varied)


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
            D, A, B, _ = _linear_terms(theta, still, 0.0, numbers, 1j * (z + (i - harmonics)) * omega)
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
