"""How far the map's label can be trusted, cell by cell.

The truth of a cell is first taken from the order-2H balance, where it agrees with order H: then more harmonics would
not change it. Where it does not, nothing is known unless integration has looked. In this order, the later winning:

- same label as the map's: confirmed. Another label: shifted if the map's label occurs at order 2H within delta, else
  wrong count if the number n differs, wrong impact state if only the states do.
- integration from all the solutions that the label counts, each period-1: where the orders are silent, or agree with
  the map's n, it decides about the impact states: all confirmed, or the label with the states that were seen is the
  truth (shifted if that label occurs at order 2H within delta). A start that settles on another period-1 motion tells
  that a solution is wrong only where the orders are silent: it may merely lie in another basin than the true motion.
- not a period-1 motion: one of the solutions counted is dynamically unstable at order 2H, or integration from one
  ended on another kind of motion.

Distances are largest differences on the two axes, each measured in lengths of its axis.
"""

import enum
from dataclasses import dataclass

import numpy as np

from pipeline.analysis.verification.verdicts import Verdict
from solver import domain_code, domain_parts

__all__ = ["Credibility", "Samples", "credibility", "reach"]


class Credibility(enum.IntEnum):
    """What order H, order 2H and integration say about a label of the map."""

    UNCHECKED = 0
    CONFIRMED = 1
    SHIFTED = 2
    WRONG_COUNT = 3
    WRONG_IMPACT_STATE = 4
    NOT_PERIOD_1_MOTION = 5

    @property
    def words(self) -> str:
        """How it is called in figures and tables."""
        return _WORDS[self]


_WORDS = {
    Credibility.UNCHECKED: "unchecked",
    Credibility.CONFIRMED: "confirmed",
    Credibility.SHIFTED: "shifted",
    Credibility.WRONG_COUNT: "wrong count",
    Credibility.WRONG_IMPACT_STATE: "wrong impact state",
    Credibility.NOT_PERIOD_1_MOTION: "not a period-1 motion",
}


@dataclass(frozen=True)
class Samples:
    """What integration saw, one entry per solution; all stable solutions of a cell are there.

    Parameters
    ----------
    row, column : (k,) int arrays
    verdict : (k,) int array
        `Verdict`.
    impact : (k,) int array
        `ImpactState` that was seen, -1 if none.
    """

    row: np.ndarray
    column: np.ndarray
    verdict: np.ndarray
    impact: np.ndarray


def reach(shape: tuple[int, int], delta: float) -> tuple[int, int]:
    """How many rows and columns away is within delta."""
    rows, columns = (int(np.floor(delta * (size - 1) + 1e-9)) for size in shape)
    return rows, columns


def credibility(
    domain: np.ndarray, low: np.ndarray, high: np.ndarray, unstable: np.ndarray, samples: Samples, delta: float
) -> np.ndarray:
    """Judge every cell.

    Parameters
    ----------
    domain, low, high : (P, X) arrays
        Codes of the labels of the map and at orders H and 2H; 0 where there is none.
    unstable : (P, X) int array
        1 where a solution counted by the map's label is dynamically unstable.
    samples : Samples
    delta : float

    Returns
    -------
    (P, X) int8 array of `Credibility`
    """
    computed = domain != 0
    known = computed & (low == high) & (high != 0)
    nearby = _Nearby(high, reach(domain.shape, delta))
    result = np.full(domain.shape, int(Credibility.UNCHECKED), dtype=np.int8)
    n, theirs = domain_parts(domain)[0], domain_parts(high)[0]
    result[known] = np.where(n == theirs, int(Credibility.WRONG_IMPACT_STATE), int(Credibility.WRONG_COUNT))[known]
    for code in np.unique(domain[known & (domain != high)]):
        result[known & (domain == code) & nearby.occurs(int(code))] = Credibility.SHIFTED
    result[known & (domain == high)] = Credibility.CONFIRMED
    result[computed & (unstable == 1)] = Credibility.NOT_PERIOD_1_MOTION

    cells = samples.row.astype(np.int64) * domain.shape[1] + samples.column
    for cell in np.unique(cells):
        place, here = np.unravel_index(cell, domain.shape), cells == cell
        silent, agrees = not known[place], known[place] and n[place] == theirs[place]
        said = _judge(int(domain[place]), samples.verdict[here], samples.impact[here], silent, agrees, nearby, place)
        if said is not None and result[place] != Credibility.NOT_PERIOD_1_MOTION:
            result[place] = said
    return result


def _judge(code: int, verdicts, impacts, silent: bool, agrees: bool, nearby: "_Nearby", place) -> Credibility | None:
    """What integration decides about one cell; None where it decides nothing."""
    present = set(verdicts.tolist())
    if present & {Verdict.NOT_PERIOD_1, Verdict.UNBOUNDED}:
        return Credibility.NOT_PERIOD_1_MOTION
    if present & {Verdict.UNSETTLED, Verdict.FAILED} or not (silent or agrees):
        return None
    if Verdict.OTHER_MOTION in present:
        return Credibility.WRONG_COUNT if silent else None
    if Verdict.WRONG_IMPACT not in present:
        return Credibility.CONFIRMED
    n, mask = domain_parts(code)
    seen = int(np.bitwise_or.reduce(1 << impacts.astype(np.int64)))
    if seen == int(mask):
        # Two wrong states may still make up the right set.
        return Credibility.CONFIRMED
    return Credibility.SHIFTED if nearby.occurs(int(domain_code(n, seen)))[place] else Credibility.WRONG_IMPACT_STATE


class _Nearby:
    """Where a label occurs within some rows and columns."""

    def __init__(self, labels: np.ndarray, within: tuple[int, int]):
        self._labels, self._within = labels, within
        self._known: dict[int, np.ndarray] = {}

    def occurs(self, code: int) -> np.ndarray:
        """(P, X) bool."""
        if code not in self._known:
            found = self._labels == code
            for axis, steps in enumerate(self._within):
                found = _spread(found, axis, steps)
            self._known[code] = found
        return self._known[code]


def _spread(flags: np.ndarray, axis: int, steps: int) -> np.ndarray:
    """True where a flag is set within `steps` along one axis."""
    count = np.cumsum(flags, axis=axis, dtype=np.int64)
    count = np.concatenate([np.zeros_like(np.take(count, [0], axis)), count], axis=axis)
    size = flags.shape[axis]
    first, stop = np.arange(size) - steps, np.arange(size) + steps + 1
    return np.take(count, stop.clip(0, size), axis) > np.take(count, first.clip(0, size), axis)
