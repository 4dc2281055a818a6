"""Taylor series of the motion within one contact zone.

Between two contact switches the equation is linear with entire (trigonometric) coefficients, so the series of its
solution converges everywhere and follows from a recurrence that costs less than the stages of a Runge-Kutta step of
order 8: with M^-1 multiplied through and Taylor coefficients written with an index,

    (k + 2)(k + 1) y_{k+2} = -D (k + 1) y_{k+1} - S y_k - q sum_j s_j lambda_{k-j} + g_k

where S holds the contact stiffness of the zone and g the load and the offset of the zone's law. The polynomial is as
accurate within the step as at its end: switches, extremes and integrals are taken from it and no step is ever repeated.
Steps are chosen from the last two coefficients (A. Jorba, M. Zou, "A software package for the numerical integration of
ODEs by means of high-order Taylor methods", Experimental Mathematics 14 (2005) 99-117, section 3.2).
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.model.checks import frequency, instance_of
from solver.model.contact_system import ContactSystem

__all__ = [
    "ORDER",
    "PACKED",
    "WORK",
    "Packed",
    "Work",
    "land",
    "new_work",
    "pack",
    "series",
    "step_length",
    "tangent_series",
    "tangent_step_length",
]

#: Degree of the series of y. At a tolerance of 1e-12 a step covers about a third of a natural period, which contact
#: switches do not cut much shorter.
ORDER = 20


class Packed(NamedTuple):
    """A system at one frequency as the kernels see it; n coordinates.

    `numbers`: Omega, the ends of the dead zone (low, high), a length that errors are compared with, 1 where the dead
    zone is empty so that the system is linear, and the highest rate (1 / time) at which small deviations vary.
    `matrices` (3 n, n): M^-1 K without contact, with contact, M^-1 C.
    `vectors` (3, n): w, M^-1 h, M^-1 h_v. `variation` (L, 2): alpha_l cos Phi_l, alpha_l sin Phi_l.
    `load` (2 (L + 1), n): real and imaginary parts of M^-1 F_l.
    """

    numbers: np.ndarray
    matrices: np.ndarray
    vectors: np.ndarray
    variation: np.ndarray
    load: np.ndarray


class Work(NamedTuple):
    """Room for the series of one step: y and g (ORDER + 1, n), lambda and s (ORDER + 1,)."""

    y: np.ndarray
    g: np.ndarray
    contact: np.ndarray
    stiffness: np.ndarray


PACKED = types.NamedTuple((ARRAY, MATRIX, MATRIX, MATRIX, MATRIX), Packed)
WORK = types.NamedTuple((MATRIX, MATRIX, ARRAY, ARRAY), Work)


def pack(system: ContactSystem, omega: float) -> Packed:
    """A system at one frequency as flat arrays.

    Raises
    ------
    ParameterError
        If it is no ContactSystem, or omega is not a finite number above 0.
    """
    return _packed(instance_of("system", system, ContactSystem), frequency(omega))


@lru_cache(maxsize=4)
def _packed(system: ContactSystem, omega: float) -> Packed:
    # A motion is followed in many calls; no kernel writes into these arrays.
    inverse = np.linalg.inv(system.mass)
    stiffness, damping = inverse @ system.stiffness, inverse @ system.damping
    force, varying = inverse @ system.force, inverse @ system.varying_force
    rows = max(len(system.load), len(system.inertial_load))
    harmonics = system.load_harmonics(omega, rows - 1) @ inverse.T
    load = np.empty((2 * rows, system.degrees))
    load[0::2], load[1::2] = harmonics.real, harmonics.imag
    pairs = np.array(system.stiffness_harmonics, dtype=float).reshape(-1, 2)
    variation = np.column_stack([pairs[:, 0] * np.cos(pairs[:, 1]), pairs[:, 0] * np.sin(pairs[:, 1])])
    if not np.any(varying):
        variation = np.empty((0, 2))
    low, high = -system.back_gap, system.front_gap
    length = max(abs(high), abs(low) if system.two_sided else 0.0, np.max(np.abs(load)))
    return Packed(
        np.array([omega, low, high, length, float(low == high), _rate(system, omega)]),
        np.concatenate([stiffness, stiffness + np.outer(force, system.contact), damping]),
        np.array([system.contact, force, varying]),
        np.ascontiguousarray(variation),
        load,
    )


def _rate(system: ContactSystem, omega: float) -> float:
    """Bound, in practice, of the frequencies and growth rates of small deviations in any zone."""
    varied = any(amplitude for amplitude, _ in system.stiffness_harmonics) and np.any(system.varying_force)
    return _highest_rate(system) + (len(system.stiffness_harmonics) * omega if varied else 0.0)


@lru_cache(maxsize=4)
def _highest_rate(system: ContactSystem) -> float:
    """The part that does not depend on the frequency of the load."""
    n, highest, inverse = system.degrees, 0.0, np.linalg.inv(system.mass)
    strength = sum(abs(amplitude) for amplitude, _ in system.stiffness_harmonics)
    for force in (0.0 * system.force, system.force, system.force + strength * system.varying_force):
        lower = np.hstack([-inverse @ (system.stiffness + np.outer(force, system.contact)), -inverse @ system.damping])
        companion = np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), lower])
        highest = max(highest, float(np.max(np.abs(np.linalg.eigvals(companion)))))
    return highest


@kernel(WORK(types.int64), inner=True)
def new_work(n):
    """Room for the series of n coordinates."""
    return Work(np.empty((ORDER + 1, n)), np.empty((ORDER + 1, n)), np.empty(ORDER + 1), np.empty(ORDER + 1))


@kernel(types.void(PACKED, types.int64, types.float64, WORK), inner=True)
def _sources(packed, zone, time, work):
    """Series of s and of g about a time."""
    n = packed.vectors.shape[1]
    omega, low, high = packed.numbers[0], packed.numbers[1], packed.numbers[2]
    g, stiffness = work.g, work.stiffness
    # The order is read from the arrays: loops of known length are unrolled into code that takes a minute to compile.
    order = stiffness.shape[0] - 1
    for k in range(order - 1):
        stiffness[k] = 0.0
        for i in range(n):
            g[k, i] = 0.0
    for i in range(n):
        g[0, i] = packed.load[0, i]
    harmonics, loads = packed.variation.shape[0], packed.load.shape[0] // 2
    for l in range(1, max(harmonics + 1, loads)):
        rate = l * omega
        # cosine and sine carry the factor (l Omega)^k / k! and turn by a quarter per order.
        cosine, sine = math.cos(rate * time), math.sin(rate * time)
        for k in range(order - 1):
            if l <= harmonics:
                stiffness[k] += packed.variation[l - 1, 0] * cosine - packed.variation[l - 1, 1] * sine
            if l < loads:
                for i in range(n):
                    g[k, i] += packed.load[2 * l, i] * cosine - packed.load[2 * l + 1, i] * sine
            factor = rate / (k + 1)
            cosine, sine = -sine * factor, cosine * factor
    if zone != 0:
        offset = high if zone > 0 else low
        for i in range(n):
            g[0, i] += packed.vectors[1, i] * offset
            if harmonics > 0:
                for k in range(order - 1):
                    g[k, i] += packed.vectors[2, i] * offset * stiffness[k]


@kernel(types.void(PACKED, types.int64, types.boolean, ARRAY, WORK), inner=True)
def _recurrence(packed, zone, forced, state, work):
    """Series of y and lambda from the state, with g or without it."""
    n = packed.vectors.shape[1]
    y, contact, stiffness = work.y, work.contact, work.stiffness
    first, second = (n if zone != 0 else 0), 2 * n
    varied = zone != 0 and packed.variation.shape[0] > 0
    contact[0], contact[1] = 0.0, 0.0
    for i in range(n):
        y[0, i], y[1, i] = state[i], state[n + i]
        contact[0] += packed.vectors[0, i] * state[i]
        contact[1] += packed.vectors[0, i] * state[n + i]
    for k in range(contact.shape[0] - 2):
        product = 0.0
        if varied:
            for j in range(k + 1):
                product += stiffness[j] * contact[k - j]
        scale = 1.0 / ((k + 2.0) * (k + 1.0))
        total = 0.0
        for i in range(n):
            value = work.g[k, i] if forced else 0.0
            rate = 0.0
            for j in range(n):
                value -= packed.matrices[first + i, j] * y[k, j]
                rate += packed.matrices[second + i, j] * y[k + 1, j]
            value -= (k + 1.0) * rate
            if varied:
                value -= packed.vectors[2, i] * product
            value *= scale
            y[k + 2, i] = value
            total += packed.vectors[0, i] * value
        contact[k + 2] = total


@kernel(types.void(PACKED, types.int64, types.float64, ARRAY, WORK), inner=True)
def series(packed, zone, time, state, work):
    """Series of the motion from a state at a time, the law of the zone (-1 back, 0 free, 1 front) extended beyond it.

    Parameters
    ----------
    packed : Packed
    zone : int
    time : float
    state : (2 n,) array
        y, then y'.
    work : Work
        Overwritten.
    """
    _sources(packed, zone, time, work)
    _recurrence(packed, zone, True, state, work)


@kernel(types.void(PACKED, types.int64, ARRAY, WORK), inner=True)
def tangent_series(packed, zone, state, work):
    """Series of a small deviation; `work` must hold the series of the motion, whose s is used and whose y is lost."""
    _recurrence(packed, zone, False, state, work)


@kernel(types.float64(PACKED, ARRAY, types.float64, WORK), inner=True)
def step_length(packed, state, tolerance, work):
    """Step at which the last two terms of y' fall to tolerance times max(|state|, length of the system)."""
    n = packed.vectors.shape[1]
    scale, last, previous = packed.numbers[3], 0.0, 0.0
    for i in range(2 * n):
        scale = max(scale, abs(state[i]))
    for i in range(n):
        last = max(last, abs(work.y[ORDER, i]))
        previous = max(previous, abs(work.y[ORDER - 1, i]))
    bound = tolerance * scale
    # With nothing in the series the motion is a short polynomial and any step is exact.
    step = math.inf if last == 0.0 else (bound / (ORDER * last)) ** (1.0 / (ORDER - 1))
    if previous > 0.0:
        step = min(step, (bound / ((ORDER - 1) * previous)) ** (1.0 / (ORDER - 2)))
    return step


@kernel(types.float64(PACKED, types.float64), inner=True)
def tangent_step_length(packed, tolerance):
    """Step at which the last term of the series of any small deviation has fallen to the tolerance.

    The motion may be at rest, or nearly, where its deviations are not: its own series says nothing about theirs.
    """
    return (tolerance * math.gamma(ORDER + 1.0)) ** (1.0 / ORDER) / packed.numbers[5]


@kernel(types.void(WORK, types.float64, ARRAY), inner=True)
def land(work, step, state):
    """The state (2 n,) at the end of a step."""
    n = work.y.shape[1]
    for i in range(n):
        value, slope = work.y[-1, i], 0.0
        for k in range(work.y.shape[0] - 2, -1, -1):
            slope = slope * step + value
            value = value * step + work.y[k, i]
        state[i], state[n + i] = value, slope
