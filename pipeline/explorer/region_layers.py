"""Labels n/I over the plane: exact regions where boundaries are stored and divide it, otherwise the cells."""

from collections.abc import Mapping

import numpy as np

from pipeline.explorer.boxes import cell_boxes
from pipeline.explorer.layer_data import AreaClass, Layer, Shade, Written
from pipeline.explorer.map_frame import MapFrame, label_text, map_lines, marks_of, plane_cells, told_of_cells
from pipeline.figures.layout import HEIGHT, PANEL
from pipeline.figures.map import label_places
from pipeline.figures.map_legend import share_text
from pipeline.figures.naming import STATE_NAMES
from pipeline.figures.palette import hex_colour, label_colour, text_colour
from pipeline.figures.panels import DETAIL, Panel, cell_borders, panel_of, shares_of_labels
from pipeline.plane.division import stored_division
from pipeline.plane.outlines import region_polygons
from pipeline.plane.stored import StoredPlane
from pipeline.store import FAILED
from solver import ImpactState
from solver.regions.division import Division
from solver.regions.labelling import dynamic_code, is_contradictory, static_code

__all__ = ["label_cells", "region_layer", "sketch"]


def region_layer(plane: StoredPlane, name: str, frame: MapFrame) -> Layer:
    """The labels of a plane, counted as it counts them.

    Parameters
    ----------
    plane : StoredPlane
    name : str
        Of the layer.
    frame : MapFrame
    """
    division, panel = stored_division(plane), panel_of(plane)
    if division is None:
        classes, cells = label_cells(plane, frame, shares_of_labels(plane))
        shades = _shaded_cells(plane, frame)
    else:
        classes, cells = _regions(plane, division, frame), None
        shades = _shaded_regions(plane, division, frame)
    return Layer(
        name,
        _title(plane),
        "",
        frame.x,
        frame.y,
        classes=classes,
        cells=cells,
        shades=(*shades, *_unknown(plane, frame)),
        lines=map_lines(plane, frame),
        marks=marks_of(panel.marks, frame),
        written=_written(plane, panel, frame),
        told=told_of_cells(plane, frame),
        notes=_notes(plane, classes, shades, division is None),
    )


def sketch(plane: StoredPlane, name: str, frame: MapFrame) -> Layer:
    """The cells of a plane alone, which are there at once, while its boundaries are being put together."""
    classes, cells = label_cells(plane, frame)
    return Layer(name, _title(plane), "", frame.x, frame.y, classes=classes, cells=cells, shades=_unknown(plane, frame))


def _title(plane: StoredPlane) -> str:
    return f"n/I: number of {'dynamically stable' if plane.dynamic else 'stable'} motions, and their impact states"


def label_cells(plane: StoredPlane, frame: MapFrame, shares: Mapping[int, float] | None = None):
    """The classes of labels in the cells of a plane, with their shares of it where those are given, and the cells."""
    codes, place = np.unique(plane.domain, return_inverse=True)
    known = [int(code) for code in codes if code]
    classes = tuple(_class(plane, code, shares) for code in known)
    number = {code: i for i, code in enumerate(known)}
    table = np.array([number.get(int(code), -1) for code in codes])
    return classes, plane_cells(plane, table[place.reshape(plane.domain.shape)], frame)


def _class(plane: StoredPlane, code: int, shares: Mapping[int, float] | None, polygons=()) -> AreaClass:
    label = plane.labels[code]
    share = "" if shares is None else share_text(shares.get(code, 0.0))
    return AreaClass(label_text(label), hex_colour(label_colour(label)), share, polygons)


def _regions(plane: StoredPlane, division: Division, frame: MapFrame) -> tuple[AreaClass, ...]:
    meaning, shares = dynamic_code if plane.dynamic else static_code, shares_of_labels(plane)
    found = region_polygons(division, DETAIL, lambda code: int(meaning(code)))
    return tuple(
        _class(plane, code, shares, tuple(polygon * frame.size for polygon in polygons))
        for code, polygons in found.items()
        if code
    )


def _shaded_regions(plane: StoredPlane, division: Division, frame: MapFrame) -> list[Shade]:
    """Where motions that are counted are dynamically unstable, and where the two kinds of stability contradict."""

    def kind(code: int) -> int:
        unstable = not plane.dynamic and static_code(code) != dynamic_code(code)
        return int(unstable) | 2 * int(bool(is_contradictory(code)))

    found, shares = region_polygons(division, DETAIL, kind), _shares_by(division, kind)
    shades = []
    for bit, (text, pattern) in _SHADES.items():
        polygons = tuple(one * frame.size for code, some in found.items() if code & bit for one in some)
        share = sum((share for code, share in shares.items() if code & bit), 0.0)
        if polygons:
            shades.append(Shade(text, pattern, "#262626", polygons, share=share_text(share)))
    return shades


_SHADES = {1: ("not all n dynamically stable", "lines"), 2: ("stability contradictory", "dots")}


def _shares_by(division: Division, kind) -> dict[int, float]:
    shares: dict[int, float] = {}
    for code, share in division.shares().items():
        shares[kind(code)] = shares.get(kind(code), 0.0) + share
    return shares


def _shaded_cells(plane: StoredPlane, frame: MapFrame) -> list[Shade]:
    codes = plane.stability_codes
    unstable = (static_code(codes) != dynamic_code(codes)) & (not plane.dynamic)
    marked = {1: unstable, 2: is_contradictory(codes)}
    return [
        Shade(text, pattern, "#262626", boxes=_boxes_of(plane, marked[bit], frame))
        for bit, (text, pattern) in _SHADES.items()
        if np.any(marked[bit])
    ]


def _unknown(plane: StoredPlane, frame: MapFrame) -> list[Shade]:
    """Rows that are not complete, on which regions cover nothing, and cells that may have motions above the ceiling."""
    rows = {
        "row failed": ("lines", plane.status == FAILED),
        "row not computed": ("dots", ~plane.complete & (plane.status != FAILED)),
    }
    shades = []
    for text, (pattern, some) in rows.items():
        if np.any(some):
            boxes = _boxes_of(plane, np.broadcast_to(some[:, None], plane.domain.shape), frame)
            shades.append(Shade(text, pattern, "#737373", boxes=boxes, covers=True))
    if np.any(open_ := plane.open == 1):
        text = "not excluded: motions above the ceiling of λ_a"
        shades.append(Shade(text, "crosses", "#000000", boxes=_boxes_of(plane, open_, frame)))
    return shades


def _boxes_of(plane: StoredPlane, marked: np.ndarray, frame: MapFrame) -> np.ndarray:
    return cell_boxes(marked, cell_borders(plane.plan.sweep), cell_borders(plane.plan.parameter), frame.size)


def _written(plane: StoredPlane, panel: Panel, frame: MapFrame) -> tuple[Written, ...]:
    """n/I where the map of the figures writes it, narrow regions with a line that leads there."""
    low = np.array([panel.x[0], panel.y[0]])
    span = np.array([panel.x[1], panel.y[1]]) - low

    def shown(place: tuple[float, float] | None) -> tuple[float, float] | None:
        return None if place is None else tuple(((low + np.array(place) * span) * frame.size).tolist())

    found = []
    for one in label_places(panel, plane, (PANEL, HEIGHT)):
        colour = label_colour(plane.labels[one.code])
        found.append(Written(one.text, shown(one.place), hex_colour(colour), text_colour(colour), shown(one.leads_to)))
    return tuple(found)


def _notes(plane: StoredPlane, classes: tuple[AreaClass, ...], shades: list[Shade], of_cells: bool) -> tuple[str, ...]:
    symbols = {part for one in classes for part in one.name.split("/")[1].split("-")}
    texts = [f"n: {'dynamically stable' if plane.dynamic else 'stable'} motions"]
    texts += [f"I = {state.symbol}: {STATE_NAMES[state]}" for state in ImpactState if state.symbol in symbols]
    if any(one.name == "0/\u2013" for one in classes):
        texts.append("0/\u2013: no stable motion of 1T")
    if any(shade.name == _SHADES[2][0] for shade in shades):
        texts.append("contradictory: the order is too low there")
    return (*texts, "areas: cells of the raster") if of_cells else tuple(texts)
