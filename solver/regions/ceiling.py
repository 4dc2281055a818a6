"""Where a branch passes the amplitude ceiling: a boundary of what is counted, though nothing happens to the motion.

Towards parametric resonance branches run to infinite amplitude. Solutions above the ceiling do not count, so that the
label changes where lambda_a = ceiling: a curve of the plane like a fold or a grazing.
"""

import math
from dataclasses import dataclass

import numpy as np

from solver.boundaries.contact_angles import (
    COEFFICIENTS,
    TEST_COUNT,
    angle_rows,
    determinant,
    plane_coefficients,
    system_plane_coefficients,
)
from solver.boundaries.curve import BoundaryCurve, assembled
from solver.boundaries.first_order import FirstOrderProblem
from solver.boundaries.problem import Contact, Plane
from solver.boundaries.tracer import Tracer
from solver.continuation.continuation import Continuation, Event, Problem
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.model.gear_model import Model
from solver.model.parameters import LEVEL

__all__ = ["ceiling_curve"]


@kernel(types.void(COEFFICIENTS, ARRAY, ARRAY, ARRAY, MATRIX), inner=True)
def _ceiling_rows(known, parameters, y, residual, jacobian):
    """Balance, angles and the amplitude, in units of the ceiling: (6,) and (6, 7)."""
    angle_rows(known, parameters, y, residual, jacobian)
    ceiling, amplitude = parameters[LEVEL], math.sqrt(y[1] * y[1] + y[2] * y[2])
    residual[5] = amplitude / ceiling - 1.0
    jacobian[5, :] = 0.0
    jacobian[5, 1], jacobian[5, 2] = y[1] / (amplitude * ceiling), y[2] / (amplitude * ceiling)


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))
def _ceiling_balance(parameters, parameter_slope, y, residual, jacobian):
    _ceiling_rows(plane_coefficients(parameters, parameter_slope, y), parameters, y, residual, jacobian)


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))
def _system_ceiling_balance(parameters, parameter_slope, y, residual, jacobian):
    _ceiling_rows(system_plane_coefficients(parameters, parameter_slope, y), parameters, y, residual, jacobian)


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))
def _ceiling_tests(parameters, parameter_slope, y, values, gradient):
    """Nothing that ends the curve, and det dE/du."""
    values[0] = 0.0
    gradient[0, :] = 0.0
    if values.shape[0] > 1:
        known = plane_coefficients(parameters, parameter_slope, y)
        values[1] = determinant(known, parameters, y, gradient[1], np.empty((3, 3)))


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))
def _system_ceiling_tests(parameters, parameter_slope, y, values, gradient):
    """`_ceiling_tests` of a `ContactSystem`."""
    values[0] = 0.0
    gradient[0, :] = 0.0
    if values.shape[0] > 1:
        known = system_plane_coefficients(parameters, parameter_slope, y)
        values[1] = determinant(known, parameters, y, gradient[1], np.empty((3, 3)))


@dataclass(frozen=True)
class _CeilingProblem(FirstOrderProblem):
    """The ceiling in place of a grazing; both flanks may be crossed or not, as along folds."""

    ceiling: float

    def problem(self, kind: Event, contact: Contact) -> Problem:
        folds = super().problem(Event.FOLD, contact)
        folds.parameters[LEVEL] = self.ceiling
        folds.scale[:3] = self.ceiling
        rows, tests = _ceiling_balance, _ceiling_tests
        if not isinstance(self.plane.system, Model):
            rows, tests = _system_ceiling_balance, _system_ceiling_tests
        return Problem(rows, tests, folds.parameters, folds.parameter_slope, folds.scale, TEST_COUNT)


def ceiling_curve(
    plane: Plane, ceiling: float, point: np.ndarray, continuation: Continuation | None = None
) -> BoundaryCurve | None:
    """The curve lambda_a = ceiling through a point.

    Parameters
    ----------
    plane : Plane
    ceiling : float
        Amplitude.
    point : (5,) array
        lambda_m, lambda_c, lambda_s, x, p of a solution next to it.
    continuation : Continuation, optional

    Returns
    -------
    BoundaryCurve or None
        Of kind NONE, as nothing happens to the motion; None if none could be followed.
    """
    problem = _CeilingProblem(plane, float(ceiling))
    chain = Tracer(problem, Event.NONE, continuation or Continuation()).boundary(point)
    return None if chain is None else assembled(problem, Event.NONE, chain.directed())
