"""Where the map can be trusted: the credibility of its cells as areas, what integration saw as marks."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import PathPatch

from pipeline.analysis.verification.credibility import Credibility
from pipeline.analysis.verification.group import StoredVerification, read_verification
from pipeline.analysis.verification.verdicts import Verdict
from pipeline.figures.drawing import Drawing
from pipeline.figures.layout import (
    BETWEEN,
    BOTTOM,
    HEIGHT,
    LEFT,
    LEGEND,
    PANEL,
    RIGHT,
    TOP,
    WIDTH,
    ZOOM_HEIGHT,
    enlarged,
    mark_window,
    shares_of,
    zoom_places,
)
from pipeline.figures.map_legend import LINES, Entry, draw_legend, legend_height
from pipeline.figures.naming import axis_label, fixed_parameters
from pipeline.figures.palette import hex_colour
from pipeline.figures.panels import cell_borders, lines_of
from pipeline.figures.windows import coexistence_windows
from pipeline.plane.stored import StoredPlane

__all__ = ["draw_verification", "verification_of"]

#: Muted, so that marks stand out; lightness alone already tells most of them apart.
_AREAS = {
    Credibility.CONFIRMED: (229, 238, 232),
    Credibility.SHIFTED: (246, 226, 150),
    Credibility.WRONG_COUNT: (238, 164, 118),
    Credibility.WRONG_IMPACT_STATE: (190, 150, 190),
    Credibility.NOT_PERIOD_1_MOTION: (150, 182, 214),
    Credibility.UNCHECKED: (190, 190, 190),
}
_AREA_WORDS = {**{kind: kind.words for kind in Credibility}, Credibility.NOT_PERIOD_1_MOTION: "not period-1"}
_BLANK = (255, 255, 255)
_MARK = {"linestyle": "none", "markeredgecolor": "white", "markeredgewidth": 0.35, "zorder": 5}
_MARKS = {
    Verdict.CONFIRMED: {**_MARK, "marker": "o", "markersize": 3.0, "markerfacecolor": "#1b7837"},
    Verdict.WRONG_IMPACT: {**_MARK, "marker": "s", "markersize": 3.3, "markerfacecolor": "#762a83"},
    Verdict.OTHER_MOTION: {**_MARK, "marker": "^", "markersize": 4.2, "markerfacecolor": "#c1440e"},
    Verdict.NOT_PERIOD_1: {**_MARK, "marker": "D", "markersize": 3.2, "markerfacecolor": "#0b3c6f"},
    Verdict.UNBOUNDED: {**_MARK, "marker": "P", "markersize": 4.4, "markerfacecolor": "black"},
    Verdict.UNSETTLED: {
        **_MARK,
        "marker": "v",
        "markersize": 4.2,
        "markerfacecolor": "white",
        "markeredgecolor": "black",
        "markeredgewidth": 0.6,
    },
    Verdict.FAILED: {**_MARK, "marker": "x", "markersize": 3.8, "markeredgecolor": "black", "markeredgewidth": 0.9},
}
_WORDS = {
    Verdict.CONFIRMED: "confirmed",
    Verdict.WRONG_IMPACT: "other impact state",
    Verdict.OTHER_MOTION: "other motion",
    Verdict.NOT_PERIOD_1: "not period-1",
    Verdict.UNBOUNDED: "unbounded",
    Verdict.UNSETTLED: "not settled",
    Verdict.FAILED: "failed",
}
#: Inches between the middles of two marks, at least.
_APART = 0.052
#: Inches to the right end of the legend's numbers.
_SHARE = 1.54


def verification_of(store_path: Path) -> StoredVerification | None:
    """What there is to draw; None where the plane has not been verified."""
    return read_verification(store_path)


def draw_verification(plane: StoredPlane, found: StoredVerification) -> Drawing:
    """Draw the plane with agreement.

    A cell has one mark, for the worst that became of its solutions. Marks that would overlap are left out, those of
    rare verdicts last; the legend counts all cells.

    Parameters
    ----------
    plane : StoredPlane
    found : StoredVerification

    Returns
    -------
    Drawing
    """
    sweep, parameter = plane.plan.sweep, plane.plan.parameter
    columns, rows = cell_borders(sweep), cell_borders(parameter)
    whole, up = (float(columns[0]), float(columns[-1])), (float(rows[0]), float(rows[-1]))
    windows = coexistence_windows(plane.pieces, sweep.low, sweep.high)
    verdicts = _cells(plane, found)
    entries = _entries(plane, found, verdicts, lines_of(plane, whole, up))
    tall = max(HEIGHT, legend_height(entries))
    bottom = BOTTOM + (ZOOM_HEIGHT + BETWEEN if windows else 0.0)
    height = bottom + tall + TOP
    figure = Drawing((WIDTH, height))
    main = figure.add_axes(shares_of((LEFT, bottom, PANEL, tall), height))
    _fill(main, plane, found, (PANEL, tall), whole, up, verdicts)
    figure.text(1 - RIGHT / WIDTH, 1 - 0.06 / height, fixed_parameters(plane.plan), ha="right", va="top", fontsize=8)
    labels = tuple(axis_label(name, plane.attributes[name]) for name in (sweep.name, parameter.name))
    main.set(xlabel=labels[0], ylabel=labels[1])
    draw_legend(figure, entries, LEGEND, bottom + tall, _SHARE)
    if windows:
        main.set_title("(a)")
    for i, (window, place) in enumerate(zip(windows, zoom_places(len(windows)), strict=True)):
        axes = figure.add_axes(shares_of(place, height), sharey=main)
        _fill(axes, plane, found, place[2:], window, up, verdicts)
        axes.set_title(f"({'bc'[i]})")
        axes.set(xlabel=labels[0], ylabel=labels[1] if i == 0 else "")
        axes.tick_params(labelleft=i == 0)
        axes.locator_params(axis="x", nbins=6)
        mark_window(main, window, "bc"[i])
    return figure


def _cells(plane: StoredPlane, found: StoredVerification) -> dict[Verdict, np.ndarray]:
    """Verdict -> places (k, 2) of the cells whose worst solution has it."""
    rank = {verdict: i for i, verdict in enumerate(_MARKS)}
    samples = found.samples
    worst: dict[tuple[int, int], Verdict] = {}
    for row, column, value in zip(*(samples[name].tolist() for name in ("row", "column", "verdict")), strict=True):
        verdict = Verdict(value)
        worst[row, column] = max(worst.get((row, column), verdict), verdict, key=rank.__getitem__)
    x, p = plane.plan.sweep.values, plane.plan.parameter.values
    places = {verdict: [] for verdict in _MARKS}
    for (row, column), verdict in worst.items():
        places[verdict].append((x[column], p[row]))
    return {verdict: np.array(where) for verdict, where in places.items() if where}


def _fill(axes: Axes, plane: StoredPlane, found: StoredVerification, inches, x, y, verdicts) -> None:
    columns, rows = cell_borders(plane.plan.sweep), cell_borders(plane.plan.parameter)
    axes.imshow(
        enlarged(_image(plane, found)),
        extent=(columns[0], columns[-1], rows[0], rows[-1]),
        origin="lower",
        aspect="auto",
        interpolation="none",
        zorder=0,
    )
    for kind, outline in lines_of(plane, x, y).items():
        axes.add_artist(PathPatch(outline, fill=False, **LINES[kind][0]))
    scale = np.array(inches) / (x[1] - x[0], y[1] - y[0])
    taken = np.empty((0, 2))
    # The rare ones first, so that they are not crowded out.
    for verdict in sorted(verdicts, key=lambda kind: len(verdicts[kind])):
        shown = []
        for place in verdicts[verdict]:
            inside = x[0] <= place[0] <= x[1] and y[0] <= place[1] <= y[1]
            if inside and np.all(np.linalg.norm((taken - place) * scale, axis=1) >= _APART):
                taken = np.vstack([taken, place])
                shown.append(place)
        if shown:
            axes.plot(*np.array(shown).T, **_MARKS[verdict])
    axes.set(xlim=x, ylim=y)


def _image(plane: StoredPlane, found: StoredVerification) -> np.ndarray:
    colours = np.array([_AREAS[kind] for kind in Credibility], dtype=np.uint8)
    image = colours[found.layers["credibility"]]
    image[plane.domain == 0] = _BLANK
    return image


def _entries(plane: StoredPlane, found: StoredVerification, verdicts, lines) -> list[Entry]:
    judged = found.layers["credibility"][plane.domain != 0]
    entries = [Entry("label of the map", "cells")]
    for kind, colour in _AREAS.items():
        share = float(np.mean(judged == kind)) if judged.size else 0.0
        if share:
            percent = "< 0.1 %" if share < 0.0005 else f"{100.0 * share:.1f} %"
            area = {"facecolor": hex_colour(colour), "edgecolor": "0.3", "linewidth": 0.4}
            entries.append(Entry(_AREA_WORDS[kind], percent, area=area))
    if verdicts:
        entries += [Entry(), Entry("integration", "cells")]
        entries += [Entry(_WORDS[kind], str(len(where)), mark=_MARKS[kind]) for kind, where in verdicts.items()]
        entries.append(Entry("(thinned out in crowds)"))
    if lines:
        entries.append(Entry())
    entries += [Entry(text, line=style) for kind, (style, text) in LINES.items() if kind in lines]
    return entries
