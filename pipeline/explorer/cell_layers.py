"""What is known cell by cell: what integration finds, how far labels can be trusted, quantities of the motions."""

import numpy as np

from pipeline.analysis.attractors.credibility import Credibility
from pipeline.analysis.attractors.dataset import read_attractors
from pipeline.analysis.attractors.sheets import map_labels, several_right
from pipeline.analysis.attractors.wording import percents
from pipeline.config.quantities import Quantity
from pipeline.explorer.boxes import cell_boxes
from pipeline.explorer.layer_data import AreaClass, Cells, Layer, Shade, Told
from pipeline.explorer.map_frame import MapFrame, evenly, map_lines, plane_cells, told_of_cells
from pipeline.explorer.plain_text import quantity_title
from pipeline.explorer.region_layers import label_cells
from pipeline.figures.attractors import CLASSES, class_of
from pipeline.figures.cell_panels import attractor_borders
from pipeline.figures.palette import hex_colour
from pipeline.figures.panels import cell_borders
from pipeline.figures.quantity_map import ends_of
from pipeline.figures.verification import COLOURS
from pipeline.plane.quantities import scale_of
from pipeline.plane.stored import StoredPlane
from solver import ImpactState

__all__ = ["attractor_layer", "credibility_layer", "quantity_layer"]

_EXTREMES = {"worst": "Largest", "mildest": "Smallest"}
_INK = "#262626"


def quantity_layer(plane: StoredPlane, quantity: Quantity, of: str, frame: MapFrame) -> Layer:
    """A quantity of the motions that labels count, one value a cell."""
    scale = scale_of(quantity, frame.scales)
    values = plane.extreme(quantity.name, of) * (1.0 if scale is None else scale.shown)
    title = quantity_title(quantity, "" if scale is None else scale.unit)
    return Layer(
        quantity.name,
        f"{_EXTREMES[of]} {title} of the stable motions",
        "" if scale is None else scale.unit,
        frame.x,
        frame.y,
        cells=plane_cells(plane, values, frame),
        ends=ends_of(values),
        lines=map_lines(plane, frame),
        shades=_without_value(plane, values, frame),
        told=(_told_label(plane, frame), *told_of_cells(plane, frame)),
    )


def _without_value(plane: StoredPlane, values: np.ndarray, frame: MapFrame) -> tuple[Shade, ...]:
    if not np.any(empty := np.isnan(values)):
        return ()
    boxes = cell_boxes(empty, cell_borders(plane.plan.sweep), cell_borders(plane.plan.parameter), frame.size)
    return (Shade("no value: no stable motion", "dots", _INK, boxes=boxes, share=_share(empty)),)


def _share(cells: np.ndarray) -> str:
    return percents([int(cells.sum()), int((~cells).sum())])[0]


def _shares(counts: list[int]) -> list[str]:
    """In percent; empty of what there is none of, so that no legend has it."""
    return [share if count else "" for share, count in zip(percents(counts), counts, strict=True)]


def _told_label(plane: StoredPlane, frame: MapFrame) -> Told:
    """The label of the cell."""
    classes, cells = label_cells(plane, frame)
    texts = (*(one.name for one in classes), "not computed")
    values = np.where(cells.values < 0, len(classes), cells.values)
    return Told("n/I", Cells(cells.x, cells.y, values), texts)


def attractor_layer(plane: StoredPlane, frame: MapFrame) -> Layer:
    """What motions end on: the calmest kind as a colour, the most alarming of several as lines over it."""
    found = read_attractors(plane.path)
    kinds, impact = class_of(found.kind.values), found.impact.values
    columns, rows = attractor_borders(plane, found)
    calmest = np.min(np.where(kinds < 0, len(CLASSES), kinds), axis=-1)
    alarming, several = np.max(kinds, axis=-1), np.sum(kinds >= 0, axis=-1) >= 2
    alone = np.where(several, len(CLASSES), np.where(calmest == len(CLASSES), len(CLASSES) + 1, calmest))
    shares = _shares(np.bincount(alone.ravel(), minlength=len(CLASSES) + 2).tolist())
    shades = []
    for number, (name, colour) in enumerate(CLASSES):
        here = several & (alarming == number) & (calmest != number)
        if np.any(here):
            boxes = cell_boxes(here, columns, rows, frame.size)
            text = f"several, up to {name}"
            shades.append(Shade(text, "lines", hex_colour(colour), boxes=boxes, share=_share(here), bold=True))
    struck = np.any(impact == ImpactState.DOUBLE_SIDED, axis=-1)
    parting = (ImpactState.SINGLE_SIDED, ImpactState.FREE, ImpactState.MIRRORED_SINGLE_SIDED)
    lost = np.isin(impact, parting).any(axis=-1) & ~struck
    for text, pattern, here in (
        ("several of one kind", "lines", several & (alarming == calmest)),
        ("teeth part", "dots", lost),
        ("back flank struck", "crosses", struck),
    ):
        if np.any(here):
            boxes = cell_boxes(here, columns, rows, frame.size)
            shades.append(Shade(text, pattern, _INK, boxes=boxes, share=_share(here)))
    classes = tuple(
        AreaClass(name, hex_colour(colour), shares[number]) for number, (name, colour) in enumerate(CLASSES)
    )
    return Layer(
        "attractors",
        f"What motions end on: several coexist in {100.0 * several.mean():.1f} % of {several.size:,} cells",
        "",
        frame.x,
        frame.y,
        classes=classes,
        cells=evenly(np.where(calmest == len(CLASSES), -1, calmest), columns, rows, frame, plane),
        shades=tuple(shades),
        lines=map_lines(plane, frame),
        told=(_told_label(plane, frame), *told_of_cells(plane, frame)),
        notes=(str(found.attrs["bound"]),),
    )


def credibility_layer(plane: StoredPlane, frame: MapFrame) -> Layer:
    """How far the label of every cell holds by the cell's own attractors."""
    found = read_attractors(plane.path)
    labels, judged = map_labels(plane.path, plane.plan, found), found.credibility.values
    kinds = list(COLOURS)
    table = np.array([kinds.index(kind) for kind in Credibility])
    counts = [int(np.sum(judged[labels != 0] == kind)) for kind in kinds]
    classes = tuple(
        AreaClass(kind.words, hex_colour(COLOURS[kind]), share)
        for kind, share in zip(kinds, _shares(counts), strict=True)
    )
    right, several = several_right(labels, judged)
    title = (
        f"Where the label holds: right in {right:,} of {several:,} cells whose label counts several motions"
        if several
        else "Where the label holds; no label counts several motions"
    )
    return Layer(
        "credibility",
        title,
        "",
        frame.x,
        frame.y,
        classes=classes,
        cells=evenly(np.where(labels == 0, -1, table[judged]), *attractor_borders(plane, found), frame, plane),
        lines=map_lines(plane, frame),
        told=(_told_label(plane, frame), *told_of_cells(plane, frame)),
    )
