"""Slow, plain and independent versions of what the solver computes, for tests to compare with.

Nothing here uses the describing functions, the condensation or a compiled kernel: forces are sampled, the seven degrees
of freedom are eliminated with `numpy.linalg.solve` from M, C, K and the mesh vectors of `Model`.
"""

import numpy as np

from solver.contact.dead_zone import dead_zone
from solver.model.gear_model import Model

_SAMPLES = 2**15


def difference(function, x, h):
    """Derivative of a vector-valued function of one number by central differences of fourth order."""
    near = np.asarray(function(x + h)) - np.asarray(function(x - h))
    far = np.asarray(function(x + 2.0 * h)) - np.asarray(function(x - 2.0 * h))
    return (8.0 * near - far) / (12.0 * h)


def force_harmonics(mean, fundamental, b, samples=_SAMPLES):
    """Mean and one-sided fundamental of f(lambda) by FFT, lambda = mean + Re(fundamental e^{i theta})."""
    angle = 2.0 * np.pi * np.arange(samples) / samples
    force = np.fft.rfft(dead_zone(mean + (fundamental * np.exp(1j * angle)).real, b)) / samples
    return force[0].real, 2.0 * force[1]


def varied_force(model: Model, variation, mean, fundamental, samples=_SAMPLES):
    """R_0 and R_1 of (1 + variation s) times f truncated to |k| <= 1, multiplied in time and transformed back."""
    force_0, force_1 = force_harmonics(mean, fundamental, model.b, samples)
    angle = 2.0 * np.pi * np.arange(64) / 64
    truncated = force_0 + (force_1 * np.exp(1j * angle)).real
    product = np.fft.rfft((1.0 + variation * model.stiffness_variation(angle)) * truncated) / 64
    return product[0].real, 2.0 * product[1]


def projected_balance(model: Model, omega, unknowns, samples=_SAMPLES):
    """Rows (mean, cosine, sine) of the mesh equation after the six translations are solved for numerically."""
    mass, damping, stiffness = model.matrices()
    h_t, h_r = model.mesh_vectors()
    mean, fundamental = unknowns[0], complex(unknowns[1], -unknowns[2])
    force_t = varied_force(model, model.variation_translation, mean, fundamental, samples)
    force_r = varied_force(model, model.variation_rotation, mean, fundamental, samples)
    rows = []
    for k, mesh in enumerate((mean, fundamental)):
        dynamic = stiffness - (k * omega) ** 2 * mass + 1j * k * omega * damping
        right = -h_t * force_t[k] - h_r * force_r[k] - dynamic[:, 6] * mesh
        x = np.linalg.solve(dynamic[:6, :6], right[:6])
        load = model.f_pm if k == 0 else model.f_pv + model.f_e * omega**2 * np.exp(1j * model.f_e_phase)
        rows.append(dynamic[6, :6] @ x - right[6] - load)
    return np.array([rows[0].real, rows[1].real, -rows[1].imag])


def linear_response(model: Model, omega):
    """Solution (3,) of the balance of the pair without backlash, and the determinant of its matrix."""
    closed = model.replace(b=0.0)
    load = projected_balance(closed, omega, np.zeros(3), 64)
    matrix = np.column_stack([projected_balance(closed, omega, unit, 64) - load for unit in np.eye(3)])
    return np.linalg.solve(matrix, -load), np.linalg.det(matrix)
