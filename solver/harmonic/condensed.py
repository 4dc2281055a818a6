"""The numbers of the first-order balance on the contact coordinate: of a gear pair, and of any system with one contact.

Everything but lambda is linear. Seen from the contact the rest is, for the mean and for the first harmonic, one number
each in front of lambda, of the contact force f and of the modulated force s f, and a load (`solver.harmonic.impedance`,
docs/physics.md, sections 3.2 and 4.5). With f truncated to f_0 and f_1 before the stiffness multiplies it, and
S_l = alpha_l exp(i Phi_kl), the balance is

    E_0 = D_0 lambda_m + c f_0 + Re(e conj f_1) - load,    E_1 = D Lambda_1 + A f_1 + P_1 f_0 + P_2 conj(f_1) - F

A gear pair, whose rotation is free, has D_0 = 0.
"""

import math

from solver.harmonic.impedance import stiffness_phasor, system_impedance
from solver.kernels import types
from solver.kernels.compile import ARRAY, kernel
from solver.model.condensation import mesh_receptance, phasor, rotation_coupling
from solver.model.parameters import (
    ALPHA,
    ALPHA_2,
    BACK_GAP,
    BACK_STIFFNESS,
    F_E,
    F_PM,
    F_PV,
    FRONT_GAP,
    MESH_FREQUENCY,
    OMEGA,
    STIFFNESSES,
    VARIATION_R,
    VARIATION_T,
    XI_MESH,
    B,
    number_at,
)

__all__ = ["CONDENSED", "CONSTANTS", "VALUES", "coefficients", "gaps", "system_coefficients"]

VALUES, CONSTANTS = types.UniTuple(types.complex128, 6), types.UniTuple(types.float64, 6)
#: Values and their derivatives along an axis, constants and theirs.
CONDENSED = types.Tuple((VALUES, VALUES, CONSTANTS, CONSTANTS))

_F = types.float64


@kernel(CONDENSED(ARRAY, ARRAY, _F), inner=True, shared=True)
def coefficients(parameters, parameter_slope, p):
    """The numbers that the balance of a gear pair depends on at one axis value, and their derivatives along the axis.

    Parameters
    ----------
    parameters, parameter_slope : (34,) arrays
    p : float
        Axis value.

    Returns
    -------
    values, d_values : 6 complex numbers each
        D, A = c - T, P_1 = (c eps_r - T eps_t) S_1, P_2 = (c eps_r - T eps_t) S_2/2, F_1 and e = c eps_r S_1/2.
    constants, d_constants : 6 floats each
        c, the mean load f_pm, both gaps, D_0 = 0, and the stiffness of the back flank over that of the front one.
    """
    omega, d_omega = number_at(parameters, parameter_slope, p, OMEGA)
    T, U, d_T, d_U = mesh_receptance(parameters, parameter_slope, p, 1j * omega, 1j * d_omega)
    c, d_c = rotation_coupling(parameters, parameter_slope, p)
    xi, d_xi = number_at(parameters, parameter_slope, p, XI_MESH)
    eps_t, d_eps_t = number_at(parameters, parameter_slope, p, VARIATION_T)
    eps_r, d_eps_r = number_at(parameters, parameter_slope, p, VARIATION_R)
    S_1, d_S_1 = phasor(parameters, parameter_slope, p, ALPHA)
    S_2, d_S_2 = phasor(parameters, parameter_slope, p, ALPHA_2)
    error, d_error = phasor(parameters, parameter_slope, p, F_E)
    damping, d_damping = c * xi - U, d_c * xi + c * d_xi - d_U
    rotating, d_rotating = c * eps_r, d_c * eps_r + c * d_eps_r
    varying, d_varying = rotating - T * eps_t, d_rotating - d_T * eps_t - T * d_eps_t
    b, d_b = number_at(parameters, parameter_slope, p, B)
    return (
        (
            -omega * omega + 2j * omega * damping,
            c - T,
            varying * S_1,
            0.5 * varying * S_2,
            parameters[F_PV] + p * parameter_slope[F_PV] + error * omega * omega,
            0.5 * rotating * S_1,
        ),
        (
            -2.0 * omega * d_omega + 2j * (d_omega * damping + omega * d_damping),
            d_c - d_T,
            d_varying * S_1 + varying * d_S_1,
            0.5 * (d_varying * S_2 + varying * d_S_2),
            parameter_slope[F_PV] + d_error * omega * omega + 2.0 * error * omega * d_omega,
            0.5 * (d_rotating * S_1 + rotating * d_S_1),
        ),
        (c, parameters[F_PM] + p * parameter_slope[F_PM], b, b, 0.0, 1.0),
        (d_c, parameter_slope[F_PM], d_b, d_b, 0.0, 0.0),
    )


@kernel(types.UniTuple(_F, 5)(ARRAY, ARRAY, _F), inline=True)
def gaps(parameters, parameter_slope, p):
    """Both gaps of a system at one axis value, their derivatives, and how stiff the back flank is; 0 if there is none.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Of `solver.model.packing.packed`.
    p : float
        Axis value.
    """
    front, d_front = number_at(parameters, parameter_slope, p, FRONT_GAP)
    if not math.isfinite(parameters[BACK_GAP]):
        return front, 0.0, d_front, 0.0, 0.0
    back, d_back = number_at(parameters, parameter_slope, p, BACK_GAP)
    return front, back, d_front, d_back, parameters[BACK_STIFFNESS]


@kernel(CONDENSED(ARRAY, ARRAY, _F), inner=True, shared=True)
def system_coefficients(parameters, parameter_slope, p):
    """What `coefficients` gives, of a `ContactSystem`.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Of `solver.model.packing.packed` for one harmonic and one period.
    p : float
        Axis value.
    """
    omega, d_omega = number_at(parameters, parameter_slope, p, MESH_FREQUENCY)
    (D_0, A_0, B_0, G_0), (d_D_0, d_A_0, d_B_0, d_G_0) = system_impedance(parameters, parameter_slope, p, 0j, 0j, 0)
    (D, A, B, G), (d_D, d_A, d_B, d_G) = system_impedance(parameters, parameter_slope, p, 1j * omega, 1j * d_omega, 1)
    S_1, d_S_1 = stiffness_phasor(parameters, parameter_slope, p, 1)
    S_2, d_S_2 = 0j, 0j
    if parameters[STIFFNESSES] > 1.0:
        S_2, d_S_2 = stiffness_phasor(parameters, parameter_slope, p, 2)
    front, back, d_front, d_back, far = gaps(parameters, parameter_slope, p)
    return (
        (D, A, B * S_1, 0.5 * B * S_2, G, 0.5 * B_0 * S_1),
        (d_D, d_A, d_B * S_1 + B * d_S_1, 0.5 * (d_B * S_2 + B * d_S_2), d_G, 0.5 * (d_B_0 * S_1 + B_0 * d_S_1)),
        (A_0.real, G_0.real, front, back, D_0.real, far),
        (d_A_0.real, d_G_0.real, d_front, d_back, d_D_0.real, 0.0),
    )
