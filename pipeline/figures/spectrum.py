"""Waterfall of a run along a row: amplitudes over the swept parameter and over frequency or order, with the lines of
Campbell's diagram: orders of the mesh frequency, half orders, and linear natural frequencies.

What lies below the floor of the colours is left blank, and lines of orders are drawn beneath: where the motion has an
order its line is the amplitude itself.
"""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke

from pipeline.analysis.diagram.spectra import Spectra
from pipeline.figures.diagram import draw_kinds, kind_keys
from pipeline.figures.drawing import Drawing
from pipeline.figures.heading import HEAD, write_heading
from pipeline.figures.layout import from_zero, keys_below
from pipeline.figures.naming import axis_label, value_text
from pipeline.figures.physical_axes import LIFT, show_units
from pipeline.plane.resonances import contact_modes
from pipeline.plane.stored import StoredPlane
from solver import Scale

__all__ = ["draw_spectrum"]

#: Inches.
_WIDTH, _LEFT, _RIGHT, _ASIDE, _TITLE, _BOTTOM, _PITCH, _COLUMNS = 7.2, 0.6, 1.02, 0.5, 0.24, 0.44, 0.16, 4
_HEIGHT, _STRIP, _BAR, _ABOVE = 3.9, 0.135, 0.13, 0.16
#: Decades below the largest amplitude that have a colour, and the colours: from light to dark at an even pace.
_DECADES, _MAP = 4, "magma_r"
#: The frequency axis ends at so many times the upper natural frequency, or at the highest order if that is lower.
_TOP = 3.0
_ORDER = {"color": "0.62", "linewidth": 0.45, "linestyle": "solid", "zorder": 1}
_HALF = {"color": "0.62", "linewidth": 0.45, "linestyle": (0, (1.5, 1.5)), "zorder": 1}
_HALO = [withStroke(linewidth=2.2, foreground="white", alpha=0.9)]
_NATURAL = {"color": "#08519c", "linewidth": 1.0, "linestyle": (0, (6, 1.5, 1, 1.5)), "zorder": 4}
_JUMP = {"color": "0.15", "linewidth": 0.7, "linestyle": (0, (2.0, 1.2)), "zorder": 3}
_NAMES = {"up": "upwards", "down": "downwards"}
_OF = {"displacement": (r"amplitude of $\lambda$", "length"), "force": ("amplitude of the mesh force", "force")}


def draw_spectrum(plane: StoredPlane, spectra: Spectra) -> Drawing:
    """Draw spectra along a row.

    Parameters
    ----------
    plane : StoredPlane
    spectra : Spectra

    Returns
    -------
    Drawing
    """
    options, sweep, run = spectra.options, plane.plan.sweep, spectra.followed.runs[spectra.options.direction]
    keys = _legend_keys(spectra, run)
    lifted, aside = (0.0, 0.0) if plane.scales is None else (LIFT, _ASIDE)
    bottom = _BOTTOM + _PITCH * -(-len(keys) // _COLUMNS) + 0.06
    height = bottom + _HEIGHT + _ABOVE + _STRIP + HEAD + _TITLE + lifted
    width = _WIDTH - _LEFT - _RIGHT - 2.0 * aside
    figure = Drawing((_WIDTH, height))
    write_heading(figure, plane)
    text = value_text(plane.plan.parameter.name, options.way.value, plane.scales)
    text = f"{text},  {_NAMES[options.direction]}"
    figure.text(_LEFT / _WIDTH, 1.0 - (HEAD + 0.05) / height, text, ha="left", va="top", fontsize=9)

    def axes_at(left: float, low: float, wide: float, tall: float) -> Axes:
        return figure.add_axes((left / _WIDTH, low / height, wide / _WIDTH, tall / height))

    axes = axes_at(_LEFT, bottom, width, _HEIGHT)
    strip = axes_at(_LEFT, bottom + _HEIGHT + _ABOVE + lifted, width, _STRIP)
    limits = from_zero((sweep.low, sweep.high))
    strip.set_xlim(limits)
    draw_kinds(strip, run, width)
    top = _top(spectra)
    axes.set(xlim=limits, ylim=(0.0, top), xlabel=axis_label(sweep.name, plane.attributes[sweep.name]))
    label, scale = _OF[options.of]
    mesh = _draw_amplitudes(axes, spectra)
    _draw_orders(axes, spectra, inside=plane.scales is not None)
    if plane.over_frequency or options.axis == "frequency":
        _draw_natural(axes, spectra)
    for at in spectra.jumps[np.isfinite(spectra.jumps)]:
        axes.axvline(at, **_JUMP)
    bar = axes_at(_LEFT + width + aside + 0.38, bottom, _BAR, _HEIGHT)
    figure.colorbar(mesh, cax=bar)
    bar.set_ylabel(label)
    by_frequency = options.axis == "frequency"
    axes.set_ylabel(r"frequency over $\Omega_n$" if by_frequency else "order of the mesh frequency")
    show_units(axes, plane, sweep.name, sides="bt")
    if plane.scales is not None:
        bar.yaxis.tick_left()
        bar.set_ylabel("")
        _second_axis(bar, "right", plane.scales[scale], label)
        if by_frequency:
            axes.yaxis.tick_right()
            axes.yaxis.set_label_position("right")
            _second_axis(axes, "left", plane.scales["mesh_frequency"], "frequency")
    keys_below(figure, keys, _COLUMNS)
    return figure


def _second_axis(axes: Axes, side: str, scale: Scale, name: str) -> None:
    """An axis in physical units at one side."""
    other = axes.secondary_yaxis(side, functions=(lambda y: y * scale.shown, lambda y: y / scale.shown))
    other.set_ylabel(f"{name} ({scale.unit})")


def _top(spectra: Spectra) -> float:
    """Where the vertical axis ends."""
    highest = spectra.options.orders
    if spectra.options.axis == "order":
        return highest
    modes = contact_modes(spectra.followed.system)
    return min(highest * float(np.max(spectra.omega)), _TOP * max((natural for natural, _ in modes), default=np.inf))


def _draw_amplitudes(axes: Axes, spectra: Spectra):
    """Every order of every step as a cell, centred on it; blank below the floor."""
    values, orders = spectra.values, spectra.orders
    half = 0.5 / spectra.options.periods
    columns = _borders(values)
    rows = np.concatenate([orders - half, orders[-1:] + half])
    x = np.broadcast_to(columns, (rows.size, columns.size))
    omega = np.interp(columns, values, spectra.omega) if spectra.options.axis == "frequency" else np.ones(columns.size)
    largest = np.nanmax(spectra.amplitudes) if np.isfinite(spectra.amplitudes).any() else 1.0
    norm = LogNorm(largest * 10.0**-_DECADES, largest)
    shown = np.ma.masked_invalid(np.where(norm.vmin <= spectra.amplitudes.T, spectra.amplitudes.T, np.nan))
    return axes.pcolormesh(x, rows[:, None] * omega, shown, norm=norm, cmap=_MAP, rasterized=True, zorder=2)


def _borders(values: np.ndarray) -> np.ndarray:
    """Borders of cells around ascending values: halfway, and as far beyond the ends."""
    middles = 0.5 * (values[1:] + values[:-1])
    return np.concatenate([[2.0 * values[0] - middles[0]], middles, [2.0 * values[-1] - middles[-1]]])


def _draw_orders(axes: Axes, spectra: Spectra, inside: bool) -> None:
    """Whole orders and half orders between them; each that the axis does not name is named where it leaves the panel,
    or just inside where an axis stands there."""
    (_, right), (_, top) = axes.get_xlim(), axes.get_ylim()
    values, by_frequency = spectra.values, spectra.options.axis == "frequency"
    offset, side = ((-2, 3), "right") if inside else ((3, 0), "left")
    style = {"textcoords": "offset points", "fontsize": 7, "path_effects": _HALO, "zorder": 5}
    for half in range(1, int(2.0 * spectra.options.orders) + 1):
        order, whole = 0.5 * half, half % 2 == 0
        y = order * spectra.omega if by_frequency else np.full(values.size, order)
        axes.plot(values, y, **(_ORDER if whole else _HALF))
        if not whole and half > 3 or whole and not by_frequency:
            continue
        text = f"{order:g}" if whole else f"{half}/2"
        if y[-1] <= top:
            axes.annotate(text, (right, y[-1]), offset, ha=side, va="center", **style)
        elif y[0] < top:
            # Inside, on the line itself.
            place, above = (0.96 * top, -2.5) if inside else (top, 1.5)
            axes.annotate(text, (float(np.interp(place, y, values)), place), (0, above), ha="center", **style)


def _draw_natural(axes: Axes, spectra: Spectra) -> None:
    """Linear natural frequencies, named by their share of mesh strain energy."""
    modes, values = contact_modes(spectra.followed.system), spectra.values
    top = axes.get_ylim()[1]
    for mode, (frequency, share) in enumerate(modes):
        y = np.full(values.size, frequency)
        if spectra.options.axis == "order":
            y = frequency / spectra.omega
        axes.plot(values, y, path_effects=_HALO, **_NATURAL)
        # Over orders the lower line is named at its left, where the upper one is not.
        beside = mode == 0 and spectra.options.axis == "order" and spectra.followed.plan.sweep.name == "omega"
        at = int(np.argmax(y < (0.3 if beside else 0.93) * top))
        axes.annotate(
            f"{100.0 * share:.0f} % mesh",
            (values[at], y[at]),
            (-4, -7) if beside else (4, 2),
            textcoords="offset points",
            ha="right" if beside else "left",
            fontsize=7,
            color=_NATURAL["color"],
            path_effects=_HALO,
            zorder=5,
        )


def _legend_keys(spectra: Spectra, run) -> dict:
    """Text and key of everything that is shown."""
    keys = {
        "order of the mesh frequency": Line2D([], [], **_ORDER),
        "half order": Line2D([], [], **_HALF),
        "linear natural frequency": Line2D([], [], **_NATURAL),
    }
    if np.isfinite(spectra.jumps).any():
        keys["jump"] = Line2D([], [], **_JUMP)
    return keys | kind_keys([run])
