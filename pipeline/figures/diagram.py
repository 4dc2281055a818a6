"""Bifurcation diagram of a row: what one motion does while the swept parameter goes up and comes down again.

Downwards is a wide light line with open triangles under a thin dark one with filled triangles, which is upwards: where
both have the same motion both are seen, in grey as well.
"""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.patheffects import withStroke

from pipeline.analysis.diagram.following import DIRECTIONS, Followed
from pipeline.analysis.diagram.sheets import rms_along
from pipeline.figures.attractors import CLASSES, class_of
from pipeline.figures.curves import LINES, line_of
from pipeline.figures.drawing import Drawing
from pipeline.figures.heading import HEAD, write_heading
from pipeline.figures.layout import from_zero, keys_below
from pipeline.figures.naming import axis_label, symbol, value_text
from pipeline.figures.palette import hex_colour, text_colour
from pipeline.figures.physical_axes import LIFT, show_units
from pipeline.plan.numerics import System, sweep_axis
from pipeline.plan.traits import dead_zone
from pipeline.plane.resonances import contact_modes
from pipeline.plane.row_curves import RowCurves
from pipeline.plane.stored import StoredPlane
from solver.model.packing import dead_zone_ends
from solver.timedomain import AttractorKind, SlowRun

__all__ = ["FREQUENCY", "draw_diagram", "draw_kinds", "kind_keys", "mark_modes"]

#: Inches.
_WIDTH, _LEFT, _RIGHT, _ASIDE, _TITLE, _BOTTOM, _PITCH, _COLUMNS = 7.2, 0.6, 0.14, 0.5, 0.24, 0.44, 0.16, 4
_STRIP, _BETWEEN, _LETTER = 0.135, 0.1, 0.052
_HEIGHTS = (1.9, 1.55, 1.55)

_COLOURS = {"up": "#08306b", "down": "#f08c3c"}
_NAMES = {"up": "upwards", "down": "downwards"}
_LINES = {"up": {"linewidth": 0.85, "zorder": 6}, "down": {"linewidth": 2.3, "zorder": 5}}
#: Points of motions that repeat after few periods, and of all others, which are many.
_DOTS = {"up": (1.1, 0.9), "down": (2.4, 1.3)}
_MARKS = {
    "up": {"marker": "^", "markersize": 3.4, "markerfacecolor": _COLOURS["up"], "zorder": 8},
    "down": {"marker": "v", "markersize": 3.6, "markerfacecolor": "white", "zorder": 7},
}
#: A mark of the direction stands at every so many steps.
_EVERY = 20
_HALO = [withStroke(linewidth=2.0, foreground="white")]
_JUMP = (0, (2.0, 1.2))
#: Jumps that are lower than this share of the panel are not drawn in it.
_LOWEST = 0.02
FREQUENCY = {"color": "0.45", "linewidth": 0.6, "linestyle": (0, (6, 1.5, 1, 1.5)), "zorder": 1}
_MAP = "0.4"
_GAP = {"color": "0.3", "linewidth": 0.6, "linestyle": (0, (4, 2)), "zorder": 2}


def draw_diagram(plane: StoredPlane, followed: Followed, curves: RowCurves) -> Drawing:
    """Draw a row that was followed up and down.

    Parameters
    ----------
    plane : StoredPlane
    followed : Followed
    curves : RowCurves
        The branches of the map in this row.

    Returns
    -------
    Drawing
    """
    sweep = plane.plan.sweep
    keys = _legend_keys(plane, followed, curves)
    lifted, aside = (0.0, 0.0) if plane.scales is None else (LIFT, _ASIDE)
    bottom = _BOTTOM + _PITCH * -(-len(keys) // _COLUMNS) + 0.06
    top = HEAD + _TITLE + lifted
    height = bottom + sum(_HEIGHTS) + 2 * _BETWEEN + 0.06 + 2 * _STRIP + 0.03 + top
    figure = Drawing((_WIDTH, height))
    write_heading(figure, plane)
    text = value_text(plane.plan.parameter.name, followed.way.value, plane.scales)
    figure.text(_LEFT / _WIDTH, 1.0 - (HEAD + 0.05) / height, text, ha="left", va="top", fontsize=9)
    width = _WIDTH - _LEFT - _RIGHT - aside

    def axes_at(low: float, tall: float) -> Axes:
        axes = figure.add_axes((_LEFT / _WIDTH, low / height, width / _WIDTH, tall / height))
        axes.set_xlim(from_zero((sweep.low, sweep.high)))
        return axes

    low = height - top
    for direction in DIRECTIONS:
        low -= _STRIP
        strip = axes_at(low, _STRIP)
        draw_kinds(strip, followed.runs[direction], width, _NAMES[direction])
        if lifted and direction == DIRECTIONS[0] and sweep.name in plane.scales:
            strip.secondary_xaxis("top").set_xlabel(symbol(sweep.name))
        low -= 0.03
    low -= 0.03
    panels = []
    for tall in _HEIGHTS:
        low -= tall
        panels.append(axes_at(low, tall))
        low -= _BETWEEN
    _draw_sections(panels[0], followed)
    _draw_extremes(panels[1], followed)
    _draw_rms(panels[2], followed, curves)
    labels = (r"Poincaré points $\lambda$", r"extremes $\lambda_{min}$, $\lambda_{max}$", r"RMS $\lambda_{rms}$")
    for place, (axes, label) in enumerate(zip(panels, labels, strict=True)):
        axes.set_ylabel(label)
        axes.locator_params(axis="y", nbins=6)
        if plane.over_frequency:
            mark_modes(axes, followed.system, named=place == 0)
        last = place == len(panels) - 1
        axes.tick_params(labelbottom=last)
        if last:
            axes.set_xlabel(axis_label(sweep.name, plane.attributes[sweep.name]))
        show_units(axes, plane, sweep.name, "length", "lr" + "b" * last)
        axes.tick_params(axis="x", top=False)
    keys_below(figure, keys, _COLUMNS)
    return figure


def draw_kinds(axes: Axes, run: SlowRun, width: float, name: str = "") -> None:
    """A strip `width` inches wide with the kind of attractor at every step; what there is room for is written into it.

    Parameters
    ----------
    axes : Axes
        Its horizontal limits set.
    run : SlowRun
    width : float
    name : str
        At its left.
    """
    ascending = slice(None) if run.values[0] <= run.values[-1] else slice(None, None, -1)
    values, kind = run.values[ascending], run.kind[ascending]
    borders = np.concatenate([values[:1], 0.5 * (values[1:] + values[:-1]), values[-1:]])
    starts = np.flatnonzero(np.concatenate([[True], kind[1:] != kind[:-1]]))
    left, right = axes.get_xlim()
    for start, stop in zip(starts, [*starts[1:], kind.size], strict=True):
        number = int(class_of(kind[start]))
        colour = (255, 255, 255) if number < 0 else CLASSES[number][1]
        ends = borders[start], borders[stop]
        axes.add_patch(
            Rectangle((ends[0], 0.0), ends[1] - ends[0], 1.0, facecolor=hex_colour(colour), edgecolor="none")
        )
        if start:
            axes.axvline(ends[0], color="0.2", linewidth=0.3)
        text = AttractorKind(int(kind[start])).label.replace("_", "-")
        if (ends[1] - ends[0]) / (right - left) * width > _LETTER * len(text) + 0.05:
            middle = 0.5 * (ends[0] + ends[1])
            axes.text(middle, 0.46, text, ha="center", va="center", fontsize=6.5, color=text_colour(colour))
    axes.set(ylim=(0.0, 1.0), xticks=[], yticks=[])
    axes.set_ylabel(name, rotation=0, ha="right", va="center", fontsize=7, labelpad=3)


def kind_keys(runs) -> dict[str, Rectangle]:
    """Text and key of the kinds of motions that some runs have."""
    shown = np.unique(np.concatenate([class_of(run.kind) for run in runs]))
    border = {"edgecolor": "0.3", "linewidth": 0.4}
    keys = {
        name: Rectangle((0, 0), 1, 1, facecolor=hex_colour(colour), **border)
        for number, (name, colour) in enumerate(CLASSES)
        if number in shown
    }
    return keys | ({"not integrated": Rectangle((0, 0), 1, 1, facecolor="white", **border)} if -1 in shown else {})


def mark_modes(axes: Axes, system: System, named: bool) -> None:
    """Vertical lines at the linear natural frequencies; named by their share of mesh strain energy at the top."""
    left, right = axes.get_xlim()
    for frequency, share in contact_modes(system):
        if not left <= frequency <= right:
            continue
        axes.axvline(frequency, **FREQUENCY)
        if named:
            axes.text(
                frequency + 0.006 * (right - left),
                0.965,
                f"{100.0 * share:.0f} % mesh",
                transform=axes.get_xaxis_transform(),
                va="top",
                fontsize=7,
                color="0.3",
                path_effects=_HALO,
                zorder=9,
            )


def _draw_sections(axes: Axes, followed: Followed) -> None:
    for direction, run in followed.runs.items():
        few = run.kind <= AttractorKind.PERIOD_8
        for steps, size in zip((few, ~few), _DOTS[direction], strict=True):
            points = run.sections[steps]
            axes.plot(
                np.broadcast_to(run.values[steps, None], points.shape).ravel(),
                points.ravel(),
                linestyle="none",
                marker="o",
                markersize=size,
                markeredgewidth=0.0,
                color=_COLOURS[direction],
                zorder=_LINES[direction]["zorder"],
            )
        marked = _marked(direction, run)
        periodic = marked & few
        for j in range(int(AttractorKind.PERIOD_8)):
            _mark(axes, direction, run.values[periodic], run.sections[periodic, j])
        for at in run.jumps[np.isfinite(run.jumps)]:
            axes.axvline(at, color=_COLOURS[direction], linewidth=0.7, linestyle=_JUMP, zorder=3)
    _roomy(axes, np.concatenate([run.sections.ravel() for run in followed.runs.values()]))


def _draw_extremes(axes: Axes, followed: Followed) -> None:
    names = ("lowest", "highest")
    numbers = [run.quantities[name] for run in followed.runs.values() for name in names]
    up = followed.runs["up"]
    back, front = dead_zone_ends(followed.system, sweep_axis(followed.plan), up.values)
    flanks = {"$b$": front, **({"\N{MINUS SIGN}$b$": back} if np.all(np.isfinite(back)) else {})}
    _roomy(axes, np.concatenate([*numbers, *flanks.values()]))
    # A gap without a back flank goes on beyond what is shown.
    axes.fill_between(up.values, np.maximum(back, axes.get_ylim()[0]), front, color="0.93", linewidth=0.0, zorder=0)
    for label, b in flanks.items():
        axes.plot(up.values, b, **_GAP)
        # At the end where the motions are farther away.
        low, high = (min(abs(up.quantities[name][i] - b[i]) for name in names) for i in (0, -1))
        end = 0 if low > high else -1
        offset, side = (-3.0, "right") if end else (3.0, "left")
        place = {"textcoords": "offset points", "ha": side, "va": "bottom", "fontsize": 7.5, "color": "0.2"}
        axes.annotate(label, (up.values[end], b[end]), (offset, 1.5), zorder=9, path_effects=_HALO, **place)
    for name in names:
        _draw_runs(axes, followed, name)


def _draw_rms(axes: Axes, followed: Followed, curves: RowCurves) -> None:
    numbers = np.concatenate([run.quantities["rms"] for run in followed.runs.values()])
    rms, x = rms_along(curves), curves.points["position"]
    stable = [rms[segment.slice] for segment in curves.segments if segment.stable]
    seen = np.concatenate([numbers, *stable])
    seen = seen[np.isfinite(seen)]
    # A branch that runs away to the ceiling of amplitudes is not what is to be seen here.
    top = min(np.max(seen, initial=0.0), 1.6 * np.nanmax(numbers, initial=0.0)) or 1.0
    axes.set_ylim(0.0, 1.06 * top)
    for kind, (_, style) in LINES.items():
        segments = [
            p for p, lasting in zip(curves.segments, curves.lasting, strict=True) if line_of(p, lasting) == kind
        ]
        lines = [np.column_stack([x[segment.slice], rms[segment.slice]]) for segment in segments]
        more = {**style, "zorder": 2, "capstyle": "butt"}
        axes.add_collection(LineCollection(lines, colors=_MAP, linewidth=0.9, **more), autolim=False)
    _draw_runs(axes, followed, "rms")


def _draw_runs(axes: Axes, followed: Followed, name: str) -> None:
    """A quantity over both runs, each line broken where it jumps, with arrows there."""
    low, high = axes.get_ylim()
    for direction, run in followed.runs.items():
        colour, numbers = _COLOURS[direction], run.quantities[name]
        cuts = np.flatnonzero(np.isfinite(run.jumps))
        parts = zip(np.split(run.values, cuts), np.split(numbers, cuts), strict=True)
        lines = [np.column_stack(part) for part in parts]
        axes.add_collection(LineCollection(lines, colors=colour, capstyle="round", **_LINES[direction]), autolim=False)
        marked = _marked(direction, run)
        _mark(axes, direction, run.values[marked], numbers[marked])
        for i in cuts:
            if not abs(numbers[i] - numbers[i - 1]) > _LOWEST * (high - low):
                continue
            style = {"color": colour, "linewidth": 0.9, "shrinkA": 0.0, "shrinkB": 0.0, "mutation_scale": 6.5}
            arrow = {"arrowstyle": "-|>", "linestyle": _JUMP, **style}
            axes.annotate("", (run.jumps[i], numbers[i]), (run.jumps[i], numbers[i - 1]), arrowprops=arrow, zorder=6.5)


def _marked(direction: str, run: SlowRun) -> np.ndarray:
    """Steps that have a mark, (X,) bool: those of the two directions are not the same ones."""
    count = run.values.size
    ascending = np.arange(count) if direction == "up" else np.arange(count)[::-1]
    return ascending % _EVERY == (_EVERY // 4 if direction == "up" else 3 * _EVERY // 4)


def _mark(axes: Axes, direction: str, x: np.ndarray, y: np.ndarray) -> None:
    edge = {"markeredgecolor": _COLOURS[direction], "markeredgewidth": 0.8, "linestyle": "none"}
    axes.plot(x, y, **edge, **_MARKS[direction])


def _roomy(axes: Axes, numbers: np.ndarray) -> None:
    """Limits a little wider than what is shown."""
    seen = numbers[np.isfinite(numbers)]
    low, high = (float(seen.min()), float(seen.max())) if seen.size else (0.0, 1.0)
    margin = 0.06 * ((high - low) or 1.0)
    axes.set_ylim(low - margin, high + margin)


def _legend_keys(plane: StoredPlane, followed: Followed, curves: RowCurves) -> dict:
    """Text and key of everything that is shown."""
    keys = {}
    for direction in DIRECTIONS:
        edge = {"markeredgecolor": _COLOURS[direction], "markeredgewidth": 0.8}
        style = {**_LINES[direction], **_MARKS[direction], **edge}
        keys[_NAMES[direction]] = Line2D([], [], color=_COLOURS[direction], **style)
    if any(np.isfinite(run.jumps).any() for run in followed.runs.values()):
        keys["jump"] = Line2D([], [], color="0.3", linewidth=0.9, linestyle=_JUMP)
    kinds = {line_of(segment, lasting) for segment, lasting in zip(curves.segments, curves.lasting, strict=True)}
    for kind, (name, style) in LINES.items():
        if kind in kinds:
            keys[f"map: {name}"] = Line2D([], [], color=_MAP, linewidth=0.9, linestyle=style["linestyle"])
    if plane.over_frequency:
        keys["linear natural frequency"] = Line2D([], [], **FREQUENCY)
    low, high = dead_zone(followed.system)
    gap = r"gap, $|\lambda| \leq b$" if low == -high else "gap"
    keys[gap] = Rectangle((0, 0), 1, 1, facecolor="0.93", edgecolor="0.3", linewidth=0.4)
    return keys | kind_keys(followed.runs.values())
