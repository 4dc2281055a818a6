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
)

__all__ = ["mesh_receptance", "phasor", "rotation_coupling"]


@kernel(types.UniTuple(types.complex128, 2)(ARRAY, ARRAY, types.float64, types.int64), inline=True)
def phasor(theta, direction, p, slot):
    """amplitude exp(i phase) of a pair of numbers, the amplitude at a slot, and its derivative along the axis."""
    unit = cmath.exp(1j * (theta[slot + 1] + p * direction[slot + 1]))
    size = theta[slot] + p * direction[slot]
    return size * unit, (direction[slot] + 1j * size * direction[slot + 1]) * unit


@kernel(types.UniTuple(types.float64, 2)(ARRAY, ARRAY, types.float64), inline=True)
def rotation_coupling(theta, direction, p):
    """Rotation coupling c at axis value p and its derivative along the axis."""
    radians = math.pi / 180.0
    value = theta[ROTATION] + p * direction[ROTATION]
    slope = direction[ROTATION]
    if theta[ROTATION_GEOMETRIC] != 0.0:
        pressure = (theta[PRESSURE] + p * direction[PRESSURE]) * radians
        value += math.cos(pressure) ** 2
        slope -= math.sin(2.0 * pressure) * direction[PRESSURE] * radians
    return value, slope


@kernel(
    types.UniTuple(types.complex128, 4)(ARRAY, ARRAY, types.float64, types.complex128, types.complex128), inner=True
)
def mesh_receptance(theta, direction, p, s, d_s):
    """What the supports add to the mesh row at one complex frequency, and its derivative.

    Parameters
    ----------
    theta, direction : (34,) arrays
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
    cone, pressure = (
        (theta[CONE] + p * direction[CONE]) * radians,
        (theta[PRESSURE] + p * direction[PRESSURE]) * radians,
    )
    d_cone, d_pressure = direction[CONE] * radians, direction[PRESSURE] * radians
    sigma, d_sigma = theta[SIGMA] + p * direction[SIGMA], direction[SIGMA]
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
        kappa, d_kappa = theta[KAPPA + g] + p * direction[KAPPA + g], direction[KAPPA + g]
        xi_g, d_xi_g = theta[XI_TRANSLATION + g] + p * direction[XI_TRANSLATION + g], direction[XI_TRANSLATION + g]
        xi_j, k_j = (
            theta[XI_SUPPORT + j] + p * direction[XI_SUPPORT + j],
            theta[K_SUPPORT + j] + p * direction[K_SUPPORT + j],
        )
        if xi_j != xi or k_j != k:
            # Supports that are alike, as they mostly are, share one 1/Z_j. Those that differ may not share d_j either,
            # but an axis moves all supports of one kind together, so that equal supports have equal derivatives.
            xi, d_xi, k, d_k = xi_j, direction[XI_SUPPORT + j], k_j, direction[K_SUPPORT + j]
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
