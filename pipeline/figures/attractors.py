"""What really happens: the kinds of motions found in every cell, whether several coexist, and whether teeth part.

The colour says what kind of motion it is, the lightness alone too; where several coexist, stripes have all their
colours with thin lines between them. Dots: teeth part in one of them at least; crosses: both flanks are struck.
"""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline

from pipeline.analysis.attractors.wording import likely_missed, percents
from pipeline.figures.cell_panels import attractor_borders, cell_image, draw_cells, line_entries, outline_of
from pipeline.figures.drawing import Drawing
from pipeline.figures.map_legend import Entry
from pipeline.figures.palette import hex_colour
from pipeline.plane.stored import StoredPlane
from solver import ImpactState
from solver.timedomain import AttractorKind

__all__ = ["class_of", "draw_attractors", "stripes"]

#: Name and colour of what is told apart, from calm to alarming; the lightness falls by 9 (CIE) at least from one to the
#: next, so that they stay apart in grey, and hues are those of Okabe and Ito, which colour-blind eyes tell apart.
CLASSES = (
    ("1T", (222, 235, 247)),
    ("not settled", (198, 198, 198)),
    ("2T", (230, 159, 0)),
    ("3T and longer", (0, 150, 110)),
    ("quasi-periodic", (0, 100, 170)),
    ("chaotic", (138, 20, 20)),
    ("unbounded", (0, 0, 0)),
)
_NOTHING = (255, 255, 255)
#: Parts of a stripe pattern that can be told apart: enough for one, two, three or six motions side by side.
_PARTS = 6
#: Inches across the pattern; hatches of impact states, sparse enough for the colours to be seen.
_PERIOD = 0.11
_DOTS = {"facecolor": "none", "edgecolor": "0.15", "linewidth": 0.0, "hatch": "..", "zorder": 1.5}
_CROSSES = {"facecolor": "none", "edgecolor": "0.15", "linewidth": 0.0, "hatch": "xx", "zorder": 1.5}
_BETWEEN = {"color": "0.1", "linewidth": 0.35, "zorder": 1.2}


def class_of(kind: np.ndarray) -> np.ndarray:
    """Number in `CLASSES` of kinds of attractors; -1 for none."""
    table = np.full(len(AttractorKind), -1)
    table[AttractorKind.PERIOD_1], table[AttractorKind.UNSETTLED], table[AttractorKind.PERIOD_2] = 0, 1, 2
    table[AttractorKind.PERIOD_3 : AttractorKind.PERIOD_LONGER + 1] = 3
    table[AttractorKind.QUASI_PERIODIC], table[AttractorKind.CHAOTIC], table[AttractorKind.UNBOUNDED] = 4, 5, 6
    return table[kind]


def stripes(classes: np.ndarray) -> np.ndarray:
    """Class of every part of the stripe pattern of every cell, (P, X, parts); -1 where nothing was found.

    Examples
    --------
    >>> stripes(np.array([[[0, -1, -1], [2, 0, -1]]])).tolist()
    [[[0, 0, 0, 0, 0, 0], [0, 0, 0, 2, 2, 2]]]
    """
    # The calm ones first; what is none last.
    order = np.sort(np.where(classes < 0, len(CLASSES), classes), axis=-1)
    count = np.sum(classes >= 0, axis=-1)[..., None].clip(1, _PARTS)
    which = np.arange(_PARTS) * count // _PARTS
    found = np.take_along_axis(order, which.clip(0, order.shape[-1] - 1), axis=-1)
    return np.where(found == len(CLASSES), -1, found)


def draw_attractors(plane: StoredPlane, found, window: Sequence[float] | None = None) -> Drawing:
    """Draw the attractors of a plane.

    Parameters
    ----------
    plane : StoredPlane
    found : xarray.Dataset
        The group `attractors`.
    window : (x low, x high, p low, p high), optional
        The part of the plane that is drawn; all of it unless given.

    Returns
    -------
    Drawing
    """
    kind, impact = found.kind.values, found.impact.values
    classes = class_of(kind)
    parts, several = stripes(classes), np.sum(classes >= 0, axis=-1) >= 2
    columns, rows = attractor_borders(plane, found)
    struck = np.isin(impact, (ImpactState.DOUBLE_SIDED,)).any(axis=-1)
    lost = np.isin(impact, (ImpactState.SINGLE_SIDED, ImpactState.FREE, ImpactState.MIRRORED_SINGLE_SIDED)).any(axis=-1)
    lost &= ~struck
    table = np.array([*(colour for _, colour in CLASSES), _NOTHING], dtype=np.uint8)

    def paint(axes: Axes) -> None:
        patterns = _patterns(axes)
        for part in range(_PARTS):
            if part and np.array_equal(parts[..., part], parts[..., 0]):
                continue
            image = cell_image(axes, table[parts[..., part]], columns, rows, 0.1 * part)
            if part:
                image.set_clip_path(patterns[part], transform=axes.transAxes)
        if several.any():
            _separate(axes, outline_of(several, columns, rows))
        for marked, style in ((lost, _DOTS), (struck, _CROSSES)):
            if marked.any():
                axes.add_artist(PathPatch(outline_of(marked, columns, rows), **style))

    share = 100.0 * float(np.mean(several))
    head = f"What motions end on: several coexist in {share:.1f} % of {several.size:,} cells"
    entries = _entries(found, parts, several, lost, struck, line_entries(plane, window))
    return draw_cells(plane, entries, paint, head, window)


def _patterns(axes: Axes) -> list[Outline]:
    """Diagonal stripes over the axes, in their own units, for every part of the pattern."""
    width, height = _inches(axes)
    patterns = []
    for part in range(_PARTS):
        polygons = []
        for start in np.arange(-height, width + _PERIOD, _PERIOD) + part * _PERIOD / _PARTS:
            stop = start + _PERIOD / _PARTS
            corners = np.array([[start, 0.0], [stop, 0.0], [stop + height, height], [start + height, height]])
            polygons.append(Outline(np.vstack([corners, corners[:1]]) / (width, height), closed=True))
        patterns.append(Outline.make_compound_path(*polygons))
    return patterns


def _separate(axes: Axes, region: Outline) -> None:
    """Thin diagonal lines at the borders of stripes, within a region."""
    width, height = _inches(axes)
    starts = np.arange(-height, width + _PERIOD, _PERIOD / 2.0)
    lines = Outline.make_compound_path(
        *(Outline(np.array([[start, 0.0], [start + height, height]]) / (width, height)) for start in starts)
    )
    patch = PathPatch(lines, fill=False, transform=axes.transAxes, **_BETWEEN)
    axes.add_artist(patch)
    patch.set_clip_path(region, transform=axes.transData)


def _inches(axes: Axes) -> tuple[float, float]:
    box, (width, height) = axes.get_position(), axes.figure.get_size_inches()
    return box.width * width, box.height * height


def _entries(found, parts, several, lost, struck, lines: list[Entry]) -> list[Entry]:
    alone = np.where(several, len(CLASSES), parts[..., 0])
    counts = [int(np.sum(alone == number)) for number in range(len(CLASSES) + 1)] + [int(np.sum(alone < 0))]
    shares = percents(counts)
    border = {"edgecolor": "0.3", "linewidth": 0.4}
    entries = [Entry("one motion alone", "cells")]
    shown = np.unique(parts)
    for number, (name, colour) in enumerate(CLASSES):
        if number in shown:
            share = shares[number] if counts[number] else ""
            entries.append(Entry(name, share, area={"facecolor": hex_colour(colour), **border}))
    if several.any():
        entries.append(Entry("several (striped)", shares[len(CLASSES)], area={**_striped(), **border}))
    if counts[-1]:
        entries.append(Entry("row failed", shares[-1], area={"facecolor": "white", **border}))
    impacts = ((lost, _DOTS, "teeth part, $I$ = 1"), (struck, _CROSSES, "back struck, $I$ = 2"))
    marked = [
        Entry(text, f"{100.0 * cells.mean():.1f} %", area={**style, "linewidth": 0.4, "edgecolor": "0.15"})
        for cells, style, text in impacts
        if cells.any()
    ]
    if marked:
        entries += [Entry(), Entry("in one motion at least"), *marked]
    starts = int(found.attrs["starts"])
    said = [
        Entry(),
        Entry(f"{starts} random starts a cell:"),
        Entry("a basin of share $p$ is missed"),
        Entry(f"with probability $(1-p)^{{{starts}}}$,"),
        Entry(f"5 % at $p$ = {100.0 * likely_missed(starts):.2g} %"),
    ]
    return [*entries, *lines, *said]


def _striped() -> dict:
    return {"facecolor": hex_colour(CLASSES[0][1]), "hatch": "////"}
