"""The n/I map: labels as colours, folds and grazings as lines, narrow regions enlarged below; and parts of it alone."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import PathPatch

from pipeline.figures.cell_panels import outline_of
from pipeline.figures.drawing import Drawing
from pipeline.figures.layout import (
    BETWEEN,
    BOTTOM,
    HEIGHT,
    LEFT,
    LEGEND,
    PANEL,
    RIGHT,
    TOP,
    WIDTH,
    ZOOM_HEIGHT,
    enlarged,
    mark_window,
    shares_of,
    zoom_places,
)
from pipeline.figures.map_legend import (
    CONTRADICTORY_CELLS,
    FAILED_ROWS,
    LINES,
    MARKS,
    MODES,
    OPEN_CELLS,
    UNSTABLE_CELLS,
    Entry,
    draw_legend,
    legend_entries,
    legend_height,
)
from pipeline.figures.naming import axis_label, fixed_parameters
from pipeline.figures.palette import label_colour
from pipeline.figures.panels import Panel, cell_borders, panel_of
from pipeline.figures.physical_axes import lift, show_units, spare, titled
from pipeline.figures.windows import coexistence_windows
from pipeline.plane.stored import StoredPlane
from pipeline.store import FAILED

__all__ = ["draw_map", "draw_window", "fill", "modes_within", "with_main_panel"]

#: Inches for the line of fixed parameters above the marks of windows, where physical values make it long.
_HEAD = 0.14
#: A window this narrow, as a share of the values in it, writes what its ticks have in common once.
_NARROW = 1e-3


def draw_map(plane: StoredPlane) -> Drawing:
    """Draw the map of a plane.

    Where several stable motions coexist in a narrow stretch of the sweep axis, a panel below enlarges that stretch.

    Parameters
    ----------
    plane : StoredPlane

    Returns
    -------
    Drawing
    """
    sweep = plane.plan.sweep
    zooms = [panel_of(plane, window) for window in coexistence_windows(plane.pieces, sweep.low, sweep.high)]
    whole = panel_of(plane)
    below = ZOOM_HEIGHT + BETWEEN + lift(plane) if zooms else 0.0
    figure, main, labels = with_main_panel(plane, [whole, *zooms], below, True)
    height = figure.get_figheight()
    if zooms:
        titled(main, plane, "(a)")
    for i, (panel, place) in enumerate(zip(zooms, zoom_places(len(zooms), spare(plane)), strict=True)):
        axes = figure.add_axes(shares_of(place, height), sharey=main)
        fill(axes, panel, plane)
        titled(axes, plane, f"({'bc'[i]})")
        axes.set(xlabel=labels[0], ylabel=labels[1] if i == 0 else "")
        axes.tick_params(labelleft=i == 0)
        axes.locator_params(axis="x", nbins=6)
        names = (plane.plan.sweep.name, plane.plan.parameter.name)
        show_units(axes, plane, *names, sides="bt" + "l" * (i == 0) + "r" * (i == len(zooms) - 1))
        mark_window(main, panel.x, "bc"[i], lift(plane) / (main.get_position().height * height))
    return figure


def draw_window(plane: StoredPlane, window: list[float]) -> Drawing:
    """Draw a part of the plane alone.

    Parameters
    ----------
    plane : StoredPlane
    window : list of float
        Low and high end on the sweep axis, then on the parameter axis.

    Returns
    -------
    Drawing
    """
    figure, axes, _ = with_main_panel(plane, [panel_of(plane, tuple(window[:2]), tuple(window[2:]))], 0.0, False)
    axes.set(xlim=window[:2], ylim=window[2:])
    axes.locator_params(axis="x", nbins=5)
    for axis, low, high in ((axes.xaxis, *window[:2]), (axes.yaxis, *window[2:])):
        # Ticks of a narrow window share most of their digits, and there is no room for them.
        axis.get_major_formatter().set_useOffset(high - low < _NARROW * max(abs(low), abs(high)))
    return figure


def with_main_panel(plane: StoredPlane, panels: list[Panel], below: float, shares: bool, further: Sequence[Entry] = ()):
    """A figure with the first panel and the legend of all and of what is drawn further, with room below: figure, axes
    and their labels."""
    entries = [*_entries(plane, panels, shares), *further]
    tall = max(HEIGHT, legend_height(entries))
    bottom = BOTTOM + below
    height = bottom + tall + TOP + lift(plane) + (0.0 if plane.scales is None else _HEAD)
    figure = Drawing((WIDTH, height))
    axes = figure.add_axes(shares_of((LEFT, bottom, PANEL - spare(plane), tall), height))
    fill(axes, panels[0], plane)
    fixed = fixed_parameters(plane.plan, plane.scales)
    figure.text(1 - RIGHT / WIDTH, 1 - 0.06 / height, fixed, ha="right", va="top", fontsize=8)
    names = (plane.plan.sweep.name, plane.plan.parameter.name)
    labels = tuple(axis_label(name, plane.attributes[name]) for name in names)
    axes.set(xlabel=labels[0], ylabel=labels[1])
    show_units(axes, plane, *names)
    draw_legend(figure, entries, LEGEND, bottom + tall)
    return figure, axes, labels


def _entries(plane: StoredPlane, panels: list[Panel], shares: bool) -> list[Entry]:
    shown = np.unique(np.concatenate([np.unique(panel.code) for panel in panels]))
    lines = {kind for panel in panels for kind in panel.lines}
    marks = {kind for panel in panels for kind in panel.marks}
    modes = np.any([modes_within(plane, panel) for panel in panels], axis=0)
    return legend_entries([plane], [int(code) for code in shown if code], lines, marks, modes, shares)


def modes_within(plane: StoredPlane, panel: Panel) -> np.ndarray:
    """Which of the two natural frequencies a panel shows, (2,) bool."""
    if not plane.over_frequency:
        return np.zeros(2, dtype=bool)
    inside = (plane.rows >= panel.y[0]) & (plane.rows <= panel.y[1])
    levels = np.concatenate([panel.y, plane.rows[inside]])
    places = np.stack([np.interp(levels, plane.rows, mode) for mode in plane.modes.T])
    return np.any((places >= panel.x[0]) & (places <= panel.x[1]), axis=1)


def fill(axes: Axes, panel: Panel, plane: StoredPlane) -> None:
    """Fill a panel with its labels, lines and marks."""
    axes.imshow(
        _image(panel.code, plane.labels),
        extent=(*panel.x, *panel.y),
        origin="lower",
        aspect="auto",
        interpolation="none",
        zorder=0,
    )
    # Not as patches: matplotlib would look for the extrema of every segment, and the limits are the panel's.
    for kind, outline in panel.lines.items():
        axes.add_artist(PathPatch(outline, fill=False, **LINES[kind][0]))
    for kind, places in panel.marks.items():
        axes.plot(*places.T, **MARKS[kind])
    columns, rows = cell_borders(plane.plan.sweep), cell_borders(plane.plan.parameter)
    failed = np.broadcast_to((plane.status == FAILED)[:, None], plane.domain.shape)
    unstable = plane.unstable & ~plane.contradictory & (not plane.dynamic)
    for kind, marked in (
        (FAILED_ROWS, failed),
        (OPEN_CELLS, plane.open == 1),
        (UNSTABLE_CELLS, unstable),
        (CONTRADICTORY_CELLS, plane.contradictory),
    ):
        if np.any(marked):
            axes.add_artist(PathPatch(outline_of(marked, columns, rows), **kind))
    if plane.over_frequency:
        for kind, frequency in zip(MODES, plane.modes.T, strict=True):
            # To the borders of the first and last row, where the frequency is that of the row.
            x, y = np.pad(frequency, 1, mode="edge"), np.concatenate([rows[:1], plane.rows, rows[-1:]])
            axes.plot(x, y, **kind)
    axes.set(xlim=panel.x, ylim=panel.y)


def _image(code: np.ndarray, labels: dict[int, str]) -> np.ndarray:
    """Colours of the cells, (P, X, 3) uint8, each cell a block of whole pixels."""
    present, place = np.unique(code, return_inverse=True)
    colours = np.array([label_colour(labels[int(value)]) for value in present], dtype=np.uint8)
    return enlarged(colours[place.reshape(code.shape)])
