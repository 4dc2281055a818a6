"""A volume as small multiples: the maps of some of its layers side by side, with one legend."""

import numpy as np

from pipeline.figures.drawing import Drawing
from pipeline.figures.layout import BOTTOM, LEFT, LEGEND, PANEL, RIGHT, WIDTH, shares_of
from pipeline.figures.map import fill, modes_within
from pipeline.figures.map_legend import draw_legend, legend_entries, legend_height
from pipeline.figures.naming import axis_label, fixed_parameters, value_text
from pipeline.figures.panels import panel_of
from pipeline.plane.stored import StoredPlane

__all__ = ["draw_volume", "shown_layers"]

_MOST, _COLUMNS = 9, 3
#: Inches: between panels, height of one, room for its title, room above all.
_GAP, _TALL, _TITLE, _ABOVE = 0.14, 1.42, 0.24, 0.06


def shown_layers(volume: StoredPlane) -> dict[float, StoredPlane]:
    """Up to nine evenly spaced layers of a stored volume by their value of parameter2, first and last included."""
    axis = volume.plan.parameter2
    chosen = np.unique(np.linspace(0, axis.num - 1, min(axis.num, _MOST)).round().astype(int)).tolist()
    return {float(axis.values[index]): volume.layer_at(index) for index in chosen}


def draw_volume(stored: StoredPlane) -> Drawing:
    """Draw the maps of some layers of a volume.

    Parameters
    ----------
    stored : StoredPlane
        The volume.

    Returns
    -------
    Drawing
    """
    volume, layers = stored.plan, shown_layers(stored)
    planes = list(layers.values())
    panels = [panel_of(plane) for plane in planes]
    entries = _entries(planes, panels)
    rows = -(-len(planes) // _COLUMNS)
    tall = max(rows * (_TALL + _TITLE), legend_height(entries) + _TITLE)
    height = BOTTOM + tall + _ABOVE
    figure, wide = Drawing((WIDTH, height)), (PANEL - (_COLUMNS - 1) * _GAP) / _COLUMNS
    for number, (value, plane) in enumerate(layers.items()):
        row, column = divmod(number, _COLUMNS)
        bottom = BOTTOM + tall - (row + 1) * (_TALL + _TITLE)
        axes = figure.add_axes(shares_of((LEFT + column * (wide + _GAP), bottom, wide, _TALL), height))
        fill(axes, panels[number], plane)
        axes.set_title(value_text(volume.parameter2.name, value))
        axes.tick_params(labelleft=column == 0, labelbottom=number + _COLUMNS >= len(planes))
        axes.locator_params(axis="x", nbins=4)
        axes.locator_params(axis="y", nbins=4)
    foot = BOTTOM + tall - rows * (_TALL + _TITLE)
    x, y = (axis_label(axis.name, planes[0].attributes[axis.name]) for axis in (volume.sweep, volume.parameter))
    used = min(len(planes), _COLUMNS) * (wide + _GAP) - _GAP
    figure.text((LEFT + 0.5 * used) / WIDTH, (foot - BOTTOM + 0.04) / height, x, ha="center", va="bottom", fontsize=9)
    middle = 0.5 * (foot + BOTTOM + tall - _TITLE)
    figure.text(0.05 / WIDTH, middle / height, y, ha="left", va="center", rotation=90, fontsize=9)
    figure.text(1 - RIGHT / WIDTH, 1 - 0.06 / height, fixed_parameters(volume), ha="right", va="top", fontsize=8)
    draw_legend(figure, entries, LEGEND, BOTTOM + tall - _TITLE)
    return figure


def _entries(planes, panels) -> list:
    """What any of the panels shows."""
    modes = np.any([modes_within(plane, panel) for plane, panel in zip(planes, panels, strict=True)], axis=0)
    return legend_entries(planes, panels, modes, False)
