"""Hill's exponents one by one, as roots of the matrix condensed to the contact coordinate: for larger orders.

With Z = s^2 M + s C + K + gamma h w^T at s_k = s + i k Omega/nu, A = w.Z^-1 h, B = w.Z^-1 h_v, and chi and
s chi as in `hill.coupling`,

    (1 - gamma A_k) l_k + A_k (chi l)_k + B_k (s chi l)_k = 0

whose rows are those of `solver.harmonic.perturbation` but for a factor. gamma only moves the poles, which are the
exponents of the system closed by the stiffness gamma: with a negative one they are far from those of any motion. Roots
are found by Newton's method on (s, l), which is inverse iteration with the exact derivative of the matrix (Ruhe, SIAM
Journal on Numerical Analysis 10, 1973), from given exponents, in the window whose centre is nearest to them. Whether
they are all is checked by their sum, which is the negative trace of M^-1 C (Liouville) up to truncation, and by the
sign of the determinant at s = 0, which tells whether the growing real exponents are even or odd in number: static
stability is never contradicted.
"""

import math

import numpy as np

from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import eliminate_rows
from solver.stability.floquet import SYSTEMS, contact_shares
from solver.stability.hill import COMPLEX_MATRIX, Truncation, apart, coupling
from solver.stability.system_row import SystemRow

__all__ = ["condensed_exponents"]

_I, _F, _C = types.int64, types.float64, types.complex128
_COMPLEX = np.complex128

_GAMMA = -0.5
_ITERATIONS = 16
# Steps of Newton's method square: after one of this size the next is rounding.
_SETTLED = 1e-8


@kernel(types.UniTuple(_C, 4)(_C, MATRIX, MATRIX, ARRAY, ARRAY, ARRAY, types.complex128[:, :, ::1]), inner=True)
def _receptances(s, damping, stiffness, force, varying, contact, work):
    """A and B of the module and their derivatives by s."""
    n = force.shape[0]
    forward, backward, rights, across = work[0, :n], work[1, :n], work[2, :2], work[2, 2:3]
    for i in range(n):
        rights[0, i], rights[1, i], across[0, i] = force[i], varying[i], contact[i]
        for l in range(n):
            value = s * damping[i, l] + stiffness[i, l] + _GAMMA * force[i] * contact[l]
            if i == l:
                value += s * s
            forward[i, l], backward[l, i] = value, value
    if n == 2:
        # The merged gear pair: elimination costs twice as much as writing the inverse down.
        a, b, c, d = forward[0, 0], forward[0, 1], forward[1, 0], forward[1, 1]
        determinant = a * d - b * c
        size = determinant.real * determinant.real + determinant.imag * determinant.imag
        inverse = complex(determinant.real / size, -determinant.imag / size)
        for row in range(2):
            first, second = rights[row, 0], rights[row, 1]
            rights[row, 0], rights[row, 1] = (d * first - b * second) * inverse, (a * second - c * first) * inverse
        first, second = across[0, 0], across[0, 1]
        across[0, 0], across[0, 1] = (d * first - c * second) * inverse, (a * second - b * first) * inverse
    else:
        eliminate_rows(forward, rights)
        eliminate_rows(backward, across)
    A, B, d_A, d_B = 0j, 0j, 0j, 0j
    for i in range(n):
        A += contact[i] * rights[0, i]
        B += contact[i] * rights[1, i]
        for l in range(n):
            weight = across[0, i] * (damping[i, l] + (2.0 * s if i == l else 0.0))
            d_A -= weight * rights[0, l]
            d_B -= weight * rights[1, l]
    return A, B, d_A, d_B


@kernel(
    _C(
        _C,
        _F,
        _I,
        MATRIX,
        MATRIX,
        ARRAY,
        ARRAY,
        ARRAY,
        COMPLEX_MATRIX,
        COMPLEX_MATRIX,
        COMPLEX_MATRIX,
        COMPLEX_MATRIX,
        types.complex128[:, :, ::1],
    ),
    inner=True,
)
def _root(s, base, lowest, damping, stiffness, force, varying, contact, near, varied, matrix, vectors, work):
    """The root next to s over the harmonics lowest ..., with its vector left in vectors[0]; nan if none is found."""
    size = near.shape[0]
    wave, right = vectors[0], vectors[1:2]
    for iteration in range(_ITERATIONS):
        for i in range(size):
            A, B, d_A, d_B = _receptances(
                s + 1j * (lowest + i) * base, damping, stiffness, force, varying, contact, work
            )
            through, modulated = 0j, 0j
            for j in range(size):
                matrix[i, j] = A * near[i, j] + B * varied[i, j]
                through += near[i, j] * wave[j]
                modulated += varied[i, j] * wave[j]
            matrix[i, i] += 1.0 - _GAMMA * A
            # The first solution only makes the vector, by inverse iteration from all harmonics alike.
            right[0, i] = d_A * (through - _GAMMA * wave[i]) + d_B * modulated if iteration > 0 else 1.0 + 0j
        eliminate_rows(matrix, right)
        largest, place = 0.0, 0
        for i in range(size):
            if abs(right[0, i]) > largest:
                largest, place = abs(right[0, i]), i
        if not 0.0 < largest < math.inf:
            return complex(math.nan, math.nan)
        step = wave[place] / right[0, place] if iteration > 0 else 0j
        for i in range(size):
            wave[i] = right[0, i] / right[0, place]
        s -= step
        if iteration > 1 and abs(step) <= _SETTLED * (base + abs(s)):
            return s
    return complex(math.nan, math.nan)


@kernel(
    _F(
        _F,
        MATRIX,
        MATRIX,
        ARRAY,
        ARRAY,
        ARRAY,
        COMPLEX_MATRIX,
        COMPLEX_MATRIX,
        COMPLEX_MATRIX,
        COMPLEX_MATRIX,
        types.complex128[:, :, ::1],
    ),
    inner=True,
)
def _determinant(base, damping, stiffness, force, varying, contact, near, varied, matrix, right, work):
    """Determinant of the matrix over -H ... H at s = 0, where it is real."""
    size = near.shape[0]
    for i in range(size):
        s = 1j * (i - size // 2) * base
        A, B, _, _ = _receptances(s, damping, stiffness, force, varying, contact, work)
        for j in range(size):
            matrix[i, j] = A * near[i, j] + B * varied[i, j]
        matrix[i, i] += 1.0 - _GAMMA * A
    return (eliminate_rows(matrix, right) + 0j).real


@kernel(
    types.void(
        *SYSTEMS, types.int64[::1], ARRAY, MATRIX, MATRIX, _I, types.boolean, COMPLEX_MATRIX, COMPLEX_MATRIX, ARRAY
    )
)
def _follow(
    damping,
    stiffness,
    force,
    varying,
    contact,
    phasors,
    which,
    omega,
    gaps,
    motions,
    period,
    truncated,
    starts,
    found,
    signs,
):
    """Fill found (k, 2n) with the roots next to starts (k, 2n), nan where Newton's method does not settle.

    signs (k,) is filled with the sign of the matrix's determinant over -H ... H at s = 0.
    """
    order, n = motions.shape[1] // 2, force.shape[1]
    size = 2 * order + 1
    room, work = np.empty((5, size, size), _COMPLEX), np.empty((3, max(n, 3), n), _COMPLEX)
    for k in range(motions.shape[0]):
        g, base = which[k], omega[k] / period
        for half in range(2):
            width, ready = size - half, half == 0
            near = room[0].reshape(size * size)[: width * width].reshape((width, width))
            varied = room[1].reshape(size * size)[: width * width].reshape((width, width))
            matrix = room[2].reshape(size * size)[: width * width].reshape((width, width))
            vectors = room[3].reshape(size * size)[: 2 * width].reshape((2, width))
            if half == 0:
                coupling(motions[k], gaps[k, 0], gaps[k, 1], phasors[g], period, truncated, near, varied)
                vectors[:] = 0.0
                signs[k] = np.sign(
                    _determinant(
                        base,
                        damping[g],
                        stiffness[g],
                        force[g],
                        varying[g],
                        contact[g],
                        near,
                        varied,
                        matrix,
                        vectors[1:2],
                        work,
                    )
                )
            for r in range(starts.shape[1]):
                s = starts[k, r]
                # Half-odd multiples are for exponents whose mirror image lies an odd number of harmonics away, if kept.
                turns = abs(s.imag) / base
                between = abs(turns - np.rint(turns)) > 0.25 and 2.0 * turns <= order + 0.5
                if between != (half == 1):
                    continue
                if r > 0 and starts[k, r - 1] == s.conjugate() and s.imag != 0.0:
                    found[k, r] = found[k, r - 1].conjugate()
                    continue
                if not ready:
                    coupling(motions[k], gaps[k, 0], gaps[k, 1], phasors[g], period, truncated, near, varied)
                    ready = True
                # The window is symmetric about its centre, so that a start below the axis is its mirror image above it.
                s = complex(s.real, abs(s.imag))
                kept, least = complex(math.nan, math.nan), math.inf
                for _ in range(3):
                    s = _root(
                        s,
                        base,
                        -order,
                        damping[g],
                        stiffness[g],
                        force[g],
                        varying[g],
                        contact[g],
                        near,
                        varied,
                        matrix,
                        vectors,
                        work,
                    )
                    turn, weight = 0.0, 0.0
                    for i in range(width):
                        share = abs(vectors[0, i]) ** 2
                        turn += (i - order + 0.5 * half) * share
                        weight += share
                    # One image i Omega/nu further the harmonics are one less: the best image is the most centred. It
                    # may not be found, or be taken for that of another exponent.
                    centre = turn / weight
                    moved = (s - kept).imag / base if least < math.inf else 0.0
                    if not abs(centre) < least or abs(moved - np.rint(moved)) > 0.1:
                        break
                    kept, least, shift = s, abs(centre), np.rint(centre)
                    if shift == 0.0:
                        break
                    s += 1j * shift * base
                s = kept
                found[k, r] = s if starts[k, r].imag >= 0.0 else s.conjugate()


def _images(row: SystemRow, motions: np.ndarray, truncation: Truncation, starts: np.ndarray) -> np.ndarray:
    """The image s + i m Omega/nu of every start that is nearest to an exponent of the system closed for the mean time.

    Where Omega is low the image of smallest imaginary part is of harmonics that are not kept.
    """
    n, base = row.states // 2, row.omega[:, None, None] / truncation.period
    share = contact_shares(row, motions)[:, None, None]
    mean = np.zeros((len(motions), 2 * n, 2 * n))
    mean[:, :n, n:] = np.eye(n)
    closed = row.force[:, :, None] * row.contact[:, None, :]
    mean[:, n:, :n] = -row.stiffness[row.which] - share * closed[row.which]
    mean[:, n:, n:] = -row.damping[row.which]
    exponents = np.linalg.eigvals(mean)[:, None, :]
    with np.errstate(invalid="ignore"):
        turns = np.rint((exponents - starts[:, :, None]).imag / base)
        distance = np.abs(starts[:, :, None] + 1j * turns * base - exponents)
        nearest = np.argmin(distance, axis=2)[..., None]
        turns = np.take_along_axis(turns, nearest, axis=2)[..., 0]
        # Where harmonics enough are kept, the image of smallest imaginary part is the best one.
        turns[2.0 * np.abs(turns) <= truncation.harmonics] = 0.0
        half_turns = 2.0 * starts.imag / base[..., 0]
        # Real multipliers stay on their lines, where only the centred image is real in the truncated matrix too.
        free = np.abs(half_turns - np.rint(half_turns)) > 1e-9
        below = starts.imag < 0.0
    moved = np.where(free, starts + 1j * turns * base[..., 0], starts)
    # Conjugates move together.
    moved[:, 1:] = np.where(below[:, 1:] & free[:, 1:], np.conj(moved[:, :-1]), moved[:, 1:])
    return moved


def condensed_exponents(
    row: SystemRow, motions: np.ndarray, truncation: Truncation, starts: np.ndarray, defect: float = 0.05
) -> tuple[np.ndarray, np.ndarray]:
    """Exponents of motions next to given ones, and whether they are all.

    Parameters
    ----------
    row : SystemRow
        Of k motions.
    motions : (k, 2 H + 1) array
    truncation : Truncation
    starts : (k, 2n) complex array
        Exponents up to multiples of i Omega/nu, conjugates side by side: those of Floquet.
    defect : float
        Largest difference allowed between the sum of all exponents and the negative trace of M^-1 C, against the sum of
        their real parts' sizes.

    Returns
    -------
    exponents : (k, 2n) complex array
    complete : (k,) bool array
        Whether every one was found, all differ, and their sum and the number of real ones that grow are right.
    """
    starts = _images(row, motions, truncation, starts)
    found, signs = np.empty_like(starts), np.empty(len(motions))
    _follow(
        *row.systems,
        row.which,
        row.omega,
        row.gaps,
        np.ascontiguousarray(motions, dtype=float),
        truncation.period,
        truncation.truncated,
        starts,
        found,
        signs,
    )
    with np.errstate(over="ignore", invalid="ignore"):
        real = found.real
        complete = np.abs(np.sum(real, axis=1) + row.decay) <= defect * np.sum(np.abs(real), axis=1)
    base = row.omega / truncation.period
    # The uncondensed determinant at s = 0 has the sign of the number of growing real exponents.
    poles = np.linalg.slogdet(row.stiffness + _GAMMA * row.force[:, :, None] * row.contact[:, None, :])[0]
    growing = np.sum((np.abs(found.imag) < 1e-6 * base[:, None]) & (real > 0.0), axis=1)
    complete &= (growing % 2 == 0) == (signs * poles[row.which] > 0.0)
    for i in range(found.shape[1]):
        for j in range(i):
            complete &= apart(found[:, i], found[:, j], base) > 1e-6 * base
    return found, complete
