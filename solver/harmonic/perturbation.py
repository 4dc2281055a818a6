"""The balance linearised about a motion: Hill's matrix on the contact coordinate alone, at any complex frequency.

A perturbation exp(s tau) sum_k l_k exp(i k theta), theta = Omega tau/nu, of a motion with the contact spectrum chi
changes the force by chi * l, exactly (f vanishes where contact switches). With s_k = s + i k Omega/nu and psi the
spectrum of s(tau) chi,

    D(s_k) l_k + sum_m [A(s_k) chi_(k-m) + B(s_k) psi_(k-m)] l_m = 0

The motion's exponents are the s for which this matrix is singular; the linear coordinates are condensed into D, A and
B, so that it has the size of the harmonics kept. At s = 0 over k = -H ... H it is the balance's Jacobian in complex
form, hence singular at folds; at s = i Omega/(2 nu) over k = -H ... H - 1 it is singular at period doublings, and its
determinant is real: rows k and -1 - k are conjugates. For the describing function f is truncated to the harmonics kept
before it is multiplied by s(tau), as in the balance itself.
"""

import numpy as np

from solver.contact.spectrum import COMPLEX
from solver.harmonic.contact_terms import contact_of, modulated
from solver.harmonic.impedance import base_frequency, impedance, stiffness_phasor
from solver.harmonic.layout import PERIOD, STIFFNESSES
from solver.kernels import types
from solver.kernels.compile import ARRAY, kernel

__all__ = ["COMPLEX_MATRIX", "contact_and_modulated", "perturbation_matrix"]

COMPLEX_MATRIX = types.complex128[:, ::1]
_I, _F, _C = types.int64, types.float64, types.complex128


@kernel(types.void(ARRAY, ARRAY, ARRAY, _F, COMPLEX, COMPLEX), inner=True)
def contact_and_modulated(theta, direction, u, p, chi, psi):
    """Fill chi_0 ... of a motion u, and psi_0 ... psi_(size - 1); chi must be N nu longer than psi."""
    spectra = np.empty((3, max(chi.shape[0], psi.shape[0])), np.complex128)
    contact_of(theta, direction, u, p, chi, spectra[0][: chi.shape[0]], spectra[1][: chi.shape[0]])
    modulated(theta, direction, p, chi, psi, spectra[2][: psi.shape[0]])


@kernel(types.void(ARRAY, ARRAY, _F, _C, _I, COMPLEX, COMPLEX, types.boolean, COMPLEX_MATRIX), inner=True)
def perturbation_matrix(theta, direction, p, s, lowest, chi, psi, truncated, matrix):
    """Fill the matrix of the module.

    Parameters
    ----------
    theta, direction : arrays
        Of `solver.harmonic.layout.packed`.
    p : float
        Axis value.
    s : complex
    lowest : int
        The first harmonic k of the perturbation; the others follow.
    chi, psi : complex arrays
        Of `contact_and_modulated`, psi at least as long as the matrix.
    truncated : bool
        Whether the force is truncated before it is multiplied by s(tau): the describing function.
    matrix : (size, size) complex array
    """
    size, period = matrix.shape[0], int(theta[PERIOD])
    omega = base_frequency(theta, direction, p)[0]
    for i in range(size):
        at = s + 1j * (lowest + i) * omega
        D, A, B, _ = impedance(theta, direction, p, at, 0j, -1)[0]
        for j in range(size):
            step = i - j
            near = chi[step] if step >= 0 else chi[-step].conjugate()
            varied = 0j
            if not truncated:
                varied = psi[step] if step >= 0 else psi[-step].conjugate()
            else:
                for l in range(1, int(theta[STIFFNESSES]) + 1):
                    S = 0.5 * stiffness_phasor(theta, direction, p, l)[0]
                    for sign in (-1, 1):
                        middle = i - sign * l * period
                        if 0 <= middle < size:
                            step = middle - j
                            part = chi[step] if step >= 0 else chi[-step].conjugate()
                            varied += (S if sign == 1 else S.conjugate()) * part
            matrix[i, j] = A * near + B * varied
        matrix[i, i] += D
