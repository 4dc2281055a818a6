"""The n/I map: labels of the cells as colours, folds and grazings as edges, narrow regions enlarged below."""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline

from pipeline.figures.edges import curves_along, label_edges
from pipeline.figures.map_legend import FAILED_ROWS, FOLD, GRAZING, MODES, OPEN_CELLS
from pipeline.figures.map_legend import draw_legend, legend_entries, legend_height
from pipeline.figures.naming import axis_label, fixed_parameters
from pipeline.figures.palette import label_colour
from pipeline.figures.pieces import labels_at
from pipeline.figures.stored import StoredPlane
from pipeline.figures.windows import coexistence_windows
from pipeline.plan import Axis
from pipeline.store import COMPLETE, FAILED

__all__ = ["draw_map"]

#: Inches.
_WIDTH, _LEFT, _PANEL, _RIGHT, _TOP, _BOTTOM = 7.2, 0.56, 4.82, 0.1, 0.36, 0.42
_HEIGHT, _ZOOM_HEIGHT, _BETWEEN, _BESIDE, _LEGEND = 3.0, 2.5, 0.72, 0.25, 5.54
#: Columns of an enlargement: as fine as print shows.
_ZOOM_COLUMNS = 240
#: Images are enlarged to at least this many pixels, so that no viewer blurs the cells of a small plane.
_PIXELS = 400


@dataclass(frozen=True)
class _Cells:
    """Labels over a raster, the borders of its columns and rows, and the edges between labels."""

    code: np.ndarray
    x: np.ndarray
    y: np.ndarray
    fold: np.ndarray
    grazing: np.ndarray


def draw_map(plane: StoredPlane) -> Figure:
    """Draw the map of a plane.

    The large panel shows the stored cells. Where several stable motions coexist in a narrow stretch of the sweep axis,
    a panel below shows that stretch with finer columns, from the branches: their events are located exactly.

    Parameters
    ----------
    plane : StoredPlane

    Returns
    -------
    Figure
    """
    sweep = plane.plan.sweep
    rows = _borders(plane.plan.parameter)
    whole = _Cells(plane.domain, _borders(sweep), rows, *label_edges(plane.domain, plane.n_stable))
    zooms = []
    for window in coexistence_windows(plane.pieces, sweep.low, sweep.high):
        x = np.linspace(*window, _ZOOM_COLUMNS + 1)
        code, n = labels_at(plane.pieces, 0.5 * (x[1:] + x[:-1]))
        code[plane.status != COMPLETE] = 0
        zooms.append(_Cells(code, x, rows, *label_edges(code, n)))

    panels = (whole, *zooms)
    shown = np.unique(np.concatenate([cells.code.ravel() for cells in panels]))
    folds, grazings = any(len(cells.fold) for cells in panels), any(len(cells.grazing) for cells in panels)
    entries = legend_entries(plane, [int(code) for code in shown if code], folds, grazings)
    tall = max(_HEIGHT, legend_height(entries))
    bottom = _BOTTOM + (_ZOOM_HEIGHT + _BETWEEN if zooms else 0.0)
    height = bottom + tall + _TOP
    figure = Figure((_WIDTH, height))

    def panel(left, bottom, width, tall, **shared) -> Axes:
        return figure.add_axes((left / _WIDTH, bottom / height, width / _WIDTH, tall / height), **shared)

    main = panel(_LEFT, bottom, _PANEL, tall)
    _fill(main, whole, plane)
    figure.text(1 - _RIGHT / _WIDTH, 1 - 0.06 / height, fixed_parameters(plane.plan), ha="right", va="top", fontsize=8)
    labels = {axis.name: axis_label(axis.name, plane.attributes[axis.name]) for axis in (plane.plan.parameter, sweep)}
    main.set(xlabel=labels[sweep.name], ylabel=labels[plane.plan.parameter.name])
    draw_legend(figure, entries, _LEGEND, bottom + tall)
    if zooms:
        main.set_title("(a)")
    width = (_WIDTH - _LEFT - _RIGHT - _BESIDE * (len(zooms) - 1)) / max(len(zooms), 1)
    for i, cells in enumerate(zooms):
        axes = panel(_LEFT + i * (width + _BESIDE), _BOTTOM, width, _ZOOM_HEIGHT, sharey=main)
        _fill(axes, cells, plane)
        axes.set_title(f"({'bc'[i]})")
        axes.set(xlabel=labels[sweep.name], ylabel=main.get_ylabel() if i == 0 else "")
        axes.tick_params(labelleft=i == 0)
        axes.locator_params(axis="x", nbins=6)
        _mark_window(main, cells.x, "bc"[i])
    return figure


def _borders(axis: Axis) -> np.ndarray:
    """Borders of the cells, which are centred on the axis's values, (num + 1,)."""
    half = 0.5 * (axis.high - axis.low) / (axis.num - 1)
    return np.linspace(axis.low - half, axis.high + half, axis.num + 1)


def _fill(axes: Axes, cells: _Cells, plane: StoredPlane) -> None:
    axes.imshow(
        _image(cells.code, plane.labels), extent=(*cells.x[[0, -1]], *cells.y[[0, -1]]), origin="lower", aspect="auto",
        interpolation="none", zorder=0,
    )  # fmt: skip
    for kind, segments in ((FOLD, cells.fold), (GRAZING, cells.grazing)):
        lines = [np.column_stack([cells.x[curve[:, 1]], cells.y[curve[:, 0]]]) for curve in curves_along(segments)]
        axes.add_collection(LineCollection(lines, **kind), autolim=False)
    stored_x = _borders(plane.plan.sweep)
    failed = np.broadcast_to((plane.status == FAILED)[:, None], plane.domain.shape)
    for kind, marked in ((FAILED_ROWS, failed), (OPEN_CELLS, plane.open == 1)):
        if np.any(marked):
            axes.add_patch(PathPatch(_rectangles(marked, stored_x, cells.y), **kind))
    if plane.over_frequency:
        for kind, frequency in zip(MODES, plane.modes.T, strict=True):
            # To the borders of the first and last row, where the frequency is that of the row.
            x, y = np.pad(frequency, 1, mode="edge"), np.concatenate([cells.y[:1], plane.rows, cells.y[-1:]])
            axes.plot(x, y, **kind)
    axes.set_xlim(*cells.x[[0, -1]])
    axes.set_ylim(*cells.y[[0, -1]])


def _image(code: np.ndarray, labels: dict[int, str]) -> np.ndarray:
    """Colours of the cells, (P, X, 3) uint8, each cell a block of whole pixels."""
    present, place = np.unique(code, return_inverse=True)
    colours = np.array([label_colour(labels[int(value)]) for value in present], dtype=np.uint8)
    image = colours[place.reshape(code.shape)]
    for axis in (0, 1):
        image = np.repeat(image, -(-_PIXELS // code.shape[axis]), axis=axis)
    return image


def _rectangles(marked: np.ndarray, x: np.ndarray, y: np.ndarray) -> Outline:
    """One outline around every horizontal run of marked cells."""
    change = np.diff(marked.astype(np.int8), axis=1, prepend=0, append=0)
    (row, start), (_, stop) = np.nonzero(change == 1), np.nonzero(change == -1)
    left, right, low, high = x[start], x[stop], y[row], y[row + 1]
    corners = np.stack([[left, low], [right, low], [right, high], [left, high], [left, low]]).transpose(2, 0, 1)
    codes = [Outline.MOVETO, Outline.LINETO, Outline.LINETO, Outline.LINETO, Outline.CLOSEPOLY]
    return Outline(corners.reshape(-1, 2), np.tile(codes, len(row)))


def _mark_window(axes: Axes, x: np.ndarray, letter: str) -> None:
    """A bar above the panel over the stretch that another panel enlarges."""
    above = axes.get_xaxis_transform()
    axes.plot(x[[0, -1]], [1.022, 1.022], transform=above, color="black", linewidth=1.6, clip_on=False,
              solid_capstyle="butt")  # fmt: skip
    axes.text(0.5 * (x[0] + x[-1]), 1.035, f"({letter})", transform=above, ha="center", va="bottom", fontsize=8)
