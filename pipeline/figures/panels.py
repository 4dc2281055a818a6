"""What a panel of the map shows: an image of labels, the lines between them and marked points, from either source.

With boundary curves in the store, lines are the curves themselves and labels are exact at every pixel; without, lines
are the borders between neighbouring cells of the raster.
"""

from dataclasses import dataclass, field

import numpy as np
from matplotlib.path import Path as Outline

from pipeline.analysis.boundaries.events import MARGINS
from pipeline.figures.edges import curves_along, label_edges
from pipeline.figures.regions import region_codes
from pipeline.plan.axes import Axis
from pipeline.plane.boundaries import StoredBoundaries, special_places
from pipeline.plane.segments import labels_at
from pipeline.plane.stored import StoredPlane
from solver import Event
from solver.boundaries import SpecialPoint

__all__ = ["MARKED", "Panel", "cell_borders", "lines_of", "panel_of"]

#: Points that panels mark.
MARKED = (SpecialPoint.CUSP, SpecialPoint.FOLD_GRAZING, SpecialPoint.ISOLA, SpecialPoint.MERGER)

#: Pixels of an image with exact labels, across and up: as fine as print shows.
_FINE = (1440, 900)
#: Columns of an enlargement without boundaries.
_COLUMNS = 240


@dataclass(frozen=True)
class Panel:
    """One part of the plane.

    Parameters
    ----------
    code : (m, n) array
        Labels, evenly over the panel.
    x, y : (float, float)
        What the image covers.
    lines : dict
        "fold", "grazing", "period_doubling", "neimark_sacker" -> Outline, those that are there.
    marks : dict
        SpecialPoint -> (k, 2) array of places.
    """

    code: np.ndarray
    x: tuple[float, float]
    y: tuple[float, float]
    lines: dict[str, Outline]
    marks: dict[SpecialPoint, np.ndarray] = field(default_factory=dict)


def panel_of(plane: StoredPlane, x: tuple[float, float] | None = None, y: tuple[float, float] | None = None) -> Panel:
    """A part of the plane, all of it unless told.

    Parameters
    ----------
    plane : StoredPlane
    x, y : (low, high), optional
        On the sweep axis and on the parameter axis.
    """
    sweep, parameter = plane.plan.sweep, plane.plan.parameter
    if plane.boundaries is not None and not plane.dynamic and plane.plan.solver["balance"] == "describing_function":
        return _exact_panel(plane, x or (sweep.low, sweep.high), y or (parameter.low, parameter.high))
    rows, columns = cell_borders(parameter), cell_borders(sweep)
    code, n = plane.domain, plane.n_stable
    if x is not None and plane.dynamic:
        inside = slice(np.searchsorted(columns, x[0], side="right") - 1, np.searchsorted(columns, x[1], side="left"))
        code, n, columns = code[:, inside], n[:, inside], columns[inside.start : inside.stop + 1]
    elif x is not None:
        # Folds and grazings of the rows are located exactly, so that columns may be as fine as one likes.
        columns = np.linspace(*x, _COLUMNS + 1)
        code, n = labels_at(plane.pieces, 0.5 * (columns[1:] + columns[:-1]))
        code[~plane.complete] = 0
    if y is not None:
        inside = slice(np.searchsorted(rows, y[0], side="right") - 1, np.searchsorted(rows, y[1], side="left"))
        code, n, rows = code[inside], n[inside], rows[inside.start : inside.stop + 1]
    ends = _ends(columns), _ends(rows)
    if plane.boundaries is not None and not plane.dynamic:
        return Panel(code, *ends, _lines(plane.boundaries, *ends), _marks(plane.boundaries, *ends))
    return Panel(code, *ends, _cell_lines(code, n, columns, rows))


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


def _ends(borders: np.ndarray) -> tuple[float, float]:
    return float(borders[0]), float(borders[-1])


def _polygons(segments: np.ndarray, x: np.ndarray, y: np.ndarray) -> Outline:
    """Cell borders, joined where they meet."""
    lines = [Outline(np.column_stack([x[corner[:, 1]], y[corner[:, 0]]])) for corner in curves_along(segments)]
    return Outline.make_compound_path(*lines) if lines else Outline(np.empty((0, 2)))


def _exact_panel(plane: StoredPlane, x: tuple[float, float], y: tuple[float, float]) -> Panel:
    middles = [
        low + (np.arange(count) + 0.5) / count * (high - low) for (low, high), count in zip((x, y), _FINE, strict=True)
    ]
    code, _ = region_codes(plane, *middles)
    return Panel(code, x, y, _lines(plane.boundaries, x, y), _marks(plane.boundaries, x, y))


def lines_of(plane: StoredPlane, x: tuple[float, float], y: tuple[float, float]) -> dict[str, Outline]:
    """Line kind -> the lines within a part of the plane, without the labels between them."""
    if plane.boundaries is not None:
        return _lines(plane.boundaries, x, y)
    return _cell_lines(plane.domain, plane.n_stable, cell_borders(plane.plan.sweep), cell_borders(plane.plan.parameter))


def _lines(boundaries: StoredBoundaries, x: tuple[float, float], y: tuple[float, float]) -> dict[str, Outline]:
    """Line kind -> the curves of that kind within a window."""
    kinds = {
        "fold": (Event.FOLD,),
        "grazing": tuple(MARGINS),
        "period_doubling": (Event.PERIOD_DOUBLING,),
        "neimark_sacker": (Event.NEIMARK_SACKER,),
    }
    return _present({kind: _outline(boundaries, events, x, y) for kind, events in kinds.items()})


def _outline(boundaries: StoredBoundaries, kinds, x: tuple[float, float], y: tuple[float, float]) -> Outline:
    """The curves within a window as Bezier curves, which are the stored cubics and stay smooth at any magnification."""
    vertices, codes = [np.empty((0, 2))], [np.empty(0, Outline.code_type)]
    for curve in boundaries.curves:
        if curve.kind not in kinds or len(curve.points) < 2:
            continue
        controls = curve.arcs.controls()
        # An arc lies within the hull of its control points. What lies outside would only cost dashes.
        lowest, highest = controls.min(axis=1), controls.max(axis=1)
        near = np.all((highest >= (x[0], y[0])) & (lowest <= (x[1], y[1])), axis=1) & curve.arc_shows
        for first, stop in _runs(near):
            vertices.append(np.concatenate([controls[first, :1], controls[first:stop, 1:].reshape(-1, 2)]))
            codes.append(np.full(len(vertices[-1]), Outline.CURVE4, Outline.code_type))
            codes[-1][0] = Outline.MOVETO
    return Outline(np.concatenate(vertices), np.concatenate(codes))


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
