"""Branches cut at their events: segments along which stability and impact state are constant."""

from dataclasses import dataclass

import numpy as np

from solver import Event, domain_code
from solver.contact.impact import impact_of_range

__all__ = ["BranchSegment", "labels_at", "segments_of_row"]

_TURNS = (Event.FOLD, Event.BRANCH_POINT)


@dataclass(frozen=True)
class BranchSegment:
    """Points `start` ... `stop` - 1 of a row; neighbouring segments share the event point between them.

    Between folds a branch is monotonic in the swept parameter, so that a stable segment is exactly one stable solution
    at every value from `low` to `high`.
    """

    start: int
    stop: int
    low: float
    high: float
    stable: bool
    impact: int

    @property
    def slice(self) -> slice:
        """For the row's point arrays."""
        return slice(self.start, self.stop)


def segments_of_row(points: dict[str, np.ndarray], back: np.ndarray, front: np.ndarray) -> list[BranchSegment]:
    """Cut the branches of one row.

    Parameters
    ----------
    points : dict
        Name -> (point,) array: position, mean, amplitude, stable, impact, branch, event.
    back, front : (point,) arrays
        Ends of the gap at every point, -b and b of a bevel pair.

    Returns
    -------
    list of BranchSegment
        In the order of the points.
    """
    position, event, branch = points["position"], points["event"], points["branch"]
    first, last = (np.flatnonzero(np.diff(branch, **{side: -1})) for side in ("prepend", "append"))
    bounds = np.unique(np.concatenate([first, np.flatnonzero(event != Event.NONE), last]))
    segments = []
    for start, end in zip(bounds[:-1].tolist(), bounds[1:].tolist(), strict=True):
        if branch[start] != branch[end]:
            continue
        # The state of an event point is the boundary's; a segment takes its own from a regular point of it.
        inside = next((i for i in (start + 1, start, end) if i <= end and event[i] == Event.NONE), None)
        if inside is not None:
            stable, impact = bool(points["stable"][inside]), int(points["impact"][inside])
        else:
            stable, impact = _stable_between(points, start), _impact_between(points, back, front, start)
        low, high = sorted((float(position[start]), float(position[end])))
        segments.append(BranchSegment(start, end + 1, low, high, stable, impact))
    return segments


def _stable_between(points: dict[str, np.ndarray], start: int) -> bool:
    """Stability between two neighbouring event points: that of the nearest regular point, turned over at every fold."""
    event, branch = points["event"], points["branch"]
    regular = np.flatnonzero((event == Event.NONE) & (branch == branch[start]))
    if regular.size == 0:
        return False
    nearest = regular[np.argmin(np.abs(regular - start - 0.5))]
    turns = np.cumsum(np.isin(event, _TURNS))
    return bool(points["stable"][nearest]) != bool((turns[nearest] - turns[start]) % 2)


def _impact_between(points: dict[str, np.ndarray], back: np.ndarray, front: np.ndarray, start: int) -> int:
    """Impact state half-way between two neighbouring event points."""
    mean, amplitude, low, high = (
        0.5 * (array[start] + array[start + 1]) for array in (points["mean"], points["amplitude"], back, front)
    )
    return int(impact_of_range(mean - amplitude, mean + amplitude, low, high))


def labels_at(segments: list[list[BranchSegment]], positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Codes of the n/I labels at any positions on the sweep axis, not only the stored ones.

    Nothing is solved or interpolated: events are located exactly, so that a segment covers a position or does not.

    Parameters
    ----------
    segments : list of list of BranchSegment
        Per row.
    positions : (k,) array
        Ascending.

    Returns
    -------
    code : (P, k) uint16 array
    n : (P, k) uint8 array
        Number of stable solutions.
    """
    n = np.zeros((len(segments), positions.size), dtype=np.uint8)
    states = np.zeros(n.shape, dtype=np.uint8)
    for row, row_segments in enumerate(segments):
        for segment in row_segments:
            if segment.stable:
                here = slice(*np.searchsorted(positions, (segment.low, segment.high)))
                n[row, here] += 1
                states[row, here] |= 1 << segment.impact
    return domain_code(n, states), n
