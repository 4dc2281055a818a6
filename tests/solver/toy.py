"""A one-unknown curve of which everything is known, for what continuation shall do at places gears do not have.

E = t0 u^3 + t1 u + t2 u p + t3 p = 0, undefined (nan) for p > t4;  monitor: |u|, (u - t5)^2 - t6
"""

import math

import numpy as np

from solver import Problem
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))
def balance(theta, direction, y, residual, jacobian):
    """Residual (1,) and Jacobian (1, 2) at y = (u, p)."""
    u, p = y[0], y[1]
    residual[0] = theta[0] * u**3 + theta[1] * u + theta[2] * u * p + theta[3] * p
    jacobian[0, 0] = 3.0 * theta[0] * u * u + theta[1] + theta[2] * p
    jacobian[0, 1] = theta[2] * u + theta[3]
    if p > theta[4]:
        residual[0] = math.nan


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))
def test_functions(theta, direction, y, values, gradient):
    """Amplitude |u| and a parabola in u, which two places graze."""
    values[0], values[1] = abs(y[0]), (y[0] - theta[5]) ** 2 - theta[6]
    gradient[0, 0], gradient[0, 1] = math.copysign(1.0, y[0]), 0.0
    gradient[1, 0], gradient[1, 1] = 2.0 * (y[0] - theta[5]), 0.0


def toy(cubic=0.0, linear=0.0, mixed=0.0, parameter=0.0, limit=np.inf, centre=0.0, depth=-1.0) -> Problem:
    """The curve with the given coefficients; p is scaled by 1."""
    theta = np.array([cubic, linear, mixed, parameter, limit, centre, depth])
    return Problem(balance, test_functions, theta, np.zeros(7), np.ones(2), test_count=2)


def s_curve(gap: float, **changes) -> Problem:
    """p = u^3 - gap u: stable where p grows with u, folds at u = -+sqrt(gap/3)."""
    return toy(cubic=1.0, linear=-gap, parameter=-1.0, **changes)
