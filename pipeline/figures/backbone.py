"""Backbones of both modes with the resonance peaks of the rows: how far a peak moves from the linear frequency."""

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from pipeline.figures.drawing import Drawing
from pipeline.figures.heading import HEAD, balance_text, write_heading
from pipeline.figures.naming import axis_label, mesh_energies, symbol
from pipeline.figures.peaks import resonance_peaks
from pipeline.figures.physical_axes import LIFT, show_bar_units, show_units, titled
from pipeline.plan.numerics import row_system
from pipeline.plan.traits import is_loaded_pair
from pipeline.plane.row_curves import RowCurves, curves_at
from pipeline.plane.stored import StoredPlane
from solver import Backbone, Model, backbone

__all__ = ["draw_backbone", "has_backbone", "round_values"]

#: Inches.
_WIDTH, _LEFT, _PANEL, _BESIDE, _BAR_LEFT, _BAR = 7.2, 0.46, 2.7, 0.4, 6.42, 0.13
_HEIGHT, _TOP, _BOTTOM = 2.9, 0.3, 0.72
_LINE = {"linewidth": 1.1, "zorder": 2}
_PEAK = {"linestyle": "none", "marker": "o", "markersize": 3.2, "markeredgewidth": 0.7}
_LINEAR = {"color": "0.45", "linewidth": 0.6, "linestyle": (0, (6, 1.5, 1, 1.5)), "zorder": 1}
#: At most this many rows have their peaks shown, at first order and at higher ones, where a row takes a second; this
#: many have a backbone of their own, where it depends on the row, with this many amplitudes.
_PEAKS, _PEAKS_OF_ORDER, _BACKBONES, _AMPLITUDES = 26, 7, 5, 100
#: Without the brightest end, which paper swallows.
_COLOURS = ListedColormap(colormaps["viridis"](np.linspace(0.0, 0.9, 256)))
#: How far from a round value, as a share of the axis, a row may be that stands for it.
_BESIDE_ROUND = 0.003
#: What differs by less, as a share, is drawn once.
_SAME = 1e-6


def has_backbone(plane: StoredPlane) -> bool:
    """Whether there is a backbone to draw: rows over the mesh frequency, and mean load in at least one."""
    return plane.over_frequency and bool(_loaded_models(plane))


def round_values(plane: StoredPlane, most: int) -> list[float]:
    """At most so many round values of the row parameter, evenly spaced."""
    axis = plane.plan.parameter
    ticks = MaxNLocator(nbins=max(most - 1, 1), steps=[1, 2, 2.5, 5, 10]).tick_values(axis.low, axis.high)
    inside = [float(tick) for tick in ticks if axis.low <= tick <= axis.high]
    return [float(f"{value:.12g}") for value in inside] or [axis.low]


def _loaded_models(plane: StoredPlane) -> dict[float, Model]:
    """Row value -> model for a few rows; without mean load there is no backbone."""
    models = {value: row_system(plane.plan, value) for value in round_values(plane, _BACKBONES)}
    return {value: model for value, model in models.items() if is_loaded_pair(model)}


def draw_backbone(plane: StoredPlane) -> Drawing:
    """Draw the backbones, and the largest stable amplitude near each resonance over rows of round values.

    Parameters
    ----------
    plane : StoredPlane
        One for which `has_backbone`.

    Returns
    -------
    Drawing
    """
    first_order = plane.plan.solver["balance"] == "describing_function"
    rows = _rows(plane, _PEAKS if first_order else _PEAKS_OF_ORDER)
    values = np.array([row.value for row in rows])
    lasting = resonance_peaks(rows, True)
    peaks = lasting if plane.dynamic else resonance_peaks(rows)
    # A peak that dynamic stability does not shift or take away is a stable motion.
    kept = np.all(np.abs(peaks - lasting) < 1e-9, axis=-1)
    models = _loaded_models(plane)
    tops = _tops(peaks, models)
    row_axis = plane.plan.parameter
    scale = ScalarMappable(Normalize(row_axis.low, row_axis.high), _COLOURS)

    shown = plane.scales is not None
    panel, beside = (_PANEL - 0.54, _BESIDE + 0.44) if shown else (_PANEL, _BESIDE)
    height = _BOTTOM + _HEIGHT + _TOP + HEAD + (LIFT if shown else 0.0)
    figure = Drawing((_WIDTH, height))
    write_heading(figure, plane)
    energies = mesh_energies(plane)
    for mode in range(2):
        left = _LEFT + mode * (panel + beside)
        axes = figure.add_axes((left / _WIDTH, _BOTTOM / height, panel / _WIDTH, _HEIGHT / height))
        amplitudes = np.linspace(0.0, tops[mode], _AMPLITUDES)
        curves = _distinct({value: backbone(model, amplitudes) for value, model in models.items()})
        _draw_mode(axes, values, peaks[:, mode], kept[:, mode], curves, mode, scale)
        axes.set(xlabel=axis_label("omega", plane.attributes["omega"]), ylabel="" if mode else r"amplitude $\lambda_a$")
        titled(axes, plane, f"({'ab'[mode]}) backbone of the {('lower', 'upper')[mode]} mode, {energies[mode]}")
        show_units(axes, plane, "omega", "length", "blrt")
    bar = figure.add_axes((_BAR_LEFT / _WIDTH, _BOTTOM / height, _BAR / _WIDTH, _HEIGHT / height))
    # By hand: a colorbar is a mesh of 256 areas, and a PDF would hold each of them.
    bar.imshow(
        _COLOURS(np.linspace(0.0, 1.0, 256))[:, None],
        extent=(0.0, 1.0, row_axis.low, row_axis.high),
        origin="lower",
        aspect="auto",
        interpolation="none",
    )
    bar.set(xticks=[], ylabel=axis_label(row_axis.name, plane.attributes[row_axis.name]))
    bar.yaxis.tick_right()
    bar.yaxis.set_label_position("right")
    if shown and row_axis.name in plane.scales:
        scale = plane.scales[row_axis.name]
        bar.set_title(symbol(row_axis.name), loc="right")
        show_bar_units(bar, scale).set_ylabel(f"{scale.name} ({scale.unit})")
    keys = {"backbone: undamped, free, order 1": Line2D([], [], color="black", **_LINE)}
    found = np.isfinite(peaks[..., 0])
    stable = "dynamically stable" if plane.dynamic else "stable"
    if np.any(found & kept):
        text = rf"largest {stable} $\lambda_a$, {balance_text(plane.plan).partition(' (')[0]}"
        keys[text] = Line2D([], [], color="0.3", markerfacecolor="0.3", **_PEAK)
    if np.any(found & ~kept):
        keys["the same, dynamically unstable"] = Line2D([], [], color="0.3", markerfacecolor="white", **_PEAK)
    keys["linear natural frequency"] = Line2D([], [], **_LINEAR)
    figure.legend(
        keys.values(),
        keys.keys(),
        loc="lower center",
        ncols=len(keys),
        bbox_to_anchor=(0.5, 0.07 / height),
        columnspacing=1.2,
    )
    return figure


def _rows(plane: StoredPlane, most: int) -> list[RowCurves]:
    """Rows of round values, at most so many; in place of one the stored row beside it, if it is so close that nobody
    sees a difference."""
    axis, stored = plane.plan.parameter, plane.rows[plane.complete]
    close = _BESIDE_ROUND * (axis.high - axis.low)
    values = round_values(plane, most)
    nearest = [min(stored, key=lambda row, value=value: abs(row - value), default=np.inf) for value in values]
    return [
        curves_at(plane, float(row) if abs(row - value) <= close else value)
        for value, row in zip(values, nearest, strict=True)
    ]


def _tops(peaks: np.ndarray, models: dict[float, Model]) -> list[float]:
    """Upper ends of the two amplitude axes: all peaks of the mode, and the backbone's turn if it is not far above."""
    highest = 1.12 * np.fmax.reduce(peaks[..., 1], axis=0, initial=0.0)
    turn = max(2.0 * (model.b + abs(model.f_pm) / model.rotation) for model in models.values())
    return [float(max(own, min(highest.max() or turn, turn))) for own in highest]


def _draw_mode(
    axes: Axes,
    values: np.ndarray,
    peaks: np.ndarray,
    kept: np.ndarray,
    curves: dict[float, Backbone],
    mode: int,
    scale: ScalarMappable,
) -> None:
    places, linear, drawn = [peaks[:, 0]], [], []
    for value, curve in curves.items():
        place = (curve.lower, curve.upper)[mode]
        colour = "black" if len(curves) == 1 else scale.to_rgba(value)
        # Up to where it leaves those that are drawn already it is one of their lines.
        start = max((_leaves(place, other) for other in drawn), default=0)
        axes.plot(place[start:], curve.amplitude[start:], color=colour, **_LINE)
        if not any(abs(place[0] - other) <= _SAME * other for other in linear):
            linear.append(float(place[0]))
        places.append(place)
        drawn.append(place)
    for frequency in linear:
        axes.axvline(frequency, **_LINEAR)
    # Rows with one and the same peak show it once.
    _, first = np.unique(np.round(peaks / (_SAME * np.nanmax(np.abs(peaks), initial=1.0))), axis=0, return_index=True)
    once = np.isin(np.arange(len(peaks)), first)
    colours = scale.to_rgba(values)
    for shown, filled in ((kept, True), (~kept, False)):
        here = np.isfinite(peaks[:, 0]) & shown & once
        axes.scatter(
            *peaks[here].T,
            s=_PEAK["markersize"] ** 2,
            facecolors=colours[here] if filled else "white",
            edgecolors=colours[here],
            linewidths=_PEAK["markeredgewidth"],
            zorder=3,
        )
    low, high = np.nanmin(np.concatenate(places)), np.nanmax(np.concatenate(places))
    margin = 0.08 * (high - low) or 0.05
    top = next(iter(curves.values())).amplitude[-1]
    axes.set(xlim=(low - margin, high + margin), ylim=(0.0, top))


def _leaves(place: np.ndarray, other: np.ndarray) -> int:
    """The last point up to which two backbones over the same amplitudes are one."""
    apart = np.flatnonzero(np.abs(place - other) > _SAME * other)
    return max(int(apart[0]) - 1, 0) if apart.size else place.size


def _distinct(curves: dict[float, Backbone]) -> dict[float, Backbone]:
    """All of them where the backbone depends on the row parameter, otherwise one."""
    first = next(iter(curves.values()))
    same = all(
        np.allclose((curve.lower, curve.upper), (first.lower, first.upper), rtol=_SAME, atol=0.0)
        for curve in curves.values()
    )
    return {next(iter(curves)): first} if same else curves
