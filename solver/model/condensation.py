"""Exact condensation of the seven-degree-of-freedom model to the mesh coordinate, with derivatives along an axis.

Only lambda enters nonlinearly, so the translations leave the balance exactly (docs/physics.md, section 3). Kernels see
a model as one flat vector `theta`. An axis of a plane is a `direction` in that space: at axis value p the parameters
are theta + p * direction, so that every scalar of the gear, the frequency included, is swept by the same code.
"""

import math

import numpy as np

from solver.kernels import types
from solver.kernels.compile import ARRAY, kernel
from solver.model.checks import ParameterError
from solver.model.gear_model import GEOMETRIC, SCALAR_PARAMETERS, Model

__all__ = ["AXES", "axis_vectors", "mesh_receptance", "parameter_vector"]

OMEGA, B, ALPHA, ALPHA_PHASE, ALPHA_2, ALPHA_2_PHASE, F_E, F_E_PHASE, F_PM, F_PV, XI_MESH = range(11)
KAPPA, XI_TRANSLATION, XI_SUPPORT, K_SUPPORT = 11, 13, 15, 21
CONE, PRESSURE, SIGMA, ROTATION, ROTATION_GEOMETRIC, VARIATION_T, VARIATION_R = range(27, 34)
SIZE = 34

_SLOTS = {
    "omega": slice(OMEGA, OMEGA + 1),
    "b": slice(B, B + 1),
    "alpha": slice(ALPHA, ALPHA + 1),
    "alpha_phase": slice(ALPHA_PHASE, ALPHA_PHASE + 1),
    "f_e": slice(F_E, F_E + 1),
    "f_e_phase": slice(F_E_PHASE, F_E_PHASE + 1),
    "f_pm": slice(F_PM, F_PM + 1),
    "f_pv": slice(F_PV, F_PV + 1),
    "xi_mesh": slice(XI_MESH, XI_MESH + 1),
    "kappa": slice(KAPPA, KAPPA + 2),
    "xi_translation": slice(XI_TRANSLATION, XI_TRANSLATION + 2),
    "xi_support": slice(XI_SUPPORT, XI_SUPPORT + 6),
    "k_support": slice(K_SUPPORT, K_SUPPORT + 6),
    "pitch_cone_angle": slice(CONE, CONE + 1),
    "pressure_angle": slice(PRESSURE, PRESSURE + 1),
    "translation_coupling": slice(SIGMA, SIGMA + 1),
    "rotation_coupling": slice(ROTATION, ROTATION + 1),
    "variation_translation": slice(VARIATION_T, VARIATION_T + 1),
    "variation_rotation": slice(VARIATION_R, VARIATION_R + 1),
}

#: Everything that may be an axis of a plane or of a continuation.
AXES = ("omega", *SCALAR_PARAMETERS)


def parameter_vector(model: Model, omega: float) -> np.ndarray:
    """The model at one frequency as the flat vector that kernels read, of shape (34,); angles in degrees."""
    theta = np.zeros(SIZE)
    theta[OMEGA] = omega
    for name in SCALAR_PARAMETERS:
        value = getattr(model, name)
        theta[_SLOTS[name]] = 0.0 if value == GEOMETRIC else value
    theta[SIGMA] = model.sigma
    theta[ROTATION_GEOMETRIC] = float(model.rotation_coupling == GEOMETRIC)
    if model.alpha_harmonics:
        theta[ALPHA_2], theta[ALPHA_2_PHASE] = model.alpha_harmonics[0]
    return theta


def axis_vectors(model: Model, axis: str, omega: float | None = None) -> tuple[np.ndarray, np.ndarray]:
    """`theta` with the axis set to 0, and the direction of the axis.

    Parameters
    ----------
    model : Model
    axis : str
        One of `AXES`.
    omega : float, optional
        The frequency; needed unless it is the axis.

    Returns
    -------
    theta, direction : (34,) arrays

    Raises
    ------
    ParameterError
        If the axis is unknown.
    """
    if axis not in AXES:
        raise ParameterError("axis", axis, f"one of {', '.join(AXES)}")
    theta = parameter_vector(model, 0.0 if axis == "omega" else omega)
    direction = np.zeros(SIZE)
    theta[_SLOTS[axis]] = 0.0
    direction[_SLOTS[axis]] = 1.0
    if axis == "rotation_coupling":
        theta[ROTATION_GEOMETRIC] = 0.0
    return theta, direction


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
