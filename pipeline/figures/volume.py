"""A volume: some of its layers in one row, and below in how many layers several motions coexist."""

import numpy as np
from matplotlib import colormaps
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline

from pipeline.figures.drawing import Drawing
from pipeline.figures.edges import curves_along, label_edges
from pipeline.figures.heading import HEAD, write_heading
from pipeline.figures.layout import BOTTOM, LEFT, LEGEND, PANEL, RIGHT, WIDTH, enlarged, from_zero, shares_of
from pipeline.figures.map import fill, modes_within, write_labels
from pipeline.figures.map_legend import Entry, draw_legend, legend_entries, legend_height
from pipeline.figures.naming import axis_label, value_text
from pipeline.figures.panels import cell_borders, panel_of
from pipeline.plane.stored import StoredPlane

__all__ = ["coexistence", "draw_volume", "shown_layers"]

_MOST = 5
#: Inches: between layers, height of one, room for a title, for the names of axes, least height of the overlay.
_GAP, _TALL, _TITLE, _NAMES, _OVERLAY = 0.12, 1.5, 0.22, 0.42, 2.6
#: From white, where several motions coexist in no layer, to the last colour, where they do in all.
_COLOURS = colormaps["YlOrRd"]
_DARKEST = 0.85
_ANY = {"edgecolor": "black", "linewidth": 0.8, "zorder": 3}


def shown_layers(volume: StoredPlane) -> dict[float, StoredPlane]:
    """Up to five evenly spaced layers of a stored volume by their value of parameter2, first and last included."""
    axis = volume.plan.parameter2
    chosen = np.unique(np.linspace(0, axis.num - 1, min(axis.num, _MOST)).round().astype(int)).tolist()
    return {float(axis.values[index]): volume.layer_at(index) for index in chosen}


def coexistence(volume: StoredPlane) -> np.ndarray:
    """In how many layers two or more stable motions coexist, (P, X)."""
    layers = (volume.layer_at(index) for index in range(volume.plan.parameter2.num))
    return sum(((layer.n_stable >= 2) & (layer.domain != 0)).astype(int) for layer in layers)


def draw_volume(stored: StoredPlane) -> Drawing:
    """Draw the maps of some layers of a volume in one row, and where several motions coexist in any layer.

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
    modes = np.any([modes_within(plane, panel) for plane, panel in zip(planes, panels, strict=True)], axis=0)
    counts, number = coexistence(stored), volume.parameter2.num
    entries = [*legend_entries(planes, panels, modes, False), Entry(), *_overlay_entries(counts, number)]
    foot = max(_OVERLAY + _TITLE, legend_height(entries))
    height = BOTTOM + foot + _NAMES + _TALL + _TITLE + HEAD
    figure = Drawing((WIDTH, height))
    write_heading(figure, stored)
    wide = (WIDTH - LEFT - RIGHT - (len(planes) - 1) * _GAP) / len(planes)
    low = BOTTOM + foot + _NAMES
    x, y = (axis_label(axis.name, planes[0].attributes[axis.name]) for axis in (volume.sweep, volume.parameter))
    for place, ((value, plane), panel) in enumerate(zip(layers.items(), panels, strict=True)):
        axes = figure.add_axes(shares_of((LEFT + place * (wide + _GAP), low, wide, _TALL), height))
        fill(axes, panel, plane)
        # No lines beside regions: there is no room, and the legend has the colours.
        write_labels(axes, panel, plane, [panel.x])
        axes.set_title(value_text(volume.parameter2.name, value))
        axes.tick_params(labelleft=place == 0)
        # Labels at both ends stand beside those of the next layer.
        axes.locator_params(axis="x", nbins=2)
        axes.locator_params(axis="y", nbins=4)
    middle = LEFT + 0.5 * (WIDTH - LEFT - RIGHT)
    figure.text(middle / WIDTH, (low - 0.2) / height, x, ha="center", va="top", fontsize=9)
    figure.text(0.05 / WIDTH, (low + 0.5 * _TALL) / height, y, ha="left", va="center", rotation=90, fontsize=9)
    axes = figure.add_axes(shares_of((LEFT, BOTTOM, PANEL, foot - _TITLE), height))
    _draw_overlay(axes, stored, counts)
    axes.set(xlabel=x, ylabel=y, title=f"layers in which $n$ is at least 2, of {number}")
    draw_legend(figure, entries, LEGEND, BOTTOM + foot)
    return figure


def _shade(count: int, number: int) -> tuple[float, float, float]:
    return (1.0, 1.0, 1.0) if count == 0 else _COLOURS(0.15 + (_DARKEST - 0.15) * count / number)[:3]


def _draw_overlay(axes, stored: StoredPlane, counts: np.ndarray) -> None:
    columns, rows = cell_borders(stored.plan.sweep), cell_borders(stored.plan.parameter)
    shades = np.array([_shade(count, stored.plan.parameter2.num) for count in range(counts.max() + 1)])
    axes.imshow(
        enlarged((255 * shades[counts]).round().astype(np.uint8)),
        extent=(columns[0], columns[-1], rows[0], rows[-1]),
        origin="lower",
        aspect="auto",
        interpolation="none",
    )
    # Around what coexists in any layer.
    there = np.where(counts > 0, 2, 1)
    edges = curves_along(label_edges(there, there)[0])
    lines = [Outline(np.column_stack([columns[corner[:, 1]], rows[corner[:, 0]]])) for corner in edges]
    if lines:
        axes.add_artist(PathPatch(Outline.make_compound_path(*lines), fill=False, **_ANY))
    axes.set(xlim=from_zero((columns[0], columns[-1])), ylim=from_zero((rows[0], rows[-1])))


def _overlay_entries(counts: np.ndarray, number: int) -> list[Entry]:
    """Keys of the overlay: how many layers, those that are there, at most five."""
    present = [int(count) for count in np.unique(counts) if count > 0]
    chosen = [present[i] for i in np.unique(np.linspace(0, len(present) - 1, min(5, len(present))).round().astype(int))]
    entries = [Entry("$n$ at least 2 in", area=None)] if chosen else [Entry("$n$ at least 2: nowhere")]
    return entries + [
        Entry(
            f"{count} of {number} layers",
            area={"facecolor": _shade(count, number), "edgecolor": "0.3", "linewidth": 0.4},
        )
        for count in chosen
    ]
