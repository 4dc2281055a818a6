"""The plane of initial states lambda and lambda': where attractors begin, basins behind them, and a state to drag."""

from collections.abc import Sequence

import numpy as np
from bokeh.models import HoverTool, LinearColorMapper, PointDrawTool

from pipeline.analysis.attractors.places import IntegratedPlace
from pipeline.analysis.attractors.wording import attractor_name
from pipeline.analysis.motion.motions import Motion
from pipeline.explorer.legend import Entry, area_entry
from pipeline.explorer.plain_figure import empty, name_axes, numbers, plain_figure, set_range, source_of
from pipeline.figures.basins import basin_colours, slice_ends
from pipeline.figures.palette import hex_colour

__all__ = ["fill_states", "state_plane"]

#: Poincaré points of an attractor that are marked.
_POINTS = 400


def state_plane(**options):
    """An empty figure; `fill_states` gives it data.

    Returns
    -------
    bokeh.plotting.figure
        Named "state-plane", with renderers "basins", "attractors" and "start", the one state that can be dragged.
    """
    found = plain_figure(name="state-plane", **options)
    name_axes(found, "λ at τ = 0", "λ' at τ = 0")
    # It would lie over the basins.
    found.grid.visible = False
    basins = empty("image", "x", "y", "dw", "dh")
    mapper = LinearColorMapper(palette=["#ffffff"])
    found.image("image", "x", "y", "dw", "dh", source=basins, color_mapper=mapper, level="image", name="basins")
    style = dict(size=6, fill_color="white", line_color="black", marker="diamond")
    found.scatter("x", "y", source=empty("x", "y"), name="attractors", **style)
    style = dict(size=13, fill_color="#d7301f", line_color="white", line_width=1.5)
    start = found.scatter("x", "y", source=empty("x", "y"), name="start", **style)
    drag = PointDrawTool(renderers=[start], add=False, num_objects=1, description="drag the initial state")
    found.add_tools(drag, HoverTool(renderers=[start], tooltips="initial state: drag it"))
    found.toolbar.active_drag = drag
    return found


def fill_states(found, attractors: Sequence[Motion], place: IntegratedPlace | None) -> list[Entry]:
    """Show states in a figure of `state_plane`.

    Parameters
    ----------
    found : bokeh.plotting.figure
    attractors : sequence of Motion
        Whose states at tau = 0 mod 2 pi / Omega are marked.
    place : IntegratedPlace or None
        With a slice of the basins.

    Returns
    -------
    list of Entry
        The legend of the basins.
    """
    points = np.concatenate([np.empty((0, 2)), *(one.curves.points[:_POINTS] for one in attractors)])
    source_of(found, "attractors").data = {"x": numbers(points[:, 0]), "y": numbers(points[:, 1])}
    if place is None:
        source_of(found, "basins").data = {name: [] for name in ("image", "x", "y", "dw", "dh")}
        _fit(found, points if len(points) else np.zeros((1, 2)))
        return []
    return _fill_basins(found, place)


def _fill_basins(found, place: IntegratedPlace) -> list[Entry]:
    kinds, impacts = place.row.kind[0], place.row.impact[0]
    colours = [hex_colour(colour) for colour in basin_colours(kinds)]
    (basins,) = (one for one in found.renderers if one.name == "basins")
    basins.glyph.color_mapper.update(palette=["#ffffff", *colours], low=-1.5, high=len(colours) - 0.5)
    x, y = (slice_ends(values) for values in (place.displacement, place.speed))
    columns = {"x": [x[0]], "y": [y[0]], "dw": [x[1] - x[0]], "dh": [y[1] - y[0]]}
    basins.data_source.data = {"image": [place.slots.astype(np.int8)], **columns}
    set_range(found.x_range, *x)
    set_range(found.y_range, *y)
    entries = []
    for slot in np.flatnonzero(kinds).tolist():
        share = 100.0 * float(np.mean(place.slots == slot))
        words = f"{attractor_name(int(kinds[slot]), int(impacts[slot]))}: {share:.1f} % of the slice"
        entries.append(area_entry(words, colours[slot]))
    return entries


def _fit(found, points: np.ndarray) -> None:
    """Ranges about some points, with room to drag one of them."""
    for axis, values in ((found.x_range, points[:, 0]), (found.y_range, points[:, 1])):
        low, high = float(values.min()), float(values.max())
        room = 0.5 * (high - low) or max(0.5 * abs(high), 0.5)
        set_range(axis, low - room, high + room)
