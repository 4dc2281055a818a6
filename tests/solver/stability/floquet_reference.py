"""Floquet multipliers and Hill exponents computed plainly: time integration between contact switches, dense
eigenproblems.

The only things shared with the solver are the matrices of `gear_system` and the motion to be looked at.
"""

import functools

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import eigvals
from scipy.optimize import brentq

from solver.model.contact_system import gear_system
from solver.model.gear_model import Model


def displacement(motion, angle):
    """lambda of (Lambda_0, c_1, s_1, ...) at angles of any shape."""
    k = np.arange(1, motion.size // 2 + 1)
    turns = np.multiply.outer(angle, k)
    return motion[0] + np.cos(turns) @ motion[1::2] + np.sin(turns) @ motion[2::2]


def _above(motion, level, angle):
    return displacement(motion, angle) - level


def contact_intervals(motion, b):
    """(begin, end, in contact) over a period, in angle."""
    grid = np.linspace(0.0, 2.0 * np.pi, 4001)
    switches = []
    for level in (b, -b):
        values = displacement(motion, grid) - level
        for i in np.flatnonzero(values[:-1] * values[1:] < 0.0):
            above = functools.partial(_above, motion, level)
            switches.append(brentq(above, grid[i], grid[i + 1], xtol=1e-14))
    ends = np.array([0.0, *sorted(switches), 2.0 * np.pi])
    middle = displacement(motion, 0.5 * (ends[:-1] + ends[1:]))
    return list(zip(ends[:-1], ends[1:], np.abs(middle) > b, strict=True))


def multipliers(model: Model, omega: float, motion: np.ndarray) -> np.ndarray:
    """Multipliers over one forcing period of perturbations of a motion, by integration of the variational equation."""
    system = gear_system(model)
    n = system.degrees
    inverse = np.linalg.inv(system.mass)
    monodromy = np.eye(2 * n)
    for begin, end, contact in contact_intervals(motion, model.b):

        def slope(angle, state, contact=contact):
            y, v = state.reshape(2 * n, 2 * n)[:n], state.reshape(2 * n, 2 * n)[n:]
            force = system.force + system.varying_force * model.stiffness_variation(angle)
            total = system.damping @ v + system.stiffness @ y + contact * np.outer(force, system.contact) @ y
            return np.concatenate([v, -inverse @ total]).ravel() / omega

        done = solve_ivp(slope, (begin, end), monodromy.ravel(), method="DOP853", rtol=1e-11, atol=1e-13)
        monodromy = done.y[:, -1].reshape(2 * n, 2 * n)
    return np.linalg.eigvals(monodromy)


def _contact_matrix(model, motion, rows, columns):
    """chi_(row - column) of a motion."""
    order = np.subtract.outer(rows, columns)
    total = np.zeros(order.shape, dtype=complex)
    for begin, end, contact in contact_intervals(motion, model.b):
        safe = np.where(order == 0, 1, order)
        piece = 1j * (np.exp(-1j * safe * end) - np.exp(-1j * safe * begin)) / (2.0 * np.pi * safe)
        total += contact * np.where(order == 0, (end - begin) / (2.0 * np.pi), piece)
    return total


def hill_exponents(model: Model, omega: float, motion: np.ndarray, harmonics: np.ndarray, truncated: bool):
    """Eigenvalues s of Hill's problem in all coordinates, for perturbations of the given harmonics."""
    system = gear_system(model)
    n, size = system.degrees, harmonics.size
    wide = np.arange(harmonics[0] - 40, harmonics[-1] + 41) if not truncated else harmonics
    variation = np.zeros((size, wide.size), dtype=complex)
    for l, (alpha, phase) in enumerate(model.stiffness_harmonics(), start=1):
        shift = np.subtract.outer(harmonics, wide)
        variation += 0.5 * alpha * (np.exp(1j * phase) * (shift == l) + np.exp(-1j * phase) * (shift == -l))
    chi = _contact_matrix(model, motion, harmonics, harmonics)
    psi = variation @ _contact_matrix(model, motion, wide, harmonics)
    shift = np.kron(np.diag(1j * harmonics * omega), np.eye(n))
    mass, damping = np.kron(np.eye(size), system.mass), np.kron(np.eye(size), system.damping)
    stiffness = np.kron(np.eye(size), system.stiffness).astype(complex)
    stiffness += np.kron(chi, np.outer(system.force, system.contact))
    stiffness += np.kron(psi, np.outer(system.varying_force, system.contact))
    total = size * n
    inverse = np.linalg.inv(mass)
    # M (s + shift)^2 + C (s + shift) + K with v = (s + shift) y.
    state = np.block([[-shift, np.eye(total)], [-inverse @ stiffness, -inverse @ damping - shift]])
    return eigvals(state)
