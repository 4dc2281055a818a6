"""Every motion at one point, a card each: time history, mesh force, phase portrait, spectrum; equal axes everywhere."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from pipeline.analysis.motion.curves import HIGHEST_ORDER, Curves
from pipeline.analysis.motion.motions import MapMotion, Motion, Motions
from pipeline.analysis.motion.wording import card_name, quantity_line, standing, summary
from pipeline.figures.drawing import Drawing
from pipeline.figures.heading import HEAD, write_heading
from pipeline.figures.layout import RIGHT, WIDTH, shares_of
from pipeline.figures.motion_axes import Units, common_cards, limits_of, units_of
from pipeline.figures.naming import value_text
from pipeline.figures.palette import hex_colour, state_colour
from pipeline.plane.stored import StoredPlane
from pipeline.run.sheets import number_text

__all__ = ["PER_PAGE", "draw_motions", "pages"]

#: Cards on a page of A4.
PER_PAGE = 4
#: Inches: left edges and widths of the columns; of a card the text above, the force panel, what is between, lambda.
_TIME, _PHASE, _SPECTRUM = (0.5, 2.56), (3.64, 1.44), (5.64, 1.46)
_TEXT, _FORCE, _GAP, _LAMBDA, _BELOW, _NAMES = 0.37, 0.56, 0.07, 1.0, 0.27, 0.2
_CARD = _TEXT + _LAMBDA + _GAP + _FORCE + _BELOW
_TITLE, _LEGEND = 0.27, 0.21
#: Where a card's description begins, beside its name.
_DESCRIPTION = 1.42
#: Periods that are shown of a motion without one, and at most of any.
_APERIODIC, _MOST = 12, 16
#: Drive flank in contact, no contact, back flank in contact.
_ZONES = tuple(hex_colour(state_colour(state)) for state in ("0", "1", "2"))
_BAND = {"color": "0.9", "linewidth": 0.0, "zorder": 0}
_BALANCE = {"color": "black", "linewidth": 0.8, "dashes": (3.0, 2.0), "zorder": 4}
_POINT = {"linestyle": "none", "marker": "o", "markeredgecolor": "white", "color": "black", "zorder": 6}
_FAINT = {"color": "0.8", "linewidth": 0.4, "zorder": 0.5}


def pages(found: Motions) -> list[Sequence[Motion | MapMotion]]:
    """The cards of each page: attractors, then the motions of the map that none of them is."""
    cards = [*found.attractors, *found.others]
    return [cards[first : first + PER_PAGE] for first in range(0, len(cards), PER_PAGE)] or [[]]


def draw_motions(plane: StoredPlane, found: Motions, cards: Sequence[Motion | MapMotion] | None = None) -> Drawing:
    """Draw motions, a card each.

    Parameters
    ----------
    plane : StoredPlane
    found : Motions
    cards : sequence, optional
        Those of `found` that are drawn, all unless given; the axes are those of all. Only motions of the map that are
        far larger than any attractor have axes of their own.

    Returns
    -------
    Drawing
    """
    everything = [*found.attractors, *found.others]
    cards = everything if cards is None else cards
    units, height = units_of(plane, found), HEAD + _TITLE + _LEGEND + _CARD * max(len(cards), 1) + _NAMES
    figure = Drawing((WIDTH, height))
    write_heading(figure, plane)
    _write_title(figure, plane, found, height)
    common, shown = common_cards(found), _shown_periods(everything)
    for i, card in enumerate(cards):
        top = height - HEAD - _TITLE - _LEGEND - i * _CARD
        fits = card in common
        limits = limits_of(common if fits else [card], found, units)
        _write_card(figure, plane, found, card, top, fits)
        _draw_card(figure, found, card, units, limits, shown, top - _TEXT, i == len(cards) - 1)
    if cards:
        _draw_legend(figure, cards, found.gap, height)
    return figure


def _shown_periods(cards) -> int:
    wanted = [2 * card.curves.repeats if card.curves.repeats else _APERIODIC for card in cards]
    return min(max(wanted, default=2), _MOST)


def _write_title(figure: Drawing, plane: StoredPlane, found: Motions, height: float) -> None:
    names = (plane.plan.sweep.name, plane.plan.parameter.name)
    at = ",  ".join(value_text(name, v, plane.scales) for name, v in zip(names, (found.x, found.p), strict=True))
    y = 1.0 - (HEAD + 0.08) / height
    figure.text(0.08 / WIDTH, y, f"Motions at {at}", ha="left", va="top", fontsize=10, weight="bold")
    figure.text(1.0 - RIGHT / WIDTH, y, summary(found), ha="right", va="top", fontsize=8)


def _write_card(figure: Drawing, plane: StoredPlane, found: Motions, card, top: float, fits: bool) -> None:
    height = figure.get_figheight()
    name = f"{card_name(card)}   {card.label}"
    first, second = (1.0 - (height - top + drop) / height for drop in (0.02, 0.18))
    figure.add_artist(Line2D([0.08 / WIDTH, 1.0 - RIGHT / WIDTH], [top / height] * 2, color="0.75", linewidth=0.5))
    figure.text(0.08 / WIDTH, first, name, ha="left", va="top", fontsize=9, weight="bold")
    what = standing(card, found) + ("" if fits else ";  axes of its own")
    figure.text(_DESCRIPTION / WIDTH, first, what, ha="left", va="top", fontsize=8)
    told = quantity_line(card.quantities, plane.scales).replace("K_v", "$K_v$").replace("λ", "$λ$")
    figure.text(0.08 / WIDTH, second, told, ha="left", va="top", fontsize=8)


def _draw_card(figure, found: Motions, card, units: Units, limits, shown: int, top: float, last: bool) -> None:
    height, bottom = figure.get_figheight(), top - _LAMBDA - _GAP - _FORCE

    def panel(column: tuple[float, float], low: float, tall: float) -> Axes:
        return figure.add_axes(shares_of((column[0], low, column[1], tall), height))

    whole = _LAMBDA + _GAP + _FORCE
    time, force = panel(_TIME, bottom + _FORCE + _GAP, _LAMBDA), panel(_TIME, bottom, _FORCE)
    phase, spectrum = panel(_PHASE, bottom, whole), panel(_SPECTRUM, bottom, whole)
    # A gap without a back flank goes on beyond what is shown.
    low, high = (end * units.length if np.isfinite(end) else limits["displacement"][0] for end in found.gap)
    time.axhspan(low, high, **_BAND)
    phase.axvspan(low, high, **_BAND)
    of_map = card if isinstance(card, MapMotion) else card.of_map
    if isinstance(card, Motion):
        _draw_solid(card.curves, found.gap, units, shown, time, force, phase)
        _draw_spectrum(card.curves, units, limits["amplitude"][0], spectrum)
    if of_map is not None:
        _draw_balance(of_map.curves, units, shown, time, force, phase, spectrum, isinstance(card, MapMotion))
    _draw_force_marks(card, found, units, force)
    for axes in (time, force):
        axes.set_xlim(0.0, shown * units.time)
        if units.time == 1.0:
            axes.set_xticks(range(0, shown + 1, max(1, shown // 6)))
        for k in range(1, shown):
            axes.axvline(k * units.time, **_FAINT)
        axes.yaxis.set_label_coords(-0.12, 0.5)
    time.tick_params(labelbottom=False)
    time.set(ylim=limits["displacement"], ylabel=units.displacement_label)
    force.set(ylim=limits["force"], ylabel=units.force_label)
    phase.yaxis.set_label_coords(-0.275, 0.5)
    phase.set(xlim=limits["displacement"], ylim=limits["speed"], ylabel=units.speed_label)
    spectrum.set(xlim=(0.0, HIGHEST_ORDER), ylim=limits["amplitude"], yscale="log", ylabel=units.spectrum_label)
    spectrum.set_xticks(range(int(HIGHEST_ORDER) + 1))
    spectrum.set_xticks(np.arange(0.5, HIGHEST_ORDER), minor=True)
    for order in range(1, int(HIGHEST_ORDER)):
        spectrum.axvline(order, **_FAINT)
    if last:
        force.set_xlabel(units.time_label)
        phase.set_xlabel(units.displacement_label)
        spectrum.set_xlabel("order of the mesh frequency")


def _draw_solid(
    curves: Curves, gap: tuple[float, float], units: Units, shown: int, time: Axes, force: Axes, phase: Axes
) -> None:
    """What integration gives: its colour tells which flank is in contact."""
    periods, displacement, forces = curves.over(shown)
    for zone, (x, y) in _parts(periods * units.time, displacement, gap):
        time.plot(x, y * units.length, color=_ZONES[zone], linewidth=1.0, zorder=3)
    force.plot(periods * units.time, forces * units.force, color=_ZONES[0], linewidth=0.9, zorder=3)
    closed = curves.repeats is not None
    path = [np.append(part, part[:1]) if closed else part for part in (curves.displacement, curves.speed)]
    for zone, (x, y) in _parts(path[0], path[1], gap, of=path[0]):
        phase.plot(x * units.length, y * units.speed, color=_ZONES[zone], linewidth=1.0 if closed else 0.3, zorder=3)
    size = {"markersize": 4.2, "markeredgewidth": 0.6} if closed else {"markersize": 1.1, "markeredgewidth": 0.0}
    phase.plot(curves.points[:, 0] * units.length, curves.points[:, 1] * units.speed, **_POINT, **size)


def _draw_balance(curves: Curves, units: Units, shown: int, time, force, phase, spectrum, alone: bool) -> None:
    """What the harmonic balance gives, dashed."""
    style = {**_BALANCE, "linewidth": 1.0} if alone else _BALANCE
    periods, displacement, forces = curves.over(shown)
    time.plot(periods * units.time, displacement * units.length, **style)
    force.plot(periods * units.time, forces * units.force, **style)
    path = [np.append(part, part[:1]) for part in (curves.displacement, curves.speed)]
    phase.plot(path[0] * units.length, path[1] * units.speed, **style)
    if alone:
        x, y = curves.points.T
        phase.plot(x * units.length, y * units.speed, markersize=4.2, markeredgewidth=0.6, **_POINT)
    amplitudes = curves.amplitudes * units.length
    if alone:
        spectrum.vlines(curves.orders, 1e-9, amplitudes, color="black", linewidth=0.8, linestyle=(0, (3.0, 2.0)))
    spectrum.plot(
        curves.orders,
        amplitudes,
        linestyle="none",
        marker="_",
        markersize=6.0,
        markeredgewidth=1.0,
        color="black",
        zorder=5,
    )


def _draw_spectrum(curves: Curves, units: Units, floor: float, axes: Axes) -> None:
    amplitudes = curves.amplitudes * units.length
    if curves.repeats is None:
        axes.plot(curves.orders, np.maximum(amplitudes, 0.1 * floor), color=_ZONES[0], linewidth=0.6, zorder=3)
        return
    whole = np.isclose(curves.orders, np.round(curves.orders))
    for lines, width in ((whole, 1.6), (~whole, 1.1)):
        axes.vlines(curves.orders[lines], 0.1 * floor, amplitudes[lines], color=_ZONES[0], linewidth=width, zorder=3)


def _draw_force_marks(card: Motion | MapMotion, found: Motions, units: Units, axes: Axes) -> None:
    axes.axhline(0.0, color="0.6", linewidth=0.4, zorder=1)
    factor = card.quantities.dynamic_factor
    if not found.static_force or not np.isfinite(factor):
        return
    axes.axhline(found.static_force * units.force, color="0.35", linewidth=0.6, dashes=(1.0, 1.4), zorder=2)
    axes.text(
        0.985,
        0.93,
        f"$K_v$ = {number_text(factor)}",
        transform=axes.transAxes,
        ha="right",
        va="top",
        fontsize=8,
        zorder=7,
    )


def _parts(x: np.ndarray, y: np.ndarray, gap: tuple[float, float], of: np.ndarray | None = None):
    """Zone -> both coordinates of a line where lambda is in it, nan between its pieces; neighbours meet."""
    displacement = y if of is None else of
    zones = np.where(displacement > gap[1], 0, np.where(displacement < gap[0], 2, 1))
    for zone in (0, 1, 2):
        inside = zones == zone
        # A piece goes on to the sample after it.
        drawn = inside | np.append(False, inside[:-1])
        if np.any(inside):
            yield zone, (x, np.where(drawn, y, np.nan))


def _draw_legend(figure: Drawing, cards, gap: tuple[float, float], height: float) -> None:
    """One line that says what lines and dots are, of what is there."""
    integrated = [card for card in cards if isinstance(card, Motion)]
    met = {zone for card in integrated for zone, _ in _parts(*[card.curves.displacement] * 2, gap)}
    names = ("drive flank", "no contact", "back flank")
    handles = [Line2D([], [], color=_ZONES[zone], linewidth=1.2, label=names[zone]) for zone in sorted(met)]
    if len(integrated) < len(cards) or any(card.of_map is not None for card in integrated):
        handles.append(Line2D([], [], **{**_BALANCE, "zorder": 1}, label="harmonic balance of the map"))
    handles += [
        Line2D([], [], markersize=4.2, markeredgewidth=0.6, **_POINT, label="start of a mesh period"),
        *([Patch(facecolor="0.9", label="gap, $|λ| ≤ b$" if gap[0] == -gap[1] else "gap")] if gap[1] > gap[0] else []),
    ]
    figure.legend(
        handles=handles,
        loc="upper left",
        bbox_to_anchor=(0.08 / WIDTH, 1.0 - (HEAD + _TITLE) / height),
        ncols=len(handles),
        columnspacing=1.4,
        handlelength=1.6,
    )
