"""Floquet multipliers along the branches of some rows: their moduli over the swept parameter, and where they lie."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from pipeline.figures.curves import LINES, MARKS, line_of
from pipeline.figures.drawing import Drawing
from pipeline.figures.heading import HEAD, write_heading
from pipeline.figures.layout import from_zero, keys_below
from pipeline.figures.naming import STATE_NAMES, axis_label, value_text
from pipeline.figures.palette import hex_colour, state_colour
from pipeline.figures.physical_axes import lift, show_units, titled
from pipeline.plane.row_curves import RowCurves, curves_at
from pipeline.plane.stored import StoredPlane
from solver import Event, ImpactState

__all__ = ["draw_multipliers"]

#: Inches.
_WIDTH, _LEFT, _RIGHT, _BESIDE, _CIRCLE = 7.2, 0.5, 0.12, 0.5, 2.1
_BETWEEN, _TOP, _BOTTOM, _PITCH, _COLUMNS = 0.42, 0.24, 0.42, 0.16, 4
#: What is drawn of moduli beyond the circle, which may grow without bound.
_MOST = 1.6
_OTHERS = {"colors": "0.7", "linewidths": 0.5, "zorder": 1}
_UNIT = {"color": "0.3", "linewidth": 0.6, "zorder": 2}
_EVENTS = (Event.FOLD, Event.PERIOD_DOUBLING, Event.NEIMARK_SACKER)


def draw_multipliers(plane: StoredPlane, values: list[float]) -> Drawing:
    """Draw the Floquet multipliers of the motions at some values of the row parameter, a line of two panels each.

    Parameters
    ----------
    plane : StoredPlane
    values : list of float
        What is no row of the plane is solved.

    Returns
    -------
    Drawing
        Left the moduli of all multipliers over the swept parameter, the largest of every motion by its impact state and
        stability; right where those of statically stable motions lie in the complex plane.
    """
    rows = [curves_at(plane, float(value)) for value in dict.fromkeys(values)]
    keys = _legend_keys(rows)
    bottom = _BOTTOM + _PITCH * -(-len(keys) // _COLUMNS) + 0.1
    top = _TOP + HEAD + lift(plane)
    height = bottom + len(rows) * (_CIRCLE + _BETWEEN) - _BETWEEN + top
    figure = Drawing((_WIDTH, height))
    write_heading(figure, plane)
    sweep = plane.plan.sweep
    wide = _WIDTH - _LEFT - _RIGHT - _BESIDE - _CIRCLE
    for line, row in enumerate(rows):
        low = height - top - (line + 1) * _CIRCLE - line * _BETWEEN
        moduli = figure.add_axes((_LEFT / _WIDTH, low / height, wide / _WIDTH, _CIRCLE / height))
        circle = figure.add_axes(((_LEFT + wide + _BESIDE) / _WIDTH, low / height, _CIRCLE / _WIDTH, _CIRCLE / height))
        last = line == len(rows) - 1
        moduli.set(
            xlim=from_zero((sweep.low, sweep.high)),
            ylim=(0.0, _MOST),
            ylabel=r"modulus $|\mu|$",
            xlabel=axis_label(sweep.name, plane.attributes[sweep.name]) if last else "",
        )
        titled(moduli, plane, value_text(plane.plan.parameter.name, row.value, plane.scales), below_axis=line > 0)
        circle.set(xlim=(-_MOST, _MOST), ylim=(-_MOST, _MOST), xlabel=r"Re $\mu$" if last else "", ylabel=r"Im $\mu$")
        for axes in (moduli, circle):
            axes.tick_params(labelbottom=last)
        if row.segments:
            _draw_moduli(moduli, row)
            _draw_circle(circle, row)
        else:
            moduli.text(0.5, 0.5, "no branch", transform=moduli.transAxes, ha="center", va="center", color="0.4")
        show_units(moduli, plane, sweep.name, sides="t" * (line == 0) + "b" * last)
    keys_below(figure, keys, _COLUMNS)
    return figure


def _draw_moduli(axes: Axes, row: RowCurves) -> None:
    x, sizes = row.points["position"], np.sort(np.abs(row.multipliers), axis=1)
    axes.add_collection(
        LineCollection(
            [
                np.column_stack([x[segment.slice], sizes[segment.slice, k]])
                for segment in row.segments
                for k in range(sizes.shape[1] - 1)
            ],
            **_OTHERS,
        ),
        autolim=False,
    )
    axes.axhline(1.0, **_UNIT)
    for segment, lasts in zip(row.segments, row.lasting, strict=True):
        _, style = LINES[segment.stable, bool(lasts)]
        colour = _colour(segment.impact)
        axes.plot(x[segment.slice], sizes[segment.slice, -1], color=colour, linewidth=1.1, **style)
    for events, style in MARKS.values():
        here = np.isin(row.points["event"], [event for event in events if event in _EVENTS])
        if np.any(here):
            axes.plot(x[here], sizes[here, -1], **style)


def _draw_circle(axes: Axes, row: RowCurves) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 361)
    axes.plot(np.cos(angle), np.sin(angle), **_UNIT)
    axes.axhline(0.0, color="0.85", linewidth=0.5, zorder=0)
    axes.axvline(0.0, color="0.85", linewidth=0.5, zorder=0)
    for segment in row.segments:
        if segment.stable:
            found = row.multipliers[segment.slice].ravel()
            axes.plot(
                found.real,
                found.imag,
                linestyle="none",
                marker="o",
                markersize=1.4,
                markeredgewidth=0.0,
                color=_colour(segment.impact),
                zorder=3,
            )


def _colour(impact: int) -> str:
    return hex_colour(state_colour(ImpactState(impact).symbol))


def _legend_keys(rows: list[RowCurves]) -> dict[str, Line2D]:
    """Text and key of everything that these rows show."""
    states = sorted({segment.impact for row in rows for segment in row.segments})
    keys = {
        f"$I$ = {ImpactState(code).symbol}: {STATE_NAMES[ImpactState(code)]}": Line2D([], [], color=_colour(code))
        for code in states
    }
    kinds = {line_of(segment, lasts) for row in rows for segment, lasts in zip(row.segments, row.lasting, strict=True)}
    for kind, (name, style) in LINES.items():
        if kind in kinds:
            keys[f"largest, {name}"] = Line2D([], [], color="0.3", linestyle=style["linestyle"])
    keys["all others"] = Line2D([], [], color="0.7", linewidth=0.7)
    for name, (events, style) in MARKS.items():
        if any(np.any(np.isin(row.points["event"], [e for e in events if e in _EVENTS])) for row in rows):
            keys[name] = Line2D([], [], **style)
    return keys
