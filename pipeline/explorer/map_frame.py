"""What all layers of a map have in common: axes, boundary curves, natural frequencies, what is told of a cell."""

from dataclasses import dataclass

import numpy as np
from matplotlib.path import Path as Outline

from pipeline.analysis.attractors.credibility import Credibility
from pipeline.analysis.attractors.dataset import read_attractors
from pipeline.analysis.attractors.wording import cell_label
from pipeline.explorer.layer_data import Cells, LineKind, MapAxis, MarkKind, Told
from pipeline.explorer.plain_text import axis_text, plain
from pipeline.figures.cell_panels import attractor_borders
from pipeline.figures.map_legend import LINES, MARK_NAMES
from pipeline.figures.naming import axis_label, mesh_energies, symbol
from pipeline.figures.panels import DETAIL, cell_borders, lines_of
from pipeline.plan.scales import scales_of
from pipeline.plane.outlines import flattened, thinned
from pipeline.plane.stored import StoredPlane
from solver import Scales

__all__ = ["MapFrame", "evenly", "frame_of_map", "label_text", "map_lines", "marks_of", "plane_cells", "told_of_cells"]


@dataclass(frozen=True, eq=False)
class MapFrame:
    """The axes of a map, and the scales of its quantities; None where it is dimensionless."""

    x: MapAxis
    y: MapAxis
    scales: Scales | None

    @property
    def size(self) -> np.ndarray:
        """What points (x, p) are multiplied with to be shown, (2,)."""
        return np.array([self.x.size, self.y.size])


def frame_of_map(plane: StoredPlane, physical: bool) -> MapFrame:
    """The frame of a plane, in physical units or not."""
    scales = scales_of(plane.plan) if physical else None
    return MapFrame(*(_axis(plane, axis, scales) for axis in (plane.plan.sweep, plane.plan.parameter)), scales)


def _axis(plane: StoredPlane, axis, scales: Scales | None) -> MapAxis:
    name = axis.name
    if scales is not None and name in scales:
        scale = scales[name]
        low, high = sorted((axis.low * scale.shown, axis.high * scale.shown))
        return MapAxis(name, axis_text(scale.name, "", scale.unit), scale.name, scale.unit, low, high, scale.shown)
    unit = plane.attributes[name]["units"]
    label = plain(axis_label(name, plane.attributes[name]))
    return MapAxis(name, label, plain(symbol(name)), "" if unit == "1" else unit, axis.low, axis.high, 1.0)


def label_text(label: str) -> str:
    """A label n/I as people write it."""
    return label.replace("/-", "/\u2013")


def map_lines(plane: StoredPlane, frame: MapFrame) -> tuple[LineKind, ...]:
    """The boundaries between labels by kind, as the map of the figures has them, and the natural frequencies."""
    ends = (plane.plan.sweep.low, plane.plan.sweep.high), (plane.plan.parameter.low, plane.plan.parameter.high)
    allowed = DETAIL * np.array([high - low for low, high in ends])
    kinds = [
        LineKind(kind, plain(LINES[kind][1]), tuple(line * frame.size for line in _lines(outline, allowed)))
        for kind, outline in lines_of(plane, *ends).items()
    ]
    return (*kinds, *_modes(plane, frame, allowed))


def _lines(outline: Outline, allowed: np.ndarray) -> list[np.ndarray]:
    """The lines of an outline, cubics among them as points."""
    vertices, codes = outline.vertices, outline.codes
    if codes is None:
        return [vertices] if len(vertices) else []
    begins = np.flatnonzero(codes == Outline.MOVETO)
    found = []
    for part, kind in zip(np.split(vertices, begins[1:]), np.split(codes, begins[1:]), strict=True):
        if len(part) > 1 and kind[1] == Outline.CURVE4:
            # Neighbouring cubics share a point.
            controls = np.concatenate([part[:-1].reshape(-1, 3, 2), part[3::3, None]], axis=1)
            part = flattened(controls, allowed)
        found.append(part)
    return found


def _modes(plane: StoredPlane, frame: MapFrame, allowed: np.ndarray) -> list[LineKind]:
    """Natural frequencies as far as they lie within the plane."""
    if not np.any(plane.resonances):
        return []
    kinds = []
    for number, (energy, seen) in enumerate(zip(mesh_energies(plane), plane.resonances, strict=True)):
        if seen:
            line = np.column_stack([plane.modes[:, number], plane.rows])
            line = thinned(line[np.isfinite(line[:, 0])], allowed) * frame.size
            kinds.append(LineKind(f"mode {number + 1}", f"linear mode, {energy}", (line,)))
    return kinds


def marks_of(marks: dict, frame: MapFrame) -> tuple[MarkKind, ...]:
    """The marks of a panel of the figures."""
    return tuple(MarkKind(kind.name, MARK_NAMES[kind], places * frame.size) for kind, places in marks.items())


def told_of_cells(plane: StoredPlane, frame: MapFrame) -> tuple[Told, ...]:
    """What is told of every cell where attractors are stored: what integration found, and what that makes of the
    label."""
    found = read_attractors(plane.path)
    if found is None:
        return ()
    kinds, impacts = found.kind.values.astype(np.int64), found.impact.values.astype(np.int64)
    # Every set of attractors once: the order of slots says nothing.
    code = np.sort(np.where(kinds > 0, kinds * 16 + impacts + 1, 0), axis=-1)
    sets, place = np.unique(code.reshape(-1, code.shape[-1]), axis=0, return_inverse=True)
    texts = tuple(cell_label(one // 16, one % 16 - 1) or "nothing found" for one in sets)
    columns, rows = attractor_borders(plane, found)
    place, judged = place.reshape(kinds.shape[:-1]), found.credibility.values.astype(np.int64)
    words = tuple(kind.words for kind in Credibility)
    return (
        Told("integration", evenly(place, columns, rows, frame, plane), texts),
        Told("verdict", evenly(judged, columns, rows, frame, plane), words),
    )


def evenly(values: np.ndarray, columns: np.ndarray, rows: np.ndarray, frame: MapFrame, plane: StoredPlane) -> Cells:
    """Cells (P, X) between borders (X + 1,) and (P + 1,) as cells of one size.

    Where they are uneven, as borders halfway between some columns of the plane are, they become cells of half a column
    and half a row.
    """
    for axis, borders, steps in ((1, columns, plane.plan.sweep.num), (0, rows, plane.plan.parameter.num)):
        widths = np.diff(borders)
        if np.ptp(widths) > 1e-9 * widths.max():
            middles = borders[0] + (np.arange(2 * steps) + 0.5) / (2 * steps) * (borders[-1] - borders[0])
            values = np.take(values, np.searchsorted(borders[1:-1], middles), axis=axis)
    x, y = (tuple((ends[[0, -1]] * size).tolist()) for ends, size in zip((columns, rows), frame.size, strict=True))
    return Cells(x, y, values)


def plane_cells(plane: StoredPlane, values: np.ndarray, frame: MapFrame) -> Cells:
    """Values of the cells of the plane itself."""
    return evenly(values, cell_borders(plane.plan.sweep), cell_borders(plane.plan.parameter), frame, plane)
