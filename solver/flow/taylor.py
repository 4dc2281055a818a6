"""Taylor series of a motion and of small deviations from it within one contact zone.

Between two contact switches the equation of `solver.flow.switched_system` is linear with entire (trigonometric)
coefficients, so that the series of its solutions converge everywhere and follow from a recurrence that costs less than
the stages of a Runge-Kutta step of order 8. With Taylor coefficients written with an index,

    (j + 2)(j + 1) y_{j+2} = -(j + 1) D y_{j+1} - S y_j - q sum_i s_i lambda_{j-i} + g_j

with g for the motion and without it for deviations. The polynomial is as accurate within the step as at its end:
switches, extremes and integrals are taken from it and no step is ever repeated. Steps are chosen from the last two
coefficients (A. Jorba, M. Zou, "A software package for the numerical integration of ODEs by means of high-order Taylor
methods", Experimental Mathematics 14 (2005) 99-117, section 3.2).

States stand in blocks of four columns, which run through the recurrence side by side: the contact term is a product of
scalar series, one for each column, and four of them take little longer than one. A motion, where there is one, is the
first column of the first block; unused columns are 0.
"""

import math
from typing import NamedTuple

import numpy as np

from solver.flow.switched_system import FREQUENCY, HIGH, LENGTH, LOW, SWITCHED_SYSTEM
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel

__all__ = [
    "BLOCKS",
    "ORDER",
    "SERIES",
    "Series",
    "carry_deviations",
    "count_blocks",
    "new_series",
    "set_identity",
    "series_at",
    "state_at",
    "step_length",
]

_F, _I, _B = types.float64, types.int64, types.boolean

#: States in blocks of four columns, (blocks, 2 n, 4): y above y'.
BLOCKS = types.float64[:, :, ::1]

#: Degree of the series of y. The number of steps falls with it as the work of one grows: measured at tolerances from
#: 1e-13 to 1e-10, monodromy matrices cost least between 24 and 32.
ORDER = 28

# Truncation error of deviations in a step, as a share of their largest component: some 1e-11 in a matrix over a period.
_TOLERANCE = 1e-10

# Steps of one passage through a zone, each about four radians of the fastest mode: what needs more is left undecided.
_MOST_STEPS = 5_000


class Series(NamedTuple):
    """The series of one step: y (blocks, ORDER + 1, n, 4), lambda (blocks, ORDER + 1, 4), and of the motion lambda once
    more (ORDER + 1,); s (ORDER + 1,) and g (ORDER + 1, n)."""

    y: np.ndarray
    contact: np.ndarray
    motion: np.ndarray
    stiffness: np.ndarray
    g: np.ndarray


SERIES = types.NamedTuple((types.float64[:, :, :, ::1], BLOCKS, ARRAY, ARRAY, MATRIX), Series)


@kernel(_I(_I), inline=True)
def count_blocks(columns):
    """Blocks that so many columns take."""
    return (columns + 3) // 4


@kernel(SERIES(_I, _I), inner=True)
def new_series(degrees, columns):
    """Room for the series of so many columns of n coordinates."""
    blocks = count_blocks(columns)
    return Series(
        np.zeros((blocks, ORDER + 1, degrees, 4)),
        np.empty((blocks, ORDER + 1, 4)),
        np.empty(ORDER + 1),
        np.empty(ORDER + 1),
        np.empty((ORDER + 1, degrees)),
    )


@kernel(types.void(SWITCHED_SYSTEM, _I, _F, _B, SERIES), inner=True)
def _sources(system, zone, time, forced, series):
    """Series of s and, where there is a motion, of g about a time."""
    n, omega = system.vectors.shape[1], system.numbers[FREQUENCY]
    g, stiffness = series.g, series.stiffness
    # The order is read from the arrays: loops of known length are unrolled into code that takes a minute to compile.
    order = stiffness.shape[0] - 1
    harmonics, loads = system.variation.shape[0], system.load.shape[0] // 2 if forced else 0
    for j in range(order - 1):
        stiffness[j] = 0.0
        if forced:
            for i in range(n):
                g[j, i] = 0.0
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
    if not forced:
        return
    for i in range(n):
        g[0, i] += system.load[0, i]
    if zone != 0:
        offset = system.numbers[HIGH] if zone > 0 else system.numbers[LOW]
        for i in range(n):
            g[0, i] += system.vectors[1, i] * offset
            for j in range(order - 1):
                g[j, i] += system.vectors[2, i] * offset * stiffness[j]


@kernel(types.void(SWITCHED_SYSTEM, _I, _B, types.float64[:, :, ::1], MATRIX, ARRAY, MATRIX), inner=True)
def _recurrence(system, zone, forced, y, contact, stiffness, g):
    """Fill in the series of one block, y (ORDER + 1, n, 4) and contact (ORDER + 1, 4), from y_0 and y_1."""
    n, order = system.vectors.shape[1], stiffness.shape[0] - 1
    matrices, vectors = system.matrices, system.vectors
    first, second = (n if zone != 0 else 0), 2 * n
    varied = zone != 0 and system.variation.shape[0] > 0
    for j in range(2):
        t0, t1, t2, t3 = 0.0, 0.0, 0.0, 0.0
        for i in range(n):
            w = vectors[0, i]
            t0 += w * y[j, i, 0]
            t1 += w * y[j, i, 1]
            t2 += w * y[j, i, 2]
            t3 += w * y[j, i, 3]
        contact[j, 0], contact[j, 1], contact[j, 2], contact[j, 3] = t0, t1, t2, t3
    for j in range(order - 1):
        p0, p1, p2, p3 = 0.0, 0.0, 0.0, 0.0
        if varied:
            for i in range(j + 1):
                s = stiffness[j - i]
                p0 += s * contact[i, 0]
                p1 += s * contact[i, 1]
                p2 += s * contact[i, 2]
                p3 += s * contact[i, 3]
        grade = j + 1.0
        scale = -1.0 / ((j + 2.0) * grade)
        t0, t1, t2, t3 = 0.0, 0.0, 0.0, 0.0
        for i in range(n):
            q = vectors[2, i]
            v0, v1, v2, v3 = q * p0, q * p1, q * p2, q * p3
            for l in range(n):
                spring, drag = matrices[first + i, l], grade * matrices[second + i, l]
                v0 += spring * y[j, l, 0] + drag * y[j + 1, l, 0]
                v1 += spring * y[j, l, 1] + drag * y[j + 1, l, 1]
                v2 += spring * y[j, l, 2] + drag * y[j + 1, l, 2]
                v3 += spring * y[j, l, 3] + drag * y[j + 1, l, 3]
            v0, v1, v2, v3 = scale * v0, scale * v1, scale * v2, scale * v3
            if forced:
                v0 -= scale * g[j, i]
            y[j + 2, i, 0], y[j + 2, i, 1], y[j + 2, i, 2], y[j + 2, i, 3] = v0, v1, v2, v3
            w = vectors[0, i]
            t0 += w * v0
            t1 += w * v1
            t2 += w * v2
            t3 += w * v3
        contact[j + 2, 0], contact[j + 2, 1], contact[j + 2, 2], contact[j + 2, 3] = t0, t1, t2, t3


@kernel(types.void(SWITCHED_SYSTEM, _I, _F, _B, BLOCKS, SERIES), inner=True)
def series_at(system, zone, time, forced, states, series):
    """Series of all columns from their states at a time, the law of the zone extended beyond it.

    Parameters
    ----------
    system : SwitchedSystem
    zone : int
        -1 back, 0 free, 1 front.
    time : float
    forced : bool
        Whether the first column is a motion, under the load; all others are deviations.
    states : (blocks, 2 n, 4) array
    series : Series
        Overwritten.
    """
    _sources(system, zone, time, forced, series)
    n = system.vectors.shape[1]
    for block in range(states.shape[0]):
        y, state = series.y[block], states[block]
        for i in range(n):
            for column in range(4):
                y[0, i, column], y[1, i, column] = state[i, column], state[n + i, column]
        _recurrence(system, zone, forced and block == 0, y, series.contact[block], series.stiffness, series.g)
    if forced:
        for j in range(series.motion.shape[0]):
            series.motion[j] = series.contact[0, j, 0]


@kernel(_F(_F, _F, _F), inline=True)
def _reach(bound, last, previous):
    """Largest step h with k |y_k| h^(k - 1) at most the bound for the last two coefficients of y."""
    # With nothing in the series the solution is a short polynomial and any step is exact.
    step = math.inf
    if last > 0.0:
        step = (bound / (ORDER * last)) ** (1.0 / (ORDER - 1))
    if previous > 0.0 and not (ORDER - 1) * previous * step ** (ORDER - 2) <= bound:
        step = (bound / ((ORDER - 1) * previous)) ** (1.0 / (ORDER - 2))
    return step


@kernel(_F(SWITCHED_SYSTEM, _B, _F, BLOCKS, SERIES), inner=True)
def step_length(system, forced, tolerance, states, series):
    """Step at which the last two terms of y' fall to the tolerance.

    For a motion it counts relative to max(|state|, length of the system). For deviations, which may grow where the
    motion rests, it is 1e-10 of the largest component among them.

    Parameters
    ----------
    system, forced, states, series
        As for `series_at`, which must have been called.
    tolerance : float
        For the motion.

    Returns
    -------
    float
        Infinite where the series ends; nan where it is not finite.
    """
    n = system.vectors.shape[1]
    step = math.inf
    if forced:
        size, last, previous = system.numbers[LENGTH], 0.0, 0.0
        for i in range(n):
            size = max(size, abs(states[0, i, 0]), abs(states[0, n + i, 0]))
            last = max(last, abs(series.y[0, ORDER, i, 0]))
            previous = max(previous, abs(series.y[0, ORDER - 1, i, 0]))
        step = _reach(tolerance * size, last, previous)
    size, last, previous = 0.0, 0.0, 0.0
    for block in range(states.shape[0]):
        for i in range(n):
            for column in range(1 if forced and block == 0 else 0, 4):
                size = max(size, abs(states[block, i, column]), abs(states[block, n + i, column]))
                last = max(last, abs(series.y[block, ORDER, i, column]))
                previous = max(previous, abs(series.y[block, ORDER - 1, i, column]))
    return min(step, _reach(_TOLERANCE * size, last, previous))


@kernel(types.void(SERIES, _F, BLOCKS), inner=True)
def state_at(series, step, states):
    """Fill in the states at the end of a step."""
    n = series.y.shape[2]
    for block in range(states.shape[0]):
        y, state = series.y[block], states[block]
        for i in range(n):
            v0, v1, v2, v3 = y[ORDER, i, 0], y[ORDER, i, 1], y[ORDER, i, 2], y[ORDER, i, 3]
            d0, d1, d2, d3 = 0.0, 0.0, 0.0, 0.0
            for j in range(series.stiffness.shape[0] - 2, -1, -1):
                d0, d1, d2, d3 = d0 * step + v0, d1 * step + v1, d2 * step + v2, d3 * step + v3
                v0 = v0 * step + y[j, i, 0]
                v1 = v1 * step + y[j, i, 1]
                v2 = v2 * step + y[j, i, 2]
                v3 = v3 * step + y[j, i, 3]
            state[i, 0], state[i, 1], state[i, 2], state[i, 3] = v0, v1, v2, v3
            state[n + i, 0], state[n + i, 1], state[n + i, 2], state[n + i, 3] = d0, d1, d2, d3


@kernel(types.void(BLOCKS), inner=True)
def set_identity(states):
    """Make the columns of all blocks those of the unit matrix."""
    states[:, :, :] = 0.0
    for i in range(states.shape[1]):
        states[i // 4, i, i % 4] = 1.0


@kernel(_B(SWITCHED_SYSTEM, _I, _F, _F, BLOCKS, SERIES), inner=True)
def carry_deviations(system, zone, begin, end, states, series):
    """Carry deviations through a zone from one time to another; False where they are not finite any more."""
    time = begin
    for _ in range(_MOST_STEPS):
        series_at(system, zone, time, False, states, series)
        step, rest = step_length(system, False, 0.0, states, series), end - time
        if step >= rest:
            state_at(series, rest, states)
            return True
        if not time + step > time:
            return False
        state_at(series, step, states)
        time += step
    return False
