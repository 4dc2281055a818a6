"""The contact spectra of a motion of a system, and what the periodic stiffness makes of a spectrum."""

import numpy as np

from solver.contact.spectrum import COMPLEX, contact_arcs, contact_spectrum
from solver.harmonic.impedance import stiffness_phasor
from solver.kernels import types
from solver.kernels.compile import ARRAY, kernel
from solver.model.parameters import BACK_GAP, BACK_STIFFNESS, FRONT_GAP, PERIOD, STIFFNESSES, number_at

__all__ = ["coefficient", "contact_of", "modulated"]

_I, _F = types.int64, types.float64


@kernel(types.complex128(COMPLEX, _I), inline=True)
def coefficient(coefficients, k):
    """Coefficient k of a real function whose coefficients k >= 0 are given."""
    return coefficients[k] if k >= 0 else coefficients[-k].conjugate()


@kernel(types.void(ARRAY, ARRAY, ARRAY, _F, COMPLEX, COMPLEX, COMPLEX), inner=True)
def contact_of(parameters, parameter_slope, u, p, contact, ahead, behind):
    """Fill the spectra chi, chi+ and chi- of a motion u at one axis value, those of the back flank times its stiffness.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Parameters at p = 0 and what p adds to them.
    u : (n,) array
        Unknowns (Lambda_0, c_1, s_1, ...).
    p : float
        Axis value.
    contact, ahead, behind : arrays
        Filled with the harmonics of the contact, and of the contact at either flank.
    """
    room = 2 * u.shape[0] + 8
    angles, zones = np.empty(room), np.empty(room, np.int64)
    (front, _), (back, _) = (
        number_at(parameters, parameter_slope, p, FRONT_GAP),
        number_at(parameters, parameter_slope, p, BACK_GAP),
    )
    count = contact_arcs(u, front, back, angles, zones)
    contact_spectrum(count, angles, zones, contact, ahead, behind)
    stiffness = parameters[BACK_STIFFNESS]
    if stiffness != 1.0:
        for k in range(contact.shape[0]):
            behind[k] *= stiffness
            contact[k] = ahead[k] + behind[k]


@kernel(types.void(ARRAY, ARRAY, _F, COMPLEX, COMPLEX, COMPLEX), inner=True)
def modulated(parameters, parameter_slope, p, spectrum, product, slope):
    """Coefficients of s(tau) times a real function: fill `product`, and `slope` with the derivative along the axis.

    `spectrum` must reach N nu further than `product`.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Parameters at p = 0 and what p adds to them.
    p : float
        Axis value.
    spectrum : array
        Coefficients of the function, from k = 0 on.
    product, slope : arrays
        Filled.
    """
    period = int(parameters[PERIOD])
    for k in range(product.shape[0]):
        product[k], slope[k] = 0j, 0j
    for l in range(1, int(parameters[STIFFNESSES]) + 1):
        S, d_S = stiffness_phasor(parameters, parameter_slope, p, l)
        if S == 0.0 and d_S == 0.0:
            continue
        for k in range(product.shape[0]):
            before, after = coefficient(spectrum, k - l * period), spectrum[k + l * period]
            product[k] += 0.5 * (S * before + S.conjugate() * after)
            slope[k] += 0.5 * (d_S * before + d_S.conjugate() * after)
