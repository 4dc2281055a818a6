"""The condensed balance of a gear pair as intervals: a proof then holds for the model, not for its rounding.

The same formulas as `solver.harmonic.condensed.coefficients` (docs/physics.md, sections 3 and 4), in interval
arithmetic and without derivatives. The numbers parameters + p * parameter_slope are taken as the exact floats they are.
"""

import math

import numpy as np

from solver.enumeration.enclosed import (
    FACTORED,
    HALF_GAP,
    LAW_ROW,
    MEAN_GAIN,
    MEAN_LOAD,
    MIRRORED,
    SHIFT,
    put,
    put_complex,
)
from solver.enumeration.interval import (
    COMPLEX,
    INTERVAL,
    add,
    complex_add,
    complex_multiply,
    complex_reciprocal,
    complex_scale,
    complex_subtract,
    cosine,
    exact,
    multiply,
    phasor,
    square,
    subtract,
)
from solver.kernels import types
from solver.kernels.compile import ARRAY, kernel
from solver.model.parameters import (
    ALPHA,
    ALPHA_2,
    ALPHA_2_PHASE,
    ALPHA_PHASE,
    CONE,
    F_E,
    F_E_PHASE,
    F_PM,
    F_PV,
    K_SUPPORT,
    KAPPA,
    OMEGA,
    PRESSURE,
    ROTATION,
    ROTATION_GEOMETRIC,
    SIGMA,
    VARIATION_R,
    VARIATION_T,
    XI_MESH,
    XI_SUPPORT,
    XI_TRANSLATION,
    B,
)

__all__ = ["enclose_gear", "enclosed_coefficients"]

_F = types.float64
_RADIANS = (math.pi / 180.0 * (1.0 - 4.5e-16), math.pi / 180.0 * (1.0 + 4.5e-16))


@kernel(types.UniTuple(COMPLEX, 2)(ARRAY, INTERVAL, INTERVAL, INTERVAL, INTERVAL, INTERVAL), inner=True)
def _receptance(parameters, omega, omega_squared, cone_cos, pressure_cos, pressure_sin):
    """T = omega^2 sum_j d_j^2 kappa_g/Z_j and U = omega^2 sum_j d_j^2 xi_hg/Z_j; the last three are squares."""
    zero = exact(0.0), exact(0.0)
    total_t, total_u, inverse = zero, zero, zero
    cone_sin = subtract(exact(1.0), cone_cos)
    sigma = exact(parameters[SIGMA])
    for j in range(6):
        if j % 3 == 0:
            weight = multiply(sigma, multiply(cone_cos, pressure_sin))
        elif j % 3 == 1:
            weight = multiply(sigma, multiply(cone_sin, pressure_sin))
        else:
            weight = multiply(sigma, pressure_cos)
        xi, k = parameters[XI_SUPPORT + j], parameters[K_SUPPORT + j]
        if j == 0 or xi != parameters[XI_SUPPORT + j - 1] or k != parameters[K_SUPPORT + j - 1]:
            damping = multiply(exact(2.0 * xi), omega)
            inverse = complex_reciprocal((subtract(exact(k), omega_squared), damping))
        g = j // 3
        kappa, xi_translation = exact(parameters[KAPPA + g]), exact(parameters[XI_TRANSLATION + g])
        total_t = complex_add(total_t, complex_scale(multiply(weight, kappa), inverse))
        total_u = complex_add(total_u, complex_scale(multiply(weight, xi_translation), inverse))
    return complex_scale(omega_squared, total_t), complex_scale(omega_squared, total_u)


@kernel(types.Tuple((types.UniTuple(COMPLEX, 6), INTERVAL))(ARRAY, ARRAY, _F), inner=True)
def enclosed_coefficients(parameters, parameter_slope, p):
    """Enclosures of the numbers that the balance depends on at one axis value.

    Parameters
    ----------
    parameters, parameter_slope : (34,) arrays
    p : float
        Axis value.

    Returns
    -------
    values : 6 complex intervals
        D, c - T, P_1, P_2, F_1 and e, as `solver.harmonic.condensed.coefficients`; nan where a support
        without damping is in resonance.
    c : interval
    """
    x = np.empty(parameters.shape[0])
    for i in range(parameters.shape[0]):
        x[i] = parameters[i] + p * parameter_slope[i]
    omega = exact(x[OMEGA])
    omega_squared = square(omega)
    pressure = multiply(exact(x[PRESSURE]), _RADIANS)
    pressure_cos = square(cosine(pressure))
    pressure_sin = subtract(exact(1.0), pressure_cos)
    cone_cos = square(cosine(multiply(exact(x[CONE]), _RADIANS)))
    T, U = _receptance(x, omega, omega_squared, cone_cos, pressure_cos, pressure_sin)

    c = exact(x[ROTATION])
    if x[ROTATION_GEOMETRIC] != 0.0:
        c = add(c, pressure_cos)
    S_1, S_2 = phasor(exact(x[ALPHA]), x[ALPHA_PHASE]), phasor(exact(x[ALPHA_2]), x[ALPHA_2_PHASE])
    error = phasor(multiply(exact(x[F_E]), omega_squared), x[F_E_PHASE])
    damping = complex_subtract((multiply(c, exact(x[XI_MESH])), exact(0.0)), U)
    twice = multiply(exact(2.0), omega)
    rotating = multiply(c, exact(x[VARIATION_R]))
    varying = complex_subtract((rotating, exact(0.0)), complex_scale(exact(x[VARIATION_T]), T))
    return (
        (
            (subtract(multiply(twice, (-damping[1][1], -damping[1][0])), omega_squared), multiply(twice, damping[0])),
            complex_subtract((c, exact(0.0)), T),
            complex_multiply(varying, S_1),
            complex_scale(exact(0.5), complex_multiply(varying, S_2)),
            (add(exact(x[F_PV]), error[0]), error[1]),
            complex_scale(multiply(exact(0.5), rotating), S_1),
        ),
        c,
    )


@kernel(types.boolean(ARRAY, ARRAY, _F, types.int64, types.int64), inline=True)
def _are_zero(parameters, parameter_slope, p, first, stop):
    """Whether parameters first ... stop - 1 are exactly 0 at an axis value."""
    for slot in range(first, stop):  # noqa: SIM110 (kernels have no generators)
        if parameters[slot] + p * parameter_slope[slot] != 0.0:
            return False
    return True


@kernel(types.boolean(ARRAY, ARRAY, _F), inner=True)
def _has_common_factor(parameters, parameter_slope, p):
    """Whether D and A' are real and Q and e are 0 for certain: nothing is damped, and what could make Q and e is 0."""
    uncoupled = _are_zero(parameters, parameter_slope, p, SIGMA, SIGMA + 1)
    undamped = _are_zero(parameters, parameter_slope, p, XI_MESH, XI_MESH + 1) and (
        uncoupled
        or (
            _are_zero(parameters, parameter_slope, p, XI_TRANSLATION, XI_TRANSLATION + 2)
            and _are_zero(parameters, parameter_slope, p, XI_SUPPORT, XI_SUPPORT + 6)
        )
    )
    first_fixed = _are_zero(parameters, parameter_slope, p, ALPHA, ALPHA + 1)
    second_fixed = _are_zero(parameters, parameter_slope, p, ALPHA_2, ALPHA_2 + 1)
    rotation_fixed = _are_zero(parameters, parameter_slope, p, VARIATION_R, VARIATION_R + 1)
    all_fixed = rotation_fixed and (
        uncoupled or _are_zero(parameters, parameter_slope, p, VARIATION_T, VARIATION_T + 1)
    )
    return undamped and (first_fixed or rotation_fixed) and (second_fixed or all_fixed)


@kernel(types.void(ARRAY, ARRAY, ARRAY, types.float64[:, :, ::1]))
def enclose_gear(parameters, parameter_slope, grid, enclosed):
    """Fill `enclosed` (X, SLOTS, 2), of `solver.enumeration.enclosed`, at many axis values of a gear pair.

    Parameters
    ----------
    parameters, parameter_slope : (34,) arrays
    grid : (X,) array
        Axis values.
    enclosed : (X, SLOTS, 2) array
        Filled.
    """
    for i in range(grid.shape[0]):
        p, here = grid[i], enclosed[i]
        values, c = enclosed_coefficients(parameters, parameter_slope, p)
        for k in range(6):
            put_complex(here, 2 * k, values[k])
        put(here, MEAN_GAIN, c)
        put(here, MEAN_LOAD, exact(parameters[F_PM] + p * parameter_slope[F_PM]))
        put(here, HALF_GAP, exact(parameters[B] + p * parameter_slope[B]))
        put(here, SHIFT, (0.0, 0.0))
        put(here, FACTORED, exact(1.0 if _has_common_factor(parameters, parameter_slope, p) else 0.0))
        # The rotation is free, and there are two flanks.
        put(here, LAW_ROW, (0.0, 0.0))
        put(here, LAW_ROW + 1, (1.0, 1.0))
        put(here, MIRRORED, (0.0, 0.0))
