"""The Poincare map, for kernels: motions from section to section by the flows of the zones.

    flows = zone_flows(system, tolerance, flows)        once for a system: some ten microseconds
    room = new_room(flows)                              once for systems of one size; allocates
    status, _ = carry_period(flows, state, tangents, steps, ceiling, room)       as often as wanted

A step goes to the end of an interval of `solver.flow.zone_flows`, or to the contact switch before it. It takes one
small product of a matrix and the state, and sixteen coefficients that tell that lambda stays within its zone. Where a
motion goes depends on nothing but its own state: motions may be carried in any order and any company.

What a motion does within the period is told by its steps, which are kept if wanted (`new_steps`). A step is a row
(row of the flows, begin, end, m): within it the state is Phi(u) m + p(u), begin <= u <= end.
"""

import math
from typing import NamedTuple

import numpy as np

from solver.flow.switched_system import DASHPOT, strength_of
from solver.flow.zone_flows import COEFFICIENTS, CUBE, ZONE_FLOWS, apply_map, matrix_at
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import copy_into
from solver.timedomain.bernstein import first_exit_of_hull, hull_within, keep_left, keep_right, widen_by_hull
from solver.timedomain.integrator import CEILING, COMPLETE, NOT_FINITE, TOO_MANY_STEPS, zone_of

__all__ = [
    "BEGIN",
    "END",
    "MAP_ROOM",
    "ROW",
    "STATE",
    "MapRoom",
    "carry_period",
    "hull_of_step",
    "new_room",
    "new_steps",
    "widen_over",
]

_F, _I, _B = types.float64, types.int64, types.boolean

#: Slots of a step; the state m begins at STATE.
ROW, BEGIN, END, STATE = range(4)


class MapRoom(NamedTuple):
    """What `carry_period` works in.

    `state` and `image` (padded,): m and what becomes of it; `vector` likewise for a deviation. `phi` (2 n + 1, padded)
    and `gamma` (2 n, padded) at a switch. `hull`, `powers`, `piece` (16,): lambda over the step in the two bases, and
    room.
    """

    state: np.ndarray
    image: np.ndarray
    vector: np.ndarray
    phi: np.ndarray
    gamma: np.ndarray
    hull: np.ndarray
    powers: np.ndarray
    piece: np.ndarray


MAP_ROOM = types.NamedTuple((ARRAY, ARRAY, ARRAY, MATRIX, MATRIX, ARRAY, ARRAY, ARRAY), MapRoom)


@kernel(MAP_ROOM(ZONE_FLOWS), inner=True, shared=True)
def new_room(flows):
    """Room for `carry_period` along flows of so many coordinates."""
    size, width = flows.backward.shape[2], flows.backward.shape[3]
    return MapRoom(
        np.zeros(width),
        np.zeros(width),
        np.zeros(width),
        np.zeros((size + 1, width)),
        np.zeros((size, width)),
        np.empty(COEFFICIENTS),
        np.empty(COEFFICIENTS),
        np.empty(COEFFICIENTS),
    )


@kernel(_I(ZONE_FLOWS), inline=True)
def most_steps(flows):
    """Steps that a period may take: far more than a motion needs that does not rattle within rounding."""
    return 100 * flows.count[0] + 1000


@kernel(MATRIX(ZONE_FLOWS), inner=True)
def new_steps(flows):
    """Room for the steps of one period along such flows."""
    return np.empty((most_steps(flows), STATE + flows.backward.shape[3]))


@kernel(_B(CUBE, _I, ARRAY, _F, _F), inline=True)
def _stays(table, row, state, low, high):
    """Whether lambda stays within a range over the whole interval: `apply_map` and `hull_within` in one."""
    columns, outside = table.shape[1] - 1, False
    for r in range(0, COEFFICIENTS, 4):
        t0, t1 = table[row, columns, r], table[row, columns, r + 1]
        t2, t3 = table[row, columns, r + 2], table[row, columns, r + 3]
        for c in range(columns):
            z = state[c]
            t0 += table[row, c, r] * z
            t1 += table[row, c, r + 1] * z
            t2 += table[row, c, r + 2] * z
            t3 += table[row, c, r + 3] * z
        outside |= (t0 < low) | (t1 < low) | (t2 < low) | (t3 < low)
        outside |= (t0 > high) | (t1 > high) | (t2 > high) | (t3 > high)
    return not outside


@kernel(types.Tuple((_F, _I))(ZONE_FLOWS, _I, _I, _F, MAP_ROOM), inline=True)
def _end_of_step(flows, zone, row, begin, room):
    """Where the motion of `room.state` leaves a zone after `begin`, at the end of the interval otherwise; the side."""
    z, slack = zone % 3, flows.slack[0]
    low, high = flows.limits[z, 0] - slack, flows.limits[z, 1] + slack
    if begin == -1.0 and _stays(flows.bernstein, row, room.state, low, high):
        return 1.0, 0
    apply_map(flows.bernstein, row, room.state, room.hull)
    if begin > -1.0:
        keep_right(room.hull, 0.5 * (begin + 1.0))
        if hull_within(room.hull, low, high):
            return 1.0, 0
    apply_map(flows.contact, row, room.state, room.powers)
    return first_exit_of_hull(room.hull, room.powers, begin, flows.limits[z], slack, room.piece)


@kernel(types.void(CUBE, _I, ARRAY, ARRAY), inline=True)
def _carry_tangent(maps, row, tangent, image):
    """Carry a deviation (2 n,) by the linear part of a map."""
    size = tangent.shape[0]
    for r in range(size):
        total = 0.0
        for c in range(size):
            total += maps[row, c, r] * tangent[c]
        image[r] = total
    copy_into(tangent, image)


@kernel(types.void(MATRIX, ARRAY, ARRAY), inline=True)
def _multiply(columns, vector, image):
    """Replace a vector (2 n,) by the sum of 2 n columns that it is the coefficients of."""
    size = vector.shape[0]
    for r in range(size):
        total = 0.0
        for c in range(size):
            total += columns[c, r] * vector[c]
        image[r] = total
    copy_into(vector, image)


@kernel(types.void(ZONE_FLOWS, _I, _I, _F, _F, MATRIX, MAP_ROOM), inner=True)
def _change_zone(flows, row, after, at, jump, tangents, room):
    """Describe the motion, and deviations with it, by the flow of another zone, whose row is `after`, from u on.

    The speeds of deviations jump by -jump M^-1 h delta lambda.
    """
    size, phi, gamma, state, image = flows.backward.shape[2], room.phi, room.gamma, room.state, room.image
    matrix_at(flows.forward, after, size, at, phi)
    for r in range(size):
        image[r] = -phi[size, r]
    matrix_at(flows.forward, row, 0, at, phi)
    matrix_at(flows.backward, after, 0, at, gamma)
    for r in range(size):
        total = phi[size, r] + image[r]
        for c in range(size):
            total += phi[c, r] * state[c]
        image[r] = total
    for r in range(size):
        total = 0.0
        for c in range(size):
            total += gamma[c, r] * image[c]
        state[r] = total
    for k in range(tangents.shape[0]):
        _multiply(phi, tangents[k], room.vector)
        if jump != 0.0:
            seen, vectors = 0.0, flows.system.vectors
            for i in range(vectors.shape[1]):
                seen += vectors[0, i] * tangents[k, i]
            for i in range(vectors.shape[1]):
                tangents[k, vectors.shape[1] + i] -= jump * vectors[1, i] * seen
        _multiply(gamma, tangents[k], room.vector)


@kernel(types.UniTuple(_I, 2)(ZONE_FLOWS, ARRAY, MATRIX, MATRIX, _F, MAP_ROOM), inner=True, shared=True)
def carry_period(flows, state, tangents, steps, ceiling, room):
    """Carry a motion, and small deviations from it, from one section to the next.

    Parameters
    ----------
    flows : ZoneFlows
    state : (2 n,) array
        y, then y', at tau = 0 modulo the forcing period; overwritten.
    tangents : (k, 2 n) array
        Deviations, overwritten; k may be 0.
    steps : (m, STATE + padded) array
        Of `new_steps`, overwritten; or without rows, where the steps are not wanted.
    ceiling : float
        A motion is given up where |lambda| exceeds it at the end of the period.
    room : MapRoom

    Returns
    -------
    status : int
        `Status`.
    count : int
        Number of steps.
    """
    system, count = flows.system, flows.count[0]
    if count == 0:
        return TOO_MANY_STEPS, 0
    zone, size, n = zone_of(system, state), state.shape[0], system.vectors.shape[1]
    row, k, begin, kept = (zone % 3) * count, 0, -1.0, steps.shape[0]
    for i in range(size):
        room.image[i] = state[i]
    apply_map(flows.entry, row, room.image, room.state)
    for t in range(tangents.shape[0]):
        _carry_tangent(flows.entry, row, tangents[t], room.vector)
    for step in range(kept if kept > 0 else most_steps(flows)):
        end, side = _end_of_step(flows, zone, row, begin, room)
        if kept > 0:
            steps[step, ROW], steps[step, BEGIN], steps[step, END] = row, begin, end
            for i in range(room.state.shape[0]):
                steps[step, STATE + i] = room.state[i]
        if side != 0:
            jump = system.numbers[DASHPOT] * (strength_of(system, zone + side) - strength_of(system, zone))
            zone += side
            after = (zone % 3) * count + k
            _change_zone(flows, row, after, end, jump, tangents, room)
            row, begin = after, end
            continue
        last = k == count - 1
        maps = flows.leave if last else flows.step
        apply_map(maps, row, room.state, room.image)
        for t in range(tangents.shape[0]):
            _carry_tangent(maps, row, tangents[t], room.vector)
        if last:
            displacement, finite = 0.0, True
            for i in range(n):
                displacement += system.vectors[0, i] * room.image[i]
            for i in range(size):
                state[i] = room.image[i]
                finite = finite and math.isfinite(state[i])
            if not finite:
                return NOT_FINITE, step + 1
            return (COMPLETE if abs(displacement) <= ceiling else CEILING), step + 1
        copy_into(room.state, room.image)
        row, k, begin = row + 1, k + 1, -1.0
    return TOO_MANY_STEPS, most_steps(flows)


@kernel(types.void(ZONE_FLOWS, ARRAY, ARRAY), inner=True)
def hull_of_step(flows, step, hull):
    """Fill in the Bernstein coefficients (16,) of lambda over one step."""
    apply_map(flows.bernstein, int(step[ROW]), step[STATE:], hull)
    begin, end = step[BEGIN], step[END]
    if begin > -1.0:
        keep_right(hull, 0.5 * (begin + 1.0))
    if end < 1.0:
        keep_left(hull, (end - begin) / (1.0 - begin))


@kernel(types.void(ZONE_FLOWS, MATRIX, _I, ARRAY, MAP_ROOM), inner=True, shared=True)
def widen_over(flows, steps, count, extremes, room):
    """Widen the lowest and highest lambda (2,) to all that it takes over so many steps."""
    for s in range(count):
        step = steps[s]
        hull_of_step(flows, step, room.hull)
        if not hull_within(room.hull, extremes[0], extremes[1]):
            apply_map(flows.contact, int(step[ROW]), step[STATE:], room.powers)
            widen_by_hull(room.hull, room.powers, step[BEGIN], step[END], flows.slack[0], extremes, room.piece)
