"""Exact condensation of the seven-degree-of-freedom model to the mesh coordinate, with derivatives along an axis.

Only lambda enters nonlinearly, so the translations leave the balance exactly (docs/physics.md, section 3). The vectors
are those of a gear in `solver.model.parameters`: every scalar of it, the frequency included, is swept by the same code.
"""

import cmath
import math

from solver.kernels import types
from solver.kernels.compile import ARRAY, kernel
from solver.model.parameters import (
    CONE,
    K_SUPPORT,
    KAPPA,
    PRESSURE,
    ROTATION,
    ROTATION_GEOMETRIC,
    SIGMA,
    XI_SUPPORT,
    XI_TRANSLATION,
    number_at,
)

__all__ = ["NO_COUPLING", "direction_squares", "mesh_receptance", "phasor", "rotation_coupling"]

#: A support has no part in the contact direction where its share of d . d is rounding: cos 90 degrees is 6e-17.
NO_COUPLING = 1e-30


@kernel(types.UniTuple(types.complex128, 2)(ARRAY, ARRAY, types.float64, types.int64), inline=True)
def phasor(parameters, parameter_slope, p, slot):
    """amplitude exp(i phase) of a pair of numbers, the amplitude at a slot, and its derivative along the axis.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Parameters at p = 0 and what p adds to them.
    p : float
        Axis value.
    slot : int
        Of the amplitude; the phase is in the next one.
    """
    (size, d_size), (phase, d_phase) = (
        number_at(parameters, parameter_slope, p, slot),
        number_at(parameters, parameter_slope, p, slot + 1),
    )
    unit = cmath.exp(1j * phase)
    return size * unit, (d_size + 1j * size * d_phase) * unit


@kernel(types.UniTuple(types.float64, 2)(ARRAY, ARRAY, types.float64), inline=True)
def rotation_coupling(parameters, parameter_slope, p):
    """Rotation coupling c at axis value p and its derivative along the axis.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Parameters at p = 0 and what p adds to them.
    p : float
        Axis value.
    """
    radians = math.pi / 180.0
    value, slope = number_at(parameters, parameter_slope, p, ROTATION)
    if parameters[ROTATION_GEOMETRIC] != 0.0:
        pressure, d_pressure = number_at(parameters, parameter_slope, p, PRESSURE)
        pressure *= radians
        value += math.cos(pressure) ** 2
        slope -= math.sin(2.0 * pressure) * d_pressure * radians
    return value, slope


@kernel(types.UniTuple(types.float64, 3)(ARRAY, ARRAY, types.float64), inner=True)
def direction_squares(parameters, parameter_slope, p):
    """d_j^2 of the radial, axial and tangential support of either gear, of a gear's own numbers at one axis value."""
    radians = math.pi / 180.0
    cone = (parameters[CONE] + p * parameter_slope[CONE]) * radians
    pressure = (parameters[PRESSURE] + p * parameter_slope[PRESSURE]) * radians
    sigma, sine = parameters[SIGMA] + p * parameter_slope[SIGMA], math.sin(pressure) ** 2
    return (sigma * math.cos(cone) ** 2 * sine, sigma * math.sin(cone) ** 2 * sine, sigma * math.cos(pressure) ** 2)


@kernel(
    types.UniTuple(types.complex128, 4)(ARRAY, ARRAY, types.float64, types.complex128, types.complex128), inner=True
)
def mesh_receptance(parameters, parameter_slope, p, s, d_s):
    """What the supports add to the mesh row at one complex frequency, and its derivative.

    Parameters
    ----------
    parameters, parameter_slope : (34,) arrays
    p : float
        Axis value.
    s, d_s : complex
        Motion like exp(s tau), s = i k Omega for harmonic k, and how s itself moves.

    Returns
    -------
    T, U, dT, dU : complex
        T = -s^2 sum_j d_j^2 kappa_g/Z_j and U = -s^2 sum_j d_j^2 xi_hg/Z_j with Z_j = k_j + 2 xi_j s + s^2 (for s = i
        omega those of docs/physics.md, section 3), and their derivatives along the axis, s moving by d_s.
    """
    radians = math.pi / 180.0
    cone, d_cone = number_at(parameters, parameter_slope, p, CONE)
    pressure, d_pressure = number_at(parameters, parameter_slope, p, PRESSURE)
    cone, d_cone, pressure, d_pressure = cone * radians, d_cone * radians, pressure * radians, d_pressure * radians
    sigma, d_sigma = number_at(parameters, parameter_slope, p, SIGMA)
    cone_cos, cone_sin = math.cos(cone) ** 2, math.sin(cone) ** 2
    pressure_cos, pressure_sin = math.cos(pressure) ** 2, math.sin(pressure) ** 2
    turn_cone, turn_pressure = math.sin(2.0 * cone) * d_cone, math.sin(2.0 * pressure) * d_pressure
    total_t, total_u, d_total_t, d_total_u = 0j, 0j, 0j, 0j
    xi, k, inverse, d_inverse = math.nan, math.nan, 0j, 0j
    for j in range(6):
        if j % 3 == 0:
            shape, d_shape = cone_cos * pressure_sin, -turn_cone * pressure_sin + cone_cos * turn_pressure
        elif j % 3 == 1:
            shape, d_shape = cone_sin * pressure_sin, turn_cone * pressure_sin + cone_sin * turn_pressure
        else:
            shape, d_shape = pressure_cos, -turn_pressure
        weight, d_weight = sigma * shape, d_sigma * shape + sigma * d_shape
        g = j // 3
        kappa, d_kappa = number_at(parameters, parameter_slope, p, KAPPA + g)
        xi_g, d_xi_g = number_at(parameters, parameter_slope, p, XI_TRANSLATION + g)
        xi_j, d_xi_j = number_at(parameters, parameter_slope, p, XI_SUPPORT + j)
        k_j, d_k_j = number_at(parameters, parameter_slope, p, K_SUPPORT + j)
        if xi_j != xi or k_j != k:
            # Supports that are alike, as they mostly are, share one 1/Z_j. Those that differ may not share d_j either,
            # but an axis moves all supports of one kind together, so that equal supports have equal derivatives.
            xi, d_xi, k, d_k = xi_j, d_xi_j, k_j, d_k_j
            stiffness = k + 2.0 * xi * s + s * s
            # By the reciprocal: numba raises where a complex number is divided by 0, and this may be a resonance.
            reciprocal = 1.0 / (stiffness.real * stiffness.real + stiffness.imag * stiffness.imag)
            inverse = complex(stiffness.real * reciprocal, -stiffness.imag * reciprocal)
            d_inverse = -(d_k + 2.0 * d_xi * s + 2.0 * (xi + s) * d_s) * inverse * inverse
        total_t += weight * kappa * inverse
        total_u += weight * xi_g * inverse
        d_total_t += (d_weight * kappa + weight * d_kappa) * inverse + weight * kappa * d_inverse
        d_total_u += (d_weight * xi_g + weight * d_xi_g) * inverse + weight * xi_g * d_inverse
    square, d_square = -s * s, -2.0 * s * d_s
    return (
        square * total_t,
        square * total_u,
        d_square * total_t + square * d_total_t,
        d_square * total_u + square * d_total_u,
    )
