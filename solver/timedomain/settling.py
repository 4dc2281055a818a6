"""Where the motions of one cell settle.

Motions are followed from section to section until one is certain to end on a known attractor. One that returns close to
itself after q forcing periods is polished by Newton's method, which makes an orbit known. What does not settle within
`transient` periods is watched together with a small deviation: the growth of that tells chaos from a torus.
"""

import math
from typing import NamedTuple

import numpy as np

from solver.flow.switched_system import LENGTH, SWITCHED_SYSTEM
from solver.flow.zone_flows import ZONE_FLOWS
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import copy_into
from solver.timedomain.attractor import AttractorKind
from solver.timedomain.integrator import CEILING, COMPLETE
from solver.timedomain.orbits import ORBIT
from solver.timedomain.recognition import HIGHEST_PERIOD, KNOWN, SAMPLE, distance, recognised, try_orbit
from solver.timedomain.samples import LOOKED, keep_sample, within_sample
from solver.timedomain.section_map import MAP_ROOM, carry_period

__all__ = ["FAILED", "LIMITS", "MEMORY", "NO_ROOM", "Limits", "Memory", "new_memory", "settle_state", "spread_sample"]

_F, _I, _B = types.float64, types.int64, types.boolean
_COUNTS = types.int64[::1]

LONGER, QUASI_PERIODIC = int(AttractorKind.PERIOD_LONGER), int(AttractorKind.QUASI_PERIODIC)
CHAOTIC = int(AttractorKind.CHAOTIC)
UNBOUNDED, UNSETTLED = int(AttractorKind.UNBOUNDED), int(AttractorKind.UNSETTLED)

#: What `settle_state` gives besides a slot: the integrator could not go on; there was no slot left.
FAILED, NO_ROOM = -2, -3

# What `_approached` gives where it cannot tell.
_PERHAPS = -4

# Sections that are kept of a motion: twice the longest period, and as many again to see that it stays.
_KEPT = 3 * HIGHEST_PERIOD

# Periods before a motion is compared with samples of attractors.
_SETTLED = 40

# Periods between two tries of Newton's method, at first and at most.
_WAIT, _LONGEST_WAIT = 4, 128

# Longest period that is looked for, from how many sections on, and how near a return must be: the motion has arrived.
_MOST_PERIODS, _ENOUGH, _EXACT, _APART = 64, 160, 1e-6, 1e-4

# How far a motion is moved that stays on an unstable orbit, as a share of the length.
_NUDGE = 1e-3

# A motion this near to an orbit, as a share of the length, that has come so much nearer is taken to end there; one that
# has come a little nearer may do so.
_NEAR_ENOUGH, _NEARER, _LITTLE = 0.2, 0.7, 0.97

# Batches of the growth of a deviation; the first part lets it turn into the direction that grows fastest.
_BATCHES, _TURNING = 20, 40

# Chaos is told every so many periods, from the third time on, if it is so much stronger than the floor. Weak chaos is
# often a transient: it is watched to the end, and followed so many times as long.
_TOLD_EVERY, _STRONG, _LONG = 200, 10.0, 4


class Limits(NamedTuple):
    """How long and how strictly motions are watched; see `solver.timedomain.attractors.AttractorSearch`."""

    tolerance: float
    ceiling: float
    near: float
    transient: int
    watched: int
    floor: float


LIMITS = types.NamedTuple((_F, _F, _F, _I, _I, _F), Limits)


class Memory(NamedTuple):
    """What is kept of a motion while it is followed.

    `before` (m,): the last section but one. `entry` and `returns` (A,), `hits` (A, 48): see `recognised` and
    `within_sample`. `tries` (18,): for every period up to 8 when Newton's method may be tried again, and how long to
    wait after that. `kept` (24, m): a ring of the last sections. `sections` (N, m) and `logarithms` (N,): what is
    watched. `tangent` (1, m), `work` (3, m), `sample` (128, m) and `gaps` (128,) are worked in; `none` (0, m).
    """

    before: np.ndarray
    entry: np.ndarray
    returns: np.ndarray
    hits: np.ndarray
    tries: np.ndarray
    kept: np.ndarray
    sections: np.ndarray
    logarithms: np.ndarray
    tangent: np.ndarray
    work: np.ndarray
    sample: np.ndarray
    gaps: np.ndarray
    none: np.ndarray


MEMORY = types.NamedTuple(
    (ARRAY, ARRAY, _COUNTS, types.int64[:, ::1], _COUNTS, MATRIX, MATRIX, ARRAY, MATRIX, MATRIX, MATRIX, ARRAY, MATRIX),
    Memory,
)


def new_memory(size: int, room: int, watched: int) -> Memory:
    """Room for a motion.

    Parameters
    ----------
    size : int
        Numbers m of a state.
    room : int
        Attractors that it may end on.
    watched : int
        Sections over which it may be watched.
    """
    return Memory(
        np.empty(size),
        np.empty(room),
        np.empty(room, np.int64),
        np.empty((room, LOOKED), np.int64),
        np.empty(2 * (HIGHEST_PERIOD + 1), np.int64),
        np.empty((_KEPT, size)),
        np.empty((watched, size)),
        np.empty(watched),
        np.empty((1, size)),
        np.empty((3, size)),
        np.empty((SAMPLE, size)),
        np.empty(SAMPLE),
        np.empty((0, size)),
    )


@kernel(types.void(MEMORY), inner=True)
def _forget(memory):
    """Nothing has been seen and tried yet."""
    memory.returns[:] = 0
    memory.hits[:, :] = 0
    for period in range(HIGHEST_PERIOD + 1):
        memory.tries[period], memory.tries[HIGHEST_PERIOD + 1 + period] = 0, _WAIT


@kernel(_I(KNOWN, _I), inner=True)
def _slot_of(known, kind):
    """The slot of what has no sections (unbounded and unsettled motions), which is taken if it was not; or NO_ROOM."""
    for slot in range(known.count[0]):
        if known.kind[slot] == kind:
            return slot
    slot = known.count[0]
    if slot == known.kind.shape[0]:
        return NO_ROOM
    known.kind[slot] = kind
    known.count[0] += 1
    return slot


@kernel(types.void(ZONE_FLOWS, KNOWN, MEMORY, _I, LIMITS, ORBIT, MAP_ROOM), inner=True)
def _seek_return(flows, known, memory, now, limits, orbit, room):
    """Try Newton's method where the motion has stayed near itself for q periods; at most one orbit becomes known.

    Parameters
    ----------
    flows : ZoneFlows
    known : Known
    memory : Memory
        Its ring of sections is full.
    now : int
        Number of the newest section.
    limits : Limits
    orbit : Orbit
    room : MapRoom
    """
    near, kept, tries = limits.near * flows.system.numbers[LENGTH], memory.kept, memory.tries
    for slot in range(known.count[0]):
        # It is on its way to what is known.
        if memory.returns[slot] > 0:
            return
    for period in range(1, HIGHEST_PERIOD + 1):
        if now < tries[period]:
            continue
        stays, back = True, 0
        while stays and back <= period:
            one, other = (now - back) % _KEPT, (now - back - period) % _KEPT
            stays = distance(flows.system, kept[one], kept[other]) < near
            back += 1
        if stays:
            # Found or not: what is known by now is recognised without another try.
            wait = HIGHEST_PERIOD + 1 + period
            tries[period] = now + tries[wait]
            tries[wait] = min(4 * tries[wait], _LONGEST_WAIT)
            if try_orbit(flows, known, kept[now % _KEPT], period, limits.ceiling, 10.0 * near, orbit, room) >= 0:
                return


@kernel(types.UniTuple(_F, 2)(ARRAY, _I), inner=True)
def _batch_means(logarithms, count):
    """Mean growth of a deviation in a period and its standard error, from batches after the first periods."""
    per = (count - _TURNING) // _BATCHES
    mean, square = 0.0, 0.0
    for batch in range(_BATCHES):
        total = 0.0
        for i in range(per):
            total += logarithms[count - _BATCHES * per + batch * per + i]
        total /= per
        mean += total
        square += total * total
    mean /= _BATCHES
    variance = max(square / _BATCHES - mean * mean, 0.0) * _BATCHES / (_BATCHES - 1.0)
    return mean, math.sqrt(variance / _BATCHES)


@kernel(types.void(MATRIX, _I, MATRIX), inner=True)
def spread_sample(sections, count, sample):
    """Fill a sample (128, m) with sections spread over the later ones, so that slow turns of a torus are seen whole."""
    for i in range(SAMPLE):
        # Multiples of the golden ratio: evenly spread, and in step with no period.
        share = (i * 0.6180339887498949) % 1.0
        copy_into(sample[i], sections[count - 1 - int(share * (count - _TURNING))])


@kernel(_B(SWITCHED_SYSTEM, MATRIX, _I), inner=True)
def _repeats(system, sections, now):
    """Whether a motion has come to repeat itself after more than eight periods."""
    scale = system.numbers[LENGTH]
    for period in range(1, HIGHEST_PERIOD + 1):
        if distance(system, sections[now], sections[now - period]) < _APART * scale:
            return False
    for period in range(HIGHEST_PERIOD + 1, _MOST_PERIODS + 1):
        near = distance(system, sections[now], sections[now - period]) < _EXACT * scale
        if near and distance(system, sections[now - period], sections[now - 2 * period]) < _EXACT * scale:
            return True
    return False


@kernel(_I(SWITCHED_SYSTEM, KNOWN, MATRIX), inner=True)
def _approached(system, known, sections):
    """Slot of a stable orbit that a motion slowly ends on: near, and nearer at half the pace of its multipliers.

    -1 where there is none, _PERHAPS where it may be approaching one. A growth so close to 0 looks like that of a torus;
    the largest distance over many sections does not feel where in its slow beat the motion happens to be.
    """
    count, answer = sections.shape[0], -1
    for slot in range(known.count[0]):
        if known.kind[slot] > HIGHEST_PERIOD or known.kind[slot] < 1:
            continue
        early, late = 0.0, 0.0
        for i in range(2 * SAMPLE):
            at = i if i < SAMPLE else count - 2 * SAMPLE + i
            least = math.inf
            for j in range(known.kind[slot]):
                least = min(least, distance(system, known.points[slot, j], sections[at]))
            if i < SAMPLE:
                early = max(early, least)
            else:
                late = max(late, least)
        promised = math.exp(0.5 * known.rates[slot, 0] * (count - SAMPLE))
        if late < _NEAR_ENOUGH * system.numbers[LENGTH] and late < min(promised, _NEARER) * early:
            return slot
        if late < _LITTLE * early:
            answer = _PERHAPS
    return answer


@kernel(_I(ZONE_FLOWS, KNOWN, ARRAY, LIMITS, MEMORY, ORBIT, MAP_ROOM), inner=True, shared=True)
def settle_state(flows, known, state, limits, memory, orbit, room):
    """Follow a motion until it is known where it settles.

    Parameters
    ----------
    flows : ZoneFlows
    known : Known
        What is found becomes known.
    state : (m,) array
        On the section; overwritten.
    limits : Limits
    memory : Memory
    orbit : Orbit
    room : MapRoom

    Returns
    -------
    int
        The slot that it ends in, or FAILED or NO_ROOM.
    """
    slot = _follow(flows, known, state, limits.transient, limits, memory, orbit, room)
    if slot == -1 and _stands_still(flows.system, memory.kept, limits.transient - 1):
        # It repeats, and is recognised as nothing stable: a nudge shows where it goes.
        for i in range(state.shape[0]):
            state[i] += _NUDGE * flows.system.numbers[LENGTH]
        slot = _follow(flows, known, state, limits.transient, limits, memory, orbit, room)
    return slot if slot != -1 else _watch(flows, known, state, limits, memory, orbit, room)


@kernel(_B(SWITCHED_SYSTEM, MATRIX, _I), inner=True)
def _stands_still(system, kept, now):
    """Whether a motion repeats after up to eight periods."""
    for period in range(1, HIGHEST_PERIOD + 1):
        if distance(system, kept[now % _KEPT], kept[(now - period) % _KEPT]) < _EXACT * system.numbers[LENGTH]:
            return True
    return False


@kernel(_I(ZONE_FLOWS, KNOWN, ARRAY, _I, LIMITS, MEMORY, ORBIT, MAP_ROOM), inner=True)
def _follow(flows, known, state, periods, limits, memory, orbit, room):
    """As `settle_state`, over so many periods; -1 where the motion has not settled by then."""
    system = flows.system
    _forget(memory)
    for now in range(periods):
        copy_into(memory.before, state)
        status, _ = carry_period(flows, state, memory.none, memory.none, limits.ceiling, room)
        if status != COMPLETE:
            return _slot_of(known, UNBOUNDED) if status == CEILING else FAILED
        copy_into(memory.kept[now % _KEPT], state)
        slot = recognised(system, known, memory.before, state, memory.entry, memory.returns, memory.work)
        if slot < 0 and now >= _SETTLED:
            slot = within_sample(system, known, state, memory.hits, now)
        if slot >= 0:
            return slot
        if now >= _KEPT:
            _seek_return(flows, known, memory, now, limits, orbit, room)
    return -1


@kernel(_I(ZONE_FLOWS, KNOWN, ARRAY, LIMITS, MEMORY, ORBIT, MAP_ROOM), inner=True)
def _watch(flows, known, state, limits, memory, orbit, room):
    """Slot of what a motion does that has not settled, as `settle_state`, from the growth of a deviation."""
    system, size, tangent = flows.system, state.shape[0], memory.tangent
    sections, last = memory.sections, limits.watched - 1
    tangent[0, :] = 1.0
    _forget(memory)
    for now in range(limits.watched):
        copy_into(memory.before, state)
        status, _ = carry_period(flows, state, tangent, memory.none, limits.ceiling, room)
        if status != COMPLETE:
            return _slot_of(known, UNBOUNDED) if status == CEILING else FAILED
        length = 0.0
        for i in range(size):
            length += tangent[0, i] ** 2
        length = math.sqrt(length)
        memory.logarithms[now] = math.log(length)
        for i in range(size):
            tangent[0, i] /= length
        copy_into(memory.kept[now % _KEPT], state)
        copy_into(sections[now], state)
        slot = recognised(system, known, memory.before, state, memory.entry, memory.returns, memory.work)
        if slot < 0:
            slot = within_sample(system, known, state, memory.hits, now)
        if slot >= 0:
            return slot
        if now >= _KEPT:
            _seek_return(flows, known, memory, now, limits, orbit, room)
        if now >= _ENOUGH and now % 20 == 0 and _repeats(system, sections, now):
            mean, error = _batch_means(memory.logarithms, now + 1)
            return _kept(system, known, LONGER, sections[now + 1 - SAMPLE : now + 1], mean, error, memory)
        if now == last or ((now + 1) % _TOLD_EVERY == 0 and now + 1 >= 3 * _TOLD_EVERY):
            mean, error = _batch_means(memory.logarithms, now + 1)
            spread_sample(sections, now + 1, memory.sample)
            if mean - 4.0 * error > _STRONG * limits.floor:
                return _kept(system, known, CHAOTIC, memory.sample, mean, error, memory)
    if mean - 4.0 * error > limits.floor:
        slot = _follow(flows, known, state, _LONG * limits.watched, limits, memory, orbit, room)
        return slot if slot != -1 else _kept(system, known, CHAOTIC, memory.sample, mean, error, memory)
    for tried in range(3):
        # Orbits of one, two and four periods.
        try_orbit(flows, known, state, 1 << tried, limits.ceiling, math.inf, orbit, room)
    slot = _approached(system, known, sections[: limits.watched])
    if slot >= 0:
        return slot
    if slot == -1 and abs(mean) <= max(limits.floor, 4.0 * error):
        return _kept(system, known, QUASI_PERIODIC, memory.sample, mean, error, memory)
    return _slot_of(known, UNSETTLED)


@kernel(_I(SWITCHED_SYSTEM, KNOWN, _I, MATRIX, _F, _F, MEMORY), inner=True)
def _kept(system, known, kind, sample, mean, error, memory):
    """`keep_sample`, NO_ROOM where there is no slot left."""
    slot = keep_sample(system, known, kind, sample, mean, error, memory.gaps)
    return slot if slot >= 0 else NO_ROOM
