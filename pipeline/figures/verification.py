"""Where the map can be trusted: how far the label of every cell holds by the cell's own attractors."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from pipeline.analysis.attractors.credibility import Credibility
from pipeline.analysis.attractors.sheets import map_labels, several_right
from pipeline.analysis.attractors.wording import percents
from pipeline.figures.cell_panels import attractor_borders, cell_image, draw_cells, line_entries
from pipeline.figures.drawing import Drawing
from pipeline.figures.map_legend import Entry
from pipeline.figures.palette import hex_colour
from pipeline.plane.stored import StoredPlane

__all__ = ["COLOURS", "draw_verification"]

#: What is right is nearly white, what is wrong is not; the lightness tells all of them apart.
COLOURS = {
    Credibility.CONFIRMED: (238, 245, 240),
    Credibility.SHIFTED: (245, 214, 70),
    Credibility.UNCHECKED: (190, 190, 190),
    Credibility.MORE_MOTIONS_EXIST: (225, 135, 0),
    Credibility.WRONG_IMPACT_STATE: (190, 95, 150),
    Credibility.WRONG_COUNT: (190, 50, 10),
    Credibility.NOT_A_PERIOD_1_MOTION: (105, 5, 45),
}
#: Where the legend has no room for all of it.
_SHORT = {Credibility.NOT_A_PERIOD_1_MOTION: "not period-1"}
_NO_LABEL = (255, 255, 255)


def draw_verification(plane: StoredPlane, found, window: Sequence[float] | None = None) -> Drawing:
    """Draw how far labels can be trusted.

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
    labels, judged = map_labels(plane.path, plane.plan, found), found.credibility.values
    colours = np.array([COLOURS[kind] for kind in Credibility], dtype=np.uint8)[judged]
    colours[labels == 0] = _NO_LABEL
    columns, rows = attractor_borders(plane, found)

    def paint(axes: Axes) -> None:
        cell_image(axes, colours, columns, rows)

    right, several = several_right(labels, judged)
    share = f" ({100.0 * right / several:.1f} %)" if several else ""
    head = (
        f"Of {several:,} cells whose label counts several motions, {right:,}{share} are right"
        if several
        else "No label counts several motions"
    )
    entries = [*_entries(labels, judged), *line_entries(plane, window)]
    return draw_cells(plane, entries, paint, head, window)


def _entries(labels: np.ndarray, judged: np.ndarray) -> list[Entry]:
    counts = [int(np.sum(judged[labels != 0] == kind)) for kind in COLOURS]
    entries = [Entry("label of the map", "cells")]
    for (kind, colour), count, share in zip(COLOURS.items(), counts, percents(counts), strict=True):
        if count:
            area = {"facecolor": hex_colour(colour), "edgecolor": "0.3", "linewidth": 0.4}
            entries.append(Entry(_SHORT.get(kind, kind.words), share, area=area))
    return [*entries, Entry("all", "100.0 %")]
