"""How far the map's label n/I can be trusted, cell by cell, by the attractors of the cell itself.

First every stable motion that the label counts is given an attractor that repeats after the map's period, in the same
impact state: the one whose mean and amplitude agree within a tolerance, else the one that the motion leads to, else any
that is left. No two motions have the same one. Then the motion is *there*. If only attractors in other impact states
are left for it, it is there *in another impact state*, unless it leads to what does not repeat. If none is left, where
the motion leads to decides: to an attractor that does not repeat after the map's period (2T, a torus, chaos,
unbounded), to one that another motion has, or it is not settled and nothing is known. A label does not tell amplitudes:
how far these are off is the `deviation` of a cell. Then, the first that holds:

| what was found | credibility |
| --- | --- |
| no label, or the row failed | unchecked |
| a motion is not there and leads to what does not repeat | not a period-1 motion |
| a motion is not there and leads to what another motion has | wrong count |
| the label counts none, and there is a period-1 attractor | wrong count |
| a motion is there in another impact state | wrong impact state |
| of a motion nothing is known | unchecked |
| all are there, and another attractor, or an unbounded motion, or more than there is room for | more motions exist |
| all are there, but a start did not settle or could not be integrated; or nothing was found | unchecked |
| all are there, and nothing else was found | confirmed |

A wrong count, a wrong impact state and more motions become *shifted* where everything that was found repeats after the
map's period, so that the true label is known, and both labels change sides within `delta`: the map's label is the true
one of some cell at most so far away on either axis, and the true label is the map's of such a cell.
"""

import enum
import itertools
from dataclasses import dataclass

import numpy as np

from solver import domain_code
from solver.timedomain import AttractorKind

__all__ = ["Cells", "Credibility", "judge", "partners", "reach"]


class Credibility(enum.IntEnum):
    """What attractors say about the label of a cell."""

    UNCHECKED = 0
    CONFIRMED = 1
    MORE_MOTIONS_EXIST = 2
    WRONG_IMPACT_STATE = 3
    WRONG_COUNT = 4
    NOT_A_PERIOD_1_MOTION = 5
    SHIFTED = 6

    @property
    def words(self) -> str:
        """How it is called in figures and tables."""
        return self.name.lower().replace("_", " ").replace("period 1", "period-1")


@dataclass(frozen=True, eq=False)
class Cells:
    """What is known of the cells of a plane: P rows, X columns, S motions of the map, A attractors.

    Parameters
    ----------
    label : (P, X) int array
        Code of the map's label; 0 for none.
    stable : (P, X, S) bool array
        The motions that the label counts.
    mean, amplitude : (P, X, S) arrays
    impact : (P, X, S) int array
        Of the map's motions.
    leads : (P, X, S) int array
        Attractor that each leads to; -1 where it is not known.
    kind, found_impact : (P, X, A) int arrays
        Of the attractors.
    found_mean, found_amplitude : (P, X, A) arrays
    size : (P, X) array
        Gap and static deflection.
    unresolved : (P, X) bool array
        Where a start could not be integrated.
    overflow : (P, X) bool array
        Where there are more attractors than could be told apart.
    failed : (P, X) bool array
        Where nothing is known.
    period : int
        Forcing periods after which the map's motions repeat.
    """

    label: np.ndarray
    stable: np.ndarray
    mean: np.ndarray
    amplitude: np.ndarray
    impact: np.ndarray
    leads: np.ndarray
    kind: np.ndarray
    found_impact: np.ndarray
    found_mean: np.ndarray
    found_amplitude: np.ndarray
    size: np.ndarray
    unresolved: np.ndarray
    overflow: np.ndarray
    failed: np.ndarray
    period: int = 1

    @property
    def settled(self) -> np.ndarray:
        """Attractors and unbounded motions, (P, X, A) bool."""
        return (self.kind > AttractorKind.NONE) & (self.kind < AttractorKind.UNSETTLED)

    @property
    def repeats(self) -> np.ndarray:
        """Attractors that repeat after the map's period, (P, X, A) bool."""
        periodic = (self.kind >= AttractorKind.PERIOD_1) & (self.kind <= AttractorKind.PERIOD_8)
        return periodic & (self.period % np.where(periodic, self.kind, 1) == 0)

    @property
    def doubtful(self) -> np.ndarray:
        """Where something did not come to an end, (P, X) bool."""
        return self.unresolved | np.any(self.kind == AttractorKind.UNSETTLED, axis=-1)

    @property
    def true_label(self) -> np.ndarray:
        """Code of the label that the attractors have; 0 where it is not known or they have none."""
        n = np.sum(self.repeats, axis=-1)
        states = np.where(self.repeats, 1 << self.found_impact.astype(np.int64).clip(0), 0)
        known = ~self.failed & ~self.doubtful & ~self.overflow & np.all(self.settled == self.repeats, axis=-1) & (n > 0)
        return np.where(known, domain_code(n, np.bitwise_or.reduce(states, axis=-1)), 0)


def judge(cells: Cells, tolerance: float, within: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Judge every cell.

    Parameters
    ----------
    cells : Cells
    tolerance : float
        How far mean and amplitude may be off for a motion to be known again, as a share of `cells.size`.
    within : (int, int)
        Rows and columns within which a label may be shifted; see `reach`.

    Returns
    -------
    credibility : (P, X) int8 array
        `Credibility`.
    deviation : (P, X) array
        By how much mean or amplitude of a motion is off at most, as a share of `cells.size`; nan unless all are there.
    """
    there, other_state, claimed, off, _ = _matched(cells, tolerance)
    missing = cells.stable & ~there & ~other_state
    end = np.take_along_axis(cells.kind, cells.leads.clip(0).astype(np.int64), axis=-1)
    unknown = missing & ((cells.leads < 0) | (end == AttractorKind.NONE) | (end == AttractorKind.UNSETTLED))
    end_repeats = np.take_along_axis(cells.repeats, cells.leads.clip(0).astype(np.int64), axis=-1)
    no_label = (cells.label == 0) | cells.failed
    none_stable = ~np.any(cells.stable, axis=-1)
    further = np.any(cells.settled & ~claimed, axis=-1) | cells.overflow
    verdicts = (
        (no_label, Credibility.UNCHECKED),
        (np.any(missing & ~unknown & ~end_repeats, axis=-1), Credibility.NOT_A_PERIOD_1_MOTION),
        (
            np.any(missing & ~unknown & end_repeats, axis=-1) | (none_stable & np.any(cells.repeats, axis=-1)),
            Credibility.WRONG_COUNT,
        ),
        (np.any(other_state, axis=-1), Credibility.WRONG_IMPACT_STATE),
        (np.any(unknown, axis=-1), Credibility.UNCHECKED),
        (further, Credibility.MORE_MOTIONS_EXIST),
        (cells.doubtful | none_stable, Credibility.UNCHECKED),
    )
    result = np.select(*zip(*verdicts, strict=True), default=Credibility.CONFIRMED).astype(np.int8)
    true = cells.true_label
    near = _near(cells.label, true, within) & _near(true, cells.label, within)
    wrong = (Credibility.WRONG_COUNT, Credibility.WRONG_IMPACT_STATE, Credibility.MORE_MOTIONS_EXIST)
    result[np.isin(result, wrong) & (true != 0) & (true != cells.label) & near] = Credibility.SHIFTED
    known = ~no_label & ~none_stable & ~np.any(missing, axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return result, np.where(known, np.max(off, axis=-1) / cells.size, np.nan)


def partners(cells: Cells, tolerance: float) -> np.ndarray:
    """The attractor that every motion is, in the same impact state or another, (P, X, S); -1 where it is none."""
    return _matched(cells, tolerance)[-1]


def _matched(cells: Cells, tolerance: float) -> tuple[np.ndarray, ...]:
    """Motions (P, X, S) that are among the attractors, those that differ in the impact state alone, the attractors
    (P, X, A) that they are, how far (P, X, S) mean or amplitude is off, and which attractor (P, X, S) each is."""
    claimed = np.zeros(cells.kind.shape, bool)
    there, other_state = np.zeros(cells.stable.shape, bool), np.zeros(cells.stable.shape, bool)
    apart, room = np.zeros(cells.stable.shape), tolerance * cells.size[..., None]
    partner = np.full(cells.stable.shape, -1)
    slots = np.arange(cells.kind.shape[-1])
    # What leads to an attractor of another kind is not taken for one in another impact state.
    end = cells.leads.clip(0).astype(np.int64)
    elsewhere = (cells.leads >= 0) & np.take_along_axis(cells.settled & ~cells.repeats, end, axis=-1)
    known_again = itertools.product((there, other_state), ("near", "led to"))
    for found, how in (*known_again, (there, "left"), (other_state, "left")):
        for s in range(cells.stable.shape[-1]):
            open_ = cells.stable[..., s] & ~there[..., s] & ~other_state[..., s]
            if found is other_state:
                open_ &= ~elsewhere[..., s]
            if not np.any(open_):
                continue
            mean, amplitude, impact = (array[..., s, None] for array in (cells.mean, cells.amplitude, cells.impact))
            leads = slots == cells.leads[..., s, None]
            with np.errstate(invalid="ignore"):
                off = np.maximum(np.abs(cells.found_mean - mean), np.abs(cells.found_amplitude - amplitude))
                alike = {"near": off <= room, "led to": leads, "left": True}[how]
            alike = alike & cells.repeats & ~claimed & open_[..., None]
            alike &= (cells.found_impact == impact) == (found is there)
            # The one that it leads to, where several are like it, else the nearest.
            rank = np.where(alike, np.where(leads, -1.0, off), np.inf)
            best = np.argmin(rank, axis=-1)[..., None]
            hit = np.take_along_axis(alike, best, axis=-1)
            np.put_along_axis(claimed, best, np.take_along_axis(claimed, best, axis=-1) | hit, axis=-1)
            found[..., s] |= hit[..., 0]
            partner[..., s] = np.where(hit, best, partner[..., s, None])[..., 0]
            apart[..., s] = np.where(hit, np.take_along_axis(off, best, axis=-1), apart[..., s, None])[..., 0]
    return there, other_state, claimed, apart, partner


def reach(rows: np.ndarray, columns: np.ndarray, lengths: tuple[float, float], delta: float) -> tuple[int, int]:
    """How many rows and columns away is within `delta` of the lengths of both axes, for evenly spaced values."""

    def steps(values: np.ndarray, length: float) -> int:
        return int(np.floor(delta * length / np.max(np.diff(values)) + 1e-9)) if values.size > 1 else 0

    return steps(rows, lengths[0]), steps(columns, lengths[1])


def _near(labels: np.ndarray, others: np.ndarray, within: tuple[int, int]) -> np.ndarray:
    """Where the label of a cell occurs among the `others` within some rows and columns, (P, X) bool."""
    result = np.zeros(labels.shape, bool)
    for code in np.unique(labels[labels != 0]):
        found = others == code
        for axis, steps in enumerate(within):
            found = _spread(found, axis, steps)
        result |= found & (labels == code)
    return result


def _spread(flags: np.ndarray, axis: int, steps: int) -> np.ndarray:
    """True where a flag is set within `steps` along one axis."""
    count = np.cumsum(flags, axis=axis, dtype=np.int64)
    count = np.concatenate([np.zeros_like(np.take(count, [0], axis)), count], axis=axis)
    size = flags.shape[axis]
    first, stop = np.arange(size) - steps, np.arange(size) + steps + 1
    return np.take(count, stop.clip(0, size), axis) > np.take(count, first.clip(0, size), axis)
