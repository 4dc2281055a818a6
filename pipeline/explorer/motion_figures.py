"""Motions over one another as Bokeh figures: displacement and mesh force in time, phase portrait, spectrum."""

from collections.abc import Sequence

import numpy as np
from bokeh.models import Span

from pipeline.analysis.motion.curves import HIGHEST_ORDER
from pipeline.analysis.motion.motions import MapMotion, Motion, Motions
from pipeline.analysis.motion.wording import card_name
from pipeline.explorer.legend import Entry, line_entry
from pipeline.explorer.plain_figure import empty, name_axes, numbers, plain_figure, set_range, source_of
from pipeline.explorer.plain_text import plain
from pipeline.figures.motion_axes import Units, limits_of

__all__ = ["MOTION_FIGURES", "fill_motions", "motion_figures"]

#: The figures of motions, in order.
MOTION_FIGURES = ("time", "force", "phase", "spectrum")
#: Periods of a motion that are shown: of one that repeats two of its own, of others so many.
_APERIODIC, _MOST = 12, 16
#: Of motions one after the other; they differ in lightness as well.
_INKS = ("#0072b2", "#d55e00", "#009e73", "#56367d", "#a06a00", "#000000")
_WIDTH, _THIN = 1.6, 0.6
_STYLE = ("colour", "dash", "width")


def motion_figures(**options) -> dict:
    """Empty figures; `fill_motions` gives them data.

    Parameters
    ----------
    **options
        Further properties of every figure, such as `width`, `height`.

    Returns
    -------
    dict of str to bokeh.plotting.figure
        By the names of `MOTION_FIGURES`, each with a renderer "motions"; time and force move together.
    """
    options = {"width": 420, "height": 240, **options}
    found = {
        name: plain_figure(small=True, name=name, **options, **({"y_axis_type": "log"} if name == "spectrum" else {}))
        for name in MOTION_FIGURES
    }
    found["force"].x_range = found["time"].x_range
    in_time = empty("time", "displacement", "force", *_STYLE)
    style = dict(line_color="colour", line_dash="dash", line_width="width", name="motions")
    found["time"].multi_line("time", "displacement", source=in_time, **style)
    found["force"].multi_line("time", "force", source=in_time, **style)
    for name in ("phase", "spectrum"):
        found[name].multi_line("xs", "ys", source=empty("xs", "ys", *_STYLE), **style)
    points = empty("x", "y", "colour", "size")
    found["phase"].scatter("x", "y", source=points, size="size", fill_color="colour", line_color=None, name="points")
    for name, dimension in (("time", "width"), ("phase", "height")):
        for end in ("back", "front"):
            found[name].add_layout(
                Span(dimension=dimension, line_color="#808080", line_dash="2 3", line_width=1, name=end, visible=False)
            )
    return found


def fill_motions(figures: dict, cards: Sequence[Motion | MapMotion], found: Motions, units: Units) -> list[Entry]:
    """Show motions in figures of `motion_figures`.

    Attractors are solid lines, motions of the balance dashed ones.

    Parameters
    ----------
    figures : dict of str to bokeh.plotting.figure
    cards : sequence of Motion or MapMotion
    found : Motions
        At the place that they belong to.
    units : Units
        Of `pipeline.figures.motion_axes.units_of`.

    Returns
    -------
    list of Entry
        The legend of all figures.
    """
    displacement, speed, time, force, spectrum = (
        plain(getattr(units, f"{one}_label")) for one in ("displacement", "speed", "time", "force", "spectrum")
    )
    # How long a mesh period is has no room there.
    time = time.partition(";")[0]
    name_axes(figures["time"], time, displacement)
    name_axes(figures["force"], time, force)
    name_axes(figures["phase"], displacement, speed)
    name_axes(figures["spectrum"], "order", spectrum)
    _show_gap(figures, found.gap, units)
    periods = [2 * card.curves.repeats if card.curves.repeats else _APERIODIC for card in cards]
    shown = min(max(periods, default=2), _MOST)
    floor = _set_ranges(figures, cards, found, units, shown)
    curves = [card.curves for card in cards]
    closed = [one.repeats is not None for one in curves]
    style = {
        "colour": [_INKS[number % len(_INKS)] for number in range(len(cards))],
        "dash": ["6 4" if isinstance(card, MapMotion) else "" for card in cards],
        "width": [_WIDTH] * len(cards),
    }
    in_time = [one.over(shown) for one in curves]
    source_of(figures["time"], "motions").data = {
        "time": [numbers(periods * units.time) for periods, _, _ in in_time],
        "displacement": [numbers(values * units.length) for _, values, _ in in_time],
        "force": [numbers(values * units.force) for _, _, values in in_time],
        **style,
    }
    source_of(figures["phase"], "motions").data = {
        "xs": [numbers(_path(one.displacement, ends) * units.length) for one, ends in zip(curves, closed, strict=True)],
        "ys": [numbers(_path(one.speed, ends) * units.speed) for one, ends in zip(curves, closed, strict=True)],
        **style,
        "width": [_WIDTH if ends else _THIN for ends in closed],
    }
    counts = [len(one.points) for one in curves]
    points = np.concatenate([np.empty((0, 2)), *(one.points for one in curves)]) * (units.length, units.speed)
    source_of(figures["phase"], "points").data = {
        "x": numbers(points[:, 0]),
        "y": numbers(points[:, 1]),
        "colour": np.repeat(style["colour"], counts).tolist(),
        "size": np.repeat([6.0 if ends else 2.0 for ends in closed], counts).tolist(),
    }
    lines = [_spectrum(one, units.length, floor) for one in curves]
    source_of(figures["spectrum"], "motions").data = {
        "xs": [numbers(orders) for orders, _ in lines],
        "ys": [numbers(amplitudes) for _, amplitudes in lines],
        **style,
    }
    texts = [f"{card_name(card)}  {card.label}" for card in cards]
    return [line_entry(*one) for one in zip(texts, style["colour"], style["width"], style["dash"], strict=True)]


def _show_gap(figures: dict, gap: tuple[float, float], units: Units) -> None:
    """Both ends of the gap; one without a back flank has one end."""
    for name in ("time", "phase"):
        for span in (one for one in figures[name].center if isinstance(one, Span)):
            end = gap[span.name == "front"]
            span.visible = bool(gap[0] < gap[1] and np.isfinite(end))
            if span.visible:
                span.location = end * units.length


def _set_ranges(figures: dict, cards, found: Motions, units: Units, shown: int) -> float:
    """Limits as in print; where a spectrum begins."""
    set_range(figures["time"].x_range, 0.0, shown * units.time)
    set_range(figures["spectrum"].x_range, 0.0, HIGHEST_ORDER + 0.3)
    if not cards:
        return 0.0
    limits = limits_of(cards, found, units)
    set_range(figures["time"].y_range, *limits["displacement"])
    set_range(figures["force"].y_range, *limits["force"])
    set_range(figures["phase"].x_range, *limits["displacement"])
    set_range(figures["phase"].y_range, *limits["speed"])
    set_range(figures["spectrum"].y_range, *limits["amplitude"])
    return limits["amplitude"][0]


def _path(values: np.ndarray, closed: bool) -> np.ndarray:
    return np.append(values, values[:1]) if closed else values


def _spectrum(curves, length: float, floor: float) -> tuple[np.ndarray, np.ndarray]:
    """Lines from below the figure of a motion that repeats, and one curve of others."""
    amplitudes = np.maximum(curves.amplitudes * length, 0.1 * floor)
    if curves.repeats is None:
        return curves.orders, amplitudes
    nowhere, below = np.full(amplitudes.size, np.nan), np.full(amplitudes.size, 0.1 * floor)
    return (
        np.column_stack([curves.orders, curves.orders, nowhere]).ravel(),
        np.column_stack([below, amplitudes, nowhere]).ravel(),
    )
