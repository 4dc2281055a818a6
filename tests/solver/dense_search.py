"""Solutions of the first-order balance by brute force: Newton's method from a dense grid over mean and amplitude.

Slow, proves nothing, and shares with the enumeration only the coefficients of the balance; the dead zone, the balance
and its Jacobian (by differences) are written out anew.
"""

import numpy as np

from solver.harmonic.condensed import coefficients
from solver.model.packing import axis_vectors

__all__ = ["dense_search"]


def _dead_zone_harmonics(mean, amplitude, b):
    """f_0 and N_a from the contact angles of both flanks."""
    force, gain = np.zeros_like(mean), np.zeros_like(mean)
    resting = amplitude < 1e-12
    size = np.where(resting, 1.0, amplitude)
    for side in (1.0, -1.0):
        angle = np.arccos(np.clip((b - side * mean) / size, -1.0, 1.0))
        force += side * ((side * mean - b) * angle + size * np.sin(angle)) / np.pi
        gain += (angle - 0.5 * np.sin(2.0 * angle)) / np.pi
    still = np.sign(mean) * np.maximum(np.abs(mean) - b, 0.0)
    return np.where(resting, still, force), np.where(resting, np.abs(mean) > b, gain)


def dense_search(model, omega: float, amplitude_max: float, density: int = 60) -> np.ndarray:
    """Solutions (lambda_m, lambda_c, lambda_s) with amplitude up to the given one, ascending amplitude, (n, 3)."""
    (D, A, P_1, P_2, F, e), _, (c, f_pm, b, *_), _ = coefficients(*axis_vectors(model, "omega"), omega)

    def residual(u):
        fundamental = u[1] - 1j * u[2]
        force, gain = _dead_zone_harmonics(u[0], np.abs(fundamental), b)
        contact = gain * fundamental
        row = D * fundamental + A * contact + P_1 * force + P_2 * contact.conj() - F
        return np.array([c * force + (e * contact.conj()).real - f_pm, row.real, row.imag])

    reach = b + (abs(f_pm) + abs(e) * amplitude_max) / c
    mean, amplitude = np.meshgrid(
        np.linspace(-reach, reach, density), amplitude_max * np.linspace(0.0, 1.0, density) ** 1.5
    )
    mean, amplitude = mean.ravel(), amplitude.ravel()
    force, gain = _dead_zone_harmonics(mean, amplitude, b)
    X, Y, G = D + A * gain, P_2 * gain, F - P_1 * force
    fundamental = (X.conj() * G - Y * G.conj()) / (np.abs(X) ** 2 - np.abs(Y) ** 2)
    u = np.array([mean, fundamental.real, -fundamental.imag])
    settled = []
    for _ in range(40):
        value, jacobian = residual(u), np.empty((3, 3, u.shape[1]))
        for j in range(3):
            step = np.zeros((3, 1))
            step[j] = 1e-7
            jacobian[:, j] = (residual(u + step) - residual(u - step)) / 2e-7
        jacobian += 1e-14 * np.eye(3)[:, :, None]
        move = np.linalg.solve(np.moveaxis(jacobian, 2, 0), -value.T[:, :, None])[:, :, 0].T
        length = np.max(np.abs(move), axis=0)
        move *= np.minimum(1.0, 0.5 / np.maximum(length, 1e-300))
        u = u + move
        inside = np.all(np.isfinite(u), axis=0) & (np.max(np.abs(u), axis=0) < 10.0 * (reach + amplitude_max))
        # One more step from there would change nothing.
        there = inside & (length < 1e-10)
        settled.append(u[:, there])
        u, length = u[:, inside & ~there], length[inside & ~there]
    u = np.hstack([*settled, u[:, length < 1e-6]])
    u = u[:, np.max(np.abs(residual(u)), axis=0) < 1e-10].T
    u = u[np.hypot(u[:, 1], u[:, 2]) <= amplitude_max]
    found: list[np.ndarray] = []
    for candidate in u:
        if not any(np.max(np.abs(candidate - other)) < 1e-5 for other in found):
            found.append(candidate)
    return np.array(sorted(found, key=lambda v: np.hypot(v[1], v[2]))).reshape(-1, 3)
