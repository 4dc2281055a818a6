"""Regions of a divided plane as polygons, as close to the boundary curves as is asked for."""

import itertools
from collections.abc import Callable, Sequence

import numpy as np

from solver.regions.division import DividedSlab, Division
from solver.regions.slabs import RowCrossings

__all__ = ["flattened", "region_polygons", "thinned"]

# Rows of a slab at first and at most, 2^level + 1 of them.
_LEVELS = (4, 12)
# Two arcs meet at the end of a slab if their distance falls to this share of what it is at the next row.
_MEETING = 0.1


def region_polygons(
    division: Division, detail: float, meaning: Callable[[int], int] = int
) -> dict[int, tuple[np.ndarray, ...]]:
    """Polygons that cover a divided plane without overlap, one for every part of a slab.

    Neighbours have their corners in common, so that polygons of one code, filled as one path, show no seam.

    Parameters
    ----------
    division : Division
    detail : float
        How far a polygon may be off its boundary, as a share of the axes; half of it is spent on rows that are close
        enough, half on corners that are left out.
    meaning : callable, optional
        Code of the division -> what is told apart; boundaries with the same on both sides are left out.

    Returns
    -------
    dict of int to tuple of (k, 2) arrays
        What is told apart -> corners (x, p) of its polygons, the first one not repeated at the end.
    """
    spans = np.array([np.ptp(division.plane.x_range), np.ptp(division.plane.p_range)])
    allowed = 0.5 * detail * spans
    slabs = [part.merged([meaning(code) for code in part.codes]) for part in division.slabs]
    # What slabs leave out between them belongs half to either, as in the areas.
    middles = [0.5 * (below.slab.high + above.slab.low) for below, above in itertools.pairwise(slabs)]
    ends = itertools.pairwise([division.plane.p_range[0], *middles, division.plane.p_range[1]])
    crossings = RowCrossings(division.curves, division.plane.x_range)
    found: dict[int, list[np.ndarray]] = {}
    for part, (p, x), (low, high) in zip(slabs, _sampled(crossings, slabs, allowed), ends, strict=True):
        sides = _sides(x, p, low, high, allowed)
        for code, (left, _), (_, right) in zip(part.codes, sides[:-1], sides[1:], strict=True):
            found.setdefault(code, []).append(np.concatenate([left, right[::-1]]))
    return {code: tuple(found[code]) for code in sorted(found)}


def _sampled(
    crossings: RowCrossings, slabs: Sequence[DividedSlab], allowed: np.ndarray
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Rows (v,) of every slab and x (v, arcs) of its arcs in them, dense enough for straight lines in between."""
    found: list = [None] * len(slabs)
    waiting = list(range(len(slabs)))
    for level in range(_LEVELS[0], _LEVELS[1] + 1):
        rows = [_rows(slabs[number], level) for number in waiting]
        table, start, further = crossings.table(np.concatenate([np.empty(0), *rows])), 0, []
        for number, p in zip(waiting, rows, strict=True):
            arcs, x = crossings.joined(table[start : start + p.size], p)
            start += p.size
            found[number] = p, x[:, [arcs.index(arc) for arc in slabs[number].slab.arcs]]
            if level < _LEVELS[1] and _bulge(*found[number], allowed) > 1.0:
                further.append(number)
        waiting = further
    return found


def _rows(part: DividedSlab, level: int) -> np.ndarray:
    """Rows from end to end of a slab; next to the ends, where arcs may turn round like square roots, evenly in x."""
    low, high = part.slab.inner_ends
    shares = np.sin(0.5 * np.pi * np.linspace(0.0, 1.0, 2**level + 1)) ** 2
    return low + (high - low) * shares


def _bulge(p: np.ndarray, x: np.ndarray, allowed: np.ndarray) -> float:
    """How far any arc is off the line between every second row, as a multiple of what is allowed."""
    points = np.stack([x, np.broadcast_to(p[:, None], x.shape)], axis=-1) / allowed
    return float(np.max(_off(points[1:-1:2], points[:-2:2], points[2::2])))


def _off(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Distance of points from lines between two others, (..., 2) each."""
    along, away = end - start, points - start
    length = np.hypot(along[..., 0], along[..., 1])
    across = np.abs(along[..., 0] * away[..., 1] - along[..., 1] * away[..., 0])
    return np.where(length > 0.0, across / np.where(length > 0.0, length, 1.0), np.hypot(away[..., 0], away[..., 1]))


def _sides(x: np.ndarray, p: np.ndarray, low: float, high: float, allowed: np.ndarray) -> list:
    """Every arc of a slab from `low` to `high`: as the left side of what follows it, and as the right side of what
    comes before, (k, 2) each. Where two arcs meet they end in one corner."""
    arcs = [thinned(np.column_stack([x[:, k], p]), allowed) for k in range(x.shape[1])]
    ends = []
    for inner, at, border in ((0, 1, low), (-1, -2, high)):
        gaps = np.diff(x[[inner, at]], axis=1)
        meet = gaps[0] <= _MEETING * gaps[1]
        middle = 0.5 * (x[inner, 1:] + x[inner, :-1])
        # Left and right side of every gap.
        corners = np.where(meet, middle, x[inner, :-1]), np.where(meet, middle, x[inner, 1:])
        ends.append([np.column_stack([corner, np.full(corner.size, border)]) for corner in corners])
    (left_low, right_low), (left_high, right_high) = ends
    last = len(arcs) - 1
    return [
        (
            None if k == last else np.vstack([left_low[k], arc, left_high[k]]),
            None if k == 0 else np.vstack([right_low[k - 1], arc, right_high[k - 1]]),
        )
        for k, arc in enumerate(arcs)
    ]


def flattened(controls: np.ndarray, allowed: np.ndarray) -> np.ndarray:
    """Cubic Bezier curves end to end as one line of points.

    A cubic cut evenly into n parts is off its chords by at most sqrt(3)/18 ... 3/4 max|P_i - 2 P_i+1 + P_i+2|/n^2 (the
    bound of G. Wang for degree 3).

    Parameters
    ----------
    controls : (m, 4, 2) array
        Each begins where the one before ends.
    allowed : (2,) array
        How far the line may be off the curve, along each axis.

    Returns
    -------
    (k, 2) array
    """
    scaled = controls / allowed
    bend = scaled[:, :-2] - 2.0 * scaled[:, 1:-1] + scaled[:, 2:]
    largest = np.max(np.hypot(bend[..., 0], bend[..., 1]), axis=1)
    count = np.ceil(np.sqrt(0.75 * largest)).astype(int).clip(1)
    number = np.repeat(np.arange(count.size), count)
    first = np.cumsum(count) - count
    t = ((np.arange(number.size) - first[number]) / count[number])[:, None]
    a, b, c, d = (controls[number, k] for k in range(4))
    s = 1.0 - t
    points = s**3 * a + 3.0 * s * s * t * b + 3.0 * s * t * t * c + t**3 * d
    return thinned(np.concatenate([points, controls[-1:, 3]]), allowed)


def thinned(line: np.ndarray, allowed: Sequence[float] | np.ndarray) -> np.ndarray:
    """A line without the points that it does not need (Ramer, Douglas and Peucker).

    Parameters
    ----------
    line : (k, 2) array
    allowed : (2,) array
        No point that is left out is further than this from what is left, along each axis.

    Returns
    -------
    (m, 2) array
        With both ends.
    """
    scaled = line / np.asarray(allowed)
    kept = np.zeros(len(line), dtype=bool)
    kept[[0, -1]] = True
    waiting = [(0, len(line) - 1)]
    while waiting:
        first, last = waiting.pop()
        if last - first < 2:
            continue
        off = _segment_off(scaled[first + 1 : last], scaled[first], scaled[last])
        worst = int(np.argmax(off))
        if off[worst] > 1.0:
            middle = first + 1 + worst
            kept[middle] = True
            waiting += [(first, middle), (middle, last)]
    return line[kept]


def _segment_off(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Distance of points (k, 2) from the segment between two others: a line may turn back beyond its ends."""
    along, away = end - start, points - start
    size = along @ along
    share = np.clip(away @ along / size, 0.0, 1.0) if size > 0.0 else np.zeros(len(points))
    rest = away - share[:, None] * along
    return np.hypot(rest[:, 0], rest[:, 1])
