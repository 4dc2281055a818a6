"""Backbones of both modes with the resonance peaks of the rows: how far a peak moves from the linear frequency."""

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.lines import Line2D

from pipeline.figures.drawing import Drawing
from pipeline.figures.naming import axis_label, fixed_parameters
from pipeline.figures.peaks import resonance_peaks
from pipeline.figures.physical_axes import LIFT, show_bar_units, show_units, titled
from pipeline.plan.numerics import model_at
from pipeline.plane.stored import StoredPlane
from solver import Backbone, Model, backbone

__all__ = ["draw_backbone", "has_backbone"]

#: Inches.
_WIDTH, _LEFT, _PANEL, _BESIDE, _BAR_LEFT, _BAR = 7.2, 0.46, 2.7, 0.4, 6.42, 0.13
_HEIGHT, _TOP, _BOTTOM = 2.9, 0.44, 0.72
_TITLES = ("(a) mesh-frequency resonance", "(b) shaft-frequency resonance")
_LINE = {"linewidth": 1.1, "zorder": 2}
_PEAK = {"linestyle": "none", "marker": "o", "markersize": 2.8, "markeredgewidth": 0.0, "color": "0.3"}
_LINEAR = {"color": "0.45", "linewidth": 0.6, "linestyle": (0, (6, 1.5, 1, 1.5)), "zorder": 1}
#: At most this many rows have their peaks shown, more would merge into a line; and this many rows have a backbone of
#: their own, where it depends on the row, with this many amplitudes.
_PEAKS, _BACKBONES, _AMPLITUDES = 60, 5, 100
#: Without the brightest end, which paper swallows.
_COLOURS = ListedColormap(colormaps["viridis"](np.linspace(0.0, 0.9, 256)))


def has_backbone(plane: StoredPlane) -> bool:
    """Whether there is a backbone to draw: rows over the mesh frequency, and mean load in at least one."""
    return plane.over_frequency and bool(_loaded_models(plane))


def _loaded_models(plane: StoredPlane) -> dict[float, Model]:
    """Row value -> model for a few rows from the first to the last; without mean load there is no backbone."""
    rows = _spread(plane, _BACKBONES)
    models = {float(plane.rows[row]): model_at(plane.plan, plane.rows[row], plane.plan.sweep.low) for row in rows}
    return {value: model for value, model in models.items() if model.f_pm != 0.0}


def _spread(plane: StoredPlane, most: int) -> np.ndarray:
    """At most so many rows, from the first to the last."""
    count = plane.rows.size
    return np.linspace(0, count - 1, min(most, count)).round().astype(int)


def draw_backbone(plane: StoredPlane) -> Drawing:
    """Draw the backbones, and the largest stable amplitude near each resonance over the rows.

    Parameters
    ----------
    plane : StoredPlane
        One for which `has_backbone`.

    Returns
    -------
    Drawing
    """
    rows = _spread(plane, _PEAKS)
    peaks = resonance_peaks(plane, rows)
    models = _loaded_models(plane)
    tops = _tops(peaks, models)
    row_axis = plane.plan.parameter
    scale = ScalarMappable(Normalize(row_axis.low, row_axis.high), _COLOURS)

    shown = plane.scales is not None
    panel, beside = (_PANEL - 0.54, _BESIDE + 0.44) if shown else (_PANEL, _BESIDE)
    height = _BOTTOM + _HEIGHT + _TOP + (LIFT if shown else 0.0)
    figure = Drawing((_WIDTH, height))
    for mode, title in enumerate(_TITLES):
        left = _LEFT + mode * (panel + beside)
        axes = figure.add_axes((left / _WIDTH, _BOTTOM / height, panel / _WIDTH, _HEIGHT / height))
        amplitudes = np.linspace(0.0, tops[mode], _AMPLITUDES)
        curves = _distinct({value: backbone(model, amplitudes) for value, model in models.items()})
        _draw_mode(axes, plane.rows[rows], peaks[:, mode], curves, mode, scale)
        axes.set(xlabel=axis_label("omega", plane.attributes["omega"]), ylabel="" if mode else r"amplitude $\lambda_a$")
        titled(axes, plane, title)
        show_units(axes, plane, "omega", "length", "blrt")
    right = (_LEFT + 2 * panel + beside) / _WIDTH
    figure.text(right, 1 - 0.05 / height, fixed_parameters(plane.plan, plane.scales), ha="right", va="top", fontsize=8)
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
    if shown:
        show_bar_units(bar, plane, row_axis.name)
    keys = {
        "backbone (undamped, free)": Line2D([], [], color="black", **_LINE),
        rf"largest stable $\lambda_a$ ({rows.size} of {plane.rows.size} rows)": Line2D([], [], **_PEAK),
        "linear natural frequency": Line2D([], [], **_LINEAR),
    }
    figure.legend(keys.values(), keys.keys(), loc="lower center", ncols=3, bbox_to_anchor=(0.45, 0.07 / height))
    return figure


def _tops(peaks: np.ndarray, models: dict[float, Model]) -> list[float]:
    """Upper ends of the two amplitude axes: all peaks of the mode, and the backbone's turn if it is not far above."""
    highest = 1.12 * np.fmax.reduce(peaks[..., 1], axis=0, initial=0.0)
    turn = max(2.0 * (model.b + abs(model.f_pm) / model.rotation) for model in models.values())
    return [float(max(own, min(highest.max() or turn, turn))) for own in highest]


def _draw_mode(
    axes: Axes, rows: np.ndarray, peaks: np.ndarray, curves: dict[float, Backbone], mode: int, scale: ScalarMappable
) -> None:
    places = [peaks[:, 0]]
    for value, curve in curves.items():
        place = (curve.lower, curve.upper)[mode]
        colour = "black" if len(curves) == 1 else scale.to_rgba(value)
        axes.plot(place, curve.amplitude, color=colour, **_LINE)
        axes.axvline(place[0], **_LINEAR)
        places.append(place)
    found = np.isfinite(peaks[:, 0])
    axes.scatter(*peaks[found].T, s=_PEAK["markersize"] ** 2, c=scale.to_rgba(rows[found]), linewidths=0.0, zorder=3)
    low, high = np.nanmin(np.concatenate(places)), np.nanmax(np.concatenate(places))
    margin = 0.08 * (high - low) or 0.05
    top = next(iter(curves.values())).amplitude[-1]
    axes.set(xlim=(low - margin, high + margin), ylim=(0.0, top))


def _distinct(curves: dict[float, Backbone]) -> dict[float, Backbone]:
    """All of them where the backbone depends on the row parameter, otherwise one."""
    first = next(iter(curves.values()))
    same = all(
        np.allclose((curve.lower, curve.upper), (first.lower, first.upper), rtol=1e-9, atol=0.0)
        for curve in curves.values()
    )
    return {next(iter(curves)): first} if same else curves
