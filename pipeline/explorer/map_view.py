"""The map of a page: a layer, the places that were clicked, the row through them, and the design point as a box."""

from collections.abc import Callable

from bokeh.events import RangesUpdate, Tap
from bokeh.models import BoxAnnotation, ColumnDataSource, Span

from pipeline.explorer.later import Later
from pipeline.explorer.layer_data import Layer
from pipeline.explorer.map_figure import map_figure, update_map
from pipeline.explorer.quiet import Quiet
from pipeline.explorer.view_state import ViewState
from pipeline.plan.plan import Plan

__all__ = ["MapView"]

#: A box without tolerances is this large, as a share of the axes, so that it can be taken hold of.
_SMALLEST = 0.012
#: Pixels.
_HEIGHT = 470


class MapView:
    """The map of one page.

    Parameters
    ----------
    layer : Layer
        What is shown first.
    plan : Plan
    later : Later
    change : callable
        change(**values) changes the view.
    """

    def __init__(self, layer: Layer, plan: Plan, later: Later, change: Callable):
        self._plan, self._later, self._change = plan, later, change
        self._layer, self._quiet = layer, Quiet()
        self.figure = map_figure(layer, legend=False, sizing_mode="stretch_width", height=_HEIGHT)
        # What the map shows is said by the choice beside it.
        self.figure.title.visible = False
        self._places = ColumnDataSource({"x": [], "y": [], "colour": [], "name": []})
        # What is moved over the map is drawn on a canvas of its own, so that the map is not drawn again.
        over = dict(level="overlay", visible=False)
        self._row = Span(dimension="width", line_color="#d7301f", line_width=1, line_dash="dashed", **over)
        self._box = BoxAnnotation(
            editable=True, fill_color="#1d6fb8", fill_alpha=0.22, line_color="#1d6fb8", line_width=1.5, **over
        )
        self._overlay()
        self.figure.on_event(Tap, self._tapped)
        self.figure.on_event(RangesUpdate, self._zoomed)
        for side in ("left", "right", "top", "bottom"):
            self._box.on_change(side, self._dragged)

    def _overlay(self) -> None:
        """What lies over whatever layer there is."""
        marks = dict(line_color="white", line_width=1.5, level="overlay")
        self.figure.scatter("x", "y", source=self._places, size=11, fill_color="colour", name="places", **marks)
        for one in (self._row, self._box):
            if one not in self.figure.center:
                self.figure.add_layout(one)

    def show_layer(self, layer: Layer) -> None:
        """Another layer, in the window that is in sight, unless the units have changed."""
        same = (layer.x.size, layer.y.size) == (self._layer.x.size, self._layer.y.size)
        update_map(self.figure, layer)
        self._layer = layer
        self._overlay()
        if not same:
            self.window(None)

    def show(self, state: ViewState) -> None:
        """Places, row, design point and window of a view."""
        sizes = self._layer.x.size, self._layer.y.size
        found = [
            (place, colour, name)
            for place, colour, name in ((state.pin, "#1b9e77", "pinned"), (state.at, "#d7301f", "clicked"))
            if place is not None
        ]
        self._places.data = {
            "x": [place[0] * sizes[0] for place, _, _ in found],
            "y": [place[1] * sizes[1] for place, _, _ in found],
            "colour": [colour for _, colour, _ in found],
            "name": [name for _, _, name in found],
        }
        self._row.visible = state.at is not None
        if state.at is not None:
            self._row.location = state.at[1] * sizes[1]
        with self._quiet:
            self._show_design(state, sizes)

    def _show_design(self, state: ViewState, sizes: tuple[float, float]) -> None:
        self._box.visible = state.design is not None
        if state.design is None:
            return
        axes = (self._plan.sweep, self._plan.parameter)
        halves = [
            max(half, 0.5 * _SMALLEST * (axis.high - axis.low)) * size
            for half, axis, size in zip(state.tolerances, axes, sizes, strict=True)
        ]
        x, p = (value * size for value, size in zip(state.design, sizes, strict=True))
        self._box.update(left=x - halves[0], right=x + halves[0], bottom=p - halves[1], top=p + halves[1])

    def window(self, window: tuple[float, float, float, float] | None) -> None:
        """Show a part of the map; None: all of it."""
        x, y = self._layer.x, self._layer.y
        ends = (x.low, x.high, y.low, y.high)
        if window is not None:
            ends = (window[0] * x.size, window[1] * x.size, window[2] * y.size, window[3] * y.size)
        self.figure.x_range.update(start=ends[0], end=ends[1])
        self.figure.y_range.update(start=ends[2], end=ends[3])

    def _tapped(self, event: Tap) -> None:
        if event.x is None or event.y is None:
            return
        self._change(at=self._inside(event.x / self._layer.x.size, event.y / self._layer.y.size))

    def _inside(self, x: float, p: float) -> tuple[float, float]:
        """A place of the plane, to as many digits as a click can tell."""
        axes = (self._plan.sweep, self._plan.parameter)
        return tuple(
            min(max(float(f"{value:.5g}"), axis.low), axis.high) for value, axis in zip((x, p), axes, strict=True)
        )

    def _zoomed(self, event: RangesUpdate) -> None:
        x, y = self._layer.x, self._layer.y
        low, high = (
            self._inside(event.x0 / x.size, event.y0 / y.size),
            self._inside(event.x1 / x.size, event.y1 / y.size),
        )
        window = (low[0], high[0], low[1], high[1])
        whole = (self._plan.sweep.low, self._plan.sweep.high, self._plan.parameter.low, self._plan.parameter.high)
        if window[0] < window[1] and window[2] < window[3]:
            self._change(window=None if window == whole else window)

    def _dragged(self, name: str, before: float, after: float) -> None:
        if self._quiet:
            return
        # All four sides come one after the other: they are one change.
        self._later.ask("design box", lambda: None, lambda _: self._box_moved(), lambda error: None)

    def _box_moved(self) -> None:
        sizes = self._layer.x.size, self._layer.y.size
        left, right = sorted((self._box.left / sizes[0], self._box.right / sizes[0]))
        bottom, top = sorted((self._box.bottom / sizes[1], self._box.top / sizes[1]))
        design = self._inside(0.5 * (left + right), 0.5 * (bottom + top))
        halves = []
        axes = (self._plan.sweep, self._plan.parameter)
        for half, axis in zip((0.5 * (right - left), 0.5 * (top - bottom)), axes, strict=True):
            width = axis.high - axis.low
            # A box that nobody has made larger stands for no tolerance.
            halves.append(0.0 if half <= 0.5 * _SMALLEST * width * 1.001 else min(float(f"{half:.4g}"), 0.5 * width))
        self._change(design=design, tolerances=tuple(halves))
