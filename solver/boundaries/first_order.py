"""Boundaries of the describing function over a plane, as the curve problems that continuation follows.

A fold curve is E = 0 with det dE/du = 0: the minimally augmented system (Govaerts, Numerical Methods for Bifurcations
of Dynamical Equilibria, SIAM 2000), whose one extra row is a smooth function with an analytic gradient once the angles
of contact are unknowns (`solver.boundaries.contact_angles`). A grazing curve is E = 0 with one of the angles at
+-pi/2. Period doublings and Neimark-Sackers are E = 0 with test functions of the monodromy matrix
(`solver.boundaries.bifurcations`), which depends on the angles as smoothly. Neither of the two parameters is special:
both are unknowns, and the curve is followed in a box.

The contact of a stretch are the zones of front and back flank: -1 where the flank lies below the whole motion, 0 where
the motion crosses it, 1 where it lies above. At the walls between two zones the boundary goes on in the next one.
"""

import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from solver.boundaries.bifurcations import ANGLE, CONTACT_FLANK, SENSE, bifurcation_test, critical_cosines
from solver.boundaries.contact_angles import (
    BACK,
    COEFFICIENTS,
    FRONT,
    TEST_COUNT,
    P,
    X,
    angle_rows,
    determinant,
    plane_coefficients,
    system_plane_coefficients,
)
from solver.boundaries.problem import Contact, Guess, Plane, Stretch, parameters_at, plane_parameters
from solver.continuation.continuation import EndReason, Event, Problem
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.model.gear_model import Model
from solver.model.parameters import BACK_CONTACT, EVENT, FLANK, FRONT_CONTACT, LENGTH_SCALE, LEVEL

__all__ = ["FirstOrderProblem"]

# A motion this close to touching a flank, in units of lambda's size, may lie on either side of the wall.
_WALL = 1e-7

#: Slot of y whose angle is fixed on a grazing curve, and the angle.
_GRAZED = {
    Event.MIN_AT_DRIVE: (FRONT, -0.5 * math.pi),
    Event.MIN_AT_BACK: (BACK, -0.5 * math.pi),
    Event.MAX_AT_DRIVE: (FRONT, 0.5 * math.pi),
    Event.MAX_AT_BACK: (BACK, 0.5 * math.pi),
}
_NOTHING_GRAZED = (-1, 0.0)
_ANGLES = slice(FRONT, BACK + 1)
_NONE, _FOLD = int(Event.NONE), int(Event.FOLD)
_NEIMARK_SACKER, _DOUBLING = int(Event.NEIMARK_SACKER), int(Event.PERIOD_DOUBLING)
_B = types.boolean
_TURN = 2.0 * math.pi

# Columns of the switches of contact behind those of `bifurcations`: the slot of the flank's angle of contact, and how
# the angle of the switch moves with it.
_SLOT, _BY_CONTACT, _SWITCHES = range(3, 6)


@kernel(types.Tuple((types.float64, types.int64, MATRIX))(ARRAY, ARRAY), inner=True)
def _switches(parameters, y):
    """A start of the period, the zone of contact then, and the switches of contact that follow, (k, _SWITCHES).

    With lambda = lambda_m + lambda_a cos(theta - psi) there is contact at the front flank while
    |theta - psi| < pi/2 - phi_f, at the back one while |theta - psi| > pi/2 - phi_b. The period starts in the middle of
    the front contact. Beyond a wall a contact, or the time without, lasts for a negative while: what depends on the
    angles goes on smoothly.
    """
    psi, count = math.atan2(y[2], y[1]), 0
    switches = np.empty((4, _SWITCHES))
    front, back = parameters[FRONT_CONTACT], parameters[BACK_CONTACT]
    for i in range(4):
        # End of front contact, begin and end of back contact, begin of front contact.
        slot = FRONT if i == 0 or i == 3 else BACK
        if (front if slot == FRONT else back) != 0.0:
            continue
        half, later = 0.5 * math.pi - y[slot], i >= 2
        switches[count, ANGLE] = psi + _TURN - half if later else psi + half
        switches[count, SENSE] = 1.0 if i % 2 == 1 else -1.0
        switches[count, CONTACT_FLANK] = 1.0 if slot == FRONT else -1.0
        switches[count, _SLOT], switches[count, _BY_CONTACT] = slot, 1.0 if later else -1.0
        count += 1
    return psi, 1 if front <= 0.0 else (-1 if back > 0.0 else 0), switches[:count]


@kernel(types.void(COEFFICIENTS, ARRAY, ARRAY, ARRAY, ARRAY, MATRIX), inner=True)
def _bifurcation_rows(known, parameters, parameter_slope, y, residual, jacobian):
    """Balance, angles and test functions: (6,) and (6, 7) for a real multiplier, (7,) and (7, 8) for a
    Neimark-Sacker."""
    here, along_x, along_p = parameters_at(parameters, parameter_slope, y)
    event, last = int(parameters[EVENT]), y.shape[0] - 1
    real = 0.0 if event == _NEIMARK_SACKER else -1.0 if event == _DOUBLING else 1.0
    part = np.empty((5, 7))
    angle_rows(known, parameters, y, residual, part)
    for i in range(5):
        jacobian[i, 5] = 0.0
        for j in range(5):
            jacobian[i, j] = part[i, j]
        jacobian[i, last - 1], jacobian[i, last] = part[i, X], part[i, P]
    start, zone, switches = _switches(parameters, y)
    by_angle, by_axis = np.empty((2, switches.shape[0])), np.empty((2, 2))
    at = here, along_x, along_p
    values = bifurcation_test(parameters, *at, real, y[5], start, zone, switches, by_angle, by_axis)
    square = y[1] * y[1] + y[2] * y[2]
    for row in range(2 if real == 0.0 else 1):
        residual[5 + row] = values[row]
        for j in range(5):
            jacobian[5 + row, j] = 0.0
        jacobian[5 + row, 5] = values[2 + row]
        jacobian[5 + row, last - 1], jacobian[5 + row, last] = by_axis[row, 0], by_axis[row, 1]
        for c in range(switches.shape[0]):
            jacobian[5 + row, 1] -= by_angle[row, c] * y[2] / square
            jacobian[5 + row, 2] += by_angle[row, c] * y[1] / square
            jacobian[5 + row, int(switches[c, _SLOT])] += by_angle[row, c] * switches[c, _BY_CONTACT]


@kernel(types.void(COEFFICIENTS, ARRAY, ARRAY, ARRAY, ARRAY, MATRIX), inner=True)
def _rows(known, parameters, parameter_slope, y, residual, jacobian):
    """The rows of an event: balance and angles, then det dE/du of a fold, the angle of the grazed flank, the amplitude
    in units of a ceiling (no event), (6,) and (6, 7), or `_bifurcation_rows`."""
    event = int(parameters[EVENT])
    if event >= _DOUBLING:
        _bifurcation_rows(known, parameters, parameter_slope, y, residual, jacobian)
        return
    angle_rows(known, parameters, y, residual, jacobian)
    if event == _FOLD:
        residual[5] = determinant(known, parameters, y, jacobian[5], np.empty((3, 3)))
        return
    level, slot = parameters[LEVEL], int(parameters[FLANK])
    jacobian[5, :] = 0.0
    if event == _NONE:
        amplitude = math.sqrt(y[1] * y[1] + y[2] * y[2])
        residual[5] = amplitude / level - 1.0
        jacobian[5, 1], jacobian[5, 2] = y[1] / (amplitude * level), y[2] / (amplitude * level)
    else:
        residual[5] = y[slot] - level
        jacobian[5, slot] = 1.0


@kernel(_B(ARRAY, ARRAY, ARRAY, MATRIX), inner=True)
def _amplitude_test(parameters, y, values, gradient):
    """The first test function, the amplitude (0 along a ceiling); whether there is a second one."""
    values[0] = 0.0
    gradient[0, :] = 0.0
    if int(parameters[EVENT]) != _NONE:
        amplitude = math.sqrt(y[1] * y[1] + y[2] * y[2])
        values[0] = amplitude
        if amplitude > 0.0:
            gradient[0, 1], gradient[0, 2] = y[1] / amplitude, y[2] / amplitude
    return values.shape[0] > 1


@kernel(types.void(COEFFICIENTS, ARRAY, ARRAY, ARRAY, MATRIX), inner=True)
def _determinant_test(known, parameters, y, values, gradient):
    """The second one, det dE/du."""
    slopes, last = np.empty(7), y.shape[0] - 1
    values[1] = determinant(known, parameters, y, slopes, np.empty((3, 3)))
    # Of a Neimark-Sacker kappa stands before the axes.
    gradient[1, :] = 0.0
    for j in range(5):
        gradient[1, j] = slopes[j]
    gradient[1, last - 1], gradient[1, last] = slopes[X], slopes[P]


# A gear's own come first: what is compiled for it has nothing of other systems.


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))
def gear_rows(parameters, parameter_slope, y, residual, jacobian):
    """Rows of the boundaries of a gear pair, by the event in its parameters."""
    known = plane_coefficients(parameters, parameter_slope, y)
    _rows(known, parameters, parameter_slope, y, residual, jacobian)


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))
def gear_tests(parameters, parameter_slope, y, values, gradient):
    """Test functions along them."""
    if _amplitude_test(parameters, y, values, gradient):
        _determinant_test(plane_coefficients(parameters, parameter_slope, y), parameters, y, values, gradient)


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))
def system_rows(parameters, parameter_slope, y, residual, jacobian):
    """`gear_rows` of a `ContactSystem`."""
    known = system_plane_coefficients(parameters, parameter_slope, y)
    _rows(known, parameters, parameter_slope, y, residual, jacobian)


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))
def system_tests(parameters, parameter_slope, y, values, gradient):
    """`gear_tests` of a `ContactSystem`."""
    if _amplitude_test(parameters, y, values, gradient):
        _determinant_test(system_plane_coefficients(parameters, parameter_slope, y), parameters, y, values, gradient)


@dataclass(frozen=True)
class FirstOrderProblem:
    """Boundaries of the describing function; see `solver.boundaries.problem.BoundaryProblem`.

    Parameters
    ----------
    plane : Plane

    Raises
    ------
    ParameterError
        If the path of the plane uses its x axis, or is not smooth between its knots.
    """

    plane: Plane

    def __post_init__(self):
        plane, size = self.plane, self.plane.motion_size
        parameters, parameter_slope = plane_parameters(plane, 1, 1)
        parameters[LENGTH_SCALE] = size
        gear = isinstance(plane.system, Model)
        object.__setattr__(self, "_two_sided", gear or plane.system.two_sided)
        object.__setattr__(self, "_held", not gear and plane.system.held)
        # Without mean load, springs that hold lambda make its mean 0: motions graze flanks that are alike at once.
        alike = not gear and ("gap" in (plane.x_axis, plane.p_axis) or plane.system.front_gap == plane.system.back_gap)
        mirrored = self._held and alike and plane.system.bounded_change and not np.any(plane.system.load[0])
        object.__setattr__(self, "_mirrored", mirrored)
        scale = np.array([size, size, size, 1.0, 1.0, *plane.scale])
        for name, value in (("parameters", parameters), ("parameter_slope", parameter_slope), ("scale", scale)):
            value.setflags(write=False)
            object.__setattr__(self, f"_{name}", value)

    @property
    def unknowns(self) -> int:
        """Number of unknowns of a motion: lambda_m, lambda_c, lambda_s."""
        return 3

    def components(self, kind: Event) -> tuple[int, ...]:
        """Where (lambda_m, lambda_c, lambda_s, x, p) stand in y: the angles of contact, and kappa, lie between them."""
        gap = int(kind is Event.NEIMARK_SACKER)
        return 0, 1, 2, X + gap, P + gap

    def shown(self, kind: Event) -> tuple[int, ...]:
        """Which components of y a boundary shows: all but the angles and kappa."""
        return self.components(kind)

    def problem(self, kind: Event, contact: Contact) -> Problem:
        """The curve of one kind within a pair of zones; of no event it is an amplitude, LEVEL."""
        parameters, parameter_slope, scale = self._parameters.copy(), self._parameter_slope.copy(), self._scale.copy()
        parameters[[FRONT_CONTACT, BACK_CONTACT]] = contact
        parameters[EVENT] = kind
        if kind in _GRAZED:
            parameters[[FLANK, LEVEL]] = _GRAZED[kind]
        if kind is Event.NEIMARK_SACKER:
            scale = np.insert(scale, X, 1.0)
        rows, tests = (gear_rows, gear_tests) if isinstance(self.plane.system, Model) else (system_rows, system_tests)
        return Problem(rows, tests, parameters, parameter_slope, scale, 1 if kind is Event.FOLD else TEST_COUNT)

    def confined(self, kind: Event, contact: Contact) -> Problem:
        """The same: the walls of the zones are sides of the box."""
        return self.problem(kind, contact)

    def repeats(self, kind: Event) -> bool:
        """Grazings of the back flank where motions are symmetric: these graze the front one at the same time."""
        return self._mirrored and kind in (Event.MIN_AT_BACK, Event.MAX_AT_BACK)

    def box(self, kind: Event, contact: Contact) -> tuple[np.ndarray, np.ndarray]:
        """Low and high border of y, infinite where it is free: the plane, the walls of a pair of zones, and for
        Neimark-Sackers the resonances kappa = -1 and 1."""
        size = len(self._scale) + (kind is Event.NEIMARK_SACKER)
        low, high = np.full(size, -np.inf), np.full(size, np.inf)
        grazed, _ = _GRAZED.get(kind, _NOTHING_GRAZED)
        for slot, zone in zip((FRONT, BACK), contact, strict=True):
            if slot != grazed:
                low[slot] = (-np.inf, -0.5 * math.pi, 0.5 * math.pi)[zone + 1]
                high[slot] = (-0.5 * math.pi, 0.5 * math.pi, np.inf)[zone + 1]
        if not self._two_sided or (self._mirrored and grazed == FRONT):
            # Where there is no back flank nothing happens at it, nor where its grazing is that of the front one.
            low[BACK], high[BACK] = -np.inf, np.inf
        if kind is Event.NEIMARK_SACKER:
            low[X], high[X] = -1.0, 1.0
        (low[-2], high[-2]), (low[-1], high[-1]) = self.plane.x_range, self.plane.p_range
        return low, high

    def starts(self, kind: Event, point: np.ndarray) -> Iterable[tuple[Contact, np.ndarray]]:
        """Pairs of zones with contact that (lambda_m, lambda_c, lambda_s, x, p) lies in, and its y in each.

        For a Neimark-Sacker there is one for every pair of multipliers next to the unit circle.
        """
        for contact in self.zones(kind, point):
            if self.contact_free(kind, contact):
                continue
            y = self.lift(kind, contact, point)
            if kind is not Event.NEIMARK_SACKER:
                yield contact, y
                continue
            for kappa in critical_cosines(self.problem(kind, contact), np.insert(y, X, 0.0)):
                yield contact, np.insert(y, X, kappa)

    def contact_at(self, kind: Event, contact: Contact, y: np.ndarray) -> Contact:
        """The same: y is sought within its zones."""
        return contact

    def guesses_beyond(self, kind: Event, stretch: Stretch) -> Iterable[Guess]:
        """Beyond the wall at which a stretch ends, unless the motion has no contact there."""
        curve = stretch.curve
        if curve.ends[1] is not EndReason.RANGE_LEFT:
            return
        y, (low, high) = curve.points[-1], self.box(kind, stretch.contact)
        ended = np.flatnonzero((y == low) | (y == high))
        if ended.size != 1 or ended[0] not in (FRONT, BACK):
            return
        (slot,) = ended
        move = int(np.sign(curve.tangents[-1, slot]))
        contact = tuple(zone + move * int(FRONT + i == slot) for i, zone in enumerate(stretch.contact))
        if not self.contact_free(kind, contact):
            yield Guess(contact, y, move * np.eye(y.size)[slot], 0.0)

    def static_determinants(self, problem: Problem, points: np.ndarray) -> np.ndarray:
        """det dE/du."""
        return problem.observed_all(points, TEST_COUNT)[:, 1]

    def fold_rows(self, problem: Problem, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """dE/du (3, 3), dE/dp (3,) and the derivatives of det dE/du by u (3,): the angles follow u and p."""
        _, jacobian = problem.evaluated(y)
        by_y = -jacobian[3:5] / np.diag(jacobian[3:5, _ANGLES])[:, None]
        whole = jacobian + jacobian[:, _ANGLES] @ by_y
        return whole[:3, :3], whole[:3, P], whole[5, :3]

    def zones(self, kind: Event, point: np.ndarray) -> list[tuple[int, int]]:
        """Pairs of zones that (lambda_m, lambda_c, lambda_s, x, p) lies in: several on a wall, within rounding.

        The grazed flank counts as crossed.
        """
        (low, high), amplitude = self.plane.dead_zone(point[3], point[4]), math.hypot(point[1], point[2])
        grazed, _ = _GRAZED.get(kind, _NOTHING_GRAZED)
        choices = []
        for slot, distance in ((FRONT, high - point[0]), (BACK, low - point[0])):
            margin, outer = abs(distance) - amplitude, -1 if distance < 0.0 else 1
            if slot == grazed:
                choices.append([0])
            elif abs(margin) <= _WALL * self._scale[0]:
                choices.append([outer, 0])
            else:
                choices.append([0 if margin < 0.0 else outer])
        return list(itertools.product(*choices))

    def contact_free(self, kind: Event, contact: Contact) -> bool:
        """Whether nothing touches in these zones, so that f vanishes, and the balance leaves the mean open."""
        if self._held:
            return False
        grazed, angle = _GRAZED.get(kind, _NOTHING_GRAZED)
        front = contact[0] == 1 or (grazed == FRONT and angle > 0.0)
        back = contact[1] == -1 or (grazed == BACK and angle < 0.0)
        return front and back

    def lift(self, kind: Event, contact: Contact, point: np.ndarray) -> np.ndarray:
        """y (7,) of (lambda_m, lambda_c, lambda_s, x, p): the angles of contact put in."""
        (low, high), amplitude = self.plane.dead_zone(point[3], point[4]), math.hypot(point[1], point[2])
        # A back flank that is not there lies below the motion, at no distance that matters.
        low = low if np.isfinite(low) else 0.0
        angles = []
        for zone, distance in zip(contact, (high - point[0], low - point[0]), strict=True):
            if zone == 0:
                angles.append(math.asin(min(max(distance / amplitude, -1.0), 1.0)) if amplitude > 0.0 else 0.0)
            else:
                beyond = (zone * distance - amplitude) / self._parameters[LENGTH_SCALE]
                angles.append(zone * (0.5 * math.pi + beyond))
        y = np.array([*point[:3], *angles, *point[3:]])
        slot, angle = _GRAZED.get(kind, _NOTHING_GRAZED)
        if slot >= 0:
            y[slot] = angle
        return y
