"""The n/I map: labels as colours, folds and grazings as lines, narrow regions enlarged below; and parts of it alone."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, NoNorm
from matplotlib.patches import PathPatch

from pipeline.figures.cell_panels import outline_of
from pipeline.figures.drawing import Drawing
from pipeline.figures.heading import HEAD, write_heading
from pipeline.figures.layout import (
    BETWEEN,
    BOTTOM,
    HEIGHT,
    LEFT,
    LEGEND,
    PANEL,
    TOP,
    WIDTH,
    ZOOM_HEIGHT,
    enlarged,
    from_zero,
    mark_window,
    shares_of,
    show_window,
    zoom_places,
)
from pipeline.figures.map_legend import (
    FAILED_ROWS,
    LINES,
    MARKS,
    OPEN_CELLS,
    Entry,
    draw_legend,
    legend_entries,
    legend_height,
    mode_style,
)
from pipeline.figures.naming import axis_label
from pipeline.figures.palette import hex_colour, label_colour, text_colour
from pipeline.figures.panels import Panel, cell_borders, panel_of
from pipeline.figures.physical_axes import lift, show_units, spare, titled
from pipeline.figures.region_labels import RegionLabel, placed_labels
from pipeline.figures.shading import draw_dots, draw_lines
from pipeline.figures.windows import coexistence_windows
from pipeline.plane.stored import StoredPlane
from pipeline.store import FAILED

__all__ = ["draw_map", "draw_window", "fill", "label_places", "modes_within", "with_main_panel", "write_labels"]


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
    zooms = [panel_of(plane, window) for window in coexistence_windows(plane)]
    whole = panel_of(plane)
    below = ZOOM_HEIGHT + BETWEEN + lift(plane) if zooms else 0.0
    figure, main, labels = with_main_panel(plane, [whole, *zooms], below, True)
    height = figure.get_figheight()
    write_labels(main, whole, plane, [zoom.x for zoom in zooms])
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
        write_labels(axes, panel, plane)
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
    panel = panel_of(plane, tuple(window[:2]), tuple(window[2:]))
    figure, axes, _ = with_main_panel(plane, [panel], 0.0, False)
    show_window(axes, window)
    write_labels(axes, panel, plane)
    return figure


def with_main_panel(plane: StoredPlane, panels: list[Panel], below: float, shares: bool, further: Sequence[Entry] = ()):
    """A figure with the first panel and the legend of all and of what is drawn further, with room below: figure, axes
    and their labels."""
    entries = [*_entries(plane, panels, shares), *further]
    tall = max(HEIGHT, legend_height(entries))
    bottom = BOTTOM + below
    height = bottom + tall + TOP + lift(plane) + HEAD
    figure = Drawing((WIDTH, height))
    axes = figure.add_axes(shares_of((LEFT, bottom, PANEL - spare(plane), tall), height))
    fill(axes, panels[0], plane)
    write_heading(figure, plane)
    names = (plane.plan.sweep.name, plane.plan.parameter.name)
    labels = tuple(axis_label(name, plane.attributes[name]) for name in names)
    axes.set(xlabel=labels[0], ylabel=labels[1])
    show_units(axes, plane, *names)
    draw_legend(figure, entries, LEGEND, bottom + tall)
    return figure, axes, labels


def _entries(plane: StoredPlane, panels: list[Panel], shares: bool) -> list[Entry]:
    modes = np.any([modes_within(plane, panel) for panel in panels], axis=0)
    return legend_entries([plane], panels, modes, shares)


def modes_within(plane: StoredPlane, panel: Panel) -> np.ndarray:
    """Which natural frequencies a panel shows, (m,) bool."""
    if not plane.over_frequency:
        return np.zeros(plane.modes.shape[1], dtype=bool)
    inside = (plane.rows >= panel.y[0]) & (plane.rows <= panel.y[1])
    levels = np.concatenate([panel.y, plane.rows[inside]])
    places = np.array([np.interp(levels, plane.rows, mode) for mode in plane.modes.T]).reshape(-1, levels.size)
    return np.any((places >= panel.x[0]) & (places <= panel.x[1]), axis=1)


def fill(axes: Axes, panel: Panel, plane: StoredPlane) -> None:
    """Fill a panel with its labels, lines and marks."""
    colours = [label_colour(plane.labels[code]) for code in panel.present.tolist()]
    numbers = np.zeros(panel.present[-1] + 1, np.uint8)
    numbers[panel.present] = np.arange(len(colours))
    numbers = numbers[panel.code]
    axes.imshow(
        enlarged(numbers),
        cmap=ListedColormap(np.array(colours) / 255.0),
        norm=NoNorm(),
        extent=(*panel.x, *panel.y),
        origin="lower",
        aspect="auto",
        interpolation="none",
        # The numbers are laid on pixels, and not their colours, which would be four times as many.
        interpolation_stage="data",
        zorder=0,
    )
    # Not as patches: matplotlib would look for the extrema of every segment, and the limits are the panel's.
    for kind, outline in panel.lines.items():
        axes.add_artist(PathPatch(outline, fill=False, **LINES[kind][0]))
    for kind, places in panel.marks.items():
        axes.plot(*places.T, **MARKS[kind])
    columns, rows = cell_borders(plane.plan.sweep), cell_borders(plane.plan.parameter)
    failed = np.broadcast_to((plane.status == FAILED)[:, None], plane.domain.shape)
    for kind, marked in ((FAILED_ROWS, failed), (OPEN_CELLS, plane.open == 1)):
        if np.any(marked):
            axes.add_artist(PathPatch(outline_of(marked, columns, rows), **kind))
    dark = np.array([text_colour(colour) == "white" for colour in colours])[numbers]
    for mark, marked in ((draw_lines, panel.unstable), (draw_dots, panel.contradictory)):
        mark(axes, marked & ~dark, panel.x, panel.y)
        mark(axes, marked & dark, panel.x, panel.y, "white")
    if plane.over_frequency:
        for number, frequency in enumerate(plane.modes.T, start=1):
            # To the borders of the first and last row, where the frequency is that of the row.
            x, y = np.pad(frequency, 1, mode="edge"), np.concatenate([rows[:1], plane.rows, rows[-1:]])
            axes.plot(x, y, **mode_style(number))
    axes.set(xlim=from_zero(panel.x), ylim=from_zero(panel.y))


def label_places(
    panel: Panel, plane: StoredPlane, size: tuple[float, float], enlarged_in: Sequence[tuple[float, float]] = ()
) -> list[RegionLabel]:
    """Where n/I is written in a panel of so many inches; in shares of the panel."""
    width, height = panel.x[1] - panel.x[0], panel.y[1] - panel.y[0]
    blocked = []
    for places in panel.marks.values():
        for x, y in (places - (panel.x[0], panel.y[0])) / (width, height):
            blocked.append((x - 0.05 / size[0], x + 0.05 / size[0], y - 0.05 / size[1], y + 0.05 / size[1]))
    if plane.over_frequency:
        for mode in plane.modes.T:
            for below, above, *ends in zip(plane.rows[:-1], plane.rows[1:], mode[:-1], mode[1:], strict=True):
                left, right = (np.array([min(ends), max(ends)]) - panel.x[0]) / width
                rows = (np.array([below, above]) - panel.y[0]) / height
                blocked.append((left - 0.02 / size[0], right + 0.02 / size[0], *rows))
    windows = [tuple((np.array(window) - panel.x[0]) / width) for window in enlarged_in]
    drawn = panel.unstable.view(np.uint8) | panel.contradictory.view(np.uint8) << 1
    names = {code: label.replace("/-", "/\u2013") for code, label in plane.labels.items()}
    return placed_labels(panel.code, drawn, names, size, blocked, windows)


def write_labels(axes: Axes, panel: Panel, plane: StoredPlane, enlarged_in: Sequence[tuple[float, float]] = ()) -> None:
    """Write n/I into the regions of a filled panel; beside narrow ones, unless they are enlarged elsewhere."""
    width, height = panel.x[1] - panel.x[0], panel.y[1] - panel.y[0]
    # What is drawn reaches to zero where the panel does not.
    size = axes.get_position().size * axes.figure.get_size_inches()
    size = size * (width / np.ptp(axes.get_xlim()), height / np.ptp(axes.get_ylim()))
    for label in label_places(panel, plane, tuple(size), enlarged_in):
        place, *ends = (
            (panel.x[0] + across * width, panel.y[0] + up * height)
            for across, up in (label.place, label.leads_to or label.place)
        )
        colour = label_colour(plane.labels[label.code])
        if label.leads_to is not None:
            axes.plot(*np.transpose([place, *ends]), color="black", linewidth=0.5, zorder=5.5)
            axes.plot(*ends[0], linestyle="none", marker="o", markersize=1.4, color="black", zorder=5.5)
        box = {"facecolor": hex_colour(colour), "edgecolor": "none", "pad": 0.6}
        if label.leads_to is not None:
            box.update(edgecolor="black", linewidth=0.4)
        axes.text(
            *place, label.text, ha="center", va="center", fontsize=7, color=text_colour(colour), bbox=box, zorder=6
        )
