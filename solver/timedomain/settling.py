"""Where the motions of one cell settle.

Motions are followed from section to section until one is certain to end on a known attractor. One that returns close to
itself after q forcing periods is polished by Newton's method, which makes an orbit known. What does not settle within
`transient` periods is watched together with a small deviation: the growth of that tells chaos from a torus.
"""

import math
from typing import NamedTuple

import numpy as np

from solver.flow.switched_system import LENGTH, SWITCHED_SYSTEM
from solver.flow.taylor import new_series
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import copy_into
from solver.timedomain.attractor import AttractorKind
from solver.timedomain.integrator import CEILING, COMPLETE, new_deviations
from solver.timedomain.orbits import HIGHEST_PERIOD, ORBITS, SAMPLE, close_orbit, distance, keep_orbit, recognised
from solver.timedomain.poincare import carry_over_period, watch_nothing

__all__ = ["FAILED", "LIMITS", "NO_ROOM", "Limits", "keep_aperiodic", "settle_states", "try_orbit"]

_F, _I, _B = types.float64, types.int64, types.boolean
_COUNTS = types.int64[::1]

QUASI_PERIODIC, CHAOTIC = int(AttractorKind.QUASI_PERIODIC), int(AttractorKind.CHAOTIC)
UNBOUNDED, UNSETTLED = int(AttractorKind.UNBOUNDED), int(AttractorKind.UNSETTLED)

#: What `settle_states` gives besides a slot: the integrator could not go on; there was no slot left.
FAILED, NO_ROOM = -2, -3

# Sections that are kept of a motion: twice the longest period, and a little more to see that it stays.
_KEPT = 3 * HIGHEST_PERIOD

# Periods before an aperiodic attractor is looked for among the known ones, and sections that must lie in its sample.
_SETTLED, _WITHIN, _LOOKED = 40, 36, 48

# Batches of the growth of a deviation; the first part lets it turn into the direction that grows fastest.
_BATCHES, _TURNING = 20, 40


class Limits(NamedTuple):
    """How long and how strictly motions are watched; see `solver.timedomain.attractors.AttractorSearch`."""

    tolerance: float
    ceiling: float
    near: float
    transient: int
    watched: int
    floor: float


LIMITS = types.NamedTuple((_F, _F, _F, _I, _I, _F), Limits)


@kernel(_I(SWITCHED_SYSTEM, ORBITS, ARRAY, _I, _F, _F), inner=True)
def try_orbit(system, orbits, state, period, ceiling, apart):
    """Slot of the stable periodic orbit that Newton's method finds from a state; -1 if none does within a distance.

    Parameters
    ----------
    system : SwitchedSystem
    orbits : Orbits
        The orbit becomes known.
    state : (m,) array
        On the section.
    period : int
    ceiling : float
        Of |lambda|.
    apart : float
        Largest distance between the orbit and the state.
    """
    size = state.shape[0]
    points, matrices = np.empty((HIGHEST_PERIOD, size)), np.empty((HIGHEST_PERIOD, size, size))
    current = state.copy()
    least, rate = close_orbit(system, current, period, ceiling, points, matrices)
    if least == 0 or not rate < 0.0 or distance(system, current, state) > apart:
        return -1
    return keep_orbit(system, orbits, least, rate, points, matrices)


@kernel(_I(ORBITS, _I), inner=True)
def _slot_of(orbits, kind):
    """The slot of what has no sections (unbounded and unsettled motions), which is taken if it was not; or NO_ROOM."""
    for slot in range(orbits.count[0]):
        if orbits.kind[slot] == kind:
            return slot
    slot = orbits.count[0]
    if slot == orbits.kind.shape[0]:
        return NO_ROOM
    orbits.kind[slot] = kind
    orbits.count[0] += 1
    return slot


@kernel(_F(SWITCHED_SYSTEM, MATRIX, ARRAY, _I), inner=True)
def _nearest(system, sample, state, skipped):
    """Distance from a state to the nearest section of a sample, one of them left out."""
    least = math.inf
    for i in range(sample.shape[0]):
        if i != skipped:
            least = min(least, distance(system, sample[i], state))
    return least


@kernel(_I(SWITCHED_SYSTEM, ORBITS, ARRAY, types.int64[:, ::1], _I), inner=True)
def _within_sample(system, orbits, state, hits, count):
    """Slot of the aperiodic attractor in whose sample the last sections of a motion lay; -1 if there is none.

    hits (A, 48) remembers, in a ring, which of the last sections lay within; `count` sections were looked at before.
    """
    for slot in range(orbits.count[0]):
        if orbits.kind[slot] != QUASI_PERIODIC and orbits.kind[slot] != CHAOTIC:
            continue
        near = _nearest(system, orbits.samples[slot], state, -1) <= orbits.spacing[slot]
        hits[slot, count % _LOOKED] = 1 if near else 0
        total = 0
        for i in range(_LOOKED):
            total += hits[slot, i]
        if total >= _WITHIN:
            return slot
    return -1


@kernel(_I(SWITCHED_SYSTEM, ORBITS, MATRIX, _I, _I, _COUNTS, LIMITS), inner=True)
def _returned(system, orbits, kept, last, now, tries, limits):
    """Seek a periodic orbit where the motion has stayed near itself for q periods; whether one became known.

    Parameters
    ----------
    system : SwitchedSystem
    orbits : Orbits
    kept : (24, m) array
        Ring of the last sections, the newest in row `last`; all rows are filled.
    last, now : int
        Row of the newest section, and its number.
    tries : (2 * 9,) int array
        For every q when it may be tried again, and how long to wait after a vain try.
    limits : Limits
    """
    near = limits.near * system.numbers[LENGTH]
    newest = kept[last]
    for period in range(1, HIGHEST_PERIOD + 1):
        if now < tries[period]:
            continue
        stays = True
        for back in range(0, period + 1):
            if stays:
                one, other = (last - back) % _KEPT, (last - back - period) % _KEPT
                stays = distance(system, kept[one], kept[other]) < near
        if stays:
            # Found or not: what is known by now is recognised without another try.
            wait = HIGHEST_PERIOD + 1 + period
            tries[period] = now + tries[wait]
            tries[wait] = 4 * tries[wait]
            if try_orbit(system, orbits, newest, period, limits.ceiling, 10.0 * near) >= 0:
                return 1
    return 0


@kernel(types.void(_COUNTS), inner=True)
def _may_try(tries):
    """Nothing has been tried yet."""
    for period in range(HIGHEST_PERIOD + 1):
        tries[period], tries[HIGHEST_PERIOD + 1 + period] = 0, 4


@kernel(_I(SWITCHED_SYSTEM, ORBITS, ARRAY, LIMITS), inner=True)
def _watch(system, orbits, state, limits):
    """Slot of what a motion does that has not settled, or FAILED or NO_ROOM; the state is carried along."""
    size, room = state.shape[0], orbits.kind.shape[0]
    deviations, series, nothing = new_deviations(np.empty((1, size))), new_series(size // 2), watch_nothing()
    for i in range(size):
        deviations.states[0, i] = 1.0
    entry, returns, work = np.empty(room), np.zeros(room, np.int64), np.empty((3, size))
    hits, tries = np.zeros((room, _LOOKED), np.int64), np.empty(2 * HIGHEST_PERIOD + 2, np.int64)
    _may_try(tries)
    before, kept, sections = state.copy(), np.empty((_KEPT, size)), np.empty((limits.watched, size))
    logarithms = np.zeros(limits.watched)
    for now in range(limits.watched):
        copy_into(before, state)
        status = carry_over_period(system, state, deviations, limits.tolerance, limits.ceiling, 0.0, nothing, series)
        if status == CEILING:
            return _slot_of(orbits, UNBOUNDED)
        if status != COMPLETE:
            return FAILED
        length = 0.0
        for i in range(size):
            length += deviations.states[0, i] ** 2
        length = math.sqrt(length)
        logarithms[now] = math.log(length)
        for i in range(size):
            deviations.states[0, i] /= length
        copy_into(kept[now % _KEPT], state)
        copy_into(sections[now], state)
        slot = recognised(system, orbits, before, state, entry, returns, work)
        if slot < 0:
            slot = _within_sample(system, orbits, state, hits, now)
        if slot >= 0:
            return slot
        if now >= _KEPT and not np.any(returns > 0):
            _returned(system, orbits, kept, now % _KEPT, now, tries, limits)
        if now + 1 == limits.watched or (now + 1) % 200 == 0 and now + 1 >= 400:
            mean, error = _batch_means(logarithms, now + 1)
            sample = _sample(sections, now + 1)
            if mean - 4.0 * error > limits.floor:
                return keep_aperiodic(system, orbits, CHAOTIC, sample, mean, error)
            if now + 1 == limits.watched and abs(mean) <= max(limits.floor, 4.0 * error):
                for period in (1, 2):
                    try_orbit(system, orbits, state, period, limits.ceiling, math.inf)
                if not _approaching(system, orbits, sections):
                    return keep_aperiodic(system, orbits, QUASI_PERIODIC, sample, mean, error)
    return _slot_of(orbits, UNSETTLED)


@kernel(MATRIX(MATRIX, _I), inner=True)
def _sample(sections, count):
    """Sections (128, m) spread over the later ones of `count`, so that slow turns of a torus are seen whole."""
    sample = np.empty((SAMPLE, sections.shape[1]))
    # An odd stride other than the periods that are common.
    stride = 7 if count > 7 * SAMPLE else 3
    for i in range(SAMPLE):
        copy_into(sample[i], sections[count - 1 - stride * i])
    return sample


@kernel(_B(SWITCHED_SYSTEM, ORBITS, MATRIX), inner=True)
def _approaching(system, orbits, sections):
    """Whether a motion comes nearer to a stable orbit, at least half as fast as the multipliers promise.

    A growth so close to 0 looks like that of a torus; the largest distance over many sections does not feel where in
    its slow beat the motion happens to be.
    """
    count = sections.shape[0]
    for slot in range(orbits.count[0]):
        if orbits.kind[slot] > HIGHEST_PERIOD or orbits.kind[slot] < 1:
            continue
        early, late = 0.0, 0.0
        for i in range(2 * SAMPLE):
            at = i if i < SAMPLE else count - 2 * SAMPLE + i
            least = math.inf
            for j in range(orbits.kind[slot]):
                least = min(least, distance(system, orbits.points[slot, j], sections[at]))
            if i < SAMPLE:
                early = max(early, least)
            else:
                late = max(late, least)
        if late < early * math.exp(0.5 * orbits.rates[slot, 0] * (count - SAMPLE)):
            return True
    return False


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


@kernel(_I(SWITCHED_SYSTEM, ORBITS, _I, MATRIX, _F, _F), inner=True)
def keep_aperiodic(system, orbits, kind, sample, rate, error):
    """The slot of an aperiodic attractor, which becomes known if it was not; NO_ROOM if there is none left."""
    for slot in range(orbits.count[0]):
        if orbits.kind[slot] == kind:
            near = 0
            for i in range(sample.shape[0]):
                if _nearest(system, orbits.samples[slot], sample[i], -1) <= orbits.spacing[slot]:
                    near += 1
            if _LOOKED * near >= _WITHIN * sample.shape[0]:
                return slot
    slot = orbits.count[0]
    if slot == orbits.kind.shape[0]:
        return NO_ROOM
    gaps = np.empty(sample.shape[0])
    for i in range(sample.shape[0]):
        copy_into(orbits.samples[slot, i], sample[i])
        gaps[i] = _nearest(system, sample, sample[i], i)
    gaps.sort()
    # Nine of ten sections have another within this distance; twice of it leaves room for the thin parts of the set.
    orbits.spacing[slot] = 2.0 * gaps[(9 * sample.shape[0]) // 10]
    orbits.kind[slot], orbits.rates[slot, 0], orbits.rates[slot, 1] = kind, rate, error
    copy_into(orbits.points[slot, 0], sample[0])
    orbits.count[0] += 1
    return slot


@kernel(types.void(SWITCHED_SYSTEM, ORBITS, MATRIX, LIMITS, _COUNTS), inner=True)
def settle_states(system, orbits, states, limits, slots):
    """Follow motions until it is known where they settle.

    Parameters
    ----------
    system : SwitchedSystem
    orbits : Orbits
        What is found becomes known.
    states : (k, m) array
        On the section; overwritten.
    limits : Limits
    slots : (k,) int array
        Slot that each motion ends in, or FAILED or NO_ROOM.
    """
    size, room = states.shape[1], orbits.kind.shape[0]
    deviations, series, nothing = new_deviations(np.empty((0, size))), new_series(size // 2), watch_nothing()
    entry, returns, work = np.empty(room), np.empty(room, np.int64), np.empty((3, size))
    hits, tries = np.empty((room, _LOOKED), np.int64), np.empty(2 * HIGHEST_PERIOD + 2, np.int64)
    before, kept = np.empty(size), np.empty((_KEPT, size))
    for motion in range(states.shape[0]):
        state, slot, now = states[motion], -1, 0
        returns[:] = 0
        hits[:, :] = 0
        _may_try(tries)
        while slot == -1 and now < limits.transient:
            copy_into(before, state)
            status = carry_over_period(
                system, state, deviations, limits.tolerance, limits.ceiling, 0.0, nothing, series
            )
            if status != COMPLETE:
                slot = _slot_of(orbits, UNBOUNDED) if status == CEILING else FAILED
                break
            copy_into(kept[now % _KEPT], state)
            slot = recognised(system, orbits, before, state, entry, returns, work)
            if slot < 0 and now >= _SETTLED:
                slot = _within_sample(system, orbits, state, hits, now)
            if slot < 0 and now >= _KEPT and not np.any(returns > 0):
                _returned(system, orbits, kept, now % _KEPT, now, tries, limits)
            now += 1
        slots[motion] = _watch(system, orbits, state, limits) if slot == -1 else slot
