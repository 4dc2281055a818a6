"""Curves between their stored points: cubics through points and slopes.

The error of such a cubic falls with the fourth power of the distance between points. Boundaries are traced with so
short steps that it stays below 1e-8 of the plane's axes, so that a stored curve can be drawn at a hundred thousandfold
magnification and nothing has to be solved again.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

__all__ = ["Arcs", "Crossings", "arcs_of", "needed_points"]

# Steps of Newton or halving, and how far the last one may move, as a share of an arc.
_MOST_STEPS, _CLOSE = 60, 1e-14


@dataclass(frozen=True)
class Arcs:
    """Cubics, each over t = 0 ... 1 between two neighbouring points of a curve.

    Parameters
    ----------
    start, end : (m, 5) arrays
        lambda_m, lambda_c, lambda_s, x, p.
    leave, arrive : (m, 5) arrays
        Their derivatives by t.
    """

    start: np.ndarray
    end: np.ndarray
    leave: np.ndarray
    arrive: np.ndarray

    def at(self, number, t) -> np.ndarray:
        """Points (k, 5) of the arcs `number` (k,) at t (k,)."""
        t = np.asarray(t, dtype=float)[:, None]
        p, q, u, v = self.start[number], self.end[number], self.leave[number], self.arrive[number]
        return p + t * (u + t * (3.0 * (q - p) - 2.0 * u - v + t * (2.0 * (p - q) + u + v)))

    def chosen(self, which) -> "Arcs":
        """Some of the arcs, by number or as flags."""
        return Arcs(self.start[which], self.end[which], self.leave[which], self.arrive[which])

    def controls(self) -> np.ndarray:
        """The four control points of every arc as a Bezier curve in the plane (x, p), (m, 4, 2)."""
        corners = (self.start, self.start + self.leave / 3.0, self.end - self.arrive / 3.0, self.end)
        return np.stack([corner[:, 3:] for corner in corners], axis=1)

    def turns(self, axis: int) -> np.ndarray:
        """t where component `axis` (3: x, 4: p) turns round, (m, 2) ascending; 0 where it does so less often."""
        p, q, u, v = (part[:, axis] for part in (self.start, self.end, self.leave, self.arrive))
        a, b = 3.0 * (2.0 * (p - q) + u + v), 3.0 * (q - p) - 2.0 * u - v
        with np.errstate(all="ignore"):
            root = np.sqrt(b * b - a * u)
            # The stable one of the two forms of each root.
            far = -(b + np.where(b < 0.0, -root, root))
            found = np.stack([far / a, u / far], axis=1)
        return np.sort(np.where((found > 0.0) & (found < 1.0), found, 0.0), axis=1)

    def crossings(self, axis: int, values: np.ndarray) -> "Crossings":
        """Where the arcs meet lines on which component `axis` (3: x, 4: p) has one of the ascending values."""
        number, low, high, first, last = self._monotonic[axis - 3]
        rises = last > first
        # Each value belongs to one of two arcs that meet there: what starts at it does not cross it.
        lower, upper = np.minimum(first, last), np.maximum(first, last)
        begin, stop = np.searchsorted(values, lower, side="right"), np.searchsorted(values, upper, side="right")
        count = stop - begin
        segment = np.repeat(np.arange(number.size), count)
        line = np.arange(segment.size) - np.repeat(np.cumsum(count) - count, count) + begin[segment]
        number, low, high, rises = number[segment], low[segment], high[segment], rises[segment]
        a, b, u, p = self._powers(axis, number)
        level, t = values[line], 0.5 * (low + high)
        # The difference of two neighbours is exact, while sums with either of them would be rounded.
        above = p - level
        for _ in range(_MOST_STEPS):
            miss = above + t * (u + t * (b + t * a))
            before = (miss < 0.0) == rises
            low, high = np.where(before, t, low), np.where(before, high, t)
            # Newton, or half the bracket where that would leave it, but not where it is rounded past an end.
            with np.errstate(all="ignore"):
                following = t - miss / (u + t * (2.0 * b + t * 3.0 * a))
            inside = (following >= low - _CLOSE) & (following <= high + _CLOSE)
            following = np.where(inside, following.clip(low, high), 0.5 * (low + high))
            if np.all(np.abs(following - t) <= _CLOSE):
                break
            t = following
        points = self.at(number, t)
        points[:, axis] = level
        return Crossings(line, number, points, np.where(rises, 1, -1))

    @cached_property
    def _monotonic(self) -> list[tuple[np.ndarray, ...]]:
        """For x and for p, the arcs cut where the component turns round: number of the arc, t and the component at
        both ends."""
        found = []
        for axis in (3, 4):
            p, q = self.start[:, axis], self.end[:, axis]
            cuts = np.concatenate([np.zeros((p.size, 1)), self.turns(axis), np.ones((p.size, 1))], axis=1)
            number = np.repeat(np.arange(p.size), 3)
            low, high = cuts[:, :-1].ravel(), cuts[:, 1:].ravel()
            number, low, high = (part[high > low] for part in (number, low, high))
            found.append((number, low, high, *(self._place(number, t, axis, p, q) for t in (low, high))))
        return found

    def _place(self, number, t, axis, p, q) -> np.ndarray:
        """One component; at the ends exactly the stored value, so that neighbouring arcs agree."""
        a, b, u, start = self._powers(axis, number)
        value = start + t * (u + t * (b + t * a))
        return np.where(t == 0.0, p[number], np.where(t == 1.0, q[number], value))

    def _powers(self, axis: int, number) -> tuple[np.ndarray, ...]:
        """Coefficients of t^3, t^2, t and 1 of one component of some arcs."""
        p, q, u, v = (part[number, axis] for part in (self.start, self.end, self.leave, self.arrive))
        return 2.0 * (p - q) + u + v, 3.0 * (q - p) - 2.0 * u - v, u, p


@dataclass(frozen=True)
class Crossings:
    """Where arcs meet lines: number of the line and of the arc, the point (., 5), and whether the curve crosses towards
    growing (1) or falling (-1) values."""

    line: np.ndarray
    arc: np.ndarray
    points: np.ndarray
    direction: np.ndarray


def arcs_of(points: np.ndarray, slopes: np.ndarray, arclength: np.ndarray) -> Arcs:
    """The arcs of a curve: points and slopes (k, 5) at arc lengths (k,); a doubled point is an arc of no length."""
    length = np.diff(arclength)[:, None]
    return Arcs(points[:-1], points[1:], length * slopes[:-1], length * slopes[1:])


def needed_points(
    points: np.ndarray, slopes: np.ndarray, arclength: np.ndarray, runs: np.ndarray, allowed: np.ndarray
) -> np.ndarray:
    """Which points cubics must go through so that they pass by all others closely enough.

    Parameters
    ----------
    points, slopes : (k, d) arrays
        Of curves one after the other, and their derivatives by arc length.
    arclength : (k,) array
    runs : (r, 2) int array
        First and last point of every curve, or of a part of one, ascending.
    allowed : (d,) array
        How far a point that is left out may be off the cubic, along each axis.

    Returns
    -------
    (k,) bool array
        Those that stay, the ends of all runs among them.
    """
    points, slopes = points / allowed, slopes / allowed
    kept = np.zeros(len(points), dtype=bool)
    kept[runs] = True
    first, last = runs.T
    while (wide := last - first > 1).any():
        first, last = first[wide], last[wide]
        count = last - first - 1
        start = np.cumsum(count) - count
        inner = np.arange(count.sum()) + np.repeat(first + 1 - start, count)
        length = arclength[last] - arclength[first]
        cubics = Arcs(points[first], points[last], length[:, None] * slopes[first], length[:, None] * slopes[last])
        number = np.repeat(np.arange(first.size), count)
        with np.errstate(all="ignore"):
            t = np.where(length[number] > 0.0, (arclength[inner] - arclength[first][number]) / length[number], 0.0)
        off = np.maximum.reduceat(np.linalg.norm(cubics.at(number, t) - points[inner], axis=1), start)
        first, last = first[off > 1.0], last[off > 1.0]
        middle = (first + last) // 2
        kept[middle] = True
        first, last = np.concatenate([first, middle]), np.concatenate([middle, last])
    return kept
