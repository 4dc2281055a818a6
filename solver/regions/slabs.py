"""Slabs of a plane: ranges of the row parameter p within which every row meets the same boundaries in the same order.

Between two neighbouring values of p at which a boundary turns round, ends or is special, each crossing of a boundary
with a row is a function x(p): an arc. Two arcs change places only where they intersect in the (x, p) plane. Turning
points, ends and intersections together are the critical values; between them the labels along a row cannot change.
"""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from solver.boundaries.special_points import SpecialPoint
from solver.continuation.continuation import Event

__all__ = ["Arc", "LEFT", "RIGHT", "RegionError", "RowCrossings", "Slab", "SlabCurve", "slabs"]

#: An arc: number of the curve and which of its crossings with the row it is, in order along the curve.
Arc = tuple[int, int]
#: The side borders of the plane count as arcs.
LEFT, RIGHT = (-1, 0), (-1, 1)

# Relative to the ranges of p and x: critical values this close are not told apart, and arcs this close are equal.
_SAME_P = 1e-9
_SAME_X = 1e-10
# Where rows are sampled between two neighbouring turning points or ends, besides the curves' own points.
_ENDS = 10.0 ** -np.arange(1.0, 7.0)
_NODES = np.concatenate([_ENDS, 1.0 - _ENDS, np.linspace(0.1, 0.9, 17)])
_MOST_ROUNDS = 20
# How far inside of a slab, as a share of its height.
_INSIDE = 1e-6


class RegionError(ArithmeticError):
    """The regions of a plane do not follow from the boundaries given; the message says where and why."""


@dataclass(frozen=True)
class Slab:
    """Rows between two critical values.

    Parameters
    ----------
    low, high : float
        Values of p.
    arcs : tuple of Arc
        The boundaries that cross every row of the slab, by ascending x; the plane's sides are the first and the last.
    """

    low: float
    high: float
    arcs: tuple[Arc, ...]

    def rows(self, fractions) -> np.ndarray:
        """Values of p strictly inside, at fractions of the height."""
        return self.low + (self.high - self.low) * np.asarray(fractions, dtype=float)

    @property
    def inner_ends(self) -> tuple[float, float]:
        """The lowest and the highest p, moved inside a little.

        On the border some boundary turns round, ends or meets another, and the order of the crossings is not defined.
        """
        margin = _INSIDE * (self.high - self.low)
        return self.low + margin, self.high - margin


class SlabCurve(Protocol):
    """A boundary in the plane, as far as slabs ask; `solver.boundaries.BoundaryCurve` is one."""

    kind: Event

    @property
    def parameter(self) -> np.ndarray:
        """p of some of its points in order, (k,): its ends, and where it turns round in p, among them."""

    @property
    def special(self) -> np.ndarray:
        """`SpecialPoint` of these, (k,)."""

    def crossings(self, values) -> tuple[np.ndarray, np.ndarray]:
        """Where it meets ascending values of p: which value each place belongs to, (c,), and points (c, 5), in order
        along the curve."""


class RowCrossings:
    """Where rows meet the boundaries.

    Parameters
    ----------
    curves : sequence of SlabCurve
    x_range : (low, high)
        Sides of the plane; they may lie inside of the plane for which the curves were traced.
    """

    def __init__(self, curves: Sequence[SlabCurve], x_range: tuple[float, float]):
        self.curves, self.x_range = tuple(curves), x_range
        self._known: dict[float, tuple[np.ndarray, np.ndarray]] = {}

    def look_up(self, values: np.ndarray) -> None:
        """Look rows up together that `matrix` will be asked for in parts: that takes a fraction of the time."""
        values = np.unique(values)
        self._known = dict(zip(values.tolist(), self.table(values), strict=True))

    def table(self, values: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        """Arcs (k, 2) and x (k,) of every row, the sides first, then by arc.

        Parameters
        ----------
        values : (v,) array
            Ascending values of p.
        """
        row = [np.repeat(np.arange(values.size), 2)]
        arcs, x = [np.tile([LEFT, RIGHT], (values.size, 1))], [np.tile(self.x_range, values.size)]
        for number, curve in enumerate(self.curves):
            if values.size == 0 or curve.parameter.min() > values[-1] or curve.parameter.max() < values[0]:
                continue
            try:
                column, points = curve.crossings(values)
            except ArithmeticError as error:
                raise RegionError(str(error)) from error
            order = np.argsort(column, kind="stable")
            column = column[order]
            order_in_row = np.arange(column.size) - np.searchsorted(column, column)
            row.append(column)
            arcs.append(np.column_stack([np.full(column.size, number), order_in_row]))
            x.append(points[order, 3])
        row, arcs, x = np.concatenate(row), np.concatenate(arcs), np.concatenate(x)
        order = np.argsort(row, kind="stable")
        arcs, x, ends = arcs[order], x[order], np.cumsum(np.bincount(row, minlength=values.size)).tolist()
        return [(arcs[first:end], x[first:end]) for first, end in itertools.pairwise([0, *ends])]

    def matrix(self, values: np.ndarray) -> tuple[list[Arc], np.ndarray]:
        """The arcs of rows that all meet the same ones, and x (v, arcs).

        Raises
        ------
        RegionError
            If the rows do not.
        """
        known = [self._known.get(value) for value in values.tolist()]
        return self.joined(self.table(values) if None in known else known, values)

    @staticmethod
    def joined(rows, values) -> tuple[list[Arc], np.ndarray]:
        """`matrix` of rows of a `table`."""
        arcs = rows[0][0]
        if any(len(other) != len(arcs) for other, _ in rows) or np.any(np.stack([other for other, _ in rows]) != arcs):
            value = next(
                value for (other, _), value in zip(rows, values, strict=True) if not np.array_equal(arcs, other)
            )
            raise RegionError(f"the row at {value!r} is crossed by other boundaries than the one at {values[0]!r}")
        return list(map(tuple, arcs.tolist())), np.stack([x for _, x in rows])

    def x(self, arc: Arc, value: float) -> float:
        """x of one arc at one value of p."""
        if arc[0] < 0:
            return self.x_range[arc[1]]
        return float(self.curves[arc[0]].crossings([value])[1][arc[1], 3])


def slabs(
    crossings: RowCrossings, p_range: tuple[float, float], extra: Sequence[float] = (), levels: Sequence[float] = ()
) -> tuple[Slab, ...]:
    """The slabs of a plane, ascending.

    Parameters
    ----------
    crossings : RowCrossings
    p_range : (low, high)
    extra : sequence of float
        Rows next to which arcs are looked at more closely.
    levels : sequence of float
        More critical values: rows along which a boundary runs.

    Raises
    ------
    RegionError
        If rows between two critical values meet different boundaries.
    """
    height = p_range[1] - p_range[0]
    turning = np.unique(np.clip(np.concatenate([p_range, levels, *map(_turning_points, crossings.curves)]), *p_range))
    ranges = _between(turning, _SAME_P * height)
    extra = np.array(extra, dtype=float)
    for _ in range(_MOST_ROUNDS):
        critical = [turning]
        samples = [_samples(crossings.curves, low, high, extra) for low, high in ranges]
        table = crossings.table(np.concatenate(samples) if samples else np.empty(0))
        start = 0
        for values in samples:
            critical.append(_intersections(crossings, values, table[start : start + values.size]))
            start += values.size
        parts = _between(np.unique(np.concatenate(critical)), _SAME_P * height)
        found, extra_here = _ordered(crossings, parts)
        if not extra_here:
            return found
        # Two arcs intersect twice between two samples: look there as well.
        extra = np.unique(np.concatenate([extra, extra_here]))
    raise RegionError(f"the boundaries intersect too often near {extra[-1]!r}")


def _turning_points(curve: SlabCurve) -> np.ndarray:
    """p where a curve turns round in p, ends, or is special."""
    p = curve.parameter
    sense = np.sign(np.diff(p))
    moving = np.flatnonzero(sense)
    turns = moving[1:][sense[moving[1:]] != sense[moving[:-1]]]
    marked = (curve.special != SpecialPoint.NONE).copy()
    marked[[0, -1]] = True
    marked[turns] = True
    return p[marked]


def _between(critical: np.ndarray, same: float) -> list[tuple[float, float]]:
    """The ranges between critical values, without those too narrow to be told apart."""
    return [(float(a), float(b)) for a, b in zip(critical[:-1], critical[1:], strict=True) if b - a > same]


def _samples(curves, low: float, high: float, extra: np.ndarray) -> np.ndarray:
    """Ascending rows between two turning points: the curves' own points, as dense as the curves are bent, and more."""
    values = np.concatenate([*(curve.parameter for curve in curves), extra])
    inside = low + (high - low) * _NODES
    values = np.concatenate([values[(values > inside[5]) & (values < inside[11])], inside])
    values.sort()
    return values[np.append(True, np.diff(values) > 1e-7 * (high - low))]


def _intersections(crossings: RowCrossings, values: np.ndarray, table) -> np.ndarray:
    """p at which any two arcs intersect, refined."""
    arcs, x = crossings.joined(table, values)
    floor = _SAME_X * (crossings.x_range[1] - crossings.x_range[0])
    first, second = np.triu_indices(len(arcs), 1)
    # The sides of the plane do not intersect.
    first, second = first[second > 1], second[second > 1]
    gaps, heights = x[:, first] - x[:, second], []
    for pair in np.flatnonzero(_may_vanish(values, gaps, floor)):

        def distance(value, arc=arcs[first[pair]], other=arcs[second[pair]]):
            return crossings.x(arc, value) - crossings.x(other, value)

        heights.extend(_zeros(values, gaps[:, pair], distance, floor))
    return np.array(heights)


def _may_vanish(values: np.ndarray, gaps: np.ndarray, floor: float) -> np.ndarray:
    """Which of some functions (v, k), known at samples, `_zeros` must look at, (k,) bool."""
    unclear = np.any(np.abs(gaps) <= floor, axis=0) | np.any(gaps * gaps[:1] < 0.0, axis=0)
    return unclear | np.any(_dips(values, gaps), axis=0)


def _zeros(values: np.ndarray, gap: np.ndarray, distance: Callable[[float], float], floor: float) -> list[float]:
    """Zeros of a function known at samples; touching ones and what is below the floor do not count."""
    kept = np.flatnonzero(np.abs(gap) > floor)
    if kept.size < 2:
        return []
    # scipy.optimize takes 0.3 s to import, which every worker would pay.
    from scipy.optimize import brentq, minimize_scalar

    at, size = values[kept], gap[kept]
    brackets = [(at[k], at[k + 1]) for k in np.flatnonzero(size[1:] * size[:-1] < 0.0)]
    for k in np.flatnonzero(_dips(at, size[:, None])[:, 0]) + 1:
        sign = np.sign(size[k])
        low = minimize_scalar(lambda p, sign=sign: sign * distance(p), bounds=(at[k - 1], at[k + 1]), method="bounded")
        if low.fun < -floor:
            brackets += [(at[k - 1], low.x), (low.x, at[k + 1])]
    return [brentq(distance, low, high, xtol=1e-14, rtol=1e-14) for low, high in brackets]


def _dips(at: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Between which samples functions (v, k) may have two zeros, (v - 2, k) bool: the parabola through three falls to
    half the middle one."""
    left, middle, right = size[:-2], size[1:-1], size[2:]
    sign = np.sign(middle)
    lowest = (sign * left >= sign * middle) & (sign * right >= sign * middle)
    before, after = (np.diff(at)[:-1, None], np.diff(at)[1:, None])
    fall, rise = sign * (middle - left) / before, sign * (right - middle) / after
    slope, bend = (fall * after + rise * before) / (before + after), (rise - fall) / (before + after)
    deep = slope**2 >= 2.0 * bend * sign * middle
    return lowest & deep & (bend > 0.0)


def _ordered(crossings: RowCrossings, parts) -> tuple[tuple[Slab, ...], list[float]]:
    """Slabs with their arcs in order, and rows that are not in that order."""
    fractions = np.array([0.02, 0.25, 0.5, 0.75, 0.98])
    table = crossings.table(np.concatenate([np.empty(0), *(a + (b - a) * fractions for a, b in parts)]))
    floor = _SAME_X * (crossings.x_range[1] - crossings.x_range[0])
    found, disorder = [], []
    for number, (low, high) in enumerate(parts):
        rows = table[number * fractions.size : (number + 1) * fractions.size]
        values = low + (high - low) * fractions
        arcs, x = crossings.joined(rows, values)
        order = sorted(range(len(arcs)), key=lambda k, x=x: (x[2, k], k))
        wrong = np.min(np.diff(x[:, order], axis=1), axis=1) < -floor
        disorder.extend(values[wrong])
        arcs = [arcs[k] for k in order]
        found.append(Slab(low, high, tuple(arcs[arcs.index(LEFT) : arcs.index(RIGHT) + 1])))
    return tuple(found), disorder
