"""A quantity and the mean over the swept parameter, for a few rows: stability, impact state, every event."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.transforms import Affine2D, Transform

from pipeline.config.quantities import AMPLITUDE, QUANTITIES
from pipeline.figures.drawing import Drawing
from pipeline.figures.heading import HEAD, write_heading
from pipeline.figures.isolated_curves import IsolatedCurves, isolated_curves_at
from pipeline.figures.layout import from_zero, keys_below
from pipeline.figures.naming import STATE_NAMES, axis_label, quantity_text, value_text
from pipeline.figures.palette import hex_colour, state_colour
from pipeline.figures.physical_axes import LIFT, show_units, titled
from pipeline.plan.traits import is_loaded_pair
from pipeline.plane.row_curves import RowCurves, curves_at
from pipeline.plane.segments import BranchSegment
from pipeline.plane.stored import StoredPlane
from pipeline.store import COMPLETE, FAILED, PENDING
from solver import EndReason, Event, ImpactState, backbone

__all__ = ["LINES", "MARKS", "chosen_values", "draw_curves", "line_of"]

#: Inches.
_WIDTH, _LEFT, _RIGHT, _BESIDE = 7.2, 0.5, 0.15, 0.55
_HEIGHT, _BETWEEN, _TOP, _BOTTOM, _PITCH, _COLUMNS = 1.85, 0.34, 0.24, 0.45, 0.16, 4
_ASIDE = 0.35

_UNSTABLE, _UNLASTING = (0, (2.6, 1.3)), (0, (0.9, 0.9))
#: Whether a segment is statically and dynamically stable -> its line.
LINES = {
    (True, True): ("stable", {"linestyle": "solid", "zorder": 4}),
    (True, False): ("dynamically unstable", {"linestyle": _UNLASTING, "zorder": 4}),
    (False, False): ("statically unstable", {"linestyle": _UNSTABLE, "zorder": 3}),
}
_FREQUENCY = {"color": "0.45", "linewidth": 0.6, "linestyle": (0, (6, 1.5, 1, 1.5)), "zorder": 1}
_BACKBONE = {"color": "black", "linewidth": 0.6, "linestyle": (0, (1, 1.2)), "zorder": 2}
_MARK = {"linestyle": "none", "markersize": 2.8, "markeredgewidth": 0.5, "markeredgecolor": "black", "zorder": 5}
#: Name -> events that share a marker, and the marker.
MARKS = {
    "fold": ((Event.FOLD,), {**_MARK, "marker": "o", "markerfacecolor": "black"}),
    "grazing, drive flank": (
        (Event.MIN_AT_DRIVE, Event.MAX_AT_DRIVE),
        {**_MARK, "marker": "D", "markerfacecolor": "none"},
    ),
    "grazing, back flank": (
        (Event.MIN_AT_BACK, Event.MAX_AT_BACK),
        {**_MARK, "marker": "s", "markerfacecolor": "none"},
    ),
    "period doubling": (
        (Event.PERIOD_DOUBLING,),
        {**_MARK, "marker": "v", "markerfacecolor": "none", "markersize": 3.6},
    ),
    "Neimark–Sacker": ((Event.NEIMARK_SACKER,), {**_MARK, "marker": "*", "markerfacecolor": "none", "markersize": 4.6}),
    "branch point": ((Event.BRANCH_POINT,), {**_MARK, "marker": "x"}),
}
_EXIT = {"marker": "^", "color": "black", "linestyle": "none", "markersize": 4.5, "zorder": 6}
#: Backbones are drawn with this many amplitudes.
_AMPLITUDES = 60
#: Inches: markers closer than this hide each other and are enlarged, in an inset of this size, at most so many times.
_CROWDED, _INSET, _MOST = 0.07, (0.72, 0.56), 2
#: Insets hide what lies below.
_ABOVE = 8


def line_of(segment: BranchSegment, lasting: bool) -> tuple[bool, bool]:
    """The key of `LINES` of a segment that is dynamically stable or not."""
    return segment.stable, bool(lasting)


def chosen_values(plane: StoredPlane, values: list[float] | None) -> list[float]:
    """The values asked for, each once; a quarter, half and three quarters of the axis unless there are any."""
    axis = plane.plan.parameter
    if values is None:
        values = [axis.low + share * (axis.high - axis.low) for share in (0.25, 0.5, 0.75)]
    return list(dict.fromkeys(float(value) for value in values))


def draw_curves(
    plane: StoredPlane,
    values: list[float] | None,
    quantity: str = AMPLITUDE.name,
    rows: Sequence[RowCurves] | None = None,
) -> Drawing:
    """Draw the curves at some values of the row parameter, a line of two panels each.

    Parameters
    ----------
    plane : StoredPlane
    values : list of float or None
        None: a quarter, half and three quarters of the axis. What is no row of the plane is solved.
    quantity : str
        One of `pipeline.config.quantities.QUANTITIES`; the mean is drawn beside it, and beside the mean the amplitude.
    rows : sequence of RowCurves, optional
        Solved already, in place of those at the values.

    Returns
    -------
    Drawing
    """
    if rows is None:
        rows = [curves_at(plane, value) for value in chosen_values(plane, values)]
    sweep = plane.plan.sweep
    names = (quantity, AMPLITUDE.name if quantity == "mean" else "mean")
    isolated = [isolated_curves_at(plane, row.value, names) for row in rows]
    keys = _legend_keys(plane, rows, names)
    for found in filter(None, isolated):
        keys |= found.keys
    bottom = _BOTTOM + _PITCH * -(-len(keys) // _COLUMNS) + 0.08
    top = _TOP + HEAD + (0.0 if plane.scales is None else LIFT)
    height = bottom + len(rows) * (_HEIGHT + _BETWEEN) - _BETWEEN + top
    figure = Drawing((_WIDTH, height))
    write_heading(figure, plane)
    aside = 0.0 if plane.scales is None else _ASIDE
    width = (_WIDTH - _LEFT - _RIGHT - _BESIDE - 2 * aside) / 2
    limits = _limits(rows, names, isolated)
    for line, (row, found) in enumerate(zip(rows, isolated, strict=True)):
        low = height - top - (line + 1) * _HEIGHT - line * _BETWEEN
        for column, name in enumerate(names):
            left = _LEFT + column * (width + aside + _BESIDE)
            axes = figure.add_axes((left / _WIDTH, low / height, width / _WIDTH, _HEIGHT / height))
            axes.set(xlim=from_zero((sweep.low, sweep.high)), ylim=limits[line][name])
            axes.set_ylabel(quantity_text(QUANTITIES[name]))
            axes.locator_params(nbins=5)
            axes.tick_params(labelbottom=line == len(rows) - 1)
            if line == len(rows) - 1:
                axes.set_xlabel(axis_label(sweep.name, plane.attributes[sweep.name]))
            if plane.over_frequency:
                _draw_frequencies(axes, row, name, limits[line].get("amplitude", (0.0, 0.0))[1])
            if row.segments:
                _draw_row(axes, row, name)
                if found is not None:
                    found.draw(axes, name)
                if column == 0:
                    _draw_exits(axes, row, name)
                _enlarge_crowded(figure, axes, row, name, found)
            else:
                why = _NOTHING[row.status]
                axes.text(0.5, 0.5, why, transform=axes.transAxes, ha="center", va="center", color="0.4")
            if column == 0:
                text = value_text(plane.plan.parameter.name, row.value, plane.scales)
                titled(axes, plane, text, below_axis=line > 0)
            sides = "lr" + "t" * (line == 0) + "b" * (line == len(rows) - 1)
            show_units(axes, plane, sweep.name, QUANTITIES[name].scale, sides)
    keys_below(figure, keys, _COLUMNS)
    return figure


_NOTHING = {PENDING: "row not computed", COMPLETE: "no branch found", FAILED: "row failed"}


def _draw_row(axes: Axes, row: RowCurves, name: str, width: float = 1.1, inset: "_Inset | None" = None) -> None:
    """Draw a row's branches and events, or those of them that an inset enlarges."""
    x, y, drawn = row.points["position"], row.values(name), []
    for kind, (_, style) in LINES.items():
        segments = [
            segment
            for segment, lasting in zip(row.segments, row.lasting, strict=True)
            if line_of(segment, lasting) == kind
        ]
        # Round ends, as lines of neighbouring segments would gape between flat ones.
        lines = LineCollection(
            [np.column_stack([x[segment.slice], y[segment.slice]]) for segment in segments],
            colors=[_state_colour(ImpactState(segment.impact)) for segment in segments],
            linewidth=width,
            capstyle="round" if all(kind) else "butt",
            joinstyle="round",
            **style,
        )
        drawn.append(lines)
    for events, style in MARKS.values():
        here = np.isin(row.points["event"], events)
        if np.any(here):
            drawn.append(Line2D(x[here], y[here], **style))
    for artist in drawn:
        if inset is not None:
            artist.set(transform=inset.transform, zorder=_ABOVE + artist.get_zorder())
        axes.add_line(artist) if isinstance(artist, Line2D) else axes.add_collection(artist, autolim=False)
        if inset is not None:
            artist.set_clip_path(inset.frame)


@dataclass(frozen=True)
class _Inset:
    """A frame in a panel, and what takes its data there; axes of their own would take five times as long."""

    frame: Rectangle
    transform: Transform


def _draw_exits(axes: Axes, row: RowCurves, name: str) -> None:
    places = _exits(row, name, axes.get_ylim()[1])
    if places:
        axes.plot(places, np.ones(len(places)), transform=axes.get_xaxis_transform(), clip_on=False, **_EXIT)


def _draw_frequencies(axes: Axes, row: RowCurves, name: str, top: float) -> None:
    """Linear natural frequencies, and where amplitudes are drawn the backbone up to the amplitude `top`."""
    for frequency in row.modes:
        axes.axvline(frequency, **_FREQUENCY)
    if top > 0.0 and is_loaded_pair(row.system):
        free = backbone(row.system, np.linspace(0.0, top, _AMPLITUDES))
        for frequency in (free.lower, free.upper):
            axes.plot(frequency, getattr(free, name), **_BACKBONE)


def _enlarge_crowded(figure: Drawing, axes: Axes, row: RowCurves, name: str, isolated: IsolatedCurves | None) -> None:
    """Insets for the places at which markers hide each other, where the panel is empty."""
    size = axes.get_position().size * figure.get_size_inches()
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    scale = np.array([right - left, high - low])
    curve = (np.column_stack([row.points["position"], row.values(name)]) - (left, low)) / scale * size
    shown = np.all((curve >= 0.0) & (curve <= size), axis=1)
    events = curve[np.isin(row.points["event"], [kind for kinds, _ in MARKS.values() for kind in kinds]) & shown]
    blocked = [curve[shown]]
    if isolated is not None:
        place = np.column_stack([isolated.points["position"], isolated.points[name]])
        blocked.append((place - (left, low)) / scale * size)
    for frequency in row.modes if row.plan.sweep.name == "omega" else ():
        place = (frequency - left) / scale[0] * size[0]
        blocked.append(np.column_stack([np.full(50, place), np.linspace(0.0, size[1], 50)]))
    for crowd in _crowds(events)[:_MOST]:
        corner = _free_corner(size, np.concatenate(blocked), crowd.mean(axis=0))
        if corner is None:
            return
        half = np.maximum(1.3 * np.ptp(crowd, axis=0), 0.025) * 0.5 + 0.006
        middle = 0.5 * (crowd.min(axis=0) + crowd.max(axis=0))
        ends = (np.stack([middle - half, middle + half]) / size * scale + (left, low)).T
        inches = Affine2D().translate(*axes.get_position().p0 * figure.get_size_inches()) + figure.dpi_scale_trans
        frame = Rectangle(
            corner, *_INSET, transform=inches, facecolor="white", edgecolor="0.3", linewidth=0.45, zorder=_ABOVE
        )
        axes.add_artist(frame)
        there = Affine2D().translate(*-ends[:, 0]).scale(*_INSET / np.ptp(ends, axis=1)).translate(*corner)
        _draw_row(axes, row, name, 0.9, _Inset(frame, there + inches))
        axes.add_patch(
            Rectangle(ends[:, 0], *np.ptp(ends, axis=1), fill=False, edgecolor="0.3", linewidth=0.45, zorder=7)
        )
        # From the nearest corner of the inset.
        box = np.array([corner, corner + _INSET])
        nearest = np.clip(middle, box[0], box[1])
        line = np.stack([nearest, middle]) / size * scale + (left, low)
        axes.plot(*line.T, color="0.3", linewidth=0.45, zorder=2.5)
        blocked.append(_filled(box))


def _crowds(events: np.ndarray) -> list[np.ndarray]:
    """Markers that lie so close together that they hide each other, the largest groups first; in inches."""
    groups: list[list[int]] = []
    for i, place in enumerate(events):
        near = [g for g in groups if np.min(np.hypot(*(events[g] - place).T)) < _CROWDED]
        groups = [g for g in groups if g not in near] + [[*(j for g in near for j in g), i]]
    crowds = [events[g] for g in groups if len(g) > 1]
    return sorted(crowds, key=lambda crowd: (-len(crowd), *crowd[0]))


def _free_corner(size: np.ndarray, blocked: np.ndarray, near: np.ndarray) -> np.ndarray | None:
    """Lower left corner of an inset that hides no curve, as near as there is; None where there is none."""
    margin = 0.04
    steps = [np.arange(margin, length - side - margin, 0.06) for length, side in zip(size, _INSET, strict=True)]
    # Every point blocks the corners of a rectangle: one more from its first row and column on, one less past its last.
    count = np.zeros([step.size + 1 for step in steps], dtype=int)
    ends = [
        (np.searchsorted(step + side + margin, place), np.searchsorted(step - margin, place, side="right"))
        for step, side, place in zip(steps, _INSET, blocked.T, strict=True)
    ]
    for i, j in itertools.product((0, 1), repeat=2):
        np.add.at(count, (ends[0][i], ends[1][j]), 1 if i == j else -1)
    free = np.argwhere(count.cumsum(axis=0).cumsum(axis=1)[:-1, :-1] == 0)
    if not len(free):
        return None
    free = np.column_stack([step[which] for step, which in zip(steps, free.T, strict=True)])
    return free[np.argmin(np.hypot(*(free + 0.5 * np.array(_INSET) - near).T))]


def _filled(box: np.ndarray) -> np.ndarray:
    """Points all over a box."""
    x, y = (np.linspace(*ends, 12) for ends in box.T)
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)


def _exits(row: RowCurves, name: str, top: float) -> list[float]:
    """Where branches that end at the amplitude ceiling leave through the top of the axis."""
    places, values = [], row.values(name)
    for number, end, reason in row.ends:
        if reason is not EndReason.AMPLITUDE_CEILING:
            continue
        of_branch = np.flatnonzero(row.points["branch"] == number)
        # From the end that ran away inwards, the first point within the axis.
        inwards = of_branch if end == 0 else of_branch[::-1]
        within = inwards[values[inwards] <= top]
        if within.size and values[inwards[0]] > top:
            places.append(float(row.points["position"][within[0]]))
    return places


def _state_colour(state: ImpactState) -> str:
    return hex_colour(state_colour(state.symbol))


def _runaway(row: RowCurves) -> list[int]:
    """Branches that end at the amplitude ceiling."""
    return [number for number, _, reason in row.ends if reason is EndReason.AMPLITUDE_CEILING]


def _limits(
    rows: list[RowCurves], names: tuple[str, ...], isolated: list[IsolatedCurves | None]
) -> list[dict[str, tuple[float, float]]]:
    """Axis limits by row and quantity: the same for all rows, except where a branch runs away to the ceiling."""
    extents = [_extent(row, names, found) if row.segments else None for row, found in zip(rows, isolated, strict=True)]
    shared = [extent for row, extent in zip(rows, extents, strict=True) if extent and not _runaway(row)]
    lows, highs = zip(*(np.transpose(extent) for extent in shared or [[(0.0, 1.0)] * len(names)]), strict=True)
    common = list(zip(np.fmin.reduce(lows), np.fmax.reduce(highs), strict=True))
    limits = []
    for row, extent in zip(rows, extents, strict=True):
        ends = extent if extent and _runaway(row) else common
        limits.append({name: _with_margin(name, *pair) for name, pair in zip(names, ends, strict=True)})
    return limits


def _with_margin(name: str, low: float, high: float) -> tuple[float, float]:
    if not (np.isfinite(low) and np.isfinite(high)):
        return 0.0, 1.0
    if not QUANTITIES[name].signed:
        return 0.0, 1.06 * high or 1.0
    margin = 0.06 * ((high - low) or 1.0)
    return low - margin, high + margin


def _extent(row: RowCurves, names: tuple[str, ...], isolated: IsolatedCurves | None) -> list[tuple[float, float]]:
    """Least and largest value of every quantity that the axes should show.

    A branch that runs away to the amplitude ceiling is shown a little beyond the last event on it.
    """
    points, away = row.points, _runaway(row)
    bounded = ~np.isin(points["branch"], away) | (points["event"] != Event.NONE)
    if not np.any(bounded):
        bounded = points["amplitude"] <= 10.0 * np.median(points["amplitude"])
    top = points["amplitude"][bounded].max() * (1.25 if away else 1.0)
    shown, extents = points["amplitude"] <= top, []
    for name in names:
        values = row.values(name)[shown]
        high = top if name == AMPLITUDE.name else np.fmax.reduce(values)
        low, others = np.fmin.reduce(values), (np.nan, np.nan) if isolated is None else isolated.extent(name)
        extents.append((float(np.fmin(low, others[0])), float(np.fmax(high, others[1]))))
    return extents


def _legend_keys(plane: StoredPlane, rows: list[RowCurves], names: tuple[str, ...]) -> dict[str, Line2D]:
    """Text and key of everything that these rows show."""
    kinds = {
        line_of(segment, lasting) for row in rows for segment, lasting in zip(row.segments, row.lasting, strict=True)
    }
    states = [ImpactState(code) for code in sorted({segment.impact for row in rows for segment in row.segments})]
    keys = {f"$I$ = {s.symbol}: {STATE_NAMES[s]}": Line2D([], [], color=_state_colour(s)) for s in states}
    for kind, (name, style) in LINES.items():
        if kind in kinds:
            keys[name] = Line2D([], [], color="0.3", linestyle=style["linestyle"])
    for name, (events, style) in MARKS.items():
        if any(np.any(np.isin(row.points["event"], events)) for row in rows):
            keys[name] = Line2D([], [], **style)
    if any(_runaway(row) for row in rows):
        ceiling = plane.plan.solver["amplitude_max"]
        keys[rf"runs on to the ceiling $\lambda_a$ = {ceiling:g}"] = Line2D([], [], **_EXIT)
    if plane.over_frequency and np.any(plane.resonances):
        keys["linear natural frequency"] = Line2D([], [], **_FREQUENCY)
        if AMPLITUDE.name in names and any(is_loaded_pair(row.system) for row in rows):
            keys["backbone"] = Line2D([], [], **_BACKBONE)
    return keys
