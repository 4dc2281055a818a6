"""What a panel of the map shows: labels, where a motion is unstable, the lines between, and marked points.

With boundary curves in the store, lines are the curves themselves and all areas end at them, at any magnification;
without, areas are the cells of the raster and lines their borders.
"""

from dataclasses import dataclass, field
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np
from matplotlib.path import Path as Outline

from pipeline.analysis.boundaries.events import MARGINS
from pipeline.figures.edges import curves_along, label_edges
from pipeline.plan.axes import Axis
from pipeline.plane.arcs import arcs_of, needed_points
from pipeline.plane.boundaries import StoredBoundaries, StoredCurve, special_places
from pipeline.plane.division import parting_arcs, stored_division
from pipeline.plane.stored import StoredPlane
from solver import Event
from solver.boundaries import SpecialPoint
from solver.regions.labelling import dynamic_code, is_contradictory, static_code

__all__ = ["DETAIL", "MARKED", "Panel", "cell_borders", "lines_of", "panel_of", "shares_of_labels"]

#: Points that panels mark.
MARKED = (SpecialPoint.CUSP, SpecialPoint.FOLD_GRAZING, SpecialPoint.ISOLA, SpecialPoint.MERGER)

#: How far points of boundaries may be off the lines that are drawn, as a share of the panel: a pixel of a screen where
#: it is magnified a thousandfold.
DETAIL = 1e-6
#: What lines are called.
_KINDS = {
    Event.FOLD: "fold",
    **dict.fromkeys(MARGINS, "grazing"),
    Event.PERIOD_DOUBLING: "period_doubling",
    Event.NEIMARK_SACKER: "neimark_sacker",
    Event.UNIT_MULTIPLIER: "unit_multiplier",
}
#: Pixels of an image with exact labels, across and up: as fine as print shows.
_FINE = (1440, 900)
_BITS = 6


@dataclass(frozen=True)
class Panel:
    """One part of the plane.

    Parameters
    ----------
    code : (m, n) array
        Labels, evenly over the panel.
    unstable : (m, n) bool array
        Where not all motions that the label counts are dynamically stable.
    contradictory : (m, n) bool array
        Where static and dynamic stability of one of them contradict each other.
    x, y : (float, float)
        What the image covers.
    lines : dict
        "fold", "grazing", "period_doubling", "neimark_sacker", "unit_multiplier" -> Outline, those that are there.
    marks : dict
        SpecialPoint -> (k, 2) array of places.
    """

    code: np.ndarray
    unstable: np.ndarray
    contradictory: np.ndarray
    x: tuple[float, float]
    y: tuple[float, float]
    lines: dict[str, Outline]
    marks: dict[SpecialPoint, np.ndarray] = field(default_factory=dict)

    @cached_property
    def present(self) -> np.ndarray:
        """The codes that there are, ascending."""
        return np.flatnonzero(np.bincount(self.code.ravel()))


def panel_of(plane: StoredPlane, x: tuple[float, float] | None = None, y: tuple[float, float] | None = None) -> Panel:
    """A part of the plane, all of it unless told.

    Parameters
    ----------
    plane : StoredPlane
    x, y : (low, high), optional
        On the sweep axis and on the parameter axis.
    """
    sweep, parameter, division = plane.plan.sweep, plane.plan.parameter, stored_division(plane)
    if division is not None:
        x, y = x or (sweep.low, sweep.high), y or (parameter.low, parameter.high)
        columns, rows = (_middles(*ends, count) for ends, count in zip((x, y), _FINE, strict=True))
        codes, number = division.lattice(columns, rows)
        codes = np.append(codes, 0)
        number[~plane.complete[np.abs(plane.rows[:, None] - rows).argmin(axis=0)]] = codes.size - 1
    else:
        rows, columns = cell_borders(parameter), cell_borders(sweep)
        within = tuple(_within(borders, ends) for borders, ends in ((rows, y), (columns, x)))
        codes, number = np.unique(plane.stability_codes[within], return_inverse=True)
        rows, columns = rows[within[0].start : within[0].stop + 1], columns[within[1].start : within[1].stop + 1]
        number = number.reshape(rows.size - 1, columns.size - 1)
        x, y = (float(columns[0]), float(columns[-1])), (float(rows[0]), float(rows[-1]))
    static, dynamic = static_code(codes), dynamic_code(codes)
    code = (dynamic if plane.dynamic else static).astype(np.uint16)[number]
    if plane.boundaries is not None:
        lines, marks = _lines(plane, x, y, DETAIL), _marks(plane.boundaries, x, y)
    else:
        lines, marks = _cell_lines(code, code - 1 >> _BITS, columns, rows), {}
    unstable = (static != dynamic) & (not plane.dynamic)
    return Panel(code, unstable[number], is_contradictory(codes)[number], x, y, lines, marks)


def shares_of_labels(plane: StoredPlane) -> dict[int, float]:
    """Share of every label of the plane, by code: from the curves where they divide it, else of the computed cells."""
    division = stored_division(plane) if np.all(plane.complete) else None
    if division is None:
        computed = plane.domain[plane.domain != 0]
        codes, cells = np.unique(computed, return_counts=True)
        return dict(zip(codes.tolist(), (cells / max(computed.size, 1)).tolist(), strict=True))
    shares: dict[int, float] = {}
    for code, share in division.shares().items():
        label = int(dynamic_code(code) if plane.dynamic else static_code(code))
        shares[label] = shares.get(label, 0.0) + share
    return shares


def _middles(low: float, high: float, count: int) -> np.ndarray:
    return low + (np.arange(count) + 0.5) / count * (high - low)


def _within(borders: np.ndarray, ends: tuple[float, float] | None) -> slice:
    """The cells that a range touches."""
    if ends is None:
        return slice(0, borders.size - 1)
    first, last = np.searchsorted(borders, ends[0], side="right") - 1, np.searchsorted(borders, ends[1], side="left")
    return slice(max(int(first), 0), int(last))


def _cell_lines(code: np.ndarray, n: np.ndarray, columns: np.ndarray, rows: np.ndarray) -> dict[str, Outline]:
    """Line kind -> the borders between cells of different labels."""
    kinds = zip(("fold", "grazing"), label_edges(code, n), strict=True)
    return _present({kind: _polygons(edges, columns, rows) for kind, edges in kinds})


def _present(lines: dict[str, Outline]) -> dict[str, Outline]:
    return {kind: outline for kind, outline in lines.items() if len(outline.vertices)}


def cell_borders(axis: Axis) -> np.ndarray:
    """Borders of the cells, which are centred on the axis's values, (num + 1,)."""
    half = 0.5 * (axis.high - axis.low) / (axis.num - 1)
    return np.linspace(axis.low - half, axis.high + half, axis.num + 1)


def _polygons(segments: np.ndarray, x: np.ndarray, y: np.ndarray) -> Outline:
    """Cell borders, joined where they meet."""
    lines = [Outline(np.column_stack([x[corner[:, 1]], y[corner[:, 0]]])) for corner in curves_along(segments)]
    return Outline.make_compound_path(*lines) if lines else Outline(np.empty((0, 2)))


def lines_of(
    plane: StoredPlane, x: tuple[float, float], y: tuple[float, float], detail: float = DETAIL
) -> dict[str, Outline]:
    """Line kind -> the lines within a part of the plane, without the labels between them.

    Parameters
    ----------
    plane : StoredPlane
    x, y : (low, high)
    detail : float
        How far a point of a stored boundary may be off its line, as a share of the part.
    """
    if plane.boundaries is not None:
        return _lines(plane, x, y, detail)
    borders = cell_borders(plane.plan.sweep), cell_borders(plane.plan.parameter)
    return _cell_lines(plane.domain, plane.n_stable, *borders)


_PARTING: WeakKeyDictionary[StoredPlane, dict[int, np.ndarray]] = WeakKeyDictionary()


def _lines(plane: StoredPlane, x: tuple[float, float], y: tuple[float, float], detail: float) -> dict[str, Outline]:
    """Line kind -> the curves of that kind within a window, where they part labels, as Bezier curves: cubics through
    stored points and slopes, which stay smooth at any magnification."""
    if plane not in _PARTING:
        _PARTING[plane] = parting_arcs(plane)
    found: list[tuple[str, StoredCurve, int, int]] = []
    for number, shows in _PARTING[plane].items():
        curve = plane.boundaries.curves[number]
        # An arc lies within the hull of its control points. What lies outside would only cost dashes.
        controls = curve.arcs.controls()
        lowest, highest = controls.min(axis=1), controls.max(axis=1)
        near = np.all((highest >= (x[0], y[0])) & (lowest <= (x[1], y[1])), axis=1) & shows
        found += [(_KINDS[curve.kind], curve, first, stop) for first, stop in _runs(near)]
    if not found:
        return {}
    points, slopes, arclength = (
        np.concatenate([getattr(curve, name)[first : stop + 1] for _, curve, first, stop in found])
        for name in ("points", "slopes", "arclength")
    )
    last = np.cumsum([stop + 1 - first for _, _, first, stop in found]) - 1
    runs = np.column_stack([np.concatenate([[0], last[:-1] + 1]), last])
    kept = needed_points(points[:, 3:], slopes[:, 3:], arclength, runs, detail * np.array([np.ptp(x), np.ptp(y)]))
    outlines: dict[str, list[Outline]] = {kind: [] for kind in dict.fromkeys(_KINDS.values())}
    for (kind, *_), (low, high) in zip(found, runs, strict=True):
        here = low + np.flatnonzero(kept[low : high + 1])
        controls = arcs_of(points[here], slopes[here], arclength[here]).controls()
        vertices = np.concatenate([controls[0, :1], controls[:, 1:].reshape(-1, 2)])
        codes = np.full(len(vertices), Outline.CURVE4, Outline.code_type)
        codes[0] = Outline.MOVETO
        outlines[kind].append(Outline(vertices, codes))
    return {kind: Outline.make_compound_path(*parts) for kind, parts in outlines.items() if parts}


def _runs(flags: np.ndarray) -> list[tuple[int, int]]:
    """First and one past the last index of every run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def _marks(boundaries: StoredBoundaries, x, y) -> dict[SpecialPoint, np.ndarray]:
    places: dict[SpecialPoint, list] = {kind: [] for kind in MARKED}
    for curve in boundaries.curves:
        for place in special_places(curve):
            at = curve.points[place, 3:]
            if curve.special[place] in places and x[0] <= at[0] <= x[1] and y[0] <= at[1] <= y[1]:
                places[SpecialPoint(curve.special[place])].append(at)
    return {kind: np.array(found) for kind, found in places.items() if found}
