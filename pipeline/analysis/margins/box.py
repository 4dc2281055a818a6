"""The largest box: a rectangle of the plane, around a design point or range, into which no boundary reaches."""

from dataclasses import dataclass

import numpy as np

from pipeline.analysis.margins.curves import Boundaries, P, X
from pipeline.analysis.margins.options import Design
from pipeline.plan.plan import Plan

__all__ = ["Box", "largest_box"]

#: Relative error of the area up to which the search is exhaustive, and how many cells it may keep open for that.
_TOLERANCE, _MOST_CELLS = 1e-6, 2**20
_FIRST_CUTS = 64
#: The best corner is polished on grids of so many values across, each so much narrower than the one before.
_GRID, _NARROWER, _ROUNDS = 9, 0.5, 40
#: Short of its reach by so much a rectangle is the same to rounding, and nothing crosses the range itself.
_BEFORE = 1.0 - 1e-10


@dataclass(frozen=True)
class Box:
    """A rectangle of the plane.

    Parameters
    ----------
    x, p : (low, high)
    area : float
        As a share of the plane.
    """

    x: tuple[float, float]
    p: tuple[float, float]
    area: float


def largest_box(boundaries: Boundaries, plan: Plan, design: Design) -> Box:
    """The axis-parallel rectangle of largest area that holds the operating range and no boundary inside.

    Largest means by area with both axes as shares of the plane's; the rectangle ends at the plane's borders. The label
    of the range must be the same all over it: then it is that of the whole rectangle, for labels change at boundaries.

    For a rectangle from p - d to p + u, the boundaries to the left of the range that reach into those rows say how far
    left it may go, which is a running maximum over the rows; likewise to the right. It changes only at boundaries' ends
    and turning points and along boundaries, where it is found from their cubics. The area over (u, d) is bounded on
    cells from the narrowest and the widest rectangle in each, and cells that cannot hold the largest are dropped until
    what is left differs by less than 1e-6 of the area; the best is then polished.

    Parameters
    ----------
    boundaries : Boundaries
    plan : Plan
    design : Design
        The box contains (low, high) of its operating range, at its p.
    """
    sides = [_Side(boundaries, plan, design, upward) for upward in (False, True)]
    width, height = plan.sweep.high - plan.sweep.low, plan.parameter.high - plan.parameter.low

    def area(down: np.ndarray, up: np.ndarray, wide_down=None, wide_up=None) -> np.ndarray:
        """Of rectangles of depth and height (.,); as wide as those of other depth and height, if these are given."""
        left, right = _joined(sides, down if wide_down is None else wide_down, up if wide_up is None else wide_up)
        return (right - left) * (down + up) / (width * height)

    cells = _first_cells(sides)
    best, corner = 0.0, np.zeros(2)
    while len(cells):
        near, far = cells[:, :2], cells[:, 2:]
        for tried in (near, far):
            value = area(*tried.T)
            if value.max() > best:
                best, corner = float(value.max()), tried[value.argmax()]
        most = area(*far.T, *near.T)
        cells = cells[most > best * (1.0 + _TOLERANCE)]
        if len(cells) > _MOST_CELLS // 4:
            break
        middle = 0.5 * (cells[:, :2] + cells[:, 2:])
        parts = [
            np.column_stack([np.where(pick, middle, cells[:, :2]), np.where(pick, cells[:, 2:], middle)])
            for pick in ([False, False], [False, True], [True, False], [True, True])
        ]
        cells = np.concatenate(parts)
    corner = _polished(area, corner, [side.reach for side in sides])
    left, right = _joined(sides, *corner[:, None])
    p = sides[0].end(float(corner[0])), sides[1].end(float(corner[1]))
    return Box((float(left[0]), float(right[0])), p, float(area(*corner[:, None])[0]))


def _joined(sides, down, up) -> tuple[np.ndarray, np.ndarray]:
    """How far left and right rectangles of depths and heights (.,) reach."""
    (left_down, right_down), (left_up, right_up) = sides[0].walls(down), sides[1].walls(up)
    return np.maximum(left_down, left_up), np.minimum(right_down, right_up)


def _first_cells(sides) -> np.ndarray:
    """Cells (., 4): least depth and height, most depth and height."""
    cuts = [np.linspace(0.0, side.reach, _FIRST_CUTS + 1) for side in sides]
    near = np.stack(np.meshgrid(cuts[0][:-1], cuts[1][:-1], indexing="ij"), axis=-1).reshape(-1, 2)
    far = np.stack(np.meshgrid(cuts[0][1:], cuts[1][1:], indexing="ij"), axis=-1).reshape(-1, 2)
    return np.column_stack([near, far])


def _polished(area, corner: np.ndarray, reach) -> np.ndarray:
    """The best depth and height next to good ones."""
    span, best = np.array(reach) / _FIRST_CUTS, area(*corner[:, None])[0]
    for _ in range(_ROUNDS):
        tries = [
            np.unique(np.clip(np.append(c + s * np.linspace(-1.0, 1.0, _GRID), c), 0.0, most))
            for c, s, most in zip(corner, span, reach, strict=True)
        ]
        down, up = (part.ravel() for part in np.meshgrid(*tries, indexing="ij"))
        values = area(down, up)
        if values.max() > best:
            best = values.max()
            corner = np.array([down[values.argmax()], up[values.argmax()]])
        span = span * _NARROWER
    return corner


class _Side:
    """What limits rectangles on one side of the row of the range.

    Parameters
    ----------
    boundaries, plan, design
    upward : bool
        Whether the rows above count, or those below.
    """

    def __init__(self, boundaries: Boundaries, plan: Plan, design: Design, upward: bool):
        self.arcs, self.design, self.sign = boundaries.arcs, design, 1.0 if upward else -1.0
        self.borders = plan.sweep.low, plan.sweep.high
        places, _ = boundaries.marked
        away = self.sign * (places[:, 1] - design.p)
        inside = (places[:, 0] > design.low) & (places[:, 0] < design.high) & (away > 0.0)
        self.border = plan.parameter.high if upward else plan.parameter.low
        blocked = [away[inside], [self.sign * (self.border - design.p)]]
        for x in (design.low, design.high):
            crossed = self.sign * (boundaries.along(X, x)[0] - design.p)
            blocked.append(crossed[crossed > 0.0])
        #: How far from the range's row nothing reaches into the range.
        self.reach = float(np.min(np.concatenate(blocked)))
        kept = (away >= 0.0) & (away <= self.reach) & ~inside
        order = np.argsort(away[kept], kind="stable")
        self._away, x = away[kept][order], places[kept, 0][order]
        low, high = self.borders
        self._left = np.maximum.accumulate(np.concatenate([[low], np.where(x <= design.low, x, low)]))
        self._right = np.minimum.accumulate(np.concatenate([[high], np.where(x >= design.high, x, high)]))
        # An arc lies within the hull of its control points.
        low, high = sorted((design.p, design.p + self.sign * self.reach))
        rows = self.arcs.controls()[:, :, 1]
        self.arcs = self.arcs.chosen((rows.max(axis=1) >= low) & (rows.min(axis=1) <= high))
        # The row itself, where rectangles begin.
        self._first = self._crossed(np.zeros(1))

    def end(self, away: float) -> float:
        """The row at a distance; the plane's border itself where that is meant."""
        row = self.design.p + self.sign * away
        return self.border if abs(row - self.border) <= 1e-14 * abs(self.design.p - self.border) else row

    def walls(self, away: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """How far left and right rectangles may go that reach so far (.,) from the row of the range."""
        # What ends the reach touches the range there: on which of its sides it comes is seen just before.
        values, place = np.unique(np.minimum(away, _BEFORE * self.reach), return_inverse=True)
        left, right = self._crossed(values)
        passed = np.searchsorted(self._away, values, side="right")
        left = np.maximum(np.maximum(left, self._left[passed]), self._first[0])
        right = np.minimum(np.minimum(right, self._right[passed]), self._first[1])
        return left[place], right[place]

    def _crossed(self, away: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The nearest boundaries to the left and to the right in rows (.,) at ascending distances."""
        rows = self.design.p + self.sign * away
        order = np.argsort(rows, kind="stable")
        found = self.arcs.crossings(P, rows[order])
        line, x = order[found.line], found.points[:, X]
        left, right = np.full(away.size, self.borders[0]), np.full(away.size, self.borders[1])
        outer = x <= self.design.low
        np.maximum.at(left, line[outer], x[outer])
        outer = x >= self.design.high
        np.minimum.at(right, line[outer], x[outer])
        return left, right
