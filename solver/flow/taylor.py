"""Taylor series of a motion within one contact zone.

Between two contact switches the equation of `solver.flow.switched_system` is linear with entire (trigonometric)
coefficients, so that the series of its solutions converge everywhere and follow from a recurrence that costs less than
the stages of a Runge-Kutta step of order 8. With Taylor coefficients written with an index,

    (j + 2)(j + 1) y_{j+2} = -(j + 1) D y_{j+1} - S y_j - q sum_i s_i lambda_{j-i} + g_j

with g for the motion and without it for deviations. A cubic spring adds the product of three series, or for deviations
that of 3 k_3 lambda^2 with theirs; convergence then ends somewhere, which the steps feel. The polynomial is as accurate
within the step as at its end: switches, extremes and integrals are taken from it and no step is ever repeated. Steps
are chosen from the last two coefficients (A. Jorba, M. Zou, "A software package for the numerical integration of ODEs
by means of high-order Taylor methods", Experimental Mathematics 14 (2005) 99-117, section 3.2).

Here is the motion; `solver.flow.deviations` carries those of a monodromy matrix. Many motions of one system are carried
by `solver.flow.zone_flows` instead.
"""

import math
from typing import NamedTuple

import numpy as np

from solver.flow.switched_system import CUBIC, FREQUENCY, HIGH, LOW, STRENGTH, SWITCHED_SYSTEM, strength_of
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel

__all__ = [
    "MOTION_ORDER",
    "SERIES",
    "Series",
    "column_at",
    "column_sizes",
    "fill_sources",
    "motion_series",
    "new_series",
    "reach",
]

_F, _I, _B = types.float64, types.int64, types.boolean

#: Degree of the series of y. At a tolerance of 1e-12 a step covers about a third of a natural period, which contact
#: switches do not cut much shorter.
MOTION_ORDER = 20


class Series(NamedTuple):
    """The series of a motion, of order m: y (m + 1, n), lambda (m + 1,), s (m + 1,) and g (m + 1, n)."""

    y: np.ndarray
    contact: np.ndarray
    stiffness: np.ndarray
    g: np.ndarray


SERIES = types.NamedTuple((MATRIX, ARRAY, ARRAY, MATRIX), Series)


@kernel(SERIES(_I), inner=True)
def new_series(degrees):
    """Room for the series of a motion of n coordinates."""
    size = MOTION_ORDER + 1
    return Series(np.empty((size, degrees)), np.empty(size), np.empty(size), np.empty((size, degrees)))


@kernel(types.void(SWITCHED_SYSTEM, _I, _F, ARRAY, MATRIX), inner=True)
def fill_sources(system, zone, time, stiffness, g):
    """Series of s and, where it has rows, of g about a time."""
    n, omega, forced = system.vectors.shape[1], system.numbers[FREQUENCY], g.shape[0] > 0
    # The order is read from the arrays: loops of known length are unrolled into code that takes a minute to compile.
    order = stiffness.shape[0] - 1
    harmonics, loads = system.variation.shape[0], system.load.shape[0] // 2 if forced else 0
    for j in range(order - 1):
        stiffness[j] = 0.0
        if forced:
            for i in range(n):
                g[j, i] = system.load[0, i] if j == 0 else 0.0
    for l in range(1, max(harmonics + 1, loads)):
        rate = l * omega
        # cosine and sine carry the factor (l Omega)^j / j! and turn by a quarter per order.
        cosine, sine = math.cos(rate * time), math.sin(rate * time)
        for j in range(order - 1):
            if l <= harmonics:
                stiffness[j] += system.variation[l - 1, 0] * cosine - system.variation[l - 1, 1] * sine
            if l < loads:
                for i in range(n):
                    g[j, i] += system.load[2 * l, i] * cosine - system.load[2 * l + 1, i] * sine
            factor = rate / (j + 1)
            cosine, sine = -sine * factor, cosine * factor
    if forced and zone != 0:
        offset = system.numbers[HIGH] if zone > 0 else system.numbers[STRENGTH] * system.numbers[LOW]
        for i in range(n):
            g[0, i] += system.vectors[1, i] * offset
            if harmonics > 0:
                for j in range(order - 1):
                    g[j, i] += system.vectors[2, i] * offset * stiffness[j]


@kernel(types.void(SWITCHED_SYSTEM, _I, _F, ARRAY, SERIES), inner=True)
def motion_series(system, zone, time, state, series):
    """Series of s and of the motion from a state at a time, the law of the zone extended beyond it.

    Parameters
    ----------
    system : SwitchedSystem
    zone : int
        -1 back, 0 free, 1 front.
    time : float
    state : (2 n,) array
        y, then y'.
    series : Series
        Overwritten.
    """
    fill_sources(system, zone, time, series.stiffness, series.g)
    n, order = system.vectors.shape[1], series.stiffness.shape[0] - 1
    y, contact, stiffness = series.y, series.contact, series.stiffness
    first, strength = n * (zone % 3), strength_of(system, zone)
    second, varied = first + 3 * n, zone != 0 and system.variation.shape[0] > 0
    contact[0], contact[1], cubic = 0.0, 0.0, system.numbers[CUBIC]
    square = np.empty(order if cubic != 0.0 else 0)
    for i in range(n):
        y[0, i], y[1, i] = state[i], state[n + i]
        contact[0] += system.vectors[0, i] * state[i]
        contact[1] += system.vectors[0, i] * state[n + i]
    for j in range(order - 1):
        product = 0.0
        if varied:
            for i in range(j + 1):
                product += stiffness[i] * contact[j - i]
            product *= strength
        cube = 0.0
        if cubic != 0.0:
            square[j] = 0.0
            for i in range(j + 1):
                square[j] += contact[i] * contact[j - i]
            for i in range(j + 1):
                cube += cubic * square[i] * contact[j - i]
        scale = 1.0 / ((j + 2.0) * (j + 1.0))
        total = 0.0
        for i in range(n):
            value, rate = series.g[j, i], 0.0
            for l in range(n):
                value -= system.matrices[first + i, l] * y[j, l]
                rate += system.matrices[second + i, l] * y[j + 1, l]
            value -= (j + 1.0) * rate
            if varied:
                value -= system.vectors[2, i] * product
            if cubic != 0.0:
                value -= system.vectors[1, i] * cube
            value *= scale
            y[j + 2, i] = value
            total += system.vectors[0, i] * value
        contact[j + 2] = total


@kernel(_F(_F, _F, _F, _I), inline=True)
def reach(bound, last, previous, order):
    """Largest step h with k |y_k| h^(k - 1), a term of y', at most the bound for the last two coefficients of y.

    Infinite where the series ends; nan where it is not finite.
    """
    # With nothing in the series the solution is a short polynomial and any step is exact.
    step = math.inf
    if last > 0.0:
        step = (bound / (order * last)) ** (1.0 / (order - 1))
    if previous > 0.0 and not (order - 1) * previous * step ** (order - 2) <= bound:
        step = (bound / ((order - 1) * previous)) ** (1.0 / (order - 2))
    return step


@kernel(types.UniTuple(_F, 3)(ARRAY, SERIES), inner=True)
def column_sizes(state, series):
    """Largest components of the state and of the last two coefficients of y, for `reach`."""
    n, order = series.y.shape[1], series.y.shape[0] - 1
    size, last, previous = 0.0, 0.0, 0.0
    for i in range(n):
        size = max(size, abs(state[i]), abs(state[n + i]))
        last = max(last, abs(series.y[order, i]))
        previous = max(previous, abs(series.y[order - 1, i]))
    return size, last, previous


@kernel(types.void(SERIES, _F, ARRAY), inner=True)
def column_at(series, step, state):
    """Fill in the state (2 n,) at the end of a step."""
    n, order = series.y.shape[1], series.y.shape[0] - 1
    for i in range(n):
        value, slope = series.y[order, i], 0.0
        for j in range(order - 1, -1, -1):
            slope = slope * step + value
            value = value * step + series.y[j, i]
        state[i], state[n + i] = value, slope
