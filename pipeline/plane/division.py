"""What the stored boundaries divide a plane into: n/I, and dynamic stability, exactly at any magnification.

Curves are the stored cubics; nothing is followed again. At first order solutions are enumerated at one place between
every two boundaries, and at more where the stored cells do not bear it out. At higher orders the stored cells between
two boundaries say what holds there; where none lies between them, the part of the same region in the rows above or
below does.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np

from pipeline.plan.numerics import frame_of
from pipeline.plane.boundaries import StoredCurve
from pipeline.plane.row_curves import curves_at
from pipeline.plane.segments import labels_at
from pipeline.plane.stored import StoredPlane
from solver import Event
from solver.boundaries import SPECTRAL
from solver.boundaries.problem import Plane
from solver.model.checks import ParameterError
from solver.regions.division import DividedSlab, Division, divided
from solver.regions.labelling import KnownCells, Labeller, dynamic_code, stability_code, stability_codes, static_code
from solver.regions.slabs import RegionError, RowCrossings, Slab

__all__ = ["parting_arcs", "stored_division"]

# Points of a curve that slabs look at, besides those where something happens.
_MOST_POINTS = 150
# Where in a slab, and where between two boundaries, solutions are enumerated if not in the middle alone.
_ROWS, _PLACES = (np.array([0.02, 0.5, 0.98]), np.array([0.2, 0.8])), np.array([0.1, 0.5, 0.9])
# Next to corners the cubics are less exact: a part of a slab this small, as a share of the plane, may be blurred.
_BLUR = 1e-8
# What branches say of a part of a slab counts less than any cell of it.
_FAINT = 1e-3
# Parts of neighbouring slabs are one region if they share more than this part of their width.
_SHARED = 0.02


@dataclass(frozen=True, eq=False)
class _Frontier:
    """A stored boundary as slabs take it, without the parts on whose two sides the same holds."""

    stored: StoredCurve

    @property
    def kind(self) -> Event:
        return self.stored.kind

    @cached_property
    def _kept(self) -> np.ndarray:
        count, ends = len(self.stored.points), self.stored.special != 0
        shows = np.concatenate([[False], self.stored.arc_shows, [False]])
        kept = ends | (shows[1:] != shows[:-1])
        kept[:: max(count // _MOST_POINTS, 1)] = True
        # The two points of a corner, which are as near to each other as the curve is exact.
        doubled = np.diff(self.stored.arclength) == 0.0
        kept[:-1] |= doubled
        kept[1:] |= doubled
        kept[-1] = True
        return kept & (shows[1:] | shows[:-1])

    @property
    def parameter(self) -> np.ndarray:
        return self.stored.points[self._kept, 4]

    @property
    def special(self) -> np.ndarray:
        # Where what shows begins or ends is as special as any point.
        shows = np.concatenate([[False], self.stored.arc_shows, [False]])
        return np.where(shows[1:] != shows[:-1], 1, self.stored.special)[self._kept]

    def crossings(self, values) -> tuple[np.ndarray, np.ndarray]:
        met = self.stored.arcs.crossings(4, np.asarray(values, dtype=float))
        shown = self.stored.arc_shows[met.arc]
        return met.line[shown], met.points[shown]


_KNOWN: WeakKeyDictionary[StoredPlane, Division | None] = WeakKeyDictionary()


def stored_division(plane: StoredPlane) -> Division | None:
    """The division of a stored plane, made once; None where its boundaries are not stored, or do not divide it.

    Codes are those of `solver.regions.labelling.stability_codes`, whatever the labels of the plane count.
    """
    plane = plane.counting(dynamic=False)
    if plane not in _KNOWN:
        _KNOWN[plane] = _divided(plane)
    return _KNOWN[plane]


def parting_arcs(plane: StoredPlane) -> dict[int, np.ndarray]:
    """Number of a stored boundary -> which of its arcs have two different labels on their sides, (k - 1,) bool.

    Labels as the plane counts, statically or dynamically; along period doublings and Neimark-Sackers dynamically. Where
    the boundaries do not divide the plane, the arcs of stable motions.
    """
    division, shown = stored_division(plane), {}
    numbers = [number for number, curve in enumerate(plane.boundaries.curves) if np.any(curve.arc_shows)]
    for place, number in enumerate(numbers):
        curve = plane.boundaries.curves[number]
        shown[number] = curve.arc_shows
        if division is not None:
            arcs = np.flatnonzero(curve.arc_shows)
            middles = curve.arcs.at(arcs, np.full(arcs.size, 0.5))[:, 3:]
            label = dynamic_code if plane.dynamic or curve.kind in SPECTRAL else static_code
            left, right = label(division.beside(place, middles)).T
            shown[number] = np.zeros(curve.arc_shows.size, dtype=bool)
            shown[number][arcs] = left != right
    return shown


def _divided(plane: StoredPlane) -> Division | None:
    if plane.boundaries is None or not np.any(plane.complete):
        return None
    plan, frame = plane.plan, Plane(*frame_of(plane.plan), plane.plan.omega)
    curves = tuple(_Frontier(curve) for curve in plane.boundaries.curves if np.any(curve.arc_shows))
    ceiling = float(plan.solver["amplitude_max"])
    try:
        if plan.solver["balance"] == "describing_function":
            known = KnownCells(plane.rows, plan.sweep.values[1:-1], plane.domain[:, 1:-1].astype(np.int64))
            return divided(
                frame, curves, lambda met: Labeller(frame, met, ceiling, stability_codes, _ROWS, _PLACES, _BLUR, known)
            )
        return _joined(divided(frame, curves, lambda met: _StoredLabels(plane, met)))
    except (RegionError, ParameterError):
        return None


class _StoredLabels:
    """What the stored cells say of slabs; 0 where no cell lies between two boundaries."""

    def __init__(self, plane: StoredPlane, crossings: RowCrossings):
        self.plane, self.crossings = plane, crossings

    def expect(self, slabs: Sequence[Slab]) -> None:
        if slabs:
            self.crossings.look_up(self.plane.rows)

    def sequence(self, slab: Slab) -> list[int]:
        rows = np.flatnonzero((self.plane.rows > slab.low) & (self.plane.rows < slab.high) & self.plane.complete)
        if rows.size == 0:
            return [0] * (len(slab.arcs) - 1)
        arcs, x = self.crossings.matrix(self.plane.rows[rows])
        ends = x[:, [arcs.index(arc) for arc in slab.arcs]]
        columns = self.plane.plan.sweep.values
        seen: list[Counter[int]] = [Counter() for _ in slab.arcs[1:]]
        for row, places in zip(rows, ends, strict=True):
            here = np.searchsorted(places[1:-1], columns, side="right")
            for gap, code in zip(here.tolist(), self.plane.stability_codes[row].tolist(), strict=True):
                seen[gap][code] += 1
            narrow = np.flatnonzero([not found for found in seen])
            if narrow.size:
                middles = 0.5 * (places[narrow] + places[narrow + 1])
                for gap, code in zip(narrow.tolist(), self._between_cells(row, middles), strict=True):
                    seen[gap][code] += _FAINT
        return [max(sorted(found), key=lambda code: found[code], default=0) for found in seen]

    def _between_cells(self, row: int, x: np.ndarray) -> list[int]:
        """What the branches of a row say at ascending places, also of dynamic stability."""
        branches = curves_at(self.plane, float(self.plane.rows[row]))
        lasting = [
            replace(segment, stable=bool(lasts))
            for segment, lasts in zip(branches.segments, branches.lasting, strict=True)
        ]
        static, dynamic = (labels_at([segments], x)[0][0].astype(int) for segments in (branches.segments, lasting))
        return [int(code) for code in stability_code(static, dynamic, False)]


def _joined(division: Division) -> Division:
    """With what holds in the parts of slabs that no row crosses: what holds in the rest of their region.

    So where a row has missed a pair of motions that the fold about it tells of: the label is the same on both sides.
    """
    ends = _ends(division)
    codes = [_without_missed(division, part, low) for part, (low, _) in zip(division.slabs, ends, strict=True)]
    # What is left where no row says anything of a region is what holds next to it.
    for least in (_SHARED, 0.0):
        _spread(codes, ends, least)
    for found in codes:
        known = [code for code in found if code]
        for gap, code in enumerate(found):
            if not code and known:
                found[gap] = found[gap - 1] if gap else known[0]
    parts = tuple(
        replace(part, codes=tuple(new or old for new, old in zip(found, part.codes, strict=True)))
        for part, found in zip(division.slabs, codes, strict=True)
    )
    return replace(division, slabs=parts)


def _spread(codes: list[list[int]], ends: list[tuple[np.ndarray, np.ndarray]], least: float) -> None:
    """Fill in codes from the slabs below and above, where parts share more than a part of their width."""
    count = len(codes)
    for before, number in (*((i, i + 1) for i in range(count - 1)), *((i + 1, i) for i in range(count - 1)[::-1])):
        upwards = before < number
        known, here = (ends[before][1], ends[number][0]) if upwards else (ends[before][0], ends[number][1])
        shared = np.minimum(known[1:, None], here[1:]) - np.maximum(known[:-1, None], here[:-1])
        for gap in np.flatnonzero(np.array(codes[number]) == 0):
            best = int(np.argmax(shared[:, gap]))
            # What begins or ends at this row is narrow there, and shares nothing with the next slab.
            if shared[best, gap] > least * max(np.diff(x)[gap] for x in ends[number]):
                codes[number][gap] = codes[before][best]


def _ends(division: Division) -> list[tuple[np.ndarray, np.ndarray]]:
    """x of the arcs of every slab in its lowest and in its highest row."""
    rows = np.array([p for part in division.slabs for p in part.slab.inner_ends])
    table, found = RowCrossings(division.curves, division.plane.x_range).table(rows), []
    for number, part in enumerate(division.slabs):
        both = []
        for arcs, places in table[2 * number : 2 * number + 2]:
            at = {(int(curve), int(which)): place for (curve, which), place in zip(arcs, places, strict=True)}
            both.append(np.array([at[arc] for arc in part.slab.arcs]))
        found.append((both[0], both[1]))
    return found


def _without_missed(division: Division, part: DividedSlab, x: np.ndarray) -> list[int]:
    """The codes of a slab, 0 for those that a fold contradicts."""
    codes, suspected = list(part.codes), Counter()
    for i, arc in enumerate(part.slab.arcs[1:-1], start=1):
        left, right = codes[i - 1], codes[i]
        if division.curves[arc[0]].kind is Event.FOLD and left and static_code(left) == static_code(right):
            suspected.update((i - 1, i))
    # Of two neighbours the one that more folds contradict, then the narrower one.
    widths = np.diff(x)
    while suspected:
        gap = max(sorted(suspected), key=lambda gap: (suspected[gap], -widths[gap]))
        codes[gap] = 0
        for other in (gap - 1, gap, gap + 1):
            suspected.pop(other, None)
    return codes
