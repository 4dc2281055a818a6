"""Amplitude and mean over the swept parameter, for a few rows: stability, impact state, folds and grazings."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from pipeline.figures.drawing import Drawing
from pipeline.figures.naming import STATE_NAMES, axis_label, fixed_parameters, value_text
from pipeline.figures.palette import hex_colour, state_colour
from pipeline.figures.physical_axes import LIFT, show_units, titled
from pipeline.plan.numerics import model_at
from pipeline.plane.stored import StoredPlane
from pipeline.store import COMPLETE, FAILED, PENDING
from solver import EndReason, Event, ImpactState, backbone

__all__ = ["chosen_rows", "draw_curves"]

#: Inches.
_WIDTH, _LEFT, _RIGHT, _BESIDE = 7.2, 0.5, 0.15, 0.55
_HEIGHT, _BETWEEN, _TOP, _BOTTOM, _PITCH, _COLUMNS = 1.75, 0.34, 0.3, 0.45, 0.16, 4
_ASIDE = 0.35

_UNSTABLE = (0, (2.6, 1.3))
_FREQUENCY = {"color": "0.45", "linewidth": 0.6, "linestyle": (0, (6, 1.5, 1, 1.5)), "zorder": 1}
_BACKBONE = {"color": "black", "linewidth": 0.6, "linestyle": (0, (1, 1.2)), "zorder": 2}
_MARK = {"linestyle": "none", "markersize": 3.0, "markeredgewidth": 0.6, "markeredgecolor": "black", "zorder": 5}
#: Name -> events that share a marker, and the marker.
_MARKS = {
    "fold": ((Event.FOLD,), {**_MARK, "marker": "o", "markerfacecolor": "black"}),
    "grazing, drive flank": (
        (Event.MIN_AT_DRIVE, Event.MAX_AT_DRIVE),
        {**_MARK, "marker": "D", "markerfacecolor": "white"},
    ),
    "grazing, back flank": (
        (Event.MIN_AT_BACK, Event.MAX_AT_BACK),
        {**_MARK, "marker": "s", "markerfacecolor": "white"},
    ),
    "branch point": ((Event.BRANCH_POINT,), {**_MARK, "marker": "x"}),
}
_EXIT = {"marker": "^", "color": "black", "linestyle": "none", "markersize": 4.5, "zorder": 6}
#: Backbones are drawn with this many amplitudes.
_AMPLITUDES = 60


def chosen_rows(plane: StoredPlane, values: list[float] | None) -> list[int]:
    """Rows nearest to the values, each once; a quarter, half and three quarters of the way unless values are given."""
    rows = plane.rows
    if values is None:
        values = [rows[0] + share * (rows[-1] - rows[0]) for share in (0.25, 0.5, 0.75)]
    return list(dict.fromkeys(int(np.argmin(np.abs(rows - value))) for value in values))


def draw_curves(plane: StoredPlane, values: list[float] | None) -> Drawing:
    """Draw the curves of the rows nearest to `values`, a line of two panels each.

    Parameters
    ----------
    plane : StoredPlane
    values : list of float or None
        Row parameter values; None: a quarter, half and three quarters of the way.

    Returns
    -------
    Drawing
    """
    rows = chosen_rows(plane, values)
    sweep = plane.plan.sweep
    keys = _legend_keys(plane, rows)
    bottom = _BOTTOM + _PITCH * -(-len(keys) // _COLUMNS) + 0.08
    top = _TOP + (0.0 if plane.scales is None else LIFT)
    height = bottom + len(rows) * (_HEIGHT + _BETWEEN) - _BETWEEN + top
    figure = Drawing((_WIDTH, height))
    aside = 0.0 if plane.scales is None else _ASIDE
    width = (_WIDTH - _LEFT - _RIGHT - _BESIDE - 2 * aside) / 2
    limits = _limits(plane, rows)
    for line, row in enumerate(rows):
        low = height - top - (line + 1) * _HEIGHT - line * _BETWEEN
        for column, (name, label) in enumerate(_QUANTITIES.items()):
            left = _LEFT + column * (width + aside + _BESIDE)
            axes = figure.add_axes((left / _WIDTH, low / height, width / _WIDTH, _HEIGHT / height))
            axes.set(xlim=(sweep.low, sweep.high), ylim=limits[row][name], ylabel=label)
            axes.locator_params(nbins=5)
            axes.tick_params(labelbottom=line == len(rows) - 1)
            if line == len(rows) - 1:
                axes.set_xlabel(axis_label(sweep.name, plane.attributes[sweep.name]))
            if plane.n_points[row]:
                _draw_row(axes, plane, row, name)
            else:
                why = _NOTHING[int(plane.status[row])]
                axes.text(0.5, 0.5, why, transform=axes.transAxes, ha="center", va="center", color="0.4")
            if plane.over_frequency:
                _draw_frequencies(axes, plane, row, name, limits[row]["amplitude"][1])
            if column == 0:
                text = value_text(plane.plan.parameter.name, plane.rows[row], plane.scales)
                titled(axes, plane, text, below_axis=line > 0)
            elif line == 0:
                fixed = fixed_parameters(plane.plan, plane.scales)
                figure.text(1 - _RIGHT / _WIDTH, 1 - 0.06 / height, fixed, ha="right", va="top", fontsize=8)
            sides = "lr" + "t" * (line == 0) + "b" * (line == len(rows) - 1)
            show_units(axes, plane, sweep.name, "length", sides)
    figure.legend(
        keys.values(),
        keys.keys(),
        loc="lower center",
        ncols=_COLUMNS,
        bbox_to_anchor=(0.5, 0.05 / height),
        columnspacing=1.4,
    )
    return figure


_NOTHING = {PENDING: "row not computed", COMPLETE: "no branch found", FAILED: "row failed"}
_QUANTITIES = {"amplitude": r"amplitude $\lambda_a$", "mean": r"mean $\lambda_m$"}


def _draw_row(axes: Axes, plane: StoredPlane, row: int, name: str) -> None:
    points = plane.row_points(row)
    x, y = points["position"], points[name]
    for stable, style in ((False, {"linestyle": _UNSTABLE, "zorder": 3}), (True, {"linestyle": "solid", "zorder": 4})):
        pieces = [piece for piece in plane.pieces[row] if piece.stable == stable]
        axes.add_collection(
            LineCollection(
                [np.column_stack([x[piece.slice], y[piece.slice]]) for piece in pieces],
                colors=[_state_colour(ImpactState(piece.impact)) for piece in pieces],
                linewidth=1.1,
                **style,
            ),
            autolim=False,
        )
    for events, style in _MARKS.values():
        here = np.isin(points["event"], events)
        axes.plot(x[here], y[here], **style)
    if name == "amplitude":
        places = _exits(plane, row, axes.get_ylim()[1])
        axes.plot(places, np.ones(len(places)), transform=axes.get_xaxis_transform(), clip_on=False, **_EXIT)


def _draw_frequencies(axes: Axes, plane: StoredPlane, row: int, name: str, top: float) -> None:
    """Linear natural frequencies, and the backbone up to the amplitude `top`."""
    for frequency in plane.modes[row]:
        axes.axvline(frequency, **_FREQUENCY)
    model = model_at(plane.plan, plane.rows[row], plane.plan.sweep.low)
    if model.f_pm != 0.0:
        free = backbone(model, np.linspace(0.0, top, _AMPLITUDES))
        for frequency in (free.lower, free.upper):
            axes.plot(frequency, getattr(free, name), **_BACKBONE)


def _exits(plane: StoredPlane, row: int, top: float) -> list[float]:
    """Where branches that end at the amplitude ceiling leave through the top of the axis."""
    points = plane.row_points(row)
    places = []
    for number, end in np.argwhere(plane.end_reason[row] == EndReason.AMPLITUDE_CEILING):
        of_branch = np.flatnonzero(points["branch"] == number)
        # From the end that ran away inwards, the first point within the axis.
        inwards = of_branch if end == 0 else of_branch[::-1]
        within = inwards[points["amplitude"][inwards] <= top]
        if within.size:
            places.append(float(points["position"][within[0]]))
    return places


def _state_colour(state: ImpactState) -> str:
    return hex_colour(state_colour(state.symbol))


def _limits(plane: StoredPlane, rows: list[int]) -> dict[int, dict[str, tuple[float, float]]]:
    """Axis limits by row and quantity: the same for all rows, except where a branch runs away to the ceiling."""
    extents = {row: _extent(plane, row) for row in rows if plane.n_points[row]}
    runaway = {row for row in extents if np.any(plane.end_reason[row] == EndReason.AMPLITUDE_CEILING)}
    shared = [extents[row] for row in extents.keys() - runaway] or [(1.0, 0.0, 1.0)]
    tops, lows, highs = zip(*shared, strict=True)
    common = (max(tops), min(lows), max(highs))
    limits = {}
    for row in rows:
        top, low, high = extents[row] if row in runaway else common
        margin = 0.06 * ((high - low) or 1.0)
        limits[row] = {"amplitude": (0.0, 1.06 * top or 1.0), "mean": (low - margin, high + margin)}
    return limits


def _extent(plane: StoredPlane, row: int) -> tuple[float, float, float]:
    """Largest amplitude, least and largest mean that the axes should show.

    A branch that runs away to the amplitude ceiling is shown a little beyond the last event on it.
    """
    points = plane.row_points(row)
    away = np.flatnonzero(np.any(plane.end_reason[row] == EndReason.AMPLITUDE_CEILING, axis=1))
    bounded = ~np.isin(points["branch"], away) | (points["event"] != Event.NONE)
    if not np.any(bounded):
        bounded = points["amplitude"] <= 10.0 * np.median(points["amplitude"])
    top = points["amplitude"][bounded].max() * (1.25 if away.size else 1.0)
    mean = points["mean"][points["amplitude"] <= top]
    return float(top), float(mean.min()), float(mean.max())


def _legend_keys(plane: StoredPlane, rows: list[int]) -> dict[str, Line2D]:
    """Text and key of everything that these rows show."""
    pieces = [piece for row in rows for piece in plane.pieces[row]]
    events = [plane.row_points(row)["event"] for row in rows]
    states = [ImpactState(code) for code in sorted({piece.impact for piece in pieces})]
    keys = {f"$I$ = {s.symbol}: {STATE_NAMES[s]}": Line2D([], [], color=_state_colour(s)) for s in states}
    for name, stable, style in (("stable", True, "solid"), ("unstable", False, _UNSTABLE)):
        if any(piece.stable == stable for piece in pieces):
            keys[name] = Line2D([], [], color="0.3", linestyle=style)
    for name, (kinds, style) in _MARKS.items():
        if any(np.any(np.isin(event, kinds)) for event in events):
            keys[name] = Line2D([], [], **style)
    if np.any(plane.end_reason[rows] == EndReason.AMPLITUDE_CEILING):
        ceiling = plane.plan.solver["amplitude_max"]
        keys[rf"runs on to the ceiling $\lambda_a$ = {ceiling:g}"] = Line2D([], [], **_EXIT)
    if np.any(plane.resonances):
        keys["linear natural frequency"] = Line2D([], [], **_FREQUENCY)
        if any(model_at(plane.plan, plane.rows[row], plane.plan.sweep.low).f_pm for row in rows):
            keys["backbone"] = Line2D([], [], **_BACKBONE)
    return keys
