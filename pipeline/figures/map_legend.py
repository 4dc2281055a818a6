"""Legend of the map, and the line and hatch styles that it explains."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.patheffects import withStroke

from pipeline.figures.naming import STATE_NAMES, mesh_energies
from pipeline.figures.palette import hex_colour, label_colour
from pipeline.figures.panels import Panel, shares_of_labels
from pipeline.figures.shading import DOT, UNSTABLE, dot_places
from pipeline.plane.division import stored_division
from pipeline.plane.stored import StoredPlane
from pipeline.store import FAILED
from solver import ImpactState
from solver.boundaries import SpecialPoint

__all__ = [
    "FAILED_ROWS",
    "LINES",
    "MARKS",
    "MARK_NAMES",
    "OPEN_CELLS",
    "Entry",
    "draw_legend",
    "legend_entries",
    "legend_height",
    "mode_style",
    "share_text",
]

#: Line kind -> its style and what the legend says of it.
LINES = {
    "fold": ({"color": "black", "linewidth": 0.65, "linestyle": "solid", "zorder": 3}, "fold: $n$ changes"),
    "grazing": (
        {"color": "0.2", "linewidth": 0.55, "linestyle": (0, (3.0, 1.6)), "zorder": 2},
        "grazing: only $I$ changes",
    ),
    "period_doubling": (
        {"color": "#7a0177", "linewidth": 0.9, "linestyle": (0, (1.0, 1.0)), "zorder": 3},
        "period doubling",
    ),
    "neimark_sacker": (
        {"color": "#00441b", "linewidth": 0.9, "linestyle": (0, (5.0, 1.0)), "zorder": 3},
        "Neimark–Sacker",
    ),
    "unit_multiplier": (
        {"color": "0.25", "linewidth": 0.6, "linestyle": (0, (0.8, 1.6)), "zorder": 2},
        "multiplier passes +1",
    ),
}
FAILED_ROWS = {"facecolor": "white", "edgecolor": "0.45", "linewidth": 0.0, "hatch": "//////", "zorder": 1}
OPEN_CELLS = {"facecolor": "none", "edgecolor": "black", "linewidth": 0.0, "hatch": "xx", "zorder": 1}
_CONTRADICTORY = {"facecolor": "white", "edgecolor": "0.1", "linewidth": 0.4}
_MODE = {
    "color": "#8b0a50",
    "linewidth": 1.0,
    "zorder": 4,
    "path_effects": [withStroke(linewidth=2.2, foreground="white", alpha=0.85)],
}
_MARK = {
    "linestyle": "none",
    "markerfacecolor": "white",
    "markeredgecolor": "black",
    "markeredgewidth": 0.6,
    "zorder": 5,
    "clip_on": False,
}
MARKS = {
    SpecialPoint.CUSP: {**_MARK, "marker": "^", "markersize": 4.2},
    SpecialPoint.FOLD_GRAZING: {**_MARK, "marker": "D", "markersize": 3.0},
    SpecialPoint.ISOLA: {**_MARK, "marker": "o", "markersize": 3.6},
    SpecialPoint.MERGER: {**_MARK, "marker": "P", "markersize": 4.4},
}

#: Inches: from line to line, width and height of a key, from key to text, right end of the shares.
_PITCH, _KEY, _KEY_HEIGHT, _TEXT, _SHARE = 0.15, 0.24, 0.095, 0.32, 1.32


def mode_style(number: int) -> dict:
    """Line style of a natural frequency: the first, 1, has one dot between its dashes, the second two, and so on."""
    return {**_MODE, "linestyle": (0, (6.0, 1.5, *((1.0, 1.5) * number)))}


@dataclass(frozen=True)
class Entry:
    """One line of the legend: its text, a number at the right, and the style of its key: area, dots in it, line or
    mark."""

    text: str = ""
    share: str = ""
    area: dict | None = None
    line: dict | None = None
    mark: dict | None = None
    dots: bool = False


def legend_entries(planes: Sequence[StoredPlane], panels: Sequence[Panel], modes, shares: bool = True) -> list[Entry]:
    """Everything that the panels show, and nothing else.

    Parameters
    ----------
    planes : sequence of StoredPlane
        One, or layers of a volume.
    panels : sequence of Panel
    modes : sequence of bool
        Which natural frequencies they show.
    shares : bool
        Whether each label's share of the plane is told.
    """
    codes = sorted({int(code) for panel in panels for code in panel.present if code})
    lines, marks = ({kind for panel in panels for kind in getattr(panel, name)} for name in ("lines", "marks"))
    entries, labels, dynamic = [], planes[0].labels, planes[0].dynamic
    if codes:
        known = shares_of_labels(planes[0]) if shares else {}
        # A label may be seen only in a window of cells, and by the curves have no share.
        symbols = {part for code in codes for part in labels[code].split("/")[1].split("-")}
        entries = [
            Entry("$n/I$", "share" if shares else ""),
            *(_label_entry(labels[code], known.get(code, 0.0) if shares else None) for code in codes),
            Entry(),
            Entry("$n$  dynamically stable" if dynamic else "$n$  stable motions"),
            *([Entry("0/\u2013  no stable motion of 1T")] if any(labels[code] == "0/-" for code in codes) else []),
            *(Entry(f"$I$ = {s.symbol}  {STATE_NAMES[s]}") for s in ImpactState if s.symbol in symbols),
            Entry(),
        ]
    if any(np.any(panel.unstable) for panel in panels):
        entries.append(Entry("not all $n$ dynamically stable", area=UNSTABLE))
    if any(np.any(panel.contradictory) for panel in panels):
        entries.append(Entry("stability contradictory:", area=_CONTRADICTORY, dots=True))
        entries.append(Entry("the order is too low"))
    entries += [Entry(text, line=style) for kind, (style, text) in LINES.items() if kind in lines]
    entries += [Entry(MARK_NAMES[kind], mark=style) for kind, style in MARKS.items() if kind in marks]
    for number, (energy, present) in enumerate(zip(mesh_energies(planes[0]), modes, strict=True), start=1):
        if present:
            entries.append(Entry(f"linear mode, {energy}", line=mode_style(number)))
    if any(stored_division(plane) is None for plane in planes):
        entries.append(Entry("areas: cells of the raster"))
    if any((plane.open == 1).any() for plane in planes):
        entries += [Entry("not excluded: motions", area=OPEN_CELLS), Entry("above the ceiling of $λ_a$")]
    if any((plane.status == FAILED).any() for plane in planes):
        entries.append(Entry("row failed", area=FAILED_ROWS))
    return entries


MARK_NAMES = {
    SpecialPoint.CUSP: "cusp: two folds end",
    SpecialPoint.FOLD_GRAZING: "fold meets grazing",
    SpecialPoint.ISOLA: "isola: a branch is born",
    SpecialPoint.MERGER: "merger: branches touch",
}


def share_text(share: float) -> str:
    """A share of the plane in percent, to two decimals."""
    return "< 0.01 %" if share < 5e-5 else f"{100.0 * share:.2f} %"


def _label_entry(label: str, share: float | None) -> Entry:
    colour = hex_colour(label_colour(label))
    percent = "" if share is None else share_text(share)
    return Entry(
        label.replace("/-", "/\u2013"), percent, area={"facecolor": colour, "edgecolor": "0.3", "linewidth": 0.4}
    )


def legend_height(entries: list[Entry]) -> float:
    """Inches."""
    return _PITCH * len(entries)


def draw_legend(figure: Figure, entries: list[Entry], left: float, top: float, share: float = _SHARE) -> None:
    """Draw the legend with its upper left corner `left` inches from the left and `top` from the bottom, the numbers
    ending `share` inches further right."""
    width, height = figure.get_size_inches()
    sheet = figure.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0.0, width), ylim=(0.0, height), zorder=-1)
    sheet.set_axis_off()
    for number, entry in enumerate(entries):
        y = top - _PITCH * (number + 0.5)
        if entry.area is not None:
            sheet.add_patch(Rectangle((left, y - 0.5 * _KEY_HEIGHT), _KEY, _KEY_HEIGHT, **entry.area))
        if entry.dots:
            # As they are in the map, in the middle. A hatch would hold a square inch of them.
            dots = dot_places(_KEY, _KEY_HEIGHT)
            dots += (left + 0.5 * _KEY, y) - 0.5 * (dots.min(axis=0) + dots.max(axis=0))
            sheet.add_line(Line2D(*dots.T, **DOT))
        if entry.line is not None:
            sheet.add_line(Line2D([left, left + _KEY], [y, y], **entry.line))
        if entry.mark is not None:
            sheet.add_line(Line2D([left + 0.5 * _KEY], [y], **entry.mark))
        sheet.text(left + _TEXT, y, entry.text, va="center_baseline", fontsize=8)
        sheet.text(left + share, y, entry.share, va="center_baseline", ha="right", fontsize=8)
