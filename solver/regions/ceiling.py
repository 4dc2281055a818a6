"""Where a branch passes the amplitude ceiling: a boundary of what is counted, though nothing happens to the motion.

Towards parametric resonance branches run to infinite amplitude. Solutions above the ceiling do not count, so that the
label changes where lambda_a = ceiling: a curve of the plane like a fold or a grazing.
"""

import math

import numpy as np

from solver.boundaries.contact_angles import GRAZED_ANGLE, MONITORS, ZONE, angle_rows, determinant, plane_coefficients
from solver.boundaries.curve import BoundaryCurve
from solver.boundaries.plane import Plane
from solver.boundaries.trace import Tracer
from solver.continuation.continuation import Continuation, Event, Problem
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel

__all__ = ["ceiling_curve"]


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))
def _ceiling_balance(theta, direction, y, residual, jacobian):
    """Balance, angles and the amplitude, in units of the ceiling: (6,) and (6, 7)."""
    angle_rows(plane_coefficients(theta, direction, y), theta, y, residual, jacobian)
    ceiling, amplitude = theta[GRAZED_ANGLE], math.sqrt(y[1] * y[1] + y[2] * y[2])
    residual[5] = amplitude / ceiling - 1.0
    jacobian[5, :] = 0.0
    jacobian[5, 1], jacobian[5, 2] = y[1] / (amplitude * ceiling), y[2] / (amplitude * ceiling)


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))
def _ceiling_monitor(theta, direction, y, values, gradient):
    """Nothing that ends the curve, and det dE/du."""
    values[0] = 0.0
    gradient[0, :] = 0.0
    if values.shape[0] > 1:
        known = plane_coefficients(theta, direction, y)
        values[1] = determinant(known, theta, y, gradient[1], np.empty((3, 3)))


class _CeilingPlane(Plane):
    """The plane with the ceiling in place of a grazing; both flanks may be crossed or not, as on fold curves."""

    ceiling: float

    def problem(self, kind: Event, zones: tuple[int, int]) -> Problem:
        theta = self._theta.copy()
        theta[ZONE : ZONE + 2] = zones
        theta[GRAZED_ANGLE] = self.ceiling
        scale = self._scale.copy()
        scale[:3] = self.ceiling
        return Problem(_ceiling_balance, _ceiling_monitor, theta, self._direction.copy(), scale, MONITORS)

    def box(self, kind: Event, zones: tuple[int, int]):
        return super().box(Event.FOLD, zones)

    def zones(self, kind: Event, point: np.ndarray):
        return super().zones(Event.FOLD, point)

    def contact_free(self, kind: Event, zones: tuple[int, int]) -> bool:
        return super().contact_free(Event.FOLD, zones)

    def lift(self, kind: Event, zones: tuple[int, int], point: np.ndarray) -> np.ndarray:
        return super().lift(Event.FOLD, zones, point)


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
    own = _CeilingPlane(plane.model, plane.x_axis, plane.p_axis, plane.x_range, plane.p_range, plane.omega)
    object.__setattr__(own, "ceiling", float(ceiling))
    return Tracer(own, Event.NONE, continuation or Continuation()).boundary(point)
