"""What belongs to a place of the map as Bokeh figures: the branches of its row, and its motions."""

from collections.abc import Sequence

import numpy as np
from bokeh.core.properties import value
from bokeh.models import ColumnDataSource, HoverTool, Legend, LegendItem, Range1d, Span
from bokeh.plotting import figure

from pipeline.analysis.motion.motions import MapMotion, Motion
from pipeline.analysis.motion.wording import card_name
from pipeline.config.quantities import AMPLITUDE, QUANTITIES
from pipeline.explorer.layer_data import MapAxis
from pipeline.explorer.plain_text import plain, quantity_title
from pipeline.explorer.styles import FONT, screen_dashes
from pipeline.figures.curves import LINES, MARKS, line_of
from pipeline.figures.motion_axes import Units
from pipeline.figures.naming import STATE_NAMES
from pipeline.figures.palette import hex_colour, state_colour
from pipeline.plane.quantities import scale_of
from pipeline.plane.row_curves import RowCurves
from solver import ImpactState, Scales

__all__ = ["MOTION_FIGURES", "curves_figure", "motion_figures", "rows_figure", "value_limits"]

#: The figures of motions, in order.
MOTION_FIGURES = ("time", "force", "phase", "spectrum")
_TOOLS = "pan,wheel_zoom,box_zoom,reset,save"
_WIDTH = 1.8
#: Markers of events as Bokeh calls them, by matplotlib's letters.
_MARKERS = {"o": "circle", "D": "diamond", "s": "square", "v": "inverted_triangle", "*": "star", "x": "x"}
#: Periods of a motion that are shown: of one that repeats two of its own, of others so many.
_APERIODIC, _MOST = 12, 16
#: Decades of a spectrum; columns of a legend.
_DECADES, _COLUMNS = 4.0, 3


def curves_figure(
    curves: RowCurves, axis: MapAxis, *, quantity: str = AMPLITUDE.name, scales: Scales | None = None, **size
):
    """A quantity along the branches of one row.

    The colour of a line is the impact state, and its dashes are the stability, as in print.

    Parameters
    ----------
    curves : RowCurves
    axis : MapAxis
        Of the swept parameter, as the map shows it.
    quantity : str
        One of `pipeline.config.quantities.QUANTITIES`.
    scales : Scales or None
        For the quantity in physical units.
    **size
        Further properties of the figure, such as `width`, `height`, `x_range`.

    Returns
    -------
    bokeh.plotting.figure
        Named "curves"; its renderers "branches" and those of events.
    """
    return rows_figure((curves,), axis, quantity=quantity, scales=scales, **size)


def rows_figure(
    rows: Sequence[RowCurves], axis: MapAxis, *, quantity: str = AMPLITUDE.name, scales: Scales | None = None, **size
):
    """The same of several rows over one another; the number of a row is the tag of what is drawn of it."""
    size = {"width": 620, "height": 360, "x_range": Range1d(axis.low, axis.high), "name": "curves", **size}
    scale = scale_of(QUANTITIES[quantity], scales)
    factor = 1.0 if scale is None else scale.shown
    found = _figure(axis.label, quantity_title(QUANTITIES[quantity], "" if scale is None else scale.unit), **size)
    lows, highs = zip(*(value_limits(row, quantity, scales) for row in rows), strict=True)
    found.y_range = Range1d(min(lows), max(highs))
    items: dict[str, LegendItem] = {}
    for number, row in enumerate(rows):
        for item in _draw_row(found, row, axis, quantity, factor, number):
            items.setdefault(item.label.value, item)
    _add_legend(found, [items[text] for text in sorted(items, key=lambda text: (text in MARKS, text))])
    return found


def _draw_row(found, row: RowCurves, axis: MapAxis, quantity: str, factor: float, number: int) -> list[LegendItem]:
    x, y = row.points["position"] * axis.size, row.values(quantity) * factor
    pieces = list(zip(row.pieces, row.lasting.tolist(), strict=True))
    dashes = [screen_dashes(LINES[line_of(piece, lasts)][1]["linestyle"], _WIDTH) for piece, lasts in pieces]
    data = {
        "xs": [x[piece.slice] for piece, _ in pieces],
        "ys": [y[piece.slice] for piece, _ in pieces],
        "colour": [_colour(piece.impact) for piece, _ in pieces],
        "dash": ["" if dash == "solid" else dash for dash in dashes],
        "standing": [LINES[line_of(piece, lasts)][0] for piece, lasts in pieces],
        "state": [_state_text(piece.impact) for piece, _ in pieces],
    }
    drawn = found.multi_line(
        "xs",
        "ys",
        source=ColumnDataSource(data),
        line_color="colour",
        line_dash="dash",
        line_width=_WIDTH,
        line_join="round",
        name="branches",
    )
    drawn.tags = [number]
    items = [
        LegendItem(label=value(text), renderers=[drawn], index=index)
        for text, index in _first_of_each(zip(data["state"], data["standing"], strict=True))
    ]
    for name, (events, style) in MARKS.items():
        here = np.isin(row.points["event"], events)
        if np.any(here):
            filled = style.get("markerfacecolor", "none") != "none"
            mark = found.scatter(
                x[here],
                y[here],
                marker=_MARKERS[style["marker"]],
                size=6,
                fill_color="black" if filled else None,
                line_color="black",
                name=name,
            )
            mark.tags = [number]
            items.append(LegendItem(label=value(name), renderers=[mark]))
    told = [(axis.symbol, "$x{0.0000}"), (plain(QUANTITIES[quantity].symbol), "$y{0.0000}")]
    told += [("motion", "@standing"), ("state", "@state")]
    found.add_tools(HoverTool(renderers=[drawn], tooltips=told, line_policy="interp", tags=[number]))
    return items


def _first_of_each(kinds) -> list[tuple[str, int]]:
    """Text of every kind of line and the first line that is of it."""
    known: dict[str, int] = {}
    for number, parts in enumerate(kinds):
        known.setdefault(", ".join(parts), number)
    return sorted(known.items())


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


def _colour(impact: int) -> str:
    return hex_colour(state_colour(ImpactState(impact).symbol))


def _state_text(impact: int) -> str:
    state = ImpactState(impact)
    return f"I = {state.symbol}: {STATE_NAMES[state]}"


def motion_figures(cards: Sequence[Motion | MapMotion], gap: tuple[float, float], units: Units, **size) -> dict:
    """Motions over one another: displacement and mesh force in time, phase portrait, spectrum.

    Attractors are solid lines, motions of the balance dashed ones.

    Parameters
    ----------
    cards : sequence of Motion or MapMotion
    gap : (low, high)
        Between the flanks: its ends are shown.
    units : Units
        Of `pipeline.figures.motion_axes.units_of`.
    **size
        Further properties of every figure, such as `width`, `height`.

    Returns
    -------
    dict of str to bokeh.plotting.figure
        By the names of `MOTION_FIGURES`; time and force move together.
    """
    size = {"width": 420, "height": 240, **size}
    names = {
        one: plain(getattr(units, f"{one}_label")) for one in ("time", "displacement", "speed", "force", "spectrum")
    }
    found = {
        "time": _figure(names["time"], names["displacement"], name="time", **size),
        "force": _figure(names["time"], names["force"], name="force", **size),
        "phase": _figure(names["displacement"], names["speed"], name="phase", **size),
        "spectrum": _figure("order", names["spectrum"], name="spectrum", y_axis_type="log", **size),
    }
    found["force"].x_range = found["time"].x_range
    _shade_gap(found["time"], "height", gap, units)
    _shade_gap(found["phase"], "width", gap, units)
    shown = min(
        max((2 * card.curves.repeats if card.curves.repeats else _APERIODIC for card in cards), default=2), _MOST
    )
    largest = max((float(card.curves.amplitudes.max(initial=0.0)) for card in cards), default=0.0) * units.length or 1.0
    items = []
    for number, card in enumerate(cards):
        style = {"line_color": _INKS[number % len(_INKS)], "line_width": 1.6}
        style["line_dash"] = "6 4" if isinstance(card, MapMotion) else "solid"
        curves, text = card.curves, f"{card_name(card)}  {card.label}"
        periods, displacement, force = _over(curves, shown)
        line = found["time"].line(periods * units.time, displacement * units.length, name=text, **style)
        found["force"].line(periods * units.time, force * units.force, name=text, **style)
        closed = curves.repeats is not None
        path = [np.append(part, part[:1]) if closed else part for part in (curves.displacement, curves.speed)]
        thin = {} if closed else {"line_width": 0.6}
        found["phase"].line(path[0] * units.length, path[1] * units.speed, name=text, **{**style, **thin})
        points = curves.points * (units.length, units.speed)
        found["phase"].scatter(
            *points.T, size=6 if closed else 2, fill_color=style["line_color"], line_color=None, name=text
        )
        amplitudes = np.maximum(curves.amplitudes * units.length, 0.1 * largest * 10.0**-_DECADES)
        if closed:
            found["spectrum"].segment(
                curves.orders,
                np.full(curves.orders.size, largest * 10.0 ** -(_DECADES + 1)),
                curves.orders,
                amplitudes,
                name=text,
                **style,
            )
        else:
            found["spectrum"].line(curves.orders, amplitudes, name=text, **style)
        items.append(LegendItem(label=value(text), renderers=[line]))
    found["spectrum"].y_range = Range1d(largest * 10.0**-_DECADES, 2.0 * largest)
    _add_legend(found["time"], items)
    return found


#: Of motions one after the other; they differ in lightness as well.
_INKS = ("#0072b2", "#d55e00", "#009e73", "#56367d", "#a06a00", "#000000")


def _shade_gap(found, dimension: str, gap: tuple[float, float], units: Units) -> None:
    along = "width" if dimension == "height" else "height"
    # A gap without a back flank has one end.
    for end in gap if gap[0] < gap[1] else ():
        if np.isfinite(end):
            found.add_layout(
                Span(location=end * units.length, dimension=along, line_color="#808080", line_dash="2 3", line_width=1)
            )


def _over(curves, shown: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time in periods, lambda and force over so many periods."""
    each = round(1.0 / (curves.periods[1] - curves.periods[0]))
    count = shown * each + 1
    times = -(-count // curves.periods.size)
    return np.arange(count) / each, *(np.tile(part, times)[:count] for part in (curves.displacement, curves.force))


def _figure(x: str, y: str, **size):
    found = figure(
        tools=_TOOLS, active_scroll="wheel_zoom", toolbar_location="above", x_axis_label=x, y_axis_label=y, **size
    )
    found.toolbar.logo = None
    found.grid.grid_line_color = "#ececec"
    for axis in found.axis:
        axis.update(axis_label_text_font=FONT, axis_label_text_font_style="normal", major_label_text_font=FONT)
    return found


def _add_legend(found, items: list[LegendItem]) -> None:
    legend = Legend(
        items=items,
        ncols=_COLUMNS,
        label_text_font=FONT,
        label_text_font_size="12px",
        spacing=1,
        padding=2,
        border_line_color=None,
    )
    found.add_layout(legend, "below")
