"""Known attractors of one system, and how a motion is recognised as one that ends on them.

A periodic attractor of q forcing periods is known by its sections p_j, j = 0 ... q - 1, and by the derivative A_j of
the Poincare map at each of them. Deviations from it shrink, from one section to the next, in the norms of the periodic
Lyapunov equation

    P_j = Q + A_j^T P_{j+1} A_j,        |A_j d|^2_{j+1} = |d|^2_j - d^T Q d

with Q = 1 for coordinates and 1 / Omega^2 for speeds (S. Bittanti, P. Colaneri, "Periodic Systems: Filtering and
Control", Springer 2009, chapter 3). While the rest r of a deviation, what the linear map does not explain, is at most
half of what the map shrinks, |r| <= (|d| - |A d|) / 2, the deviation shrinks as well. The contact force is continuous
and the rest falls faster than the deviation, so that a motion which obeyed this over several returns, and has come half
as near meanwhile, ends on the orbit.

An aperiodic attractor, or one of a longer period, is known by a sample of its sections (`solver.timedomain.samples`).
"""

import math
from typing import NamedTuple

import numpy as np

from solver.flow.switched_system import FREQUENCY, LENGTH, SWITCHED_SYSTEM
from solver.flow.zone_flows import ZONE_FLOWS
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import copy_into
from solver.timedomain.integrator import COMPLETE
from solver.timedomain.orbits import ORBIT, close_orbit, minimal_period
from solver.timedomain.section_map import MAP_ROOM, carry_period

__all__ = ["HIGHEST_PERIOD", "KNOWN", "SAMPLE", "Known", "distance", "new_known", "recognised", "try_orbit"]

_F, _I = types.float64, types.int64
_COUNTS = types.int64[::1]
_CUBE, _FOUR = types.float64[:, :, ::1], types.float64[:, :, :, ::1]

#: Forcing periods of the longest periodic motions that are told apart.
HIGHEST_PERIOD = 8

#: Sections by which an attractor that is not periodic is known.
SAMPLE = 128

# Newton's iterations and halvings, and how nearly an orbit closes.
_ITERATIONS, _HALVINGS, _CLOSED = 8, 3, 1e-10

# Two orbits are one where a section of one is this near to one of the other, as a share of the system's length.
_SAME = 1e-6

# Deviations below this share of the system's length are rounding of the integration.
_ARRIVED = 1e-7

# Returns in a row that obey the linear map before a motion counts as one that ends on the orbit.
_RETURNS, _MANY_RETURNS = 3, 24


class Known(NamedTuple):
    """Attractors of one system; all but `count` and the last four have a row for each of the A slots.

    `count` (1,) of the slots are taken. `kind` (A,) holds `AttractorKind`; the sections are `points` (A, 8, m), of
    which a periodic one has as many as periods; `matrices` and `norms` (A, 8, m, m) are A_j and P_j. `rates` (A, 2):
    growth of a deviation in a forcing period and its uncertainty. `samples` (A, 128, m): sections of the others, and
    `spacing` (A,), how far apart these lie. `trial` (m,), `tangents` (m, m) and `squares` (4, m, m) are worked in.
    """

    count: np.ndarray
    kind: np.ndarray
    points: np.ndarray
    matrices: np.ndarray
    norms: np.ndarray
    rates: np.ndarray
    samples: np.ndarray
    spacing: np.ndarray
    trial: np.ndarray
    tangents: np.ndarray
    squares: np.ndarray


KNOWN = types.NamedTuple((_COUNTS, _COUNTS, _CUBE, _FOUR, _FOUR, MATRIX, _CUBE, ARRAY, ARRAY, MATRIX, _CUBE), Known)


def new_known(room: int, size: int) -> Known:
    """Room for so many attractors of states (m,), none of them known."""
    return Known(
        np.zeros(1, np.int64),
        np.zeros(room, np.int64),
        np.full((room, HIGHEST_PERIOD, size), np.nan),
        np.full((room, HIGHEST_PERIOD, size, size), np.nan),
        np.full((room, HIGHEST_PERIOD, size, size), np.nan),
        np.full((room, 2), np.nan),
        np.full((room, SAMPLE, size), np.nan),
        np.full(room, np.nan),
        np.empty(size),
        np.empty((size, size)),
        np.empty((4, size, size)),
    )


@kernel(_F(SWITCHED_SYSTEM, ARRAY, ARRAY), inline=True)
def distance(system, one, other):
    """Distance of two states, speeds divided by Omega."""
    n, slower = one.shape[0] // 2, 1.0 / system.numbers[FREQUENCY]
    total = 0.0
    for i in range(n):
        total += (one[i] - other[i]) ** 2 + ((one[n + i] - other[n + i]) * slower) ** 2
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


@kernel(types.void(MATRIX, MATRIX), inline=True)
def _copy_matrix(target, source):
    for i in range(target.shape[0]):
        copy_into(target[i], source[i])


@kernel(_F(MATRIX, MATRIX, MATRIX), inner=True)
def _growth(matrix, power, work):
    """Logarithm of the spectral radius, from the norms of the powers 2, 4, ... 2^40; both work arrays are overwritten.

    The norm of the k-th power differs from the k-th power of the radius by a factor that is bounded by a polynomial of
    k (Gelfand): its logarithm is divided by 10^12 in the end.
    """
    n, logarithm, scale = matrix.shape[0], 0.0, 1.0
    _copy_matrix(power, matrix)
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
        _copy_matrix(power, work)
        scale *= 0.5
    return logarithm


@kernel(_I(SWITCHED_SYSTEM, KNOWN, _I, ARRAY), inner=True)
def _same_orbit(system, known, period, state):
    """Slot of the known orbit of q periods that passes through a state; -1 if none does."""
    limit = _SAME * system.numbers[LENGTH]
    for slot in range(known.count[0]):
        if known.kind[slot] == period:
            for j in range(period):
                if distance(system, known.points[slot, j], state) < limit:
                    return slot
    return -1


@kernel(types.void(SWITCHED_SYSTEM, KNOWN, _I, _I), inner=True)
def _set_norms(system, known, slot, period):
    """P_j of a stable orbit, by doubling: the sum over returns is S + M^T S M + (M^2)^T [...] M^2 + ..."""
    size, square = known.points.shape[2], 1.0 / system.numbers[FREQUENCY] ** 2
    n = size // 2
    matrices, norms = known.matrices[slot], known.norms[slot]
    total, power, product, work = known.squares[0], known.squares[1], known.squares[2], known.squares[3]
    for i in range(size):
        for k in range(size):
            total[i, k], power[i, k] = 0.0, 1.0 if i == k else 0.0
    for j in range(period):
        # Add (A_{j-1} ... A_0)^T Q (A_{j-1} ... A_0).
        for i in range(size):
            for k in range(size):
                for l in range(size):
                    total[i, k] += power[l, i] * (1.0 if l < n else square) * power[l, k]
        _multiply(matrices[j], power, product)
        _copy_matrix(power, product)
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
        _copy_matrix(power, product)
    _copy_matrix(norms[0], total)
    for j in range(period - 1, 0, -1):
        _multiply(norms[(j + 1) % period], matrices[j], product)
        for i in range(size):
            for k in range(size):
                value = (1.0 if i < n else square) if i == k else 0.0
                for l in range(size):
                    value += matrices[j, l, i] * product[l, k]
                norms[j, i, k] = value


@kernel(_I(ZONE_FLOWS, KNOWN, ARRAY, _I, _F, _F, ORBIT, MAP_ROOM), inner=True, shared=True)
def try_orbit(flows, known, state, period, ceiling, apart, orbit, room):
    """Slot of the stable periodic orbit that Newton's method finds from a state, which becomes known if it was not.

    Parameters
    ----------
    flows : ZoneFlows
    known : Known
    state : (m,) array
        On the section.
    period : int
        q.
    ceiling : float
        Of |lambda|.
    apart : float
        Largest distance between the orbit and the state.
    orbit : Orbit
    room : MapRoom

    Returns
    -------
    int
        -1 where there is no such orbit within the distance, or no slot left.
    """
    system, current, tangents = flows.system, known.trial, known.tangents
    copy_into(current, state)
    if close_orbit(flows, current, period, _CLOSED, _ITERATIONS, _HALVINGS, ceiling, orbit, room) != 0:
        return -1
    if not distance(system, current, state) <= apart:
        return -1
    least = minimal_period(flows, current, period, _CLOSED, ceiling, orbit, room)
    slot = _same_orbit(system, known, least, current)
    if slot >= 0:
        return slot
    rate = _growth(orbit.matrix, known.squares[0], known.squares[1]) / period
    slot = known.count[0]
    if not rate < 0.0 or slot == known.kind.shape[0]:
        return -1
    copy_into(orbit.end, current)
    for j in range(least):
        copy_into(known.points[slot, j], orbit.end)
        for i in range(tangents.shape[0]):
            for k in range(tangents.shape[0]):
                tangents[i, k] = 1.0 if i == k else 0.0
        status, _ = carry_period(flows, orbit.end, tangents, tangents[:0], ceiling, room)
        if status != COMPLETE:
            return -1
        for i in range(tangents.shape[0]):
            for k in range(tangents.shape[0]):
                known.matrices[slot, j, i, k] = tangents[k, i]
    known.kind[slot], known.rates[slot, 0], known.rates[slot, 1] = least, rate, 0.0
    _set_norms(system, known, slot, least)
    known.count[0] += 1
    return slot


@kernel(_F(MATRIX, ARRAY), inline=True)
def _norm(matrix, vector):
    """Root of vector^T matrix vector."""
    total = 0.0
    for i in range(vector.shape[0]):
        value = 0.0
        for k in range(vector.shape[0]):
            value += matrix[i, k] * vector[k]
        total += value * vector[i]
    return math.sqrt(max(total, 0.0))


@kernel(_I(SWITCHED_SYSTEM, KNOWN, ARRAY, ARRAY, ARRAY, _COUNTS, MATRIX), inner=True)
def recognised(system, known, before, after, entry, returns, work):
    """Slot of the periodic orbit that a motion is certain to end on; -1 if that is not known yet.

    Parameters
    ----------
    system : SwitchedSystem
    known : Known
    before, after : (m,) arrays
        Two sections of the motion, one forcing period apart.
    entry : (A,) array
        Distance from each orbit when the motion began to obey its linear map.
    returns : (A,) int array
        Returns since then; 0 where it does not.
    work : (3, m) array
    """
    size, arrived = before.shape[0], _ARRIVED * system.numbers[LENGTH]
    for slot in range(known.count[0]):
        period = known.kind[slot]
        if period > HIGHEST_PERIOD or period < 1:
            continue
        near, nearest = 0, distance(system, known.points[slot, 0], before)
        for j in range(1, period):
            apart = distance(system, known.points[slot, j], before)
            if apart < nearest:
                near, nearest = j, apart
        following = near + 1 if near + 1 < period else 0
        matrix = known.matrices[slot, near]
        for i in range(size):
            work[0, i] = before[i] - known.points[slot, near, i]
        for i in range(size):
            value = 0.0
            for k in range(size):
                value += matrix[i, k] * work[0, k]
            work[1, i] = value
            work[2, i] = after[i] - known.points[slot, following, i] - value
        first = _norm(known.norms[slot, near], work[0])
        mapped = _norm(known.norms[slot, following], work[1])
        rest = _norm(known.norms[slot, following], work[2])
        if nearest < arrived and distance(system, known.points[slot, following], after) < arrived:
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
