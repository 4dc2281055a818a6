"""Folds, grazings, period doublings and Neimark-Sackers of a balance over a plane, as curve problems.

The unknowns are y = (u, x, p) with the motion u and the axes x and p; for Neimark-Sackers (u, omega nu/Omega, x, p)
with the second frequency. Rows are the balance, then what makes the motion special: the scaled determinant of Hill's
matrix at the exponent 0 (fold), at half the base frequency (period doubling), at i omega (Neimark-Sacker: real and
imaginary part), or the distance of an extreme of lambda from a flank (grazing).

Kernels see the vectors of `solver.boundaries.problem`; the parameters are those of `solver.harmonic.layout.packed`.

A determinant has an infinite gradient where the motion grazes a flank, and its curve a corner. The contact of a stretch
says how often the motion switches contact at the front and at the back flank. A problem may be confined to it: beyond,
its equations are not numbers, and continuation stops at the corner.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numba import types

from solver.boundaries.problem import (
    BACK_CONTACT,
    BIFURCATIONS,
    EVENT,
    FLANK,
    FOLDS_AND_GRAZINGS,
    FRONT_CONTACT,
    GRAZINGS,
    HEADER,
    LEVEL,
    Contact,
    Guess,
    Plane,
    Stretch,
    parameters_at,
    plane_theta,
)
from solver.contact.spectrum import contact_arcs
from solver.continuation.continuation import EndReason, Event, Problem
from solver.continuation.problem import Balance
from solver.harmonic import describing_function, galerkin
from solver.harmonic.layout import BACK, FRONT, PAIRS, SIGN, STIFFNESSES, packed
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.model.condensation import SIZE
from solver.stability.hill_determinant import HALF, WHOLE
from solver.stability.hill_slopes import determinant_slopes
from solver.stability.scan import critical_shares

__all__ = ["HarmonicProblem"]

_FOLD, _DOUBLING, _NEIMARK_SACKER = int(Event.FOLD), int(Event.PERIOD_DOUBLING), int(Event.NEIMARK_SACKER)

WINDOW, TRUNCATED = FLANK, LEVEL
ANY = -1
# How far to look for the other side of a corner, in scaled unknowns.
_HOPS = (1e-3, 1e-2, 1e-4)

# The imaginary part of the determinant is odd about the centre of a window. Divided by the distance from it, which is
# taken to be at least this, it leaves a regular equation.
_CENTRE = 1e-4

_balance_1, _balance_h, _monitor_h = describing_function.balance, galerkin.balance, galerkin.monitor


@kernel(types.UniTuple(types.int64, 2)(ARRAY, ARRAY, ARRAY))
def _switches(theta, direction, y):
    """How often the motion at y switches contact over its period, at the front and at the back flank."""
    here, _, _ = parameters_at(theta, direction, y)
    n = y.shape[0] - (3 if int(theta[EVENT]) == _NEIMARK_SACKER else 2)
    angles, zones = np.empty(2 * n + 8), np.empty(2 * n + 8, np.int64)
    count, front = contact_arcs(y[:n], here[FRONT], here[BACK], angles, zones), 0
    for i in range(count):
        front += 1 if zones[i - 1 if i > 0 else count - 1] + zones[i] > 0 else 0
    return front, count - front


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY))
def _parameters(theta, direction, y, found):
    """The parameters at (x, p)."""
    found[:] = parameters_at(theta, direction, y)[0]


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))
def _balance(theta, direction, y, residual, jacobian):
    """Rows of the module: (n + 1,) and (n + 1, n + 2), one more of each for Neimark-Sackers."""
    total, kind, truncated = y.shape[0], int(theta[EVENT]), theta[TRUNCATED] != 0.0
    n = total - (3 if kind == _NEIMARK_SACKER else 2)
    if theta[FRONT_CONTACT] != ANY:
        front, back = _switches(theta, direction, y)
        if front != theta[FRONT_CONTACT] or back != theta[BACK_CONTACT]:
            residual[:] = math.nan
            jacobian[:] = math.nan
            return
    here, along_x, along_p = parameters_at(theta, direction, y)
    motion, part = np.zeros(n + 1), np.empty((n, n + 1))
    motion[:n] = y[:n]
    jacobian[:] = 0.0
    for column in range(total - 2, total):
        along = along_x if column == total - 2 else along_p
        if truncated:
            start = PAIRS + 2 * int(here[STIFFNESSES])
            _balance_1(here[start : start + SIZE], along[start : start + SIZE], motion, residual[:n], part)
        else:
            _balance_h(here, along, motion, residual[:n], part)
        jacobian[:n, column] = part[:, n]
    jacobian[:n, :n] = part[:, :n]
    if kind in (_FOLD, _DOUBLING, _NEIMARK_SACKER):
        window, share = int(theta[WINDOW]), 0.0 if kind == _FOLD else 0.5
        distance, sense = 1.0, 1.0 if window == WHOLE else -1.0
        if kind == _NEIMARK_SACKER:
            distance = max(y[n] if window == WHOLE else 0.5 - y[n], _CENTRE)
            share = distance if window == WHOLE else 0.5 - distance
        slopes = np.empty(n + 3, np.complex128)
        value = determinant_slopes(here, along_x, along_p, y[:n], share, window, truncated, slopes)
        residual[n] = value.real
        for j in range(n):
            jacobian[n, j] = slopes[j].real
        jacobian[n, total - 2], jacobian[n, total - 1] = slopes[n + 1].real, slopes[n + 2].real
        if kind == _NEIMARK_SACKER:
            residual[n + 1] = value.imag / distance
            for j in range(n):
                jacobian[n + 1, j] = slopes[j].imag / distance
            jacobian[n, n] = slopes[n].real
            jacobian[n + 1, n] = (slopes[n].imag - sense * value.imag / distance) / distance
            jacobian[n + 1, total - 2], jacobian[n + 1, total - 1] = (
                slopes[n + 1].imag / distance,
                slopes[n + 2].imag / distance,
            )
        return
    values, gradient = np.empty(5), np.empty((5, n + 1))
    for column in range(total - 2, total):
        _monitor_h(here, along_x if column == total - 2 else along_p, motion, values, gradient)
        jacobian[n, column] = gradient[kind - 1, n]
    residual[n] = values[kind - 1]
    jacobian[n, :n] = gradient[kind - 1, :n]


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))
def _monitor(theta, direction, y, values, gradient):
    """Size of the oscillation, and the determinant at the exponent 0 if there is room (its gradient is left at 0)."""
    total = y.shape[0]
    n = total - (3 if int(theta[EVENT]) == _NEIMARK_SACKER else 2)
    gradient[:] = 0.0
    size = 0.0
    for j in range(1, n):
        size += y[j] * y[j]
    size = math.sqrt(size)
    values[0] = size
    for j in range(1, n):
        gradient[0, j] = y[j] / size if size > 0.0 else 0.0
    if values.shape[0] > 1:
        here, along_x, along_p = parameters_at(theta, direction, y)
        slopes = np.empty(n + 3, np.complex128)
        values[1] = determinant_slopes(here, along_x, along_p, y[:n], 0.0, WHOLE, theta[TRUNCATED] != 0.0, slopes).real


@dataclass(frozen=True)
class HarmonicProblem:
    """Boundaries of a balance of any order; see `solver.boundaries.problem.BoundaryProblem`.

    Parameters
    ----------
    plane : Plane
    balance : DescribingFunction or Galerkin
        Folds and grazings of the describing function are those of `solver.boundaries.first_order`.

    Raises
    ------
    ParameterError
        If the path of the plane uses its x axis, or is not smooth between its knots.
    """

    plane: Plane
    balance: Balance

    def __post_init__(self):
        plane, balance = self.plane, self.balance
        theta, direction = plane_theta(
            plane, lambda axis, p: packed(plane.system_at(p), axis, plane.omega or 0.0, balance.order, balance.period)
        )
        theta[TRUNCATED] = balance.truncated
        scale = np.array([*[plane.motion_size] * balance.unknowns, *plane.scale])
        for name, value in (("theta", theta), ("direction", direction), ("scale", scale)):
            value.setflags(write=False)
            object.__setattr__(self, f"_{name}", value)

    @property
    def kinds(self) -> tuple[Event, ...]:
        """The boundaries that can be followed."""
        return BIFURCATIONS if self.balance.truncated else (*FOLDS_AND_GRAZINGS, *BIFURCATIONS)

    @property
    def unknowns(self) -> int:
        """Number n of unknowns u of a motion."""
        return self.balance.unknowns

    def components(self, kind: Event) -> tuple[int, ...]:
        """Where (u, x, p) stand among the unknowns y of a kind."""
        n, gap = self.unknowns, int(kind is Event.NEIMARK_SACKER)
        return *range(n), n + gap, n + gap + 1

    def shown(self, kind: Event) -> tuple[int, ...]:
        """Which components of y a boundary shows: mean, fundamental, x and p."""
        return 0, *self.balance.fundamental, *self.components(kind)[-2:]

    def parameters(self, point: np.ndarray) -> np.ndarray:
        """The packed parameters at a point (u, x, p)."""
        found = np.empty(self._direction.size)
        _parameters(self._theta.copy(), self._direction.copy(), np.array(point, dtype=float), found)
        return found

    def starts(self, kind: Event, point: np.ndarray) -> Iterable[tuple[Contact, np.ndarray]]:
        """The y that a point (u, x, p) may stand for: several for a Neimark-Sacker."""
        if kind is not Event.NEIMARK_SACKER:
            yield (HALF if kind is Event.PERIOD_DOUBLING else WHOLE, ANY, ANY), point.copy()
            return
        theta, found = self.parameters(point), np.empty(64)
        motion = np.append(point[:-2], 0.0)
        for tolerance in (1e-8, 1e-5):
            count = critical_shares(theta, np.zeros_like(theta), motion, self.balance.truncated, tolerance, found)
            if count:
                break
        shares = np.sort(found[:count])
        for share in shares[np.diff(shares, prepend=-1.0) > 1e-6]:
            windows = [WHOLE, HALF] if abs(share - 0.25) < 1e-9 else [WHOLE if share < 0.25 else HALF]
            for window in windows:
                yield (window, ANY, ANY), np.insert(point, -2, share)

    def problem(self, kind: Event, contact: Contact) -> Problem:
        """The curve of one kind, exponents sought in one window."""
        return self.confined(kind, (contact[0], ANY, ANY))

    def confined(self, kind: Event, contact: Contact) -> Problem:
        """The curve of one kind, confined to motions of so many switches of contact."""
        theta = self._theta.copy()
        theta[EVENT], theta[[WINDOW, FRONT_CONTACT, BACK_CONTACT]] = kind, contact
        scale = self._scale.copy()
        if kind is Event.NEIMARK_SACKER:
            scale = np.insert(scale, self.unknowns, 0.5)
        return Problem(_balance, _monitor, theta, self._direction.copy(), scale, monitors=2 if kind in GRAZINGS else 1)

    def box(self, kind: Event, contact: Contact) -> tuple[np.ndarray, np.ndarray]:
        """Low and high border of y in one window: the plane, and for Neimark-Sackers the window."""
        size = len(self._scale) + (kind is Event.NEIMARK_SACKER)
        low, high = np.full(size, -np.inf), np.full(size, np.inf)
        (low[-2], high[-2]), (low[-1], high[-1]) = self.plane.x_range, self.plane.p_range
        if kind is Event.NEIMARK_SACKER:
            low[-3], high[-3] = (0.0, 0.25) if contact[0] == WHOLE else (0.25, 0.5)
        return low, high

    def contact_at(self, kind: Event, contact: Contact, y: np.ndarray) -> Contact:
        """How often the motion at y switches contact; ANY for a grazing, along which that changes nothing."""
        if kind in GRAZINGS:
            return contact
        problem = self.problem(kind, contact)
        return contact[0], *_switches(problem.theta, problem.direction, y)

    def onward(self, kind: Event, stretch: Stretch) -> Iterable[Guess]:
        """Somewhere close to a corner, along the tangent of arrival: there lies a motion with other switches of
        contact, whose curve, followed back, stops at the same corner."""
        curve, (window, *_) = stretch.curve, stretch.contact
        y, tangent, scale = curve.points[-1], curve.tangents[-1], stretch.problem.scale
        if curve.ends[1] is EndReason.STEP_TOO_SMALL and kind not in GRAZINGS:
            for length in _HOPS:
                for sense in (1.0, -1.0):
                    yield Guess((window, ANY, ANY), y + sense * length * tangent * scale, tangent, length)
        elif kind is Event.NEIMARK_SACKER and curve.ends[1] is EndReason.RANGE_LEFT and y[-3] == 0.25:
            yield Guess((1 - window, ANY, ANY), y, np.eye(y.size)[-3] * (1.0 if window == WHOLE else -1.0), 0.3)

    def static_determinant(self, kind: Event, problem: Problem, y: np.ndarray) -> float:
        """The scaled determinant at the exponent 0: its sign is the motion's static stability."""
        values = np.empty(2)
        problem.monitor(problem.theta, problem.direction, y, values, np.empty((2, y.size)))
        return float(self._theta[HEADER + SIGN] * values[1])

    def fold_rows(self, problem: Problem, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """dE/du (n, n), dE/dp (n,) and the derivatives of det dE/du by u (n,)."""
        n = self.unknowns
        jacobian = np.empty((n + 1, n + 2))
        problem.balance(problem.theta, problem.direction, y, np.empty(n + 1), jacobian)
        return jacobian[:n, :n], jacobian[:n, -1], self._theta[HEADER + SIGN] * jacobian[n, :n]
