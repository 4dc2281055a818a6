"""Attractors that are known by a sample of their sections: aperiodic ones, and those of a long period."""

import math

from solver.flow.switched_system import LENGTH, SWITCHED_SYSTEM
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import copy_into
from solver.timedomain.attractor import AttractorKind
from solver.timedomain.recognition import KNOWN, SAMPLE, distance

__all__ = ["LOOKED", "fill_sample", "keep_sample", "within_sample"]

_F, _I = types.float64, types.int64
_LONGER, _CHAOTIC = int(AttractorKind.PERIOD_LONGER), int(AttractorKind.CHAOTIC)

# Sections of a motion that repeats lie in few places: this share of the length counts as near one.
_SMALLEST = 1e-3

#: Of the last sections looked at, so many must lie in the sample of an attractor.
LOOKED, _WITHIN = 48, 24


@kernel(_F(SWITCHED_SYSTEM, MATRIX, ARRAY, _I), inner=True)
def _nearest(system, sample, state, skipped):
    """Distance from a state to the nearest section of a sample, one of them left out."""
    least = math.inf
    for i in range(sample.shape[0]):
        if i != skipped:
            least = min(least, distance(system, sample[i], state))
    return least


@kernel(_I(SWITCHED_SYSTEM, KNOWN, ARRAY, types.int64[:, ::1], _I), inner=True)
def within_sample(system, known, state, hits, count):
    """Slot of the attractor in whose sample the last sections of a motion lay; -1 if there is none.

    hits (A, 48) remembers, in a ring, which of the last sections lay within; `count` sections were looked at before.
    """
    for slot in range(known.count[0]):
        if known.kind[slot] < _LONGER or known.kind[slot] > _CHAOTIC:
            continue
        near = _nearest(system, known.samples[slot], state, -1) <= known.spacing[slot]
        hits[slot, count % LOOKED] = 1 if near else 0
        total = 0
        for i in range(LOOKED):
            total += hits[slot, i]
        if total >= _WITHIN:
            return slot
    return -1


@kernel(types.void(SWITCHED_SYSTEM, KNOWN, _I, MATRIX, ARRAY), inner=True)
def fill_sample(system, known, slot, sample, gaps):
    """Fill in the sample (128, m) of an attractor, and how far apart its sections lie; gaps (128,) is overwritten."""
    for i in range(SAMPLE):
        copy_into(known.samples[slot, i], sample[i])
        gaps[i] = _nearest(system, sample, sample[i], i)
    # Nine of ten sections have another within this distance; twice of it leaves room for the thin parts of the set.
    spacing = 2.0 * _nine_tenths(gaps)
    known.spacing[slot] = max(spacing, _SMALLEST * system.numbers[LENGTH])


@kernel(_I(SWITCHED_SYSTEM, KNOWN, _I, MATRIX, _F, _F, ARRAY), inner=True)
def keep_sample(system, known, kind, sample, rate, error, gaps):
    """Slot of an attractor that is known by a sample of its sections, and becomes known if it was not.

    Parameters
    ----------
    system : SwitchedSystem
    known : Known
    kind : int
        `AttractorKind`.
    sample : (128, m) array
    rate, error : float
        Growth of a deviation in a period, and its uncertainty.
    gaps : (128,) array
        Overwritten.

    Returns
    -------
    int
        -1 where there is no slot left.
    """
    for slot in range(known.count[0]):
        if known.kind[slot] == kind:
            near = 0
            for i in range(SAMPLE):
                if _nearest(system, known.samples[slot], sample[i], -1) <= known.spacing[slot]:
                    near += 1
            if LOOKED * near >= _WITHIN * SAMPLE:
                return slot
    slot = known.count[0]
    if slot == known.kind.shape[0]:
        return -1
    fill_sample(system, known, slot, sample, gaps)
    known.kind[slot], known.rates[slot, 0], known.rates[slot, 1] = kind, rate, error
    copy_into(known.points[slot, 0], sample[0])
    known.count[0] += 1
    return slot


@kernel(_F(ARRAY), inner=True)
def _nine_tenths(values):
    """The number that a tenth of the values exceed; numpy's sort takes long to compile."""
    above = values.shape[0] // 10
    for i in range(above + 1):
        largest = i
        for k in range(i + 1, values.shape[0]):
            if values[k] > values[largest]:
                largest = k
        values[i], values[largest] = values[largest], values[i]
    return values[above]
