"""A quantity of the motions over the plane, one value a cell, with the n/I boundaries on top."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import PathPatch

from pipeline.config.quantities import QUANTITIES, Quantity
from pipeline.figures.cell_panels import cell_image, draw_cells, line_entries, outline_of
from pipeline.figures.drawing import Drawing
from pipeline.figures.layout import LEGEND, shares_of
from pipeline.figures.map_legend import FAILED_ROWS, Entry, legend_height
from pipeline.figures.naming import quantity_text
from pipeline.figures.palette import sequential_colours
from pipeline.figures.panels import cell_borders
from pipeline.figures.physical_axes import show_bar_units
from pipeline.plane.quantities import scale_of
from pipeline.plane.stored import StoredPlane
from pipeline.store import FAILED

__all__ = ["NO_VALUE", "draw_quantity_map", "ends_of", "quantity_colours"]

#: Cells without a value: dotted, since in grey their shade is that of some value.
NO_VALUE = {"facecolor": "0.82", "edgecolor": "0.4", "linewidth": 0.0, "hatch": "....", "zorder": 1}
#: Inches: height and width of the colour bar, room for numbers at its left; lines of the legend that it takes.
_BAR, _WIDE, _NUMBERS, _LINES = 1.5, 0.15, 0.36, 11
_EXTREMES = {"worst": "Largest", "mildest": "Smallest"}


def draw_quantity_map(plane: StoredPlane, name: str, of: str, window: Sequence[float] | None = None) -> Drawing:
    """Draw a quantity of the motions that labels count.

    Parameters
    ----------
    plane : StoredPlane
    name : str
        One of `pipeline.config.quantities.QUANTITIES`.
    of : str
        "worst" or "mildest": the largest or the smallest value where several motions coexist.
    window : (x low, x high, p low, p high), optional
        The part of the plane that is drawn; all of it unless given.

    Returns
    -------
    Drawing
    """
    quantity, values = QUANTITIES[name], plane.extreme(name, of)
    columns, rows = cell_borders(plane.plan.sweep), cell_borders(plane.plan.parameter)
    ends = ends_of(values)
    colours = quantity_colours(values, ends)
    marked = {
        "no value": (NO_VALUE, np.isnan(values) & (plane.status != FAILED)[:, None]),
        "row failed": (FAILED_ROWS, np.broadcast_to((plane.status == FAILED)[:, None], values.shape)),
    }

    def paint(axes: Axes) -> None:
        cell_image(axes, colours, columns, rows)
        for style, here in marked.values():
            if np.any(here):
                axes.add_artist(PathPatch(outline_of(here, columns, rows), **style))

    shown = [Entry(_unit_text(plane, quantity)), *(Entry() for _ in range(_LINES))] if ends else []
    keys = [Entry(text, area=style) for text, (style, here) in marked.items() if np.any(here)]
    stable = "dynamically stable" if plane.dynamic else "stable"
    head = f"{_EXTREMES[of]} {quantity_text(quantity)} of the {stable} motions"
    figure = draw_cells(plane, [*shown, *keys, *line_entries(plane, window)], paint, head, window)
    if ends:
        _add_bar(figure, plane, quantity, ends, legend_height(shown[:1]))
    return figure


def quantity_colours(values: np.ndarray, ends: tuple[float, float] | None) -> np.ndarray:
    """Colours of values between two ends, (..., 3) uint8; white where there is none."""
    colours = np.full((*values.shape, 3), 255, np.uint8)
    if ends:
        known = np.isfinite(values)
        share = (values[known] - ends[0]) / (ends[1] - ends[0])
        colours[known] = sequential_colours()[np.clip(256.0 * share, 0.0, 255.0).astype(int)]
    return colours


def ends_of(values: np.ndarray) -> tuple[float, float] | None:
    """Lowest and highest value; None where there is none."""
    known = values[np.isfinite(values)]
    if known.size == 0:
        return None
    low, high = float(known.min()), float(known.max())
    return (low, high) if high > low else (low - 0.5, high + 0.5)


def _unit_text(plane: StoredPlane, quantity: Quantity) -> str:
    """The symbol, and what its numbers are in units of."""
    scale, symbol = scale_of(quantity, plane.scales), f"${quantity.symbol}$"
    if scale is not None:
        return f"{symbol} ({scale.unit}), left: ${quantity.reference}$"
    return f"{symbol} in units of ${quantity.reference}$" if quantity.reference else symbol


def _add_bar(figure: Drawing, plane: StoredPlane, quantity: Quantity, ends: tuple[float, float], above: float) -> None:
    """The colour bar at the top of the legend, so many inches below it."""
    height = figure.get_figheight()
    top = figure.axes[0].get_position().y1 * height - above - 0.08
    scale = scale_of(quantity, plane.scales)
    left = LEGEND + (0.0 if scale is None else _NUMBERS)
    bar = figure.add_axes(shares_of((left, top - _BAR, _WIDE, _BAR), height))
    # By hand: a colorbar is a mesh of 256 areas, and a PDF would hold each of them.
    bar.imshow(
        sequential_colours()[:, None], extent=(0.0, 1.0, *ends), origin="lower", aspect="auto", interpolation="none"
    )
    bar.set(xticks=[])
    bar.yaxis.tick_right()
    if scale is not None:
        show_bar_units(bar, scale)
