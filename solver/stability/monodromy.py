"""The monodromy matrix of a given periodic motion, from contact switch to contact switch, for kernels.

A motion u = (Lambda_0, c_1, s_1, ...) of theta = Omega tau/nu need not be a true one: it tells when there is contact,
exactly. f is continuous, so that the monodromy matrix is the product of smooth pieces between contact switches:
saltation matrices are identities (docs/physics.md, section 6) unless touching teeth have a damper of their own, with
which each is a constant (`solver.flow.switched_system`). Deviations are carried by the integrator's own
recurrence (`solver.flow.taylor`).

For kernels (boundaries, test functions) that have the packed parameters of a balance, of either kind:

    room = new_room(parameters, parameter_slope, p, u.size)          once; allocates
    room = monodromy_at(parameters, parameter_slope, u, p, room)     as often as wanted

leaves the matrix M (2n, 2n) over the period nu 2 pi/Omega from tau = 0, on the states (y, y'), in `room.matrix`. Their
vectors are those of `solver.model.packing.packed(system, axis, omega, order, period)`, for the describing
function `packed(model, axis, omega, 1, 1)`, at axis value p. M is nan where it cannot be computed. It depends smoothly
on (u, p) as long as the motion switches contact in the same order, up to a truncation error of 1e-11 of its size; where
a switch appears or vanishes (grazing) it has a square-root corner. n may change where a coupling is exactly 0, with
which the room returned is another one.
"""

import math
from typing import NamedTuple

import numpy as np

from solver.contact.spectrum import contact_arcs
from solver.flow.deviations import (
    BLOCK_SERIES,
    BLOCKS,
    BlockSeries,
    carry_deviations,
    change_contact,
    count_blocks,
    new_block_series,
    set_identity,
)
from solver.flow.switched_system import (
    FREQUENCY,
    HIGH,
    LOW,
    SWITCHED_SYSTEM,
    SwitchedSystem,
    count_degrees,
    new_system,
    system_at,
)
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.model.parameters import PERIOD, STIFFNESSES

__all__ = [
    "ROOM",
    "Room",
    "carry_through",
    "fill_monodromies",
    "find_switches",
    "fitted_room",
    "monodromy_at",
    "new_room",
]

_I, _F = types.int64, types.float64
_TURN = 2.0 * math.pi


class Room(NamedTuple):
    """What `monodromy_at` works in: the system at p, series and states of the deviations, the motion behind its
    frequency Omega/nu (2 H + 2,), its contact angles and the zones that begin there, the result, and room for its
    multipliers (2, 2 n)."""

    system: SwitchedSystem
    series: BlockSeries
    states: np.ndarray
    motion: np.ndarray
    angles: np.ndarray
    zones: np.ndarray
    matrix: np.ndarray
    multipliers: np.ndarray


ROOM = types.NamedTuple((SWITCHED_SYSTEM, BLOCK_SERIES, BLOCKS, ARRAY, ARRAY, types.int64[::1], MATRIX, MATRIX), Room)


@kernel(ROOM(_I, _I, _I), inner=True, shared=True)
def _room(degrees, stiffnesses, unknowns):
    columns = 2 * degrees
    return Room(
        new_system(degrees, stiffnesses),
        new_block_series(degrees, columns),
        np.empty((count_blocks(columns), columns, 4)),
        np.empty(unknowns + 1),
        np.empty(2 * unknowns + 8),
        np.empty(2 * unknowns + 8, np.int64),
        np.empty((columns, columns)),
        np.empty((2, columns)),
    )


@kernel(ROOM(ARRAY, ARRAY, _F, _I), inner=True)
def new_room(parameters, parameter_slope, p, unknowns):
    """Room for the monodromy matrices of motions with so many unknowns; see the module.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Parameters at p = 0 and what p adds to them.
    p : float
        Axis value.
    unknowns : int
        n, of the motions.
    """
    return _room(count_degrees(parameters, parameter_slope, p), int(parameters[STIFFNESSES]), unknowns)


@kernel(ROOM(ARRAY, ARRAY, _F, ROOM), inner=True, shared=True)
def fitted_room(parameters, parameter_slope, p, room):
    """The room, or a new one where the system has another number of coordinates, with the system at p filled in.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Parameters at p = 0 and what p adds to them.
    p : float
        Axis value.
    room : Room
        Whose system may be kept.
    """
    degrees = count_degrees(parameters, parameter_slope, p)
    if degrees != room.system.vectors.shape[1]:
        room = _room(degrees, int(parameters[STIFFNESSES]), (room.angles.shape[0] - 8) // 2)
    system_at(parameters, parameter_slope, p, room.system)
    return room


@kernel(_I(ARRAY, ROOM), inner=True)
def find_switches(motion, room):
    """Fill in a motion, its contact angles and zones; the number of its switches."""
    numbers = room.system.numbers
    for j in range(motion.shape[0]):
        room.motion[1 + j] = motion[j]
    return contact_arcs(motion, numbers[HIGH], -numbers[LOW], room.angles, room.zones)


@kernel(types.void(_I, _F, ROOM), inner=True)
def carry_through(count, period, room):
    """Fill `room.matrix` with the monodromy matrix of a motion whose switches are found, over `period` = nu periods.

    Parameters
    ----------
    count : int
        Switches in `room`.
    period : float
        Of the motion, in units of tau.
    room : Room
        Overwritten.
    """
    system, angles, zones = room.system, room.angles, room.zones
    set_identity(room.states)
    scale = period / system.numbers[FREQUENCY]
    room.motion[0] = 1.0 / scale
    # A motion that starts in the middle of a piece: the piece before the first switch is the end of the last one.
    zone, begin, whole = zones[max(count - 1, 0)], 0.0, True
    for piece in range(count + 1):
        end = angles[piece] if piece < count else _TURN
        if whole and end > begin:
            whole = carry_deviations(system, zone, begin * scale, end * scale, room.motion, room.states, room.series)
        if piece < count:
            change_contact(system, zone, zones[piece], room.states)
            zone, begin = zones[piece], end
    matrix, states = room.matrix, room.states
    for i in range(matrix.shape[0]):
        for j in range(matrix.shape[0]):
            matrix[i, j] = states[j // 4, i, j % 4] if whole else math.nan


@kernel(ROOM(ARRAY, ARRAY, ARRAY, _F, ROOM), inner=True)
def monodromy_at(parameters, parameter_slope, motion, p, room):
    """Fill `room.matrix` with the monodromy matrix of a motion of packed parameters at one axis value; see the module.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Parameters at p = 0 and what p adds to them.
    motion : (n,) array
        Unknowns (Lambda_0, c_1, s_1, ...).
    p : float
        Axis value.
    room : Room
        Overwritten; its matrix is the result.

    Returns
    -------
    Room
        The one given, or a new one where the number of coordinates is another.
    """
    room = fitted_room(parameters, parameter_slope, p, room)
    carry_through(find_switches(motion, room), parameters[PERIOD], room)
    return room


@kernel(_I(ARRAY, ARRAY, ARRAY, MATRIX, types.float64[:, :, ::1]))
def fill_monodromies(parameters, parameter_slope, values, motions, matrices):
    """Fill found (k, 2 n, 2 n); the number of coordinates of the first motion that has not n, else 0.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Parameters at p = 0 and what p adds to them.
    values : (k,) array
        Axis values.
    motions : (k, n) array
    matrices : (k, states, states) array
        Filled.
    """
    room = new_room(parameters, parameter_slope, values[0], motions.shape[1])
    for k in range(values.shape[0]):
        room = fitted_room(parameters, parameter_slope, values[k], room)
        if room.matrix.shape[0] != matrices.shape[1]:
            return room.system.vectors.shape[1]
        carry_through(find_switches(motions[k], room), parameters[PERIOD], room)
        for i in range(matrices.shape[1]):
            for j in range(matrices.shape[1]):
                matrices[k, i, j] = room.matrix[i, j]
    return 0
