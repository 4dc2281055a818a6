"""Floquet multipliers computed plainly: time integration between contact switches, restarted at each.

The only things shared with the solver are the matrices of `gear_system` and the motion to be looked at.
"""

import functools

import numpy as np
from scipy.integrate import solve_ivp
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
