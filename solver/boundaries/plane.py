"""Folds and grazings over a plane of two parameters, as the curve problems that continuation follows.

A fold curve is E = 0 with det dE/du = 0: the minimally augmented system, whose one extra row is a smooth function with
an analytic gradient once the angles of contact are unknowns (`solver.boundaries.contact_angles`). A grazing curve is
E = 0 with one of the angles at +-pi/2. Neither of the two parameters is special: both are unknowns, and the curve is
followed in a box.
"""

import itertools
import math
from dataclasses import dataclass

import numpy as np

from solver.boundaries.contact_angles import (
    BACK,
    FRONT,
    GRAZED_ANGLE,
    GRAZED_FLANK,
    LENGTH_SCALE,
    MONITORS,
    PACKED,
    ZONE,
    X,
    angle_rows,
    determinant,
    plane_coefficients,
)
from solver.continuation.continuation import Event, Problem
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.model.checks import ParameterError
from solver.model.condensation import AXES, axis_vectors
from solver.model.gear_model import Model
from solver.model.parameter_path import ParameterPath, place_on, plane_vectors

__all__ = ["KINDS", "Plane"]

# A motion this close to touching a flank, in units of lambda's size, may lie on either side of the wall.
_WALL = 1e-7

#: Slot of y whose angle is fixed on a grazing curve, and the angle.
_GRAZED = {
    Event.MIN_AT_DRIVE: (FRONT, -0.5 * math.pi),
    Event.MIN_AT_BACK: (BACK, -0.5 * math.pi),
    Event.MAX_AT_DRIVE: (FRONT, 0.5 * math.pi),
    Event.MAX_AT_BACK: (BACK, 0.5 * math.pi),
}

#: The boundaries that can be followed.
KINDS = (Event.FOLD, *_GRAZED)


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))
def _fold_balance(theta, direction, y, residual, jacobian):
    """Balance, angles and det dE/du: (6,) and (6, 7)."""
    known = plane_coefficients(theta, direction, y)
    angle_rows(known, theta, y, residual, jacobian)
    residual[5] = determinant(known, theta, y, jacobian[5], np.empty((3, 3)))


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))
def _grazing_balance(theta, direction, y, residual, jacobian):
    """Balance, angles and the grazed flank's angle: (6,) and (6, 7)."""
    angle_rows(plane_coefficients(theta, direction, y), theta, y, residual, jacobian)
    slot = int(theta[GRAZED_FLANK])
    residual[5] = y[slot] - theta[GRAZED_ANGLE]
    jacobian[5, :] = 0.0
    jacobian[5, slot] = 1.0


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))
def _monitor(theta, direction, y, values, gradient):
    """Amplitude, and det dE/du where there is room for it."""
    amplitude = math.sqrt(y[1] * y[1] + y[2] * y[2])
    values[0] = amplitude
    gradient[0, :] = 0.0
    if amplitude > 0.0:
        gradient[0, 1], gradient[0, 2] = y[1] / amplitude, y[2] / amplitude
    if values.shape[0] > 1:
        known = plane_coefficients(theta, direction, y)
        values[1] = determinant(known, theta, y, gradient[1], np.empty((3, 3)))


@dataclass(frozen=True)
class Plane:
    """Where boundaries are sought.

    Parameters
    ----------
    model : Model
        Its own values of the two axes are not used; a path starts from it.
    x_axis : str
        One of `solver.model.condensation.AXES`.
    p_axis : str or ParameterPath
        Another one, or a path of models.
    x_range, p_range : (low, high)
    omega : float, optional
        The frequency; needed unless it is an axis.

    Raises
    ------
    ParameterError
        If the axes are equal, unknown or at odds, a range is empty, or the frequency is missing.
    """

    model: Model
    x_axis: str
    p_axis: str | ParameterPath
    x_range: tuple[float, float]
    p_range: tuple[float, float]
    omega: float | None = None

    def __post_init__(self):
        for name in ("x_axis", "p_axis"):
            axis = getattr(self, name)
            if axis not in AXES and not (name == "p_axis" and isinstance(axis, ParameterPath)):
                raise ParameterError(name, axis, f"one of {', '.join(AXES)}")
        if self.x_axis == self.p_axis:
            raise ParameterError("p_axis", self.p_axis, "another parameter than x_axis")
        for name in ("x_range", "p_range"):
            low, high = (float(v) for v in getattr(self, name))
            if not -np.inf < low < high < np.inf:
                raise ParameterError(name, (low, high), "two finite ascending numbers")
            object.__setattr__(self, name, (low, high))
        if "omega" not in (self.x_axis, self.p_axis) and (self.omega is None or not 0.0 < self.omega < np.inf):
            raise ParameterError("omega", self.omega, "a finite number above 0, as no axis is the frequency")
        at_x, _ = place_on(self.x_axis, 0.5 * sum(self.x_range), self.model)

        def vectors(axis, p):
            return axis_vectors(place_on(self.p_axis, p, at_x)[0], axis, self.omega or 0.0)

        read = plane_vectors(vectors, self.x_axis, self.p_axis, self.p_range)
        size = place_on(self.p_axis, 0.5 * sum(self.p_range), at_x)[0].motion_size
        theta = np.concatenate([read.base, read.along_x, np.zeros(PACKED - ZONE), read.bent])
        theta[LENGTH_SCALE] = size
        direction = read.along_p
        scale = np.array([size, size, size, 1.0, 1.0, *(0.1 * (r[1] - r[0]) for r in (self.x_range, self.p_range))])
        for name, value in (("theta", theta), ("direction", direction), ("scale", scale)):
            value.setflags(write=False)
            object.__setattr__(self, f"_{name}", value)

    @property
    def scale(self) -> np.ndarray:
        """Typical size of (lambda_m, lambda_c, lambda_s, phi_f, phi_b, x, p), (7,)."""
        return self._scale

    def half_backlash(self, x, p: float):
        """b at places x, a number or an array, of the row p."""
        if self.x_axis == "b":
            return x
        return np.broadcast_to(place_on(self.p_axis, p, self.model)[0].b, np.shape(x))

    def problem(self, kind: Event, zones: tuple[int, int]) -> Problem:
        """The curve of one kind within a pair of zones of front and back flank (-1 below, 0 crossed, 1 above)."""
        theta = self._theta.copy()
        theta[ZONE : ZONE + 2] = zones
        if kind is Event.FOLD:
            return Problem(_fold_balance, _monitor, theta, self._direction.copy(), self._scale.copy(), monitors=1)
        theta[GRAZED_FLANK], theta[GRAZED_ANGLE] = _GRAZED[kind]
        return Problem(_grazing_balance, _monitor, theta, self._direction.copy(), self._scale.copy(), MONITORS)

    def box(self, kind: Event, zones: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
        """The plane's border and the walls of a pair of zones: low and high (7,), infinite where free."""
        low, high = np.full(7, -np.inf), np.full(7, np.inf)
        for slot, zone in zip((FRONT, BACK), zones, strict=True):
            if kind is not Event.FOLD and _GRAZED[kind][0] == slot:
                continue
            low[slot] = (-np.inf, -0.5 * math.pi, 0.5 * math.pi)[zone + 1]
            high[slot] = (-0.5 * math.pi, 0.5 * math.pi, np.inf)[zone + 1]
        (low[X], high[X]), (low[X + 1], high[X + 1]) = self.x_range, self.p_range
        return low, high

    def zones(self, kind: Event, point: np.ndarray) -> list[tuple[int, int]]:
        """Pairs of zones that (lambda_m, lambda_c, lambda_s, x, p) lies in: several on a wall, within rounding.

        The grazed flank counts as crossed.
        """
        b, amplitude = self.half_backlash(point[3], point[4]), math.hypot(point[1], point[2])
        choices = []
        for slot, distance in ((FRONT, b - point[0]), (BACK, -b - point[0])):
            margin, outer = abs(distance) - amplitude, -1 if distance < 0.0 else 1
            if kind is not Event.FOLD and _GRAZED[kind][0] == slot:
                choices.append([0])
            elif abs(margin) <= _WALL * self._scale[0]:
                choices.append([outer, 0])
            else:
                choices.append([0 if margin < 0.0 else outer])
        return list(itertools.product(*choices))

    def contact_free(self, kind: Event, zones: tuple[int, int]) -> bool:
        """Whether the teeth never touch in these zones: f vanishes there, and the balance leaves the mean open."""
        grazed, angle = _GRAZED.get(kind, (None, 0.0))
        front = zones[0] == 1 or (grazed == FRONT and angle > 0.0)
        back = zones[1] == -1 or (grazed == BACK and angle < 0.0)
        return front and back

    def lift(self, kind: Event, zones: tuple[int, int], point: np.ndarray) -> np.ndarray:
        """y (7,) of (lambda_m, lambda_c, lambda_s, x, p): the angles of contact put in."""
        b, amplitude = self.half_backlash(point[3], point[4]), math.hypot(point[1], point[2])
        angles = []
        for zone, distance in zip(zones, (b - point[0], -b - point[0]), strict=True):
            if zone == 0:
                angles.append(math.asin(min(max(distance / amplitude, -1.0), 1.0)) if amplitude > 0.0 else 0.0)
            else:
                beyond = (zone * distance - amplitude) / self._theta[LENGTH_SCALE]
                angles.append(zone * (0.5 * math.pi + beyond))
        y = np.array([*point[:3], *angles, *point[3:]])
        if kind is not Event.FOLD:
            slot, angle = _GRAZED[kind]
            y[slot] = angle
        return y
