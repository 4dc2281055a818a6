"""Duffing's oscillator as a problem for the same continuation code, with its closed first-order solution.

q'' + 0.05 q' + q + 0.1 q^3 = 0.18 cos(Omega t), q = c cos(Omega t) + s sin(Omega t), a^2 = c^2 + s^2:

    (1 - Omega^2 + 0.075 a^2) c + 0.05 Omega s = 0.18,    (1 - Omega^2 + 0.075 a^2) s - 0.05 Omega c = 0
    a^2 [(1 - Omega^2 + 0.075 a^2)^2 + (0.05 Omega)^2] = 0.18^2

The second of these is quadratic in Omega^2: every amplitude below the resonance's has two frequencies in closed form.
"""

import math

import numpy as np
from scipy.optimize import brentq

from solver import Problem
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel

DAMPING, STIFFNESS, CUBIC, FORCE = 0.05, 1.0, 0.1, 0.18

#: The amplitude whose crossing stands in for a grazing, as event 2.
LEVEL = 2.0


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))
def balance(theta, direction, y, residual, jacobian):
    """Residual (2,) and Jacobian (2, 3) at y = (c, s, Omega); theta = (damping, stiffness, cubic, force, Omega)."""
    c, s, omega = y[0], y[1], theta[4] + y[2] * direction[4]
    damping, hard = theta[0], 0.75 * theta[2]
    detuning = theta[1] - omega * omega + hard * (c * c + s * s)
    residual[0] = detuning * c + damping * omega * s - theta[3]
    residual[1] = detuning * s - damping * omega * c
    jacobian[0, 0], jacobian[0, 1] = detuning + 2.0 * hard * c * c, damping * omega + 2.0 * hard * c * s
    jacobian[1, 0], jacobian[1, 1] = -damping * omega + 2.0 * hard * c * s, detuning + 2.0 * hard * s * s
    jacobian[0, 2] = (-2.0 * omega * c + damping * s) * direction[4]
    jacobian[1, 2] = (-2.0 * omega * s - damping * c) * direction[4]


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))
def test_functions(theta, direction, y, values, gradient):
    """values (2,) = amplitude, amplitude - LEVEL."""
    amplitude = math.sqrt(y[0] * y[0] + y[1] * y[1])
    gradient[:, :] = 0.0
    if amplitude > 0.0:
        gradient[:, 0], gradient[:, 1] = y[0] / amplitude, y[1] / amplitude
    values[0], values[1] = amplitude, amplitude - LEVEL


def duffing(low=0.05, high=2.0) -> Problem:
    """The problem over Omega in [low, high]."""
    theta = np.array([DAMPING, STIFFNESS, CUBIC, FORCE, 0.0])
    scale = np.array([1.0, 1.0, 0.1 * (high - low)])
    return Problem(balance, test_functions, theta, np.eye(5)[4], scale, test_count=2)


def squared_frequencies(amplitude):
    """Omega^2 of the left and the right flank at an amplitude, ascending; at and above the largest one they agree."""
    square = np.asarray(amplitude, dtype=float) ** 2
    stiffness = STIFFNESS + 0.75 * CUBIC * square
    half = stiffness - 0.5 * DAMPING**2
    root = np.sqrt(np.maximum(half**2 - stiffness**2 + FORCE**2 / square, 0.0))
    return half - root, half + root


def defect(amplitude, omega):
    """a^2 [(1 - Omega^2 + 0.075 a^2)^2 + (0.05 Omega)^2] - 0.18^2, 0 on the curve."""
    square = np.asarray(amplitude) ** 2
    detuning = STIFFNESS - np.asarray(omega) ** 2 + 0.75 * CUBIC * square
    return square * (detuning**2 + (DAMPING * np.asarray(omega)) ** 2) - FORCE**2


def amplitudes(omega):
    """All amplitudes at a frequency, ascending: roots of a cubic in a^2."""
    hard, linear = 0.75 * CUBIC, STIFFNESS - omega**2
    roots = np.roots([hard**2, 2.0 * hard * linear, linear**2 + (DAMPING * omega) ** 2, -(FORCE**2)])
    return np.sqrt(np.sort(roots[np.abs(roots.imag) < 1e-9].real))


def start(omega, place=0):
    """A solution y = (c, s, Omega): the smallest, or the one at another place in order of amplitude."""
    amplitude = amplitudes(omega)[place]
    detuning = STIFFNESS - omega**2 + 0.75 * CUBIC * amplitude**2
    c, s = np.linalg.solve([[detuning, DAMPING * omega], [-DAMPING * omega, detuning]], [FORCE, 0.0])
    return np.array([c, s, omega])


def folds():
    """(Omega, a) of both folds, ascending in Omega: where the closed flank Omega(a) turns round."""

    def slope(amplitude, flank):
        h = 1e-5
        high, low = (squared_frequencies(amplitude + e)[flank] for e in (h, -h))
        return high - low

    found = [brentq(slope, 1.0, 2.0, (1,), xtol=1e-12), brentq(slope, 2.5, 2.838, (1,), xtol=1e-12)]
    return [(float(np.sqrt(squared_frequencies(a)[1])), a) for a in found]
