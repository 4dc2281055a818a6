"""Rows of the balance of order H and the margins of its motions, as kernels; see `solver.harmonic.galerkin`."""

import math

import numpy as np

from solver.contact.spectrum import extremes
from solver.harmonic.contact_terms import coefficient, contact_of, modulated
from solver.harmonic.impedance import base_frequency, impedance
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.model.parameters import BACK_GAP, CUBIC, DASHPOT, FRONT_GAP, PERIOD, STIFFNESSES

__all__ = ["residual_and_jacobian", "test_functions"]

_COMPLEX = np.complex128


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX), inner=True)
def _add_cubic(parameters, parameter_slope, y, residual, jacobian):
    """Add what a cubic spring does: its force k_3 lambda^3 acts as f does, but for the damper of touching teeth.

    Its harmonics k_3 (L * L * L)_k and their derivatives 3 k_3 (L * L)_(k-m) are convolutions of those of lambda.
    """
    n = y.shape[0] - 1
    order, period, p = n // 2, int(parameters[PERIOD]), y[n]
    wave, square = np.zeros(2 * order + 1, _COMPLEX), np.zeros(2 * order + 1, _COMPLEX)
    wave[0] = y[0]
    for m in range(1, order + 1):
        wave[m] = 0.5 * complex(y[2 * m - 1], -y[2 * m])
    for k in range(2 * order + 1):
        for m in range(k - order, order + 1):
            square[k] += coefficient(wave, k - m) * coefficient(wave, m)
    omega, d_omega = base_frequency(parameters, parameter_slope, p)
    for k in range(order + 1):
        cube = 0j
        for m in range(-order, order + 1):
            cube += coefficient(square, k - m) * coefficient(wave, m)
        s, d_s = 1j * k * omega, 1j * k * d_omega
        (_, A, _, _), (_, d_A, _, _) = impedance(
            parameters, parameter_slope, p, s, d_s, k // period if k % period == 0 else -1
        )
        touching, d_touching = 1.0 + s * parameters[DASHPOT], d_s * parameters[DASHPOT]
        weight = parameters[CUBIC] * A / touching
        slope = (parameters[CUBIC] * d_A - weight * d_touching) / touching
        if k == 0:
            residual[0] += (weight * cube).real
            jacobian[0, n] += (slope * cube).real
            jacobian[0, 0] += 3.0 * (weight * square[0]).real
            for m in range(1, order + 1):
                jacobian[0, 2 * m - 1] += 3.0 * weight.real * square[m].real
                jacobian[0, 2 * m] -= 3.0 * weight.real * square[m].imag
            continue
        row, along = 2.0 * weight * cube, 2.0 * slope * cube
        residual[2 * k - 1] += row.real
        residual[2 * k] -= row.imag
        jacobian[2 * k - 1, n] += along.real
        jacobian[2 * k, n] -= along.imag
        row = 6.0 * weight * square[k]
        jacobian[2 * k - 1, 0] += row.real
        jacobian[2 * k, 0] -= row.imag
        for m in range(1, order + 1):
            near = 3.0 * weight * coefficient(square, k - m)
            far = 3.0 * weight * (square[k + m] if k + m <= 2 * order else 0j)
            jacobian[2 * k - 1, 2 * m - 1] += (near + far).real
            jacobian[2 * k, 2 * m - 1] -= (near + far).imag
            jacobian[2 * k - 1, 2 * m] += (near - far).imag
            jacobian[2 * k, 2 * m] += (near - far).real


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX), shared=True)
def residual_and_jacobian(parameters, parameter_slope, y, residual, jacobian):
    """Residual (n,) and Jacobian (n, n + 1) at y = (unknowns, axis value), n = 2 H + 1; see the module.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Parameters at p = 0 and what p adds to them.
    y : (n + 1,) array
        (u, p).
    residual, jacobian : (n,) and (n, n + 1) arrays
        Filled.
    """
    n = y.shape[0] - 1
    order, period = n // 2, int(parameters[PERIOD])
    u, p = y[:n], y[n]
    reach = order + int(parameters[STIFFNESSES]) * period
    size = order + reach + 1
    work = np.empty((4, size), _COMPLEX)
    chi, ahead, behind, psi = work[0], work[1], work[2], work[3][: 2 * order + 1]
    contact_of(parameters, parameter_slope, u, p, chi, ahead, behind)
    front, d_front, back, d_back = (
        parameters[FRONT_GAP] + p * parameter_slope[FRONT_GAP],
        parameter_slope[FRONT_GAP],
        0.0,
        parameter_slope[BACK_GAP],
    )
    if math.isfinite(parameters[BACK_GAP]):
        back = parameters[BACK_GAP] + p * d_back

    force = np.empty((4, reach + 1), _COMPLEX)
    f, d_f, q, dump = force[0], force[1], force[2][: order + 1], force[3][: order + 1]
    for k in range(reach + 1):
        total = chi[k] * u[0] - front * ahead[k] + back * behind[k]
        for m in range(1, order + 1):
            half = 0.5 * complex(u[2 * m - 1], -u[2 * m])
            total += coefficient(chi, k - m) * half + chi[k + m] * half.conjugate()
        f[k], d_f[k] = total, d_back * behind[k] - d_front * ahead[k]
    d_q = np.empty(order + 1, _COMPLEX)
    modulated(parameters, parameter_slope, p, d_f, q, dump)
    for k in range(order + 1):
        d_q[k] = q[k]
    modulated(parameters, parameter_slope, p, f, q, dump)
    for k in range(order + 1):
        d_q[k] += dump[k]
    slope = np.empty(2 * order + 1, _COMPLEX)
    modulated(parameters, parameter_slope, p, chi, psi, slope)

    omega, d_omega = base_frequency(parameters, parameter_slope, p)
    for k in range(order + 1):
        l = k // period if k % period == 0 else -1
        (D, A, B, G), (d_D, d_A, d_B, d_G) = impedance(
            parameters, parameter_slope, p, 1j * k * omega, 1j * k * d_omega, l
        )
        if k == 0:
            residual[0] = (D * u[0] + A * f[0] + B * q[0] - G).real
            jacobian[0, 0] = (D + A * chi[0] + B * psi[0]).real
            for m in range(1, order + 1):
                jacobian[0, 2 * m - 1] = (A * chi[m].real + B * psi[m].real).real
                jacobian[0, 2 * m] = -(A * chi[m].imag + B * psi[m].imag).real
            jacobian[0, n] = (d_D * u[0] + d_A * f[0] + A * d_f[0] + d_B * q[0] + B * d_q[0] - d_G).real
            continue
        motion = complex(u[2 * k - 1], -u[2 * k])
        row = D * motion + 2.0 * (A * f[k] + B * q[k]) - G
        residual[2 * k - 1], residual[2 * k] = row.real, -row.imag
        row = d_D * motion + 2.0 * (d_A * f[k] + A * d_f[k] + d_B * q[k] + B * d_q[k]) - d_G
        jacobian[2 * k - 1, n], jacobian[2 * k, n] = row.real, -row.imag
        row = 2.0 * (A * chi[k] + B * psi[k])
        jacobian[2 * k - 1, 0], jacobian[2 * k, 0] = row.real, -row.imag
        for m in range(1, order + 1):
            near, far = A * coefficient(chi, k - m) + B * coefficient(psi, k - m), A * chi[k + m] + B * psi[k + m]
            if m == k:
                near += D
            row = near + far
            jacobian[2 * k - 1, 2 * m - 1], jacobian[2 * k, 2 * m - 1] = row.real, -row.imag
            row = -1j * (near - far)
            jacobian[2 * k - 1, 2 * m], jacobian[2 * k, 2 * m] = row.real, -row.imag
    if parameters[CUBIC] != 0.0:
        _add_cubic(parameters, parameter_slope, y, residual, jacobian)


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))
def test_functions(parameters, parameter_slope, y, values, gradient):
    """Size of the oscillation and the four contact margins with their gradients.

    values (5,) = sqrt(sum_k |Lambda_k|^2), then lambda_min - front, lambda_min + back, lambda_max - front, lambda_max +
    back from the true extremes of lambda; gradient (5, n + 1). Without a back contact its margins are 1.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Parameters at p = 0 and what p adds to them.
    y : (n + 1,) array
        (u, p).
    values, gradient : (m,) and (m, n + 1) arrays
        Filled.
    """
    n = y.shape[0] - 1
    low, low_at, high, high_at = extremes(y[:n])
    size = 0.0
    for j in range(1, n):
        size += y[j] * y[j]
    size = math.sqrt(size)
    values[0] = size
    gradient[0, 0], gradient[0, n] = 0.0, 0.0
    for j in range(1, n):
        gradient[0, j] = y[j] / size if size > 0.0 else 0.0
    for i in range(1, 5):
        value, angle = (low, low_at) if i <= 2 else (high, high_at)
        slot, sense = (FRONT_GAP, -1.0) if i % 2 == 1 else (BACK_GAP, 1.0)
        if not math.isfinite(parameters[slot]):
            values[i] = 1.0
            gradient[i, :] = 0.0
            continue
        values[i] = value + sense * (parameters[slot] + y[n] * parameter_slope[slot])
        gradient[i, 0], gradient[i, n] = 1.0, sense * parameter_slope[slot]
        turn = complex(math.cos(angle), math.sin(angle))
        z = 1.0 + 0j
        for k in range(1, n // 2 + 1):
            z *= turn
            gradient[i, 2 * k - 1], gradient[i, 2 * k] = z.real, z.imag
