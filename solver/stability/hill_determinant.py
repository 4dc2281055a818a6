"""The determinant of Hill's matrix, condensed to the contact coordinate.

With z = s/(i Omega/nu) an exponent in units of the base frequency, the matrix of `solver.harmonic.perturbation` over
the harmonics k of one *window* is singular at the exponents of a motion. Two windows keep the spectrum's symmetry:

    whole  k = -H ... H      about z = 0:    real there, zero at folds
    half   k = -H ... H - 1  about z = 1/2:  real there, zero at period doublings; they are the subharmonics of order H

An exponent is sought in the window whose centre is nearer: in the other one its harmonics are cut off lopsidedly, which
splits a negative multiplier into a pair. Rows are divided by R_k = |D_k| + |A_k|, so that the determinant is of order
one.
"""

import math
from collections import namedtuple

import numpy as np

from solver.contact.spectrum import COMPLEX, contact_arcs, contact_spectrum
from solver.harmonic.contact_terms import coefficient, modulated
from solver.harmonic.impedance import base_frequency, impedance, stiffness_phasor
from solver.harmonic.layout import BACK, FRONT, GEAR, KIND, PAIRS, PERIOD, STIFFNESSES
from solver.harmonic.perturbation import COMPLEX_MATRIX
from solver.kernels import types
from solver.kernels.compile import ARRAY, kernel
from solver.model.condensation import (
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

__all__ = [
    "HALF",
    "HILL",
    "LINEAR",
    "WHOLE",
    "Hill",
    "contact_matrices",
    "determinant",
    "fill_matrix",
    "hill_of",
    "linear_numbers",
    "linear_terms",
    "magnitude",
    "motion_spectra",
    "spectrum_sizes",
]

_I, _F, _C, _B = types.int64, types.float64, types.complex128, types.boolean
_ANGLES, _ZONES = ARRAY, types.int64[::1]
_COMPLEX = np.complex128

#: What the matrices of one motion over one window have in common; see `hill_of`.
Hill = namedtuple("Hill", "theta direction p omega harmonics numbers contact varied")
HILL = types.NamedTuple((ARRAY, ARRAY, _F, _F, _I, ARRAY, COMPLEX_MATRIX, COMPLEX_MATRIX), Hill)
#: Length of what `linear_numbers` fills.
LINEAR = 5 + 4 * 6

#: The windows: by how much the number of harmonics falls short of 2 H + 1.
WHOLE, HALF = 0, 1


@kernel(types.UniTuple(_I, 2)(ARRAY, _I), inline=True)
def spectrum_sizes(theta, harmonics):
    """Lengths of chi and psi that the matrices of a motion of so many harmonics need."""
    return 2 * harmonics + 1 + int(theta[STIFFNESSES]) * int(theta[PERIOD]), 2 * harmonics + 1


@kernel(_I(ARRAY, ARRAY, ARRAY, _F, COMPLEX, COMPLEX, _ANGLES, _ZONES), inner=True)
def motion_spectra(theta, direction, u, p, chi, psi, angles, zones):
    """Fill chi, psi, angles and zones (`solver.contact.spectrum`) of a motion u; the number of angles."""
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
    """Fill `numbers` (LINEAR,) with what `linear_terms` needs of a gear pair, its supports of equal (xi_j, k_j) merged.

    They are c xi_h, c, c eps_r, eps_t and the number of kinds, then sum d_j^2 kappa_g, sum d_j^2 xi_hg, xi and k of
    each.
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
def linear_terms(theta, direction, p, numbers, s):
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
        D, A, B, pole = linear_terms(hill.theta, hill.direction, hill.p, hill.numbers, s)
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
def magnitude(value):
    """Size of a complex number, as pivoting needs it."""
    return abs(value.real) + abs(value.imag)


@kernel(_C(COMPLEX_MATRIX), inner=True)
def determinant(matrix):
    """Determinant of a complex matrix, which is overwritten."""
    n = matrix.shape[0]
    product = 1.0 + 0j
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if magnitude(matrix[i, k]) > magnitude(matrix[pivot, k]):
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
