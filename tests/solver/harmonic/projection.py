"""The balance of order H by brute force: seven degrees of freedom, the force sampled finely and transformed."""

import numpy as np

from solver import Model
from solver.continuation.problem import Problem
from solver.harmonic.galerkin import Galerkin

__all__ = ["evaluated", "projected"]


def evaluated(problem: Problem, y) -> tuple[np.ndarray, np.ndarray]:
    """Residual (n,) and Jacobian (n, n + 1) of a problem."""
    n = problem.unknowns
    residual, jacobian = np.empty(n), np.empty((n, n + 1))
    problem.residual_and_jacobian(
        problem.parameters, problem.parameter_slope, np.array(y, dtype=float), residual, jacobian
    )
    return residual, jacobian


def projected(model: Model, omega: float, balance: Galerkin, motion, samples: int = 2**16) -> np.ndarray:
    """Rows (E_0, Re E_1, -Im E_1, ...) of the mesh coordinate, the translations eliminated harmonic by harmonic."""
    angle = 2.0 * np.pi * np.arange(samples) / samples
    displacement = balance.displacement(np.asarray(motion), angle)
    force = np.maximum(displacement - model.b, 0.0) + np.minimum(displacement + model.b, 0.0)
    varied = model.stiffness_variation(balance.period * angle) * force
    harmonics = [np.fft.rfft(signal)[: balance.harmonics + 1] * 2.0 / samples for signal in (force, varied)]
    for harmonic in harmonics:
        harmonic[0] /= 2.0
    mass, damping, stiffness = model.matrices()
    translation, rotation = model.mesh_vectors()
    load = model.load_harmonics(omega, balance.order)
    rows = []
    for k in range(balance.harmonics + 1):
        w = k * omega / balance.period
        dynamic = stiffness - w**2 * mass + 1j * w * damping
        plain, varying = harmonics[0][k], harmonics[1][k]
        mesh = complex(motion[2 * k - 1], -motion[2 * k]) if k else motion[0]
        right = -translation[:6] * (plain + model.variation_translation * varying) - dynamic[:6, 6] * mesh
        row = dynamic[6, :6] @ np.linalg.solve(dynamic[:6, :6], right) + dynamic[6, 6] * mesh
        row += rotation[6] * (plain + model.variation_rotation * varying)
        if k % balance.period == 0:
            row -= load[k // balance.period]
        rows += [row.real] if k == 0 else [row.real, -row.imag]
    return np.array(rows)
