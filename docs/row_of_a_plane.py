"""Draws docs/row_of_a_plane.svg, the picture of docs/architecture.md: the steps from a plan to a map, on one real row.

    python -m docs.row_of_a_plane

The row is f_e = 0.15 of the default plane Omega x f_e at order 1, near its lower resonance.
"""

import sys
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, Rectangle
from matplotlib.path import Path as Outline

from pipeline.config.compose import compose
from pipeline.plan.numerics import frame_of, model_at
from pipeline.plan.plan import Plan
from pipeline.plan.planning import plan
from solver import Event, Row, domain_code, domain_label, enumerate_row, impact_state, sweep_row
from solver.boundaries import boundary_curves, row_events
from solver.stability import Instability

__all__ = ["draw"]

PICTURE = Path(__file__).with_suffix(".svg")
LEVEL, WINDOW, TOP = 0.15, (0.5, 0.85), 2.2
INK, ACCENT, PALE = "#1a1a1a", "#1f4e8c", "#c9c9c9"
#: Every so many rows of the plane are swept for boundaries; rows and columns of the shaded map.
_ROWS, _MAP_ROWS, _MAP_COLUMNS = 21, 101, 391
_STYLE = {
    "font.family": "sans-serif",
    "font.size": 9.5,
    "axes.linewidth": 0.7,
    "mathtext.fontset": "dejavusans",
    "svg.fonttype": "none",
    "svg.hashsalt": "bevelmap",
}
#: Shades of labels, by the number of stable motions and the severest impact: legible in grey.
_SHADES = {"1/0": "#ffffff", "1/1": "#d9d9d9", "2/0-1": "#9a9a9a", "2/0-2": "#6d6d6d"}
_OTHER = "#b8b8b8"


def draw(path: Path) -> None:
    """Compute the row and a coarse plane around it, and draw the nine steps."""
    planned = plan(compose(["plane=omega_fe"]))
    row = sweep_row(model_at(planned, LEVEL, planned.sweep.low), "omega", planned.sweep.values)
    rows = [(p, _row(planned, p)) for p in np.linspace(planned.parameter.low, planned.parameter.high, _ROWS)]
    starts = [event for p, swept in rows for event in row_events(swept.curves, float(p))]
    curves = boundary_curves(*frame_of(planned), starts)
    with matplotlib.rc_context(_STYLE):
        figure = Figure(figsize=(9.6, 8.1), facecolor="white")
        panels = figure.subplots(3, 3, gridspec_kw=dict(hspace=0.66, wspace=0.34, left=0.062, right=0.965, top=0.93))
        figure.subplots_adjust(bottom=0.065)
        steps = (_plan, _seeds, _branches, _raster, _stability, _labels, _store, _boundaries, _regions)
        for number, (step, axes) in enumerate(zip(steps, panels.flat, strict=True), start=1):
            title, note = step(axes, planned, row, starts, curves)
            axes.set_title(f"{number}  {title}", fontsize=11, fontweight="bold", loc="left", pad=22, color=INK)
            axes.text(0.0, 1.045, note, transform=axes.transAxes, fontsize=8.6, color=INK)
        _arrows(figure, panels)
        figure.savefig(
            path, format=path.suffix[1:], metadata={"Date": None} if path.suffix == ".svg" else None, dpi=130
        )


def _row(planned: Plan, value: float) -> Row:
    return sweep_row(model_at(planned, value, planned.sweep.low), "omega", planned.sweep.values)


def _plane(axes: Axes, planned: Plan) -> None:
    axes.set(xlim=(planned.sweep.low, planned.sweep.high), ylim=(planned.parameter.low, planned.parameter.high))
    axes.set_xlabel("Ω", labelpad=1)
    axes.set_ylabel("$f_e$", labelpad=1)


def _window(axes: Axes) -> None:
    axes.set(xlim=WINDOW, ylim=(0.0, TOP))
    axes.set_xlabel("Ω", labelpad=1)
    axes.set_ylabel("amplitude", labelpad=1)


def _arrows(figure: Figure, panels) -> None:
    """From panel to panel, and from the end of a line of panels to the title of the next one."""
    boxes = [axes.get_position() for axes in panels.flat]
    for number, (here, following) in enumerate(zip(boxes, boxes[1:], strict=False)):
        if number % 3 < 2:
            y, middle = here.y1 + 0.034, 0.5 * (here.x1 + following.x0)
            corners = [(middle - 0.015, y), (middle + 0.015, y)]
        else:
            right, left, gap, y = here.x1 + 0.018, following.x0 - 0.035, following.y1 + 0.066, following.y1 + 0.034
            corners = [
                (right, 0.5 * (here.y0 + here.y1)),
                (right, gap),
                (left, gap),
                (left, y),
                (following.x0 - 0.006, y),
            ]
        figure.add_artist(
            FancyArrowPatch(path=Outline(corners), arrowstyle="-|>", color=ACCENT, linewidth=1.8, mutation_scale=15)
        )


def _plan(axes: Axes, planned: Plan, row: Row, starts, curves):
    _plane(axes, planned)
    size = planned.parameter.high - planned.parameter.low
    for number, block in enumerate(planned.blocks):
        low, high = (planned.parameter.low + size * edge / planned.rows for edge in (block.start, block.stop))
        inside = low <= LEVEL < high
        axes.add_patch(
            Rectangle(
                (planned.sweep.low, low),
                planned.sweep.high - planned.sweep.low,
                high - low,
                facecolor=PALE if inside else ("#f4f4f4" if number % 2 else "white"),
                edgecolor="#8a8a8a",
                linewidth=0.5,
            )
        )
    axes.axhline(LEVEL, color=ACCENT, linewidth=1.6)
    axes.annotate(
        "this row", (1.3, LEVEL), (1.3, 0.235), color=ACCENT, ha="center", arrowprops=dict(arrowstyle="-", color=ACCENT)
    )
    return "Plan", f"{planned.sweep.num} columns, {planned.rows} rows, {len(planned.blocks)} blocks of rows"


def _seeds(axes: Axes, planned: Plan, row: Row, starts, curves):
    _window(axes)
    columns = planned.sweep.values
    found = enumerate_row(model_at(planned, LEVEL, planned.sweep.low), "omega", columns)
    for place, amplitudes in zip(columns, found.amplitude, strict=True):
        if WINDOW[0] <= place <= WINDOW[1]:
            axes.axvline(place, color=PALE, linewidth=0.4)
            axes.plot(np.full(amplitudes.size, place), amplitudes, "o", color=INK, markersize=2.6)
    return "Seeds", f"all solutions at {columns.size} columns, proven"


def _curve(axes: Axes, row: Row, **style):
    for curve in row.curves:
        axes.plot(curve.points[:, -1], curve.amplitude, **style)


def _branches(axes: Axes, planned: Plan, row: Row, starts, curves):
    _window(axes)
    _curve(axes, row, color=INK, linewidth=0.9, marker=".", markersize=3.6)
    for kinds, marker, name in (
        ((Event.FOLD,), "D", "fold"),
        ((Event.MIN_AT_DRIVE, Event.MIN_AT_BACK), "o", "grazing"),
    ):
        for curve in row.curves:
            here = np.isin(curve.event, kinds)
            axes.plot(
                curve.points[here, -1],
                curve.amplitude[here],
                marker,
                markersize=6.5,
                markerfacecolor="white",
                markeredgecolor=ACCENT,
                markeredgewidth=1.5,
                label=name,
            )
    axes.legend(loc="upper right", frameon=False, fontsize=8.6, handletextpad=0.2, borderaxespad=0.1)
    points = sum(len(curve.points) for curve in row.curves)
    return "Branches", f"pseudo-arc-length steps, {points} points"


def _raster(axes: Axes, planned: Plan, row: Row, starts, curves):
    _window(axes)
    axes.set(xlim=(0.6, 0.7), ylim=(0.0, 2.0))
    _curve(axes, row, color="#8a8a8a", linewidth=0.9)
    for place, amplitudes in zip(row.grid, row.amplitude, strict=True):
        if 0.6 <= place <= 0.7:
            axes.axvline(place, color=PALE, linewidth=0.5)
            axes.plot(np.full(amplitudes.size, place), amplitudes, "s", color=INK, markersize=3.2)
    return "Raster", "the proven solutions, each on a branch"


def _stability(axes: Axes, planned: Plan, row: Row, starts, curves):
    _window(axes)
    _curve(axes, row, color=PALE, linewidth=0.8)
    decided = row.instability == Instability.NONE
    for chosen, marker, colour, name in (
        ((row.stable == 1) & decided, "o", INK, "stable"),
        ((row.stable == 1) & ~decided, "^", ACCENT, "stable by det J only"),
        (row.stable == 0, "x", "#6d6d6d", "unstable: det J < 0"),
    ):
        column, place = np.nonzero(chosen)
        inside = (row.grid[column] >= WINDOW[0]) & (row.grid[column] <= WINDOW[1])
        axes.plot(
            row.grid[column[inside]],
            row.amplitude[column[inside], place[inside]],
            marker,
            color=colour,
            markersize=3.4,
            label=name,
        )
    axes.legend(loc="upper right", frameon=False, fontsize=8.6, handletextpad=0.2, borderaxespad=0.1)
    return "Stability", "sign of det J; Floquet multipliers"


def _labels(axes: Axes, planned: Plan, row: Row, starts, curves):
    _window(axes)
    _curve(axes, row, color=INK, linewidth=1.0)
    edges = np.flatnonzero(np.diff(row.domain.astype(int))) + 1
    for part in np.split(np.arange(row.grid.size), edges):
        low, high = row.grid[part[0]], row.grid[min(part[-1] + 1, row.grid.size - 1)]
        if high < WINDOW[0] or low > WINDOW[1]:
            continue
        label = domain_label(row.domain[part[0]])
        axes.axvspan(low, high, facecolor=_SHADES.get(label, _OTHER), edgecolor="none", zorder=0)
        left, right = max(low, WINDOW[0]), min(high, WINDOW[1])
        if right - left > 0.02:
            axes.text(0.5 * (left + right), 2.02, label, ha="center", fontsize=9.5, fontweight="bold")
    return "Labels", "n stable motions, their impact states I"


def _store(axes: Axes, planned: Plan, row: Row, starts, curves):
    axes.set(xlim=(0, 10), ylim=(0, 10))
    axes.axis("off")
    names = ("domain", "amplitude, …", "stability, …", "branches")
    for number, name in enumerate(names):
        left, bottom = 0.1 + 0.6 * number, 0.2 + 1.25 * (len(names) - 1 - number)
        for chunk in range(8):
            colour = ACCENT if chunk == 2 else "white"
            style = dict(facecolor=colour, edgecolor=INK, linewidth=0.6, zorder=10 - number)
            axes.add_patch(Rectangle((left, bottom + 0.52 * chunk), 5.2, 0.52, **style))
        axes.text(left + 5.45, bottom + 3.95, name, fontsize=8.6, va="center")
    return "Store", "a block is one task and one chunk"


def _boundaries(axes: Axes, planned: Plan, row: Row, starts, curves):
    _plane(axes, planned)
    for curve in curves:
        fold = curve.kind is Event.FOLD
        axes.plot(
            curve.x, curve.parameter, color=INK, linewidth=1.5 if fold else 0.9, linestyle="-" if fold else (0, (4, 2))
        )
    places = np.array([point[-2:] for _, point in starts])
    axes.plot(*places.T, "o", markersize=2.4, color=ACCENT)
    axes.axhline(LEVEL, color=ACCENT, linewidth=0.8)
    return "Boundaries", "traced from the events of all rows"


def _regions(axes: Axes, planned: Plan, row: Row, starts, curves):
    _plane(axes, planned)
    columns = np.linspace(planned.sweep.low, planned.sweep.high, _MAP_COLUMNS)
    values = np.linspace(planned.parameter.low, planned.parameter.high, _MAP_ROWS)
    shades = np.ones((values.size, columns.size, 4))
    for place, value in enumerate(values):
        found = enumerate_row(model_at(planned, float(value), planned.sweep.low), "omega", columns)
        impact = impact_state(found.mean - found.amplitude, found.mean + found.amplitude, 1.0).astype(int)
        bits = np.bitwise_or.reduce(np.where(found.stable == 1, 1 << impact.clip(0), 0), axis=1)
        codes = domain_code(np.sum(found.stable == 1, axis=1), bits)
        shades[place] = [matplotlib.colors.to_rgba(_SHADES.get(domain_label(int(code)), _OTHER)) for code in codes]
    extent = (planned.sweep.low, planned.sweep.high, planned.parameter.low, planned.parameter.high)
    axes.imshow(shades, origin="lower", extent=extent, aspect="auto", interpolation="nearest")
    for curve in curves:
        fold = curve.kind is Event.FOLD
        axes.plot(
            curve.x, curve.parameter, color=INK, linewidth=1.2 if fold else 0.7, linestyle="-" if fold else (0, (4, 2))
        )
    for x, p, label in ((0.27, 0.25, "1/0"), (0.98, 0.25, "1/0"), (1.66, 0.42, "1/1"), (1.75, 0.12, "1/0")):
        axes.text(x, p, label, ha="center", va="center", fontsize=9.5, fontweight="bold")
    axes.annotate(
        "2/0-1",
        (0.605, 0.15),
        (0.33, 0.07),
        fontsize=9.5,
        fontweight="bold",
        ha="center",
        arrowprops=dict(arrowstyle="-"),
    )
    return "Regions, figure", "labels between curves, exact areas"


if __name__ == "__main__":
    draw(Path(sys.argv[1]) if len(sys.argv) > 1 else PICTURE)
