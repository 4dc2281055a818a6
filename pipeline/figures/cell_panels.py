"""A plane whose cells are painted: a panel with its legend, and enlargements of narrow stretches below."""

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline

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
from pipeline.figures.map_legend import LINES, Entry, draw_legend, legend_height
from pipeline.figures.naming import axis_label
from pipeline.figures.panels import cell_borders, lines_of
from pipeline.figures.physical_axes import lift, show_units, spare, titled
from pipeline.figures.windows import coexistence_windows
from pipeline.plane.stored import StoredPlane

__all__ = [
    "attractor_borders",
    "borders_between",
    "cell_image",
    "draw_cells",
    "line_entries",
    "outline_of",
    "with_lines",
]

#: Inches of a line of text above the panel; to the right end of the legend's numbers.
_LINE, _SHARE = 0.19, 1.54
#: Pixels along an axis whose cells are of different widths.
_FINE = 1200


def draw_cells(
    plane: StoredPlane,
    entries: Sequence[Entry],
    paint: Callable[[Axes], None],
    head: str,
    window: Sequence[float] | None = None,
) -> Drawing:
    """A figure of painted cells.

    Parameters
    ----------
    plane : StoredPlane
    entries : sequence of Entry
        Of the legend.
    paint : callable
        paint(axes) paints the whole plane.
    head : str
        What matters most, above the panel.
    window : (x low, x high, p low, p high), optional
        The part of the plane that is drawn; all of it unless given.

    Returns
    -------
    Drawing
    """
    sweep, parameter = plane.plan.sweep, plane.plan.parameter
    windows = coexistence_windows(plane) if window is None else []
    tall = max(HEIGHT, legend_height(list(entries)))
    names, above = (sweep.name, parameter.name), lift(plane)
    bottom = BOTTOM + (ZOOM_HEIGHT + BETWEEN + above if windows else 0.0)
    height = bottom + tall + TOP + HEAD + _LINE + above
    figure = Drawing((WIDTH, height))
    main = figure.add_axes(shares_of((LEFT, bottom, PANEL - spare(plane), tall), height))
    if window is None:
        x, y = (tuple(cell_borders(axis)[[0, -1]].tolist()) for axis in (sweep, parameter))
    else:
        x, y = tuple(window[:2]), tuple(window[2:])
    _fill(main, plane, paint, x, y)
    write_heading(figure, plane)
    figure.text(LEFT / WIDTH, 1 - (HEAD + 0.06) / height, head, ha="left", va="top", fontsize=9, weight="bold")
    labels = tuple(axis_label(name, plane.attributes[name]) for name in names)
    main.set(xlabel=labels[0], ylabel=labels[1])
    show_units(main, plane, *names)
    draw_legend(figure, list(entries), LEGEND, bottom + tall, _SHARE)
    if window is not None:
        show_window(main, window)
    for i, (stretch, place) in enumerate(zip(windows, zoom_places(len(windows), spare(plane)), strict=True)):
        axes = figure.add_axes(shares_of(place, height), sharey=main)
        _fill(axes, plane, paint, stretch, y)
        titled(axes, plane, f"({'bc'[i]})")
        axes.set(xlabel=labels[0], ylabel=labels[1] if i == 0 else "")
        axes.tick_params(labelleft=i == 0)
        axes.locator_params(axis="x", nbins=6)
        show_units(axes, plane, *names, sides="bt" + "l" * (i == 0) + "r" * (i == len(windows) - 1))
        mark_window(main, stretch, "bc"[i], above / tall)
    return figure


def _fill(axes: Axes, plane: StoredPlane, paint: Callable[[Axes], None], x, y) -> None:
    axes.set(xlim=x, ylim=y)
    paint(axes)
    with_lines(axes, plane, x, y)
    axes.set(xlim=from_zero(x), ylim=from_zero(y))


def with_lines(axes: Axes, plane: StoredPlane, x, y) -> None:
    """The lines of the map on top."""
    for kind, outline in lines_of(plane, x, y).items():
        axes.add_artist(PathPatch(outline, fill=False, **LINES[kind][0]))


def line_entries(plane: StoredPlane, window: Sequence[float] | None = None) -> list[Entry]:
    """What the legend says of the lines of the map, or of those in a part of it."""
    sweep, parameter = plane.plan.sweep, plane.plan.parameter
    ends = (sweep.low, sweep.high, parameter.low, parameter.high) if window is None else window
    lines = lines_of(plane, tuple(ends[:2]), tuple(ends[2:]))
    found = [Entry(text, line=style) for kind, (style, text) in LINES.items() if kind in lines]
    return [Entry(), Entry("lines: the map"), *found] if found else []


def attractor_borders(plane: StoredPlane, found) -> tuple[np.ndarray, np.ndarray]:
    """Borders (X + 1,) and (P + 1,) of the cells of the group `attractors`."""
    sweep, parameter = plane.plan.sweep, plane.plan.parameter
    return borders_between(found[sweep.name].values, sweep), borders_between(found[parameter.name].values, parameter)


def borders_between(values: np.ndarray, axis) -> np.ndarray:
    """Borders of cells around some values of an axis, (n + 1,): halfway, and those of the axis at the ends."""
    ends = cell_borders(axis)[[0, -1]]
    return np.concatenate([ends[:1], 0.5 * (values[1:] + values[:-1]), ends[1:]])


def cell_image(axes: Axes, colours: np.ndarray, columns: np.ndarray, rows: np.ndarray, zorder: float = 0.0):
    """Paint cells (P, X, 3) uint8 between borders (X + 1,) and (P + 1,); the image, whose limits stay the axes' own."""
    for axis, borders in ((1, columns), (0, rows)):
        if not _even(borders):
            # As an image of even pixels, fine enough for the narrowest cell to be seen.
            middles = borders[0] + (np.arange(_FINE) + 0.5) / _FINE * (borders[-1] - borders[0])
            colours = np.take(colours, np.searchsorted(borders[1:-1], middles), axis=axis)
    extent = (columns[0], columns[-1], rows[0], rows[-1])
    return axes.imshow(
        enlarged(colours), extent=extent, origin="lower", aspect="auto", interpolation="none", zorder=zorder
    )


def _even(borders: np.ndarray) -> bool:
    steps = np.diff(borders)
    return bool(np.ptp(steps) <= 1e-9 * steps.max())


def outline_of(marked: np.ndarray, x: np.ndarray, y: np.ndarray) -> Outline:
    """One outline around every horizontal run of marked cells (P, X) between borders x (X + 1,) and y (P + 1,)."""
    change = np.diff(marked.astype(np.int8), axis=1, prepend=0, append=0)
    (row, start), (_, stop) = np.nonzero(change == 1), np.nonzero(change == -1)
    left, right, low, high = x[start], x[stop], y[row], y[row + 1]
    corners = np.stack([[left, low], [right, low], [right, high], [left, high], [left, low]]).transpose(2, 0, 1)
    codes = [Outline.MOVETO, Outline.LINETO, Outline.LINETO, Outline.LINETO, Outline.CLOSEPOLY]
    return Outline(corners.reshape(-1, 2), np.tile(codes, len(row)))
