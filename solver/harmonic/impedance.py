"""What one harmonic of the motion and of the contact force means for the contact coordinate: the exact condensation.

Everything but lambda is linear, so that a motion like exp(s tau) obeys, with the force f and the modulated force q = s
f,

    D Lambda + A f + B q = G

Gear pair (docs/physics.md, section 3): D = s^2 + 2 s (c xi_h - U), A = c - T, B = c eps_r - T eps_t, G the load on the
mesh row. Other systems, Z_0 = K + s C + s^2 M, closed by the contact so that a free rigid motion does no harm, Z = Z_0
+ h w^T: A = w.Z^-1 h, B = w.Z^-1 h_v, G = w.Z^-1 F and D = 1 - A. That is det Z_0/det Z (matrix determinant lemma) and
is computed as such, because A of a stiff contact is 1 but for its last digits. A damper of touching teeth adds c_c f',
whose harmonics are those of f times s c_c: with it (1 + s c_c) A stands in front of f.
"""

import numpy as np

from solver.kernels import types
from solver.kernels.compile import ARRAY, kernel
from solver.kernels.linear import eliminate_rows
from solver.model.condensation import mesh_receptance, phasor, rotation_coupling
from solver.model.parameters import (
    DASHPOT,
    DEGREES,
    F_PM,
    F_PV,
    GEAR,
    KIND,
    LOADS,
    MESH_FREQUENCY,
    PERIOD,
    SIGN,
    VARIATION_R,
    VARIATION_T,
    XI_MESH,
    error_slot,
    gear_numbers,
    number_at,
    stiffness_slot,
    system_loads,
    system_matrices,
)

__all__ = ["base_frequency", "impedance", "stiffness_phasor", "system_impedance"]

_I, _F, _C = types.int64, types.float64, types.complex128
_FOUR = types.UniTuple(_C, 4)
_COMPLEX = np.complex128


@kernel(types.UniTuple(_F, 2)(ARRAY, ARRAY, _F), inline=True)
def base_frequency(parameters, parameter_slope, p):
    """Omega/nu at one axis value, and its derivative.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Parameters at p = 0 and what p adds to them.
    p : float
        Axis value.
    """
    return (parameters[MESH_FREQUENCY] + p * parameter_slope[MESH_FREQUENCY]) / parameters[PERIOD], parameter_slope[
        MESH_FREQUENCY
    ] / parameters[PERIOD]


@kernel(types.UniTuple(_C, 2)(ARRAY, ARRAY, _F, _I), inline=True)
def stiffness_phasor(parameters, parameter_slope, p, l):
    """S_l = alpha_l exp(i Phi_kl), l >= 1, and its derivative along the axis.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Parameters at p = 0 and what p adds to them.
    p : float
        Axis value.
    l : int
        Harmonic of the mesh frequency, >= 1.
    """
    return phasor(parameters, parameter_slope, p, stiffness_slot(l))


@kernel(types.UniTuple(_FOUR, 2)(ARRAY, ARRAY, _F, _C, _C, _I), inner=True, shared=True)
def _gear_impedance(parameters, parameter_slope, p, s, d_s, l):
    """`impedance` of a gear pair."""
    model, along = gear_numbers(parameters, parameters), gear_numbers(parameters, parameter_slope)
    T, U, d_T, d_U = mesh_receptance(model, along, p, s, d_s)
    c, d_c = rotation_coupling(model, along, p)
    xi, d_xi = number_at(model, along, p, XI_MESH)
    eps_t, d_eps_t = number_at(model, along, p, VARIATION_T)
    eps_r, d_eps_r = number_at(model, along, p, VARIATION_R)
    damping, d_damping = c * xi - U, d_c * xi + c * d_xi - d_U
    load, d_load = 0j, 0j
    if l == 0 or l == 1:
        constant, d_constant = number_at(model, along, p, F_PM if l == 0 else F_PV)
        load, d_load = complex(constant), complex(d_constant)
    if 0 < l <= int(parameters[LOADS]):
        omega, d_omega = number_at(parameters, parameter_slope, p, MESH_FREQUENCY)
        omega, d_omega = l * omega, l * d_omega
        error, d_error = phasor(parameters, parameter_slope, p, error_slot(parameters, l))
        load += omega * omega * error
        d_load += omega * omega * d_error + 2.0 * omega * d_omega * error
    return (
        (s * s + 2.0 * s * damping, c - T, c * eps_r - T * eps_t, load),
        (
            2.0 * s * d_s + 2.0 * (d_s * damping + s * d_damping),
            d_c - d_T,
            d_c * eps_r + c * d_eps_r - d_T * eps_t - T * d_eps_t,
            d_load,
        ),
    )


@kernel(types.UniTuple(_C, 2)(ARRAY, _F, ARRAY), inline=True)
def _complex(number, p, slope):
    """A number of real and imaginary part at one axis value, and its derivative."""
    return complex(number[0] + p * slope[0], number[1] + p * slope[1]), complex(slope[0], slope[1])


@kernel(types.UniTuple(_FOUR, 2)(ARRAY, ARRAY, _F, _C, _C, _I), inner=True, shared=True)
def system_impedance(parameters, parameter_slope, p, s, d_s, l):
    """`impedance` of a `ContactSystem`."""
    n, loads = int(parameters[DEGREES]), int(parameters[LOADS])
    (mass, damping, stiffness), (contact, force, varying) = system_matrices(parameters, parameters)
    (_, d_damping, d_stiffness), _ = system_matrices(parameters, parameter_slope)
    (steady, growing), (d_steady, d_growing) = (
        system_loads(parameters, parameters),
        system_loads(parameters, parameter_slope),
    )
    forward, backward, change = np.empty((n, n), _COMPLEX), np.empty((n, n), _COMPLEX), np.empty((n, n), _COMPLEX)
    # Right-hand sides h, h_v, F and (for the derivative alone) dF; across solves the transposed system for w.
    rights, across, none = np.zeros((4, n), _COMPLEX), np.empty((1, n), _COMPLEX), np.empty((0, n), _COMPLEX)
    free = np.empty((n, n), _COMPLEX)
    omega, d_omega = number_at(parameters, parameter_slope, p, MESH_FREQUENCY)
    omega, d_omega = l * omega, l * d_omega
    for i in range(n):
        rights[0, i], rights[1, i], across[0, i] = force[i], varying[i], contact[i]
        if 0 <= l <= loads:
            fixed, d_fixed = _complex(steady[l, i], p, d_steady[l, i])
            inertial, d_inertial = _complex(growing[l, i], p, d_growing[l, i])
            rights[2, i] = fixed + omega * omega * inertial
            rights[3, i] = d_fixed + omega * omega * d_inertial + 2.0 * omega * d_omega * inertial
        for j in range(n):
            spring, damper = stiffness[i, j] + p * d_stiffness[i, j], damping[i, j] + p * d_damping[i, j]
            free[i, j] = spring + s * damper + s * s * mass[i, j]
            closed = free[i, j] + force[i] * contact[j]
            forward[i, j], backward[j, i] = closed, closed
            change[i, j] = (damper + 2.0 * s * mass[i, j]) * d_s + d_stiffness[i, j] + s * d_damping[i, j]
    D = eliminate_rows(free, none) / eliminate_rows(forward, rights)
    eliminate_rows(backward, across)
    A, B, G, d_A, d_B, d_G = 0j, 0j, 0j, 0j, 0j, 0j
    for i in range(n):
        A += contact[i] * rights[0, i]
        B += contact[i] * rights[1, i]
        G += contact[i] * rights[2, i]
        d_G += contact[i] * rights[3, i]
        for j in range(n):
            weight = across[0, i] * change[i, j]
            d_A -= weight * rights[0, j]
            d_B -= weight * rights[1, j]
            d_G -= weight * rights[2, j]
    factor = parameters[SIGN] if l == 0 else abs(parameters[SIGN])
    d_D, dashpot = -factor * d_A, parameters[DASHPOT]
    if dashpot != 0.0:
        d_A = d_A + dashpot * (d_s * A + s * d_A)
        A = A + dashpot * s * A
    return ((factor * D, factor * A, factor * B, factor * G), (d_D, factor * d_A, factor * d_B, factor * d_G))


@kernel(types.UniTuple(_FOUR, 2)(ARRAY, ARRAY, _F, _C, _C, _I), inline=True)
def impedance(parameters, parameter_slope, p, s, d_s, l):
    """D, A, B and G of the module at one complex frequency, and their derivatives along the axis.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Of `solver.model.packing.packed`.
    p : float
        Axis value.
    s, d_s : complex
        Complex frequency, and how it moves along the axis.
    l : int
        Which harmonic of the load acts: -1 for none.

    Returns
    -------
    values, slopes : 4 complex numbers each
    """
    if parameters[KIND] == GEAR:
        return _gear_impedance(parameters, parameter_slope, p, s, d_s, l)
    return system_impedance(parameters, parameter_slope, p, s, d_s, l)
