"""The branches of rows as a Bokeh figure, of one row beside the map and of several on a page to mail."""

from collections.abc import Sequence

import numpy as np
from bokeh.models import HoverTool

from pipeline.config.quantities import AMPLITUDE, QUANTITIES
from pipeline.explorer.layer_data import MapAxis
from pipeline.explorer.legend import Entry, line_entry, mark_entry
from pipeline.explorer.plain_figure import empty, name_axes, numbers, plain_figure, set_range, source_of
from pipeline.explorer.plain_text import plain, quantity_title
from pipeline.explorer.styles import screen_dashes
from pipeline.figures.curves import LINES, MARKS, line_of
from pipeline.figures.naming import STATE_NAMES
from pipeline.figures.palette import hex_colour, state_colour
from pipeline.plane.quantities import scale_of
from pipeline.plane.row_curves import RowCurves
from solver import ImpactState, Scales

__all__ = ["curves_figure", "fill_curves", "value_limits"]

_WIDTH = 1.8
#: Markers of events as Bokeh calls them, by matplotlib's letters.
_MARKERS = {"o": "circle", "D": "diamond", "s": "square", "v": "inverted_triangle", "*": "star", "x": "x"}
_CLEAR = "#00000000"


def curves_figure(count: int = 1, **options):
    """An empty figure for a quantity along the branches of rows, over one another; `fill_curves` gives it data.

    Parameters
    ----------
    count : int
        How many rows it has room for; the number of a row is the tag of what is drawn of it.
    **options
        Further properties of the figure, such as `width`, `height`, `sizing_mode`.

    Returns
    -------
    bokeh.plotting.figure
        Named "curves"; of every row its renderers "branches" and "events".
    """
    found = plain_figure(name="curves", **{"width": 620, "height": 360, **options})
    for number in range(count):
        lines = found.multi_line(
            "xs",
            "ys",
            source=empty("xs", "ys", "colour", "dash", "standing", "state"),
            line_color="colour",
            line_dash="dash",
            line_width=_WIDTH,
            line_join="round",
            name="branches",
        )
        events = found.scatter(
            "x",
            "y",
            source=empty("x", "y", "marker", "fill"),
            marker="marker",
            fill_color="fill",
            line_color="black",
            size=6,
            name="events",
        )
        lines.tags = events.tags = [number]
        found.add_tools(HoverTool(renderers=[lines], line_policy="interp", tags=[number]))
    return found


def fill_curves(
    found, rows: Sequence[RowCurves], axis: MapAxis, *, quantity: str = AMPLITUDE.name, scales: Scales | None = None
) -> list[Entry]:
    """Show rows in a figure of `curves_figure`.

    The colour of a line is the impact state, and its dashes are the stability, as in print.

    Parameters
    ----------
    found : bokeh.plotting.figure
    rows : sequence of RowCurves
        As many as the figure has room for.
    axis : MapAxis
        Of the swept parameter, as the map shows it.
    quantity : str
        One of `pipeline.config.quantities.QUANTITIES`.
    scales : Scales or None
        For the quantity in physical units.

    Returns
    -------
    list of Entry
        Its legend: every kind of line by impact state, stable ones first, then every kind of event.
    """
    scale = scale_of(QUANTITIES[quantity], scales)
    factor = 1.0 if scale is None else scale.shown
    name_axes(found, axis.label, quantity_title(QUANTITIES[quantity], "" if scale is None else scale.unit))
    set_range(found.x_range, axis.low, axis.high)
    lows, highs = zip(*(value_limits(row, quantity, scales) for row in rows), strict=True)
    set_range(found.y_range, min(lows), max(highs))
    told = [(axis.symbol, "$x{0.0000}"), (plain(QUANTITIES[quantity].symbol), "$y{0.0000}")]
    told += [("motion", "@standing"), ("state", "@state")]
    for hover in (one for one in found.tools if isinstance(one, HoverTool)):
        hover.tooltips = told
    entries: dict[tuple, Entry] = {}
    order, marks = [words for words, _ in LINES.values()], list(MARKS)
    for number, row in enumerate(rows):
        x, y = row.points["position"] * axis.size, row.values(quantity) * factor
        lines, events = _lines(row, x, y), _events(row, x, y)
        source_of(found, "branches", number).data = lines
        source_of(found, "events", number).data = {name: events[name] for name in ("x", "y", "marker", "fill")}
        for state, standing, colour, dash in zip(
            *(lines[n] for n in ("state", "standing", "colour", "dash")), strict=True
        ):
            entries[0, state, order.index(standing)] = line_entry(f"{state}, {standing}", colour, _WIDTH, dash)
        for text, marker, fill in zip(events["name"], events["marker"], events["fill"], strict=True):
            entries[1, "", marks.index(text)] = mark_entry(text, marker, fill)
    return [entries[place] for place in sorted(entries)]


def _lines(row: RowCurves, x: np.ndarray, y: np.ndarray) -> dict:
    """The segments of every kind as one line with gaps, by impact state and stability."""
    kinds: dict[tuple, list[slice]] = {}
    for segment, lasts in zip(row.segments, row.lasting.tolist(), strict=True):
        kinds.setdefault((segment.impact, line_of(segment, lasts)), []).append(segment.slice)
    styles = [LINES[line] for _, line in kinds]
    dashes = [screen_dashes(style["linestyle"], _WIDTH) for _, style in styles]
    return {
        "xs": [_with_gaps(x, segments) for segments in kinds.values()],
        "ys": [_with_gaps(y, segments) for segments in kinds.values()],
        "colour": [hex_colour(state_colour(ImpactState(impact).symbol)) for impact, _ in kinds],
        "dash": ["" if dash == "solid" else dash for dash in dashes],
        "standing": [words for words, _ in styles],
        "state": [_state_text(impact) for impact, _ in kinds],
    }


def _with_gaps(values: np.ndarray, segments: Sequence[slice]) -> np.ndarray:
    parts = [part for segment in segments for part in (values[segment], [np.nan])]
    return numbers(np.concatenate(parts[:-1]))


def _events(row: RowCurves, x: np.ndarray, y: np.ndarray) -> dict:
    """Every event with its mark."""
    found: dict[str, list] = {"x": [], "y": [], "marker": [], "fill": [], "name": []}
    for name, (events, style) in MARKS.items():
        here = np.isin(row.points["event"], events)
        count, filled = int(np.sum(here)), style.get("markerfacecolor", "none") != "none"
        found["x"] += x[here].tolist()
        found["y"] += y[here].tolist()
        found["marker"] += count * [_MARKERS[style["marker"]]]
        found["fill"] += count * ["#000000" if filled else _CLEAR]
        found["name"] += count * [name]
    return found


def _state_text(impact: int) -> str:
    state = ImpactState(impact)
    return f"I = {state.symbol}: {STATE_NAMES[state]}"


def value_limits(
    curves: RowCurves, quantity: str = AMPLITUDE.name, scales: Scales | None = None
) -> tuple[float, float]:
    """Of the axis of a row: a branch that runs on to the ceiling would hide the others."""
    scale = scale_of(QUANTITIES[quantity], scales)
    values = curves.values(quantity) * (1.0 if scale is None else scale.shown)
    bounded = values[np.isfinite(values)]
    if bounded.size == 0:
        return 0.0, 1.0
    stable = np.isfinite(values) & (curves.points["stable"] == 1)
    highest = float(np.max(values[stable] if np.any(stable) else bounded))
    low, high = float(bounded.min()), min(float(bounded.max()), 1.5 * highest if highest > 0.0 else np.inf)
    if not QUANTITIES[quantity].signed:
        return 0.0, 1.06 * high or 1.0
    room = 0.06 * ((high - low) or 1.0)
    return low - room, high + room
