"""Known attractors of one system, and how a motion is recognised as one that ends on them.

A periodic attractor of q forcing periods is known by its sections p_j, j = 0 ... q - 1, and by the derivative A_j of the
Poincare map at each of them. Deviations from it shrink, from one section to the next, in the norms of the periodic
Lyapunov equation

    P_j = Q + A_j^T P_{j+1} A_j,        |A_j d|^2_{j+1} = |d|^2_j - d^T Q d

with Q = 1 for coordinates and 1 / Omega^2 for speeds (S. Bittanti, P. Colaneri, "Periodic Systems: Filtering and
Control", Springer 2009, chapter 3). While the rest r of a deviation, what the linear map does not explain, is at most
half of what the map shrinks, |r| <= (|d| - |A d|) / 2, the deviation shrinks as well. The contact force is continuous
and the rest falls faster than the deviation, so that a motion which obeyed this over several returns, and has come half
as near meanwhile, ends on the orbit.

An aperiodic attractor is known by a sample of its sections.
"""

import math
from typing import NamedTuple

import numpy as np

from solver.flow.switched_system import FREQUENCY, LENGTH, SWITCHED_SYSTEM
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import copy_into, eliminate
from solver.timedomain.integrator import COMPLETE, new_deviations
from solver.timedomain.poincare import carry_over_period, watch_nothing
from solver.flow.taylor import new_series

__all__ = ["HIGHEST_PERIOD", "ORBITS", "Orbits", "close_orbit", "keep_orbit", "new_orbits", "recognised", "same_orbit"]

_F, _I, _B = types.float64, types.int64, types.boolean
_BOXES = types.float64[:, :, ::1]
_STACKS = types.float64[:, :, :, ::1]

#: Forcing periods of the longest periodic motions that are told apart.
HIGHEST_PERIOD = 8

#: Sections by which an aperiodic attractor is known.
SAMPLE = 128

# Iterations of Newton's method; from a motion that has nearly returned to itself it takes three or four.
_ITERATIONS = 10

# Newton's integration, and how nearly an orbit closes, as a share of the system's length.
_ACCURACY, _CLOSED = 1e-12, 1e-10

#: Two orbits are one where a section of one is this near to one of the other, as a share of the system's length.
_SAME = 1e-6

# Deviations below this share of the system's length are rounding of the integration.
_ARRIVED = 1e-7

# Returns in a row that obey the linear map before a motion counts as one that ends on the orbit.
_RETURNS, _MANY_RETURNS = 3, 24


class Orbits(NamedTuple):
    """Attractors of one system; all but `count` have a row for each of the A slots.

    `count` (1,) of the slots are taken. `kind` (A,) holds `AttractorKind`; the sections are `points` (A, 8, m), of
    which a periodic one has as many as periods; `matrices` and `norms` (A, 8, m, m) are A_j and P_j. `rates` (A, 2):
    growth of a deviation in a forcing period and its uncertainty. `samples` (A, 128, m): sections of aperiodic ones, and
    `spacing` (A,), how far apart these lie.
    """

    count: np.ndarray
    kind: np.ndarray
    points: np.ndarray
    matrices: np.ndarray
    norms: np.ndarray
    rates: np.ndarray
    samples: np.ndarray
    spacing: np.ndarray


ORBITS = types.NamedTuple((types.int64[::1], types.int64[::1], _BOXES, _STACKS, _STACKS, MATRIX, _BOXES, ARRAY), Orbits)


def new_orbits(room: int, size: int) -> Orbits:
    """Room for so many attractors of states (m,), none of them known."""
    return Orbits(
        np.zeros(1, np.int64),
        np.zeros(room, np.int64),
        np.full((room, HIGHEST_PERIOD, size), np.nan),
        np.full((room, HIGHEST_PERIOD, size, size), np.nan),
        np.full((room, HIGHEST_PERIOD, size, size), np.nan),
        np.full((room, 2), np.nan),
        np.full((room, SAMPLE, size), np.nan),
        np.full(room, np.nan),
    )


@kernel(_F(SWITCHED_SYSTEM, ARRAY, ARRAY), inner=True)
def distance(system, one, other):
    """Distance of two states, speeds divided by Omega."""
    n, omega = one.shape[0] // 2, system.numbers[FREQUENCY]
    total = 0.0
    for i in range(n):
        total += (one[i] - other[i]) ** 2 + ((one[n + i] - other[n + i]) / omega) ** 2
    return math.sqrt(total)


@kernel(types.void(MATRIX, MATRIX, MATRIX), inner=True)
def _multiply(left, right, product):
    """product = left @ right, which must not be one of them."""
    n = left.shape[0]
    for i in range(n):
        for j in range(n):
            total = 0.0
            for k in range(n):
                total += left[i, k] * right[k, j]
            product[i, j] = total


@kernel(_F(MATRIX, MATRIX, MATRIX), inner=True)
def _growth(matrix, power, work):
    """Logarithm of the spectral radius, from the norms of the powers 2, 4, ... 2^40; both work arrays are overwritten.

    The norm of the k-th power differs from the k-th power of the radius by a factor that is bounded by a polynomial of k
    (Gelfand): its logarithm is divided by 10^12 in the end.
    """
    n, logarithm, scale = matrix.shape[0], 0.0, 1.0
    for i in range(n):
        for j in range(n):
            power[i, j] = matrix[i, j]
    for _ in range(41):
        largest = 0.0
        for i in range(n):
            for j in range(n):
                largest = max(largest, abs(power[i, j]))
        if not largest > 0.0:
            return -math.inf
        logarithm += math.log(largest) * scale
        for i in range(n):
            for j in range(n):
                power[i, j] /= largest
        _multiply(power, power, work)
        for i in range(n):
            for j in range(n):
                power[i, j] = work[i, j]
        scale *= 0.5
    return logarithm


@kernel(_I(SWITCHED_SYSTEM, ARRAY, _I, _F, MATRIX, _BOXES), inner=True)
def _follow(system, state, period, ceiling, points, matrices):
    """Sections of q periods from a state, which is overwritten, and the derivative of the map at each; a status."""
    size = state.shape[0]
    deviations, series, nothing = new_deviations(np.empty((size, size))), new_series(size // 2), watch_nothing()
    for j in range(period):
        copy_into(points[j], state)
        for i in range(size):
            for k in range(size):
                deviations.states[i, k] = 1.0 if i == k else 0.0
        status = carry_over_period(system, state, deviations, _ACCURACY, ceiling, 0.0, nothing, series)
        if status != COMPLETE:
            return status
        for i in range(size):
            for k in range(size):
                matrices[j, i, k] = deviations.states[k, i]
    return COMPLETE


@kernel(types.Tuple((_I, _F))(SWITCHED_SYSTEM, ARRAY, _I, _F, MATRIX, _BOXES), inner=True)
def close_orbit(system, state, period, ceiling, points, matrices):
    """Newton's method for an orbit of q forcing periods near a state.

    Parameters
    ----------
    system : SwitchedSystem
    state : (m,) array
        On the section; the orbit's own where one was found.
    period : int
        q.
    ceiling : float
        Of |lambda|.
    points : (8, m) array
    matrices : (8, m, m) array
        Of the orbit: its sections and the derivative of the Poincare map at each.

    Returns
    -------
    period : int
        The smallest number of periods after which the orbit repeats; 0 where none was found.
    rate : float
        Logarithm of the largest modulus of its multipliers, divided by that period.
    """
    size, scale = state.shape[0], system.numbers[LENGTH]
    end, step = np.empty(size), np.empty(size)
    total, work, product = np.empty((size, size)), np.empty((size, size)), np.empty((size, size))
    before, closed = math.inf, False
    for iteration in range(_ITERATIONS):
        copy_into(end, state)
        if _follow(system, end, period, ceiling, points, matrices) != COMPLETE:
            return 0, 0.0
        gap = distance(system, end, state)
        largest = scale
        for i in range(size):
            largest = max(largest, abs(state[i]))
        closed = gap <= _CLOSED * largest
        if closed and not gap < 0.1 * before:
            break
        if not gap < math.inf or iteration > 2 and gap > 0.5 * before:
            break
        before = gap
        for i in range(size):
            for k in range(size):
                total[i, k] = matrices[0, i, k]
        for j in range(1, period):
            _multiply(matrices[j], total, product)
            for i in range(size):
                for k in range(size):
                    total[i, k] = product[i, k]
        for i in range(size):
            step[i] = end[i] - state[i]
            for k in range(size):
                work[i, k] = (1.0 if i == k else 0.0) - total[i, k]
        if closed and gap <= 1e-13 * largest:
            break
        if eliminate(work, step) == 0.0:
            break
        for i in range(size):
            state[i] += step[i]
    if not closed:
        return 0, 0.0
    copy_into(state, points[0])
    # An orbit that closes over a part of the period is one of fewer periods.
    least = period
    for part in range(1, period):
        if period % part == 0 and least == period and distance(system, points[part], points[0]) < _SAME * scale:
            least = part
    for i in range(size):
        for k in range(size):
            total[i, k] = matrices[0, i, k]
    for j in range(1, least):
        _multiply(matrices[j], total, product)
        for i in range(size):
            for k in range(size):
                total[i, k] = product[i, k]
    return least, _growth(total, work, product) / least


@kernel(_I(SWITCHED_SYSTEM, ORBITS, _I, ARRAY), inner=True)
def same_orbit(system, orbits, period, state):
    """Slot of the known orbit of q periods that passes through a state; -1 if none does."""
    limit = _SAME * system.numbers[LENGTH]
    for slot in range(orbits.count[0]):
        if orbits.kind[slot] == period:
            for j in range(period):
                if distance(system, orbits.points[slot, j], state) < limit:
                    return slot
    return -1


@kernel(types.void(SWITCHED_SYSTEM, ORBITS, _I, _I), inner=True)
def _set_norms(system, orbits, slot, period):
    """P_j of a stable orbit, by doubling: the sum over returns is S + M^T S M + (M^2)^T [...] M^2 + ..."""
    size, omega = orbits.points.shape[2], system.numbers[FREQUENCY]
    n = size // 2
    matrices, norms = orbits.matrices[slot], orbits.norms[slot]
    total, power = np.zeros((size, size)), np.zeros((size, size))
    product, work = np.empty((size, size)), np.empty((size, size))
    for i in range(size):
        power[i, i] = 1.0
    for j in range(period):
        # Add (A_{j-1} ... A_0)^T Q (A_{j-1} ... A_0).
        for i in range(size):
            for k in range(size):
                for l in range(size):
                    weight = 1.0 if l < n else 1.0 / omega**2
                    total[i, k] += power[l, i] * weight * power[l, k]
        _multiply(matrices[j], power, product)
        for i in range(size):
            for k in range(size):
                power[i, k] = product[i, k]
    for _ in range(60):
        # total += power^T total power, power = power^2.
        _multiply(total, power, product)
        largest = 0.0
        for i in range(size):
            for k in range(size):
                value = 0.0
                for l in range(size):
                    value += power[l, i] * product[l, k]
                work[i, k] = value
        for i in range(size):
            for k in range(size):
                total[i, k] += work[i, k]
                largest = max(largest, abs(work[i, k]) / (abs(total[i, i]) + abs(total[k, k])))
        if not largest > 1e-15:
            break
        _multiply(power, power, product)
        for i in range(size):
            for k in range(size):
                power[i, k] = product[i, k]
    for i in range(size):
        for k in range(size):
            norms[0, i, k] = total[i, k]
    for j in range(period - 1, 0, -1):
        after = norms[(j + 1) % period]
        _multiply(after, matrices[j], product)
        for i in range(size):
            for k in range(size):
                value = (1.0 if i < n else 1.0 / omega**2) if i == k else 0.0
                for l in range(size):
                    value += matrices[j, l, i] * product[l, k]
                norms[j, i, k] = value


@kernel(_I(SWITCHED_SYSTEM, ORBITS, _I, _F, MATRIX, _BOXES), inner=True)
def keep_orbit(system, orbits, period, rate, points, matrices):
    """Slot of a stable orbit of `close_orbit`, which becomes known if it was not; -1 where there is no room."""
    slot = same_orbit(system, orbits, period, points[0])
    if slot >= 0:
        return slot
    slot = orbits.count[0]
    if slot == orbits.kind.shape[0]:
        return -1
    size = points.shape[1]
    for j in range(period):
        for i in range(size):
            orbits.points[slot, j, i] = points[j, i]
            for k in range(size):
                orbits.matrices[slot, j, i, k] = matrices[j, i, k]
    orbits.kind[slot], orbits.rates[slot, 0], orbits.rates[slot, 1] = period, rate, 0.0
    _set_norms(system, orbits, slot, period)
    orbits.count[0] += 1
    return slot


@kernel(_F(MATRIX, ARRAY), inner=True)
def _norm(matrix, vector):
    """Root of vector^T matrix vector."""
    total = 0.0
    for i in range(vector.shape[0]):
        value = 0.0
        for k in range(vector.shape[0]):
            value += matrix[i, k] * vector[k]
        total += value * vector[i]
    return math.sqrt(max(total, 0.0))


@kernel(_I(SWITCHED_SYSTEM, ORBITS, ARRAY, ARRAY, ARRAY, types.int64[::1], MATRIX), inner=True)
def recognised(system, orbits, before, after, entry, returns, work):
    """Slot of the periodic orbit that a motion is certain to end on; -1 if that is not known yet.

    Parameters
    ----------
    system : SwitchedSystem
    orbits : Orbits
    before, after : (m,) arrays
        Two sections of the motion, one forcing period apart.
    entry : (A,) array
        Distance from each orbit when the motion began to obey its linear map.
    returns : (A,) int array
        Returns since then; 0 where it does not.
    work : (3, m) array
    """
    size, scale = before.shape[0], system.numbers[LENGTH]
    for slot in range(orbits.count[0]):
        period = orbits.kind[slot]
        if period > HIGHEST_PERIOD:
            continue
        near, nearest = 0, math.inf
        for j in range(period):
            apart = distance(system, orbits.points[slot, j], before)
            if apart < nearest:
                near, nearest = j, apart
        following = (near + 1) % period
        matrix = orbits.matrices[slot, near]
        for i in range(size):
            work[0, i] = before[i] - orbits.points[slot, near, i]
        for i in range(size):
            value = 0.0
            for k in range(size):
                value += matrix[i, k] * work[0, k]
            work[1, i] = value
            work[2, i] = after[i] - orbits.points[slot, following, i] - value
        first = _norm(orbits.norms[slot, near], work[0])
        mapped = _norm(orbits.norms[slot, following], work[1])
        rest = _norm(orbits.norms[slot, following], work[2])
        if nearest < _ARRIVED * scale and distance(system, orbits.points[slot, following], after) < _ARRIVED * scale:
            return slot
        if not rest <= 0.5 * (first - mapped):
            returns[slot] = 0
            continue
        if returns[slot] == 0:
            entry[slot] = first
        returns[slot] += 1
        closer = mapped + rest <= 0.5 * entry[slot] and returns[slot] >= _RETURNS * period
        if closer or returns[slot] >= _MANY_RETURNS * period:
            return slot
    return -1
