"""Labels at any points of the plane, from the stored rows and the boundary curves between them; nothing is solved.

In a stored row the pieces of its branches say exactly which motions are stable at any place. From the row upwards, at a
fixed place on the sweep axis, the set of stable motions changes only where the line crosses a boundary: at a fold a
stable motion comes or goes, at a grazing one changes its impact state, and the stored side of the curve says which way.
The walk must arrive at the next stored row with the set found there; where it does not (a branch that leaves through
the amplitude ceiling, a boundary that could not be followed) the nearer row is taken: only there a cell's blur remains.
"""

import numpy as np

from pipeline.analysis.boundaries.events import MARGINS, half_backlash
from pipeline.plan.plan import Plan
from pipeline.plane.boundaries import StoredBoundaries, StoredCurve
from pipeline.plane.stored import StoredPlane
from solver import Event, domain_code, impact_state
from solver.boundaries import FOLDS_AND_GRAZINGS

__all__ = ["region_codes"]

#: A set of stable motions is one integer: for every impact state the number of motions, in this many bits.
_BITS = 8
_STATES = 6


def region_codes(plane: StoredPlane, x: np.ndarray, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Codes of the n/I labels on a lattice.

    Parameters
    ----------
    plane : StoredPlane
        With boundaries.
    x, p : ascending arrays
        Places on the sweep axis and on the parameter axis.

    Returns
    -------
    code : (p, x) uint16 array
        0 where the nearest row is not complete.
    bridged : (p, x) bool array
        Whether the label was reached without contradiction; the nearest row's label elsewhere.
    """
    complete = np.flatnonzero(plane.complete)
    if complete.size == 0:
        return np.zeros((p.size, x.size), np.uint16), np.zeros((p.size, x.size), bool)
    first = max(np.searchsorted(plane.rows[complete], p[0], side="right") - 1, 0)
    last = np.searchsorted(plane.rows[complete], p[-1], side="left")
    rows = complete[first : last + 1]
    values = plane.rows[rows]
    stored = np.stack([_stored_sets(plane, row, x) for row in rows])
    at_rows, at_points = _changes(plane.boundaries, plane.plan, x, values, p)

    arrives = np.ones((rows.size, x.size), dtype=bool)
    arrives[:-1] = stored[:-1] + at_rows[1:] - at_rows[:-1] == stored[1:]
    below = (np.searchsorted(values, p, side="right") - 1).clip(0)
    sets = stored[below] + at_points - at_rows[below]
    bridged = arrives[below]
    nearest = np.abs(values[:, None] - p).argmin(axis=0)
    sets = np.where(bridged, sets, stored[nearest])
    code, possible = _codes(sets)
    if not np.all(possible):
        code, bridged = np.where(possible, code, _codes(stored[nearest])[0]), bridged & possible
    absent = ~plane.complete[np.abs(plane.rows[:, None] - p).argmin(axis=0)]
    code[absent] = 0
    return code, bridged & ~absent[:, None]


def _stored_sets(plane: StoredPlane, row: int, x: np.ndarray) -> np.ndarray:
    """The set of stable motions of a row at places x."""
    sets = np.zeros(x.size, dtype=np.int64)
    for piece in plane.pieces[row]:
        if piece.stable:
            sets[slice(*np.searchsorted(x, (piece.low, piece.high)))] += 1 << _BITS * piece.impact
    return sets


def _changes(boundaries: StoredBoundaries, plan: Plan, x: np.ndarray, *levels: np.ndarray) -> list[np.ndarray]:
    """What all crossings below each level add to the set of stable motions, (level, x) for every array of levels."""
    line, place, change = (
        np.concatenate(parts)
        for parts in zip(*(_upward(curve, plan, x) for curve in boundaries.curves), _NOTHING, strict=False)
    )
    results = []
    for ascending in levels:
        added = np.zeros((ascending.size + 1, x.size), dtype=np.int64)
        np.add.at(added, (np.searchsorted(ascending, place, side="left"), line), change)
        results.append(np.cumsum(added[:-1], axis=0))
    return results


_NOTHING = (np.empty(0, np.int64), np.empty(0), np.empty(0, np.int64))


def _upward(curve: StoredCurve, plan: Plan, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where a curve crosses the lines at x: number of the line, p, and what is added to the set by going upwards."""
    if len(curve.points) < 2 or curve.kind not in FOLDS_AND_GRAZINGS:
        return _NOTHING
    crossings = curve.arcs.crossings(3, x)
    shown = curve.arc_shows[crossings.arc]
    line, points, direction = crossings.line[shown], crossings.points[shown], crossings.direction[shown]
    b = half_backlash(plan, points[:, 3], points[:, 4])
    size = np.hypot(points[:, 1], points[:, 2])
    extremes = [points[:, 0] - size, points[:, 0] + size]
    if curve.kind is Event.FOLD:
        gained = _set_of(*extremes, b)
    else:
        of_size, of_b = MARGINS[curve.kind]
        which = 0 if of_size < 0.0 else 1
        sides = []
        for beyond in (np.inf, -np.inf):
            # The extreme itself only to rounding equals what it grazes.
            extremes[which] = np.nextafter(of_b * b, beyond)
            sides.append(_set_of(*extremes, b))
        gained = sides[0] - sides[1]
    # A line upwards comes to the left side of a curve that runs towards growing x.
    return line, points[:, 4], gained * direction * curve.side


def _set_of(lowest: np.ndarray, highest: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The set that holds one motion with these extremes."""
    return np.left_shift(np.int64(1), _BITS * impact_state(lowest, highest, b).astype(np.int64))


def _codes(sets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Codes of the labels of sets, and whether these are sets: no state was taken away more often than it was there."""
    # Neighbours are mostly equal: runs of them are sorted, and not every pixel.
    flat = sets.ravel()
    starts = np.flatnonzero(np.concatenate([[True], flat[1:] != flat[:-1]]))
    present, run = np.unique(flat[starts], return_inverse=True)
    place = np.repeat(run, np.diff(starts, append=flat.size))
    counts = present[:, None] >> _BITS * np.arange(_STATES) & (1 << _BITS) - 1
    possible = (present >= 0) & np.all(counts < 1 << _BITS - 1, axis=1)
    counts[~possible] = 0
    mask = np.sum((counts > 0) << np.arange(_STATES), axis=1)
    code = domain_code(counts.sum(axis=1), mask)
    return code[place].reshape(sets.shape), possible[place].reshape(sets.shape)
