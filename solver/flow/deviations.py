"""Deviations from a motion, carried through contact zones by Taylor series: what monodromy matrices are made of.

They stand in blocks of four, which run side by side through the recurrence of `solver.flow.taylor` without g: the
contact term is a product of scalar series, one for each column, and four of them take little longer than one. Unused
columns are 0. A cubic spring adds the product of 3 k_3 lambda^2 with the deviation.
"""

import math
from typing import NamedTuple

import numpy as np

from solver.flow.switched_system import CUBIC, DASHPOT, SWITCHED_SYSTEM, strength_of
from solver.flow.taylor import fill_sources, reach
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel

__all__ = [
    "BLOCKS",
    "BLOCK_SERIES",
    "BlockSeries",
    "DEVIATION_ORDER",
    "carry_deviations",
    "change_contact",
    "count_blocks",
    "new_block_series",
    "set_identity",
]

_F, _I, _B = types.float64, types.int64, types.boolean

#: Deviations in blocks of four columns, (blocks, 2 n, 4): y above y'.
BLOCKS = types.float64[:, :, ::1]

#: Degree of the series of y. The number of steps falls with it as the work of one grows: measured at tolerances from
#: 1e-13 to 1e-10, monodromy matrices cost least between 24 and 32.
DEVIATION_ORDER = 28

# Truncation error of deviations in a step, as a share of their largest component: some 1e-11 in a matrix over a period.
_TOLERANCE = 1e-10

# Steps of one passage through a zone, each about four radians of the fastest mode: what needs more is left undecided.
_MOST_STEPS = 5_000


class BlockSeries(NamedTuple):
    """The series of blocks of deviations: y (blocks, m + 1, n, 4), lambda (blocks, m + 1, 4), s (m + 1,), and for a
    cubic spring the lambda of the motion that they are deviations from and 3 k_3 times its square (m + 1,)."""

    y: np.ndarray
    contact: np.ndarray
    stiffness: np.ndarray
    motion: np.ndarray
    bend: np.ndarray


BLOCK_SERIES = types.NamedTuple((types.float64[:, :, :, ::1], BLOCKS, ARRAY, ARRAY, ARRAY), BlockSeries)


@kernel(_I(_I), inline=True)
def count_blocks(columns):
    """Blocks that so many columns take."""
    return (columns + 3) // 4


@kernel(BLOCK_SERIES(_I, _I), inner=True)
def new_block_series(degrees, columns):
    """Room for the series of so many deviations of n coordinates."""
    blocks, size = count_blocks(columns), DEVIATION_ORDER + 1
    return BlockSeries(
        np.zeros((blocks, size, degrees, 4)),
        np.empty((blocks, size, 4)),
        np.empty(size),
        np.empty(size),
        np.empty(size),
    )


@kernel(types.void(SWITCHED_SYSTEM, ARRAY, _F, BLOCK_SERIES), inner=True)
def _fill_bend(system, motion, time, series):
    """Fill in 3 k_3 lambda^2 about a time, of a motion (Lambda_0, c_1, s_1, ...) of theta = Omega tau/nu."""
    place, bend, size = series.motion, series.bend, series.bend.shape[0]
    # The first number is Omega/nu.
    for j in range(size):
        place[j] = motion[1] if j == 0 else 0.0
    for k in range(1, motion.shape[0] // 2):
        rate = k * motion[0]
        # cosine and sine carry the factor (k Omega/nu)^j / j! and turn by a quarter per order.
        cosine, sine = math.cos(rate * time), math.sin(rate * time)
        for j in range(size):
            place[j] += motion[2 * k] * cosine + motion[2 * k + 1] * sine
            factor = rate / (j + 1)
            cosine, sine = -sine * factor, cosine * factor
    for j in range(size):
        bend[j] = 0.0
        for i in range(j + 1):
            bend[j] += 3.0 * system.numbers[CUBIC] * place[i] * place[j - i]


@kernel(types.void(SWITCHED_SYSTEM, _I, types.float64[:, :, ::1], MATRIX, ARRAY, ARRAY), inner=True)
def _block_series(system, zone, y, contact, stiffness, bend):
    """Fill in the series of one block, y (m + 1, n, 4) and contact (m + 1, 4), from y_0 and y_1."""
    n, order = system.vectors.shape[1], stiffness.shape[0] - 1
    matrices, vectors = system.matrices, system.vectors
    first, strength = n * (zone % 3), strength_of(system, zone)
    second, varied = first + 3 * n, zone != 0 and system.variation.shape[0] > 0
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
        c0, c1, c2, c3 = 0.0, 0.0, 0.0, 0.0
        if system.numbers[CUBIC] != 0.0:
            for i in range(j + 1):
                s = bend[j - i]
                c0 += s * contact[i, 0]
                c1 += s * contact[i, 1]
                c2 += s * contact[i, 2]
                c3 += s * contact[i, 3]
        grade = j + 1.0
        scale = -1.0 / ((j + 2.0) * grade)
        t0, t1, t2, t3 = 0.0, 0.0, 0.0, 0.0
        for i in range(n):
            q, h = strength * vectors[2, i], vectors[1, i]
            v0, v1, v2, v3 = q * p0 + h * c0, q * p1 + h * c1, q * p2 + h * c2, q * p3 + h * c3
            for l in range(n):
                spring, drag = matrices[first + i, l], grade * matrices[second + i, l]
                v0 += spring * y[j, l, 0] + drag * y[j + 1, l, 0]
                v1 += spring * y[j, l, 1] + drag * y[j + 1, l, 1]
                v2 += spring * y[j, l, 2] + drag * y[j + 1, l, 2]
                v3 += spring * y[j, l, 3] + drag * y[j + 1, l, 3]
            v0, v1, v2, v3 = scale * v0, scale * v1, scale * v2, scale * v3
            y[j + 2, i, 0], y[j + 2, i, 1], y[j + 2, i, 2], y[j + 2, i, 3] = v0, v1, v2, v3
            w = vectors[0, i]
            t0 += w * v0
            t1 += w * v1
            t2 += w * v2
            t3 += w * v3
        contact[j + 2, 0], contact[j + 2, 1], contact[j + 2, 2], contact[j + 2, 3] = t0, t1, t2, t3


@kernel(_F(BLOCKS, BLOCK_SERIES), inner=True)
def _block_step(states, series):
    """Step at which the last two terms of y' fall to 1e-10 of the largest component of all columns."""
    n, order = series.y.shape[2], series.stiffness.shape[0] - 1
    size, last, previous = 0.0, 0.0, 0.0
    for block in range(states.shape[0]):
        for i in range(n):
            for column in range(4):
                size = max(size, abs(states[block, i, column]), abs(states[block, n + i, column]))
                last = max(last, abs(series.y[block, order, i, column]))
                previous = max(previous, abs(series.y[block, order - 1, i, column]))
    return reach(_TOLERANCE * size, last, previous, order)


@kernel(types.void(BLOCK_SERIES, _F, BLOCKS), inner=True)
def _blocks_at(series, step, states):
    """Fill in the deviations at the end of a step."""
    n, order = series.y.shape[2], series.stiffness.shape[0] - 1
    for block in range(states.shape[0]):
        y, state = series.y[block], states[block]
        for i in range(n):
            v0, v1, v2, v3 = y[order, i, 0], y[order, i, 1], y[order, i, 2], y[order, i, 3]
            d0, d1, d2, d3 = 0.0, 0.0, 0.0, 0.0
            for j in range(order - 1, -1, -1):
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


@kernel(types.void(SWITCHED_SYSTEM, _I, _I, BLOCKS), inner=True)
def change_contact(system, before, after, states):
    """Carry deviations over a switch of contact: those of y' jump where touching teeth have a damper of their own.

    Parameters
    ----------
    system : SwitchedSystem
    before, after : int
        The zones.
    states : BLOCKS
        Overwritten.
    """
    jump, vectors = system.numbers[DASHPOT] * (strength_of(system, after) - strength_of(system, before)), system.vectors
    if jump == 0.0:
        return
    n = vectors.shape[1]
    for block in range(states.shape[0]):
        for column in range(4):
            seen = 0.0
            for i in range(n):
                seen += vectors[0, i] * states[block, i, column]
            for i in range(n):
                states[block, n + i, column] -= jump * vectors[1, i] * seen


@kernel(_B(SWITCHED_SYSTEM, _I, _F, _F, ARRAY, BLOCKS, BLOCK_SERIES), inner=True, shared=True)
def carry_deviations(system, zone, begin, end, motion, states, series):
    """Carry deviations through a zone from one time to another; False where they are not finite any more.

    Parameters
    ----------
    system : SwitchedSystem
    zone : int
    begin, end : float
        Times tau.
    motion : (2 H + 2,) array
        Omega/nu, then (Lambda_0, c_1, s_1, ...) of the motion that they are deviations from: read for a cubic spring
        alone, and may be empty for other systems.
    states : BLOCKS
        Overwritten.
    series : BlockSeries
    """
    n, time, no_load = system.vectors.shape[1], begin, np.empty((0, 0))
    for _ in range(_MOST_STEPS):
        fill_sources(system, zone, time, series.stiffness, no_load)
        if system.numbers[CUBIC] != 0.0:
            _fill_bend(system, motion, time, series)
        for block in range(states.shape[0]):
            y, state = series.y[block], states[block]
            for i in range(n):
                for column in range(4):
                    y[0, i, column], y[1, i, column] = state[i, column], state[n + i, column]
            _block_series(system, zone, y, series.contact[block], series.stiffness, series.bend)
        step, rest = _block_step(states, series), end - time
        if step >= rest:
            _blocks_at(series, rest, states)
            return True
        if not time + step > time:
            return False
        _blocks_at(series, step, states)
        time += step
    return False
