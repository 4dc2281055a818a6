"""Bifurcations of a balance over a plane of two parameters, as the curve problems that continuation follows.

The unknowns are y = (u, x, p) with the motion u and the axes x and p; for Neimark-Sackers (u, omega nu/Omega, x, p)
with the second frequency. Rows are the balance, then what makes the motion special: the scaled determinant of Hill's
matrix at the exponent 0 (fold), at half the base frequency (period doubling), at i omega (Neimark-Sacker: real and
imaginary part), or the distance of an extreme of lambda from a flank (grazing).

Kernels see theta = (parameters with both axes at 0 | what x adds | how p bends them, `solver.model.parameter_path` |
their number | the event | the window | whether the force is truncated before the stiffness multiplies it | switches of
contact, or ANY), and direction, what p adds along a straight line. The parameters are those of
`solver.harmonic.layout.packed`.

A determinant has an infinite gradient where the motion grazes a flank, and its curve a corner. A problem may be
confined to motions that switch contact a given number of times: beyond, its equations are not numbers, and continuation
stops at the corner.
"""

import math
from dataclasses import dataclass

import numpy as np

from solver.contact.spectrum import contact_arcs
from solver.continuation.continuation import Event, Problem
from solver.continuation.problem import Balance
from solver.harmonic import describing_function, galerkin
from solver.harmonic.layout import BACK, FRONT, PAIRS, SIGN, STIFFNESSES, packed
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.model.checks import ParameterError
from solver.model.condensation import SIZE
from solver.model.contact_system import ContactSystem
from solver.model.gear_model import Model
from solver.model.parameter_path import ParameterPath, add_path, place_on, plane_vectors
from solver.stability.hill_determinant import HALF, WHOLE
from solver.stability.hill_slopes import determinant_slopes

__all__ = ["ANY", "WINDOW", "BifurcationPlane"]

_FOLD, _DOUBLING, _NEIMARK_SACKER = int(Event.FOLD), int(Event.PERIOD_DOUBLING), int(Event.NEIMARK_SACKER)
_GRAZINGS = (Event.MIN_AT_DRIVE, Event.MIN_AT_BACK, Event.MAX_AT_DRIVE, Event.MAX_AT_BACK)
_BIFURCATIONS = (Event.PERIOD_DOUBLING, Event.NEIMARK_SACKER)

#: Slots of the packed theta from its end.
NUMBER, KIND, WINDOW, TRUNCATED, SWITCHES = range(-5, 0)
ANY = -1
# Switches at the back flank count so many of those at the front one.
_BACK = 1000

# The imaginary part of the determinant is odd about the centre of a window. Divided by the distance from it, which is
# taken to be at least this, it leaves a regular equation.
_CENTRE = 1e-4

_balance_1, _balance_h, _monitor_h = describing_function.balance, galerkin.balance, galerkin.monitor


@kernel(types.UniTuple(ARRAY, 3)(ARRAY, ARRAY, ARRAY), inline=True)
def _at(theta, direction, y):
    """The parameters at (x, p), and what either axis adds to them."""
    size, last = int(theta[NUMBER]), y.shape[0] - 1
    along_x, along_p = theta[size : 2 * size], direction[:size].copy()
    here = theta[:size] + y[last - 1] * along_x + y[last] * along_p
    add_path(theta, 2 * size, y[last], here, along_p)
    return here, along_x, along_p


@kernel(types.int64(ARRAY, ARRAY, ARRAY))
def _switches(theta, direction, y):
    """How often the motion at y switches contact over its period, both flanks told apart."""
    here, _, _ = _at(theta, direction, y)
    n = y.shape[0] - (3 if int(theta[KIND]) == _NEIMARK_SACKER else 2)
    angles, zones = np.empty(2 * n + 8), np.empty(2 * n + 8, np.int64)
    count, total = contact_arcs(y[:n], here[FRONT], here[BACK], angles, zones), 0
    for i in range(count):
        total += 1 if zones[i - 1 if i > 0 else count - 1] + zones[i] > 0 else _BACK
    return total


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY))
def _parameters(theta, direction, y, found):
    """The parameters at (x, p)."""
    found[:] = _at(theta, direction, y)[0]


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))
def _balance(theta, direction, y, residual, jacobian):
    """Rows of the module: (n + 1,) and (n + 1, n + 2), one more of each for Neimark-Sackers."""
    total, kind, truncated = y.shape[0], int(theta[KIND]), theta[TRUNCATED] != 0.0
    n = total - (3 if kind == _NEIMARK_SACKER else 2)
    if theta[SWITCHES] != ANY and _switches(theta, direction, y) != int(theta[SWITCHES]):
        residual[:] = math.nan
        jacobian[:] = math.nan
        return
    here, along_x, along_p = _at(theta, direction, y)
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
    n = total - (3 if int(theta[KIND]) == _NEIMARK_SACKER else 2)
    gradient[:] = 0.0
    size = 0.0
    for j in range(1, n):
        size += y[j] * y[j]
    size = math.sqrt(size)
    values[0] = size
    for j in range(1, n):
        gradient[0, j] = y[j] / size if size > 0.0 else 0.0
    if values.shape[0] > 1:
        here, along_x, along_p = _at(theta, direction, y)
        slopes = np.empty(n + 3, np.complex128)
        values[1] = determinant_slopes(here, along_x, along_p, y[:n], 0.0, WHOLE, theta[TRUNCATED] != 0.0, slopes).real


@dataclass(frozen=True)
class BifurcationPlane:
    """Where the bifurcations of a balance are sought.

    Parameters
    ----------
    balance : DescribingFunction or Galerkin
        The describing function's folds and grazings are those of `solver.boundaries.plane.Plane`.
    system : Model or ContactSystem
        Its own values of the two axes are not used; a path starts from it.
    x_axis : str
        A name that `solver.harmonic.layout.packed` knows.
    p_axis : str or ParameterPath
        Another one, or a path of models.
    x_range, p_range : (low, high)
    omega : float, optional
        The mesh frequency; needed unless it is an axis.

    Raises
    ------
    ParameterError
        If the axes are equal, unknown or at odds, a range is empty, or the frequency is missing.
    """

    balance: Balance
    system: Model | ContactSystem
    x_axis: str
    p_axis: str | ParameterPath
    x_range: tuple[float, float]
    p_range: tuple[float, float]
    omega: float | None = None

    def __post_init__(self):
        if self.x_axis == self.p_axis:
            raise ParameterError("p_axis", self.p_axis, "another parameter than x_axis")
        for name in ("x_range", "p_range"):
            low, high = (float(v) for v in getattr(self, name))
            if not -np.inf < low < high < np.inf:
                raise ParameterError(name, (low, high), "two finite ascending numbers")
            object.__setattr__(self, name, (low, high))
        if "omega" not in (self.x_axis, self.p_axis) and (self.omega is None or not 0.0 < self.omega < np.inf):
            raise ParameterError("omega", self.omega, "a finite number above 0, as no axis is the frequency")

        def system_at(p):
            if not isinstance(self.system, Model):
                return self.system
            return place_on(self.p_axis, p, place_on(self.x_axis, 0.5 * sum(self.x_range), self.system)[0])[0]

        def vectors(axis, p):
            return packed(system_at(p), axis, self.omega or 0.0, self.balance.order, self.balance.period)

        read = plane_vectors(vectors, self.x_axis, self.p_axis, self.p_range)
        truncated = float(self.balance.truncated)
        n, size = self.balance.unknowns, system_at(0.5 * sum(self.p_range)).motion_size
        ranges = [0.1 * (high - low) for low, high in (self.x_range, self.p_range)]
        for name, value in (
            ("theta", np.concatenate([read.base, read.along_x, read.bent, [read.base.size, 0.0, 0.0, truncated, ANY]])),
            ("direction", read.along_p),
            ("scale", np.concatenate([np.full(n, size), ranges])),
        ):
            value.setflags(write=False)
            object.__setattr__(self, f"_{name}", value)

    @property
    def kinds(self) -> tuple[Event, ...]:
        """The bifurcations that can be followed."""
        return _BIFURCATIONS if self.balance.truncated else (Event.FOLD, *_GRAZINGS, *_BIFURCATIONS)

    @property
    def scale(self) -> np.ndarray:
        """Typical size of (u, x, p), (n + 2,)."""
        return self._scale

    @property
    def sign(self) -> float:
        """What makes the determinant at the exponent 0 that of the balance, up to a positive factor."""
        return float(self._theta[SIGN])

    def components(self, kind: Event) -> list[int]:
        """Where (u, x, p) stand among the unknowns y of a kind."""
        n, gap = self.balance.unknowns, int(kind is Event.NEIMARK_SACKER)
        return [*range(n), n + gap, n + gap + 1]

    def seen(self, kind: Event) -> tuple[int, ...]:
        """Which components of y a `BoundaryCurve` of a kind shows: mean, fundamental, x and p."""
        return (0, *self.balance.fundamental, *self.components(kind)[-2:])

    def parameters(self, point: np.ndarray) -> np.ndarray:
        """The packed parameters at a point (u, x, p)."""
        found = np.empty(int(self._theta[NUMBER]))
        _parameters(self._theta.copy(), self._direction.copy(), np.array(point, dtype=float), found)
        return found

    def windows(self, kind: Event, share: float) -> list[int]:
        """The windows in which a motion with this second frequency (over the base one) is sought."""
        if kind is not Event.NEIMARK_SACKER:
            return [HALF if kind is Event.PERIOD_DOUBLING else WHOLE]
        if abs(share - 0.25) < 1e-9:
            return [WHOLE, HALF]
        return [WHOLE if share < 0.25 else HALF]

    def switches(self, kind: Event, y: np.ndarray) -> int:
        """How often the motion at y switches contact, ANY for a grazing: what confines a curve between its corners."""
        problem = self.problem(kind, WHOLE)
        return ANY if kind in _GRAZINGS else int(_switches(problem.theta, problem.direction, y))

    def problem(self, kind: Event, window: int, switches: int = ANY) -> Problem:
        """The curve of one kind, exponents sought in one window, confined to motions of so many switches of contact."""
        theta = self._theta.copy()
        theta[KIND], theta[WINDOW], theta[SWITCHES] = kind, window, switches
        scale = self._scale.copy()
        if kind is Event.NEIMARK_SACKER:
            scale = np.insert(scale, self.balance.unknowns, 0.5)
        return Problem(_balance, _monitor, theta, self._direction.copy(), scale, monitors=2 if kind in _GRAZINGS else 1)

    def box(self, kind: Event, window: int) -> tuple[np.ndarray, np.ndarray]:
        """Low and high border of y in one window: the plane, and for Neimark-Sackers the window."""
        size = self.balance.unknowns + 2 + (kind is Event.NEIMARK_SACKER)
        low, high = np.full(size, -np.inf), np.full(size, np.inf)
        (low[-2], high[-2]), (low[-1], high[-1]) = self.x_range, self.p_range
        if kind is Event.NEIMARK_SACKER:
            low[-3], high[-3] = (0.0, 0.25) if window == WHOLE else (0.25, 0.5)
        return low, high

    def static_determinant(self, kind: Event, y: np.ndarray) -> float:
        """The scaled determinant at the exponent 0: its sign is the motion's static stability."""
        problem = self.problem(kind, WHOLE)
        values = np.empty(2)
        problem.monitor(problem.theta, problem.direction, y, values, np.empty((2, y.size)))
        return self.sign * float(values[1])
