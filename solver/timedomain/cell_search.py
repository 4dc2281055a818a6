"""What the motions of one cell lead to, and the quantities of the attractors found, as kernels."""

import math
from typing import NamedTuple

import numpy as np

from solver.contact.quantities import Slot
from solver.flow.loads import loaded_system_at
from solver.flow.switched_system import FREQUENCY, LENGTH
from solver.flow.tabulation import zone_flows
from solver.flow.zone_flows import ZONE_FLOWS, new_flows
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import copy_into
from solver.timedomain.attractor import AttractorKind
from solver.timedomain.gauge import GAUGE, Gauge
from solver.timedomain.integrator import COMPLETE
from solver.timedomain.orbits import new_orbit
from solver.timedomain.poincare import add_harmonics
from solver.timedomain.quantities import clear, gather, new_work, read
from solver.timedomain.recognition import HIGHEST_PERIOD, KNOWN, Known, try_orbit
from solver.timedomain.samples import fill_sample
from solver.timedomain.section_map import MAP_ROOM, carry_period, new_room, new_steps
from solver.timedomain.settling import LIMITS, MEMORY, Limits, Memory, settle_state, spread_sample

__all__ = ["AMPLITUDE", "CHAOTIC", "NUMBERS", "WINDOW", "Cell", "pursue", "recall", "seek"]

_F, _I = types.float64, types.int64
_COUNTS = types.int64[::1]

#: The last kind of a bounded attractor.
CHAOTIC = int(AttractorKind.CHAOTIC)
UNBOUNDED = int(AttractorKind.UNBOUNDED)

#: Numbers that are kept of an attractor: those of `Slot`, and the amplitude of the forcing frequency.
AMPLITUDE = len(Slot)
NUMBERS = AMPLITUDE + 1

#: Forcing periods over which the quantities of an aperiodic attractor are taken.
WINDOW = 128

# An orbit that Newton's method finds from a motion of a map, or from an attractor of a neighbouring cell, is taken for
# what that motion ends on if it is no farther away than this share of the system's length; else the motion is followed.
_APART = 0.2


class Cell(NamedTuple):
    """What kernels are told of a cell: the row's `parameters` and `parameter_slope`, its value of the axis `p`, what
    quantities are read with, what is known of it, and room for a motion."""

    parameters: np.ndarray
    parameter_slope: np.ndarray
    p: float
    gauge: Gauge
    known: Known
    memory: Memory
    limits: Limits


_CELL = types.NamedTuple((ARRAY, ARRAY, _F, GAUGE, KNOWN, MEMORY, LIMITS), Cell)


@kernel(types.void(_CELL, _I, MATRIX, _COUNTS, MATRIX, MATRIX, _COUNTS, MATRIX))
def seek(cell, period, motions, kinds, brought, states, slots, numbers):
    """What motions in one cell lead to.

    Parameters
    ----------
    cell : Cell
    period : int
        Forcing periods of the motions of a map.
    motions : (a, m) array
        States on motions of a map; overwritten, as all states are.
    kinds, brought : (b,) int array, (b, m) array
        Attractors of other cells.
    states : (c, m) array
        Others.
    slots : (a + b + c,) int array
        Slot that each leads to, in this order, or FAILED or NO_ROOM.
    numbers : (A, NUMBERS) array
        What is new is described there.
    """
    known, memory = cell.known, cell.memory
    system = loaded_system_at(cell.parameters, cell.parameter_slope, cell.p)
    limits, length = _scaled(cell.limits, system.numbers[LENGTH]), system.numbers[LENGTH]
    flows = zone_flows(system, limits.tolerance, new_flows(system, 1))
    room, orbit, before, first = new_room(flows), new_orbit(flows), known.count[0], 0
    for group in range(3):
        starts = motions if group == 0 else (brought if group == 1 else states)
        for i in range(starts.shape[0]):
            slot = -1
            if group == 0 or group == 1 and kinds[i] <= HIGHEST_PERIOD:
                repeats = period if group == 0 else kinds[i]
                slot = try_orbit(flows, known, starts[i], repeats, limits.ceiling, _APART * length, orbit, room)
            if slot < 0:
                _fill_samples(flows, known, limits, memory, room)
                slot = settle_state(flows, known, starts[i], limits, memory, orbit, room)
            slots[first + i] = slot
        first += starts.shape[0]
    _describe(flows, cell, before, limits.ceiling, numbers, room)


@kernel(_I(_CELL, ARRAY, ARRAY, ARRAY))
def pursue(cell, state, displacement, numbers):
    """Follow one motion, without a shortcut, until it has settled, and tell what it does from then on.

    Parameters
    ----------
    cell : Cell
    state : (m,) array
        Where it starts, on the section; overwritten by where it has settled.
    displacement : (WINDOW,) array
        lambda at the starts of the periods of its own period, or of all these of a motion without one, is filled in.
    numbers : (NUMBERS,) array
        Filled in from the same periods.

    Returns
    -------
    int
        Slot that it ends in, or FAILED or NO_ROOM; what is filled in is untouched where it is not bounded.
    """
    known, memory = cell.known, cell.memory
    system = loaded_system_at(cell.parameters, cell.parameter_slope, cell.p)
    limits = _scaled(cell.limits, system.numbers[LENGTH])
    flows = zone_flows(system, limits.tolerance, new_flows(system, 1))
    room = new_room(flows)
    slot = settle_state(flows, known, state, limits, memory, new_orbit(flows), room)
    if slot < 0 or known.kind[slot] == UNBOUNDED:
        return slot
    periods = WINDOW
    if known.kind[slot] <= HIGHEST_PERIOD:
        periods = known.kind[slot]
        copy_into(state, known.points[slot, 0])
    copy_into(memory.before, state)
    steps, ceiling = new_steps(flows), limits.ceiling
    describe_motion(flows, cell.gauge, memory.before, displacement[:periods], numbers, steps, ceiling, room)
    return slot


@kernel(LIMITS(LIMITS, _F), inner=True)
def _scaled(limits, length):
    """The ceiling as a length."""
    return Limits(
        limits.tolerance, limits.ceiling * length, limits.near, limits.transient, limits.watched, limits.floor
    )


@kernel(types.void(ZONE_FLOWS, _CELL, _I, _F, MATRIX, MAP_ROOM), inner=True)
def _describe(flows, cell, first, ceiling, numbers, room):
    """Fill in numbers (A, NUMBERS) of the attractors from slot `first` on: those of `Slot`, and the amplitude."""
    known, state = cell.known, cell.memory.before
    if known.count[0] == first:
        return
    steps, displacement = new_steps(flows), np.empty(WINDOW)
    for slot in range(first, known.count[0]):
        kind = known.kind[slot]
        if kind < 1 or kind > CHAOTIC:
            continue
        periods = kind if kind <= HIGHEST_PERIOD else WINDOW
        copy_into(state, known.points[slot, 0])
        describe_motion(flows, cell.gauge, state, displacement[:periods], numbers[slot], steps, ceiling, room)


@kernel(types.void(ZONE_FLOWS, GAUGE, ARRAY, ARRAY, ARRAY, MATRIX, _F, MAP_ROOM), inner=True, shared=True)
def describe_motion(flows, gauge, state, displacement, numbers, steps, ceiling, room):
    """Fill in what a motion does over some periods.

    Parameters
    ----------
    flows : ZoneFlows
    gauge : Gauge
    state : (m,) array
        On the section; overwritten by that after the last period.
    displacement : (periods,) array
        lambda at the start of each period is filled in.
    numbers : (NUMBERS,) array
        Filled in: those of `Slot`, and the amplitude.
    steps : array
        Of `new_steps`, overwritten.
    ceiling : float
        As for `carry_period`.
    room : MapRoom
    """
    omega, work, sums = flows.system.numbers[FREQUENCY], new_work(flows), np.zeros((2, 2))
    contact, periods = flows.system.vectors[0], displacement.shape[0]
    clear(work)
    for period in range(periods):
        displacement[period] = 0.0
        for i in range(contact.shape[0]):
            displacement[period] += contact[i] * state[i]
        status, count = carry_period(flows, state, steps[:0], steps, ceiling, room)
        if status != COMPLETE:
            break
        gather(flows, gauge, steps, count, work, room)
        add_harmonics(flows, steps, count, 0.0, omega, sums, room)
    read(gauge, work, numbers)
    numbers[AMPLITUDE] = math.hypot(sums[1, 0], sums[1, 1]) * omega / (math.pi * periods)


@kernel(types.void(ZONE_FLOWS, KNOWN, LIMITS, MEMORY, MAP_ROOM), inner=True)
def _fill_samples(flows, known, limits, memory, room):
    """Make the samples of attractors that were recalled without one."""
    for slot in range(known.count[0]):
        if known.kind[slot] > HIGHEST_PERIOD and known.kind[slot] <= CHAOTIC and math.isnan(known.spacing[slot]):
            copy_into(memory.before, known.points[slot, 0])
            for i in range(limits.watched):
                carry_period(flows, memory.before, memory.none, memory.none, limits.ceiling, room)
                copy_into(memory.sections[i], memory.before)
            spread_sample(memory.sections, limits.watched, memory.sample)
            fill_sample(flows.system, known, slot, memory.sample, memory.gaps)


@kernel(types.void(_CELL, _COUNTS, MATRIX, MATRIX))
def recall(cell, kinds, states, rates):
    """Make attractors of these kinds (k,) known again from a state (k, m) of each, in their slots."""
    known = cell.known
    system = loaded_system_at(cell.parameters, cell.parameter_slope, cell.p)
    limits = _scaled(cell.limits, system.numbers[LENGTH])
    flows = zone_flows(system, limits.tolerance, new_flows(system, 1))
    room, orbit = new_room(flows), new_orbit(flows)
    for slot in range(kinds.shape[0]):
        if kinds[slot] <= HIGHEST_PERIOD:
            try_orbit(flows, known, states[slot], kinds[slot], limits.ceiling, math.inf, orbit, room)
        elif kinds[slot] <= CHAOTIC and known.count[0] == slot:
            # Its sample is made when a motion has to be compared with it.
            known.kind[slot], known.spacing[slot] = kinds[slot], math.nan
            known.rates[slot, 0], known.rates[slot, 1] = rates[slot, 0], rates[slot, 1]
            copy_into(known.points[slot, 0], states[slot])
            known.count[0] += 1
        # What has no sections, or was not found again, keeps its slot.
        if known.count[0] <= slot:
            known.kind[slot] = kinds[slot] if kinds[slot] > CHAOTIC else 0
            known.count[0] = slot + 1
