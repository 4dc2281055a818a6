"""Hill's method of the order and truncation of the balance: perturbations exp(s tau) sum_k y_k exp(i k theta).

It is taken in two windows of harmonics. Over k = -H ... H a real exponent passes through 0 exactly at the folds of the
balance; over k = -H ... H - 1 with s = i Omega/(2 nu) + sigma a real sigma passes through 0 exactly where the balance
of the same order on the doubled period branches off. Both windows are symmetric about their centre, so that their
matrix is real in cosines and sines of whole or half-odd multiples of theta.

Of the exponents of a window the physical ones are those whose eigenvector is centred in it: with the mean harmonic c =
sum_k k |y_k|^2 / sum_k |y_k|^2 from the centre, real ones have c = 0, and one exponent has |c| and 1/2 - |c| in the two
windows. The 2n of smallest |c| over both represent the 2n multipliers exp(s nu 2 pi/Omega). Images s + i m Omega/nu of
one of them that lost their outer harmonics can look centred as well; they are told by their value, and of the sets with
and without them the one is taken whose sum is nearest to the negative trace of M^-1 C (Liouville). Real ones never are
images.
"""

import math
from dataclasses import dataclass

import numpy as np

from solver.contact.spectrum import COMPLEX, contact_arcs, contact_spectrum
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.stability.floquet import SYSTEMS
from solver.stability.system_row import SystemRow

__all__ = [
    "COMPLEX_MATRIX",
    "Truncation",
    "apart",
    "centred_exponents",
    "coupling",
    "hill_matrices",
    "window_exponents",
]

COMPLEX_MATRIX = types.complex128[:, ::1]
_I, _F = types.int64, types.float64
_COMPLEX = np.complex128

# Exponents this close, as a share of the base frequency and up to multiples of it, may be images of one.
_IMAGES = (0.05, 0.1)


@dataclass(frozen=True)
class Truncation:
    """Which harmonics Hill's matrix keeps, and of what.

    Parameters
    ----------
    harmonics : int
        Harmonics H of the base frequency Omega/nu, as many as the motions have.
    period : int
        nu.
    truncated : bool
        Whether the force is truncated to the harmonics kept before it is multiplied by s(tau): the describing function.
    """

    harmonics: int = 1
    period: int = 1
    truncated: bool = True


@kernel(types.void(ARRAY, _F, _F, COMPLEX, _I, types.boolean, COMPLEX_MATRIX, COMPLEX_MATRIX), inner=True)
def coupling(motion, front, back, phasors, period, truncated, near, varied):
    """Fill near[i, j] and varied[i, j]: what harmonic j of lambda gives harmonic i of chi lambda and s chi lambda."""
    size, shifts = near.shape[0], phasors.shape[0]
    room = 2 * motion.shape[0] + 8
    angles, zones = np.empty(room), np.empty(room, np.int64)
    spectra = np.empty((3, size + shifts * period), _COMPLEX)
    count = contact_arcs(motion, front, back, angles, zones)
    chi = spectra[0]
    contact_spectrum(count, angles, zones, chi, spectra[1], spectra[2])
    for i in range(size):
        for j in range(size):
            near[i, j] = chi[i - j] if i >= j else chi[j - i].conjugate()
            total = 0j
            for l in range(1, shifts + 1):
                for sign in (-1, 1):
                    middle = i - sign * l * period
                    if truncated and not 0 <= middle < size:
                        continue
                    step = middle - j
                    part = chi[step] if step >= 0 else chi[-step].conjugate()
                    phasor = phasors[l - 1] if sign == 1 else phasors[l - 1].conjugate()
                    total += 0.5 * phasor * part
            varied[i, j] = total


@kernel(types.void(MATRIX, _I, _I, _I, ARRAY, ARRAY, ARRAY, types.complex128, types.complex128, _F, _F), inner=True)
def _couple(matrix, row, column, n, force, varying, contact, near, varied, real, imag):
    """Take (real Re + imag Im) of the coupling off the block of velocities at `row` and displacements at `column`."""
    for i in range(n):
        total = force[i] * near + varying[i] * varied
        value = real * total.real + imag * total.imag
        for l in range(n):
            matrix[row + n + i, column + l] -= value * contact[l]


_FLAG = types.boolean


@kernel(types.void(*SYSTEMS, types.int64[::1], ARRAY, MATRIX, MATRIX, _I, _FLAG, _FLAG, types.float64[:, :, ::1]))
def _hill_matrices(
    damping, stiffness, force, varying, contact, phasors, which, omega, gaps, motions, period, truncated, half, found
):
    """Fill found (k, d, d) with the real matrices of one window; see `hill_matrices`."""
    n, order = force.shape[1], motions.shape[1] // 2
    size, block = 2 * order + (0 if half else 1), 2 * force.shape[1]
    near, varied = np.empty((size, size), _COMPLEX), np.empty((size, size), _COMPLEX)
    mean = 0 if half else block
    for k in range(motions.shape[0]):
        g, matrix, base = which[k], found[k], omega[k] / period
        h, v, w = force[g], varying[g], contact[g]
        coupling(motions[k], gaps[k, 0], gaps[k, 1], phasors[g], period, truncated, near, varied)
        matrix[:] = 0.0
        for part in range(matrix.shape[0] // block):
            at = part * block
            for i in range(n):
                matrix[at + i, at + n + i] = 1.0
                for l in range(n):
                    matrix[at + n + i, at + l] = -stiffness[g, i, l]
                    matrix[at + n + i, at + n + l] = -damping[g, i, l]
        if not half:
            _couple(matrix, 0, 0, n, h, v, w, near[order, order], varied[order, order], 1.0, 0.0)
        for p in range(1, order + 1):
            cosine = mean + (2 * p - 2) * block
            sine = cosine + block
            rate = (p - 0.5 if half else p) * base
            for i in range(block):
                matrix[cosine + i, sine + i] -= rate
                matrix[sine + i, cosine + i] += rate
            plus = order + p - (1 if half else 0)
            if not half:
                _couple(matrix, cosine, 0, n, h, v, w, near[plus, order], varied[plus, order], 2.0, 0.0)
                _couple(matrix, sine, 0, n, h, v, w, near[plus, order], varied[plus, order], 0.0, -2.0)
                _couple(matrix, 0, cosine, n, h, v, w, near[order, plus], varied[order, plus], 1.0, 0.0)
                _couple(matrix, 0, sine, n, h, v, w, near[order, plus], varied[order, plus], 0.0, 1.0)
            for q in range(1, order + 1):
                after, before = order + q - (1 if half else 0), order - q
                other = mean + (2 * q - 2) * block
                chi, psi = near[plus, after] + near[plus, before], varied[plus, after] + varied[plus, before]
                _couple(matrix, cosine, other, n, h, v, w, chi, psi, 1.0, 0.0)
                _couple(matrix, sine, other, n, h, v, w, chi, psi, 0.0, -1.0)
                chi, psi = near[plus, after] - near[plus, before], varied[plus, after] - varied[plus, before]
                _couple(matrix, cosine, other + block, n, h, v, w, chi, psi, 0.0, 1.0)
                _couple(matrix, sine, other + block, n, h, v, w, chi, psi, 1.0, 0.0)


def hill_matrices(row: SystemRow, motions: np.ndarray, truncation: Truncation, half: bool = False) -> np.ndarray:
    """Hill's matrix of a window in real form.

    Parameters
    ----------
    row : SystemRow
        Of k motions.
    motions : (k, 2 H + 1) array
    truncation : Truncation
    half : bool
        The window of half-odd multiples of the base frequency instead of whole ones.

    Returns
    -------
    (k, d, d) array
        On (mean, cosine 1, sine 1, ...), each of 2n states (y, y'); d = 2n (2 H + 1), or 4n H and no mean with `half`.
    """
    size = row.states * (2 * truncation.harmonics + (0 if half else 1))
    found = np.empty((len(motions), size, size))
    _hill_matrices(
        *row.systems,
        row.which,
        row.omega,
        row.gaps,
        np.ascontiguousarray(motions, dtype=float),
        truncation.period,
        truncation.truncated,
        half,
        found,
    )
    return found


def window_exponents(row: SystemRow, motions: np.ndarray, truncation: Truncation, half: bool = False):
    """All exponents of one window, measured from its centre, and their mean harmonics.

    Returns
    -------
    exponents : (k, d) complex array
        s, or sigma = s - i Omega/(2 nu) with `half`; in conjugate pairs.
    centres : (k, d) array
        c of the module.
    """
    values, vectors = np.linalg.eig(hill_matrices(row, motions, truncation, half))
    states, order, count = row.states, truncation.harmonics, len(motions)
    start = 0 if half else states
    waves = vectors[:, start:].reshape(count, order, 2, states, -1)
    # |a - i b|^2 - |a + i b|^2 = 4 Im(conj(a) b) up to its sign, and their sum 2 (|a|^2 + |b|^2).
    turn = 2.0 * np.sum(waves[:, :, 1] * np.conj(waves[:, :, 0]), axis=2).imag
    weight = np.sum(np.abs(waves) ** 2, axis=(2, 3))
    harmonics = np.arange(1, order + 1) - (0.5 if half else 0.0)
    whole = 2.0 * np.sum(np.abs(vectors[:, :start]) ** 2, axis=1) + np.sum(weight, axis=1)
    return values.astype(complex), np.einsum("p,kpd->kd", harmonics, turn) / whole


def apart(left, right, base):
    """Distance of two exponents when multiples of i times the base frequency do not count; nan if one is not finite."""
    with np.errstate(over="ignore", invalid="ignore"):
        gap = left - right
        return np.hypot(gap.real, gap.imag - base * np.rint(gap.imag / base))


@kernel(types.void(COMPLEX_MATRIX, types.int64[:, ::1], types.int64[:, ::1], ARRAY, ARRAY, COMPLEX_MATRIX))
def _select(exponents, sizes, order, base, decay, found):
    """Fill found (k, 2n) with exponents of both windows (k, d), tried in the given order.

    sizes (k, d): 1 for a real exponent, 2 for one that stands for a pair, 0 for the other of that pair.
    """
    states, many = found.shape[1], exponents.shape[1]
    chosen, image = np.empty(states, _COMPLEX), np.empty(many, np.bool_)
    for k in range(found.shape[0]):
        least = math.inf
        for reach in (0.0, _IMAGES[0], _IMAGES[1]):
            count, total = 0, decay[k]
            image[:] = False
            for again in range(2):
                for i in order[k]:
                    size, s = sizes[k, i], exponents[k, i]
                    if size == 0 or (again == 1 and not image[i]):
                        continue
                    if again == 0 and size == 2:
                        for j in range(count):
                            gap = s - chosen[j]
                            turns = gap.imag / base[k]
                            image[i] |= math.hypot(gap.real, (turns - np.rint(turns)) * base[k]) < reach * base[k]
                        if image[i]:
                            continue
                    if count + size <= states:
                        chosen[count] = s
                        if size == 2:
                            chosen[count + 1] = s.conjugate()
                        count += size
                        total += size * s.real
            if abs(total) < 0.999 * least:
                least = abs(total)
                found[k, :] = chosen


def centred_exponents(row: SystemRow, motions: np.ndarray, truncation: Truncation) -> np.ndarray:
    """The 2n physical exponents of every motion, complex (k, 2n); see the module."""
    states = row.states
    s, c = window_exponents(row, motions, truncation)
    order = np.argsort(np.abs(c), axis=1, kind="stable")[:, :states]
    found = np.take_along_axis(s, order, axis=1)
    far = np.abs(np.take_along_axis(c, order[:, -1:], axis=1)[:, 0]) > 0.25
    # A pair of exponents may not be cut by the end of the list, and images of one exponent may not stand for two.
    far |= np.abs(np.sum(found.imag, axis=1)) > 1e-9 * np.max(np.abs(found), axis=1)
    base = row.omega / truncation.period
    for i in range(states):
        for j in range(i):
            real = (found[:, i].imag == 0.0) | (found[:, j].imag == 0.0)
            far |= ~real & (apart(found[:, i], found[:, j], base) < _IMAGES[-1] * base)
    places = np.flatnonzero(far)
    if places.size:
        some = row.take(places)
        sigma, c_half = window_exponents(some, motions[places], truncation, half=True)
        both = np.concatenate([s[places], sigma], axis=1)
        sizes = np.where(both.imag == 0.0, 1, np.where(both.imag > 0.0, 2, 0))
        shifted = np.concatenate([s[places], sigma + 0.5j * base[places, None]], axis=1)
        order = np.argsort(np.abs(np.concatenate([c[places], c_half], axis=1)), axis=1, kind="stable")
        chosen = np.empty((len(places), states), dtype=complex)
        _select(shifted, sizes, order, base[places], some.decay, chosen)
        found[places] = chosen
    return found
