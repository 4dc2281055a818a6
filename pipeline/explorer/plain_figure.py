"""What all figures beside the map have in common: they are made empty, once for a page, and filled again and again."""

from collections.abc import Sequence

import numpy as np
from bokeh.models import ColumnDataSource, Range1d
from bokeh.plotting import figure

from pipeline.explorer.styles import FONT

__all__ = ["empty", "name_axes", "numbers", "plain_figure", "set_range", "source_of"]

_TOOLS = "pan,wheel_zoom,box_zoom,reset,save"
#: Ticks along a small figure, and pixels at its right for the end of its label.
_FEW, _BESIDE = 4, 14


def plain_figure(small: bool = False, **options):
    """An empty figure with ranges of its own, unless it is given some; a small one has few ticks and small labels."""
    options = {"x_range": Range1d(), "y_range": Range1d(), **options}
    found = figure(tools=_TOOLS, active_scroll="wheel_zoom", toolbar_location="above", **options)
    # Tools come with the pointer.
    found.toolbar.update(logo=None, autohide=True)
    found.grid.grid_line_color = "#ececec"
    for axis in found.axis:
        axis.update(axis_label_text_font=FONT, axis_label_text_font_style="normal", major_label_text_font=FONT)
        if small:
            axis.axis_label_text_font_size = "11px"
    if small:
        found.xaxis.ticker.desired_num_ticks = _FEW
        found.min_border_right = _BESIDE
    return found


def name_axes(found, x: str, y: str) -> None:
    """Write what the axes of a figure are."""
    found.xaxis.axis_label, found.yaxis.axis_label = x, y


def empty(*columns: str) -> ColumnDataSource:
    """A source without data."""
    return ColumnDataSource({name: [] for name in columns})


def source_of(found, name: str, number: int = 0) -> ColumnDataSource:
    """The source of the renderers of a name in a figure, of several such the one with this number."""
    return [one.data_source for one in found.renderers if one.name == name][number]


def set_range(found: Range1d, low: float, high: float) -> None:
    """Ends of an axis, to which the figure's reset goes back as well."""
    found.update(start=low, end=high, reset_start=low, reset_end=high)


def numbers(values: Sequence[float] | np.ndarray) -> np.ndarray:
    """Values as they are sent: to seven digits, more than any screen shows."""
    return np.asarray(values, dtype=np.float32)
