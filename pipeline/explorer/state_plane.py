"""The plane of initial states lambda and lambda': where attractors begin, basins behind them, and a state to drag."""

from collections.abc import Sequence

import numpy as np
from bokeh.models import ColumnDataSource, HoverTool, Legend, LegendItem, LinearColorMapper, PointDrawTool
from bokeh.plotting import figure

from pipeline.analysis.attractors.places import Place
from pipeline.analysis.attractors.wording import attractor_name
from pipeline.analysis.motion.motions import Motion
from pipeline.figures.basins import basin_colours
from pipeline.figures.palette import hex_colour

__all__ = ["state_plane"]

_HEIGHT = 300


def state_plane(attractors: Sequence[Motion], place: Place | None, start: tuple[float, float]):
    """A figure, and the source of the one state in it that can be dragged.

    Parameters
    ----------
    attractors : sequence of Motion
        Whose states at tau = 0 mod 2 pi / Omega are marked.
    place : Place or None
        With a slice of the basins.
    start : (lambda, lambda')

    Returns
    -------
    bokeh.plotting.figure, bokeh.models.ColumnDataSource
    """
    drawn = figure(
        height=_HEIGHT,
        sizing_mode="stretch_width",
        tools="pan,wheel_zoom,reset",
        active_scroll="wheel_zoom",
        x_axis_label="λ at τ = 0",
        y_axis_label="λ' at τ = 0",
        toolbar_location="above",
        name="state-plane",
    )
    drawn.toolbar.logo = None
    if place is not None:
        _draw_basins(drawn, place)
    for one in attractors:
        points = one.curves.points[:400]
        drawn.scatter(points[:, 0], points[:, 1], size=6, fill_color="white", line_color="black", marker="diamond")
    source = ColumnDataSource({"x": [start[0]], "y": [start[1]]})
    handle = drawn.scatter("x", "y", source=source, size=13, fill_color="#d7301f", line_color="white", line_width=1.5)
    drag = PointDrawTool(renderers=[handle], add=False, num_objects=1, description="drag the initial state")
    drawn.add_tools(drag, HoverTool(renderers=[handle], tooltips="initial state: drag it"))
    drawn.toolbar.active_drag = drag
    return drawn, source


def _draw_basins(drawn, place: Place) -> None:
    kinds, impacts = place.row.kind[0], place.row.impact[0]
    filled = np.flatnonzero(kinds).tolist()
    colours = [hex_colour(colour) for colour in basin_colours(kinds)]
    mapper = LinearColorMapper(palette=["#ffffff", *colours], low=-1.5, high=len(colours) - 0.5)
    x, y = (_ends(values) for values in (place.displacement, place.speed))
    drawn.image(
        [place.slots.astype(float)], x=x[0], y=y[0], dw=x[1] - x[0], dh=y[1] - y[0], color_mapper=mapper, level="image"
    )
    shares = [float(np.mean(place.slots == slot)) for slot in filled]
    items = []
    for slot, share in zip(filled, shares, strict=True):
        words = f"{attractor_name(int(kinds[slot]), int(impacts[slot]))}: {100.0 * share:.1f} % of the slice"
        square = drawn.scatter([], [], marker="square", fill_color=colours[slot], line_color="#555555")
        items.append(LegendItem(label=words, renderers=[square]))
    drawn.add_layout(Legend(items=items), "below")
    drawn.x_range.start, drawn.x_range.end = x
    drawn.y_range.start, drawn.y_range.end = y


def _ends(values: np.ndarray) -> tuple[float, float]:
    half = 0.5 * (values[-1] - values[0]) / max(values.size - 1, 1)
    return float(values[0] - half), float(values[-1] + half)
