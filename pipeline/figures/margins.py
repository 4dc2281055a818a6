"""A design point on its map: operating range, tolerances, the largest box, the ways to the nearest boundaries."""

from matplotlib.axes import Axes
from matplotlib.patches import Rectangle
from matplotlib.patheffects import withStroke

from pipeline.figures.drawing import Drawing
from pipeline.figures.layout import BETWEEN, ZOOM_HEIGHT, mark_window, shares_of, zoom_places
from pipeline.figures.map import fill, with_main_panel
from pipeline.figures.map_legend import Entry
from pipeline.figures.panels import panel_of
from pipeline.figures.physical_axes import lift, show_units, spare, titled
from pipeline.plane.stored import StoredPlane

__all__ = ["draw_margins"]


def _halo(width: float) -> list:
    return [withStroke(linewidth=width, foreground="white")]


#: Black on white stands out from every colour of the map.
_BOX = {"facecolor": "none", "edgecolor": "black", "linewidth": 1.5, "zorder": 6, "path_effects": _halo(3.4)}
_TOLERANCE = {**_BOX, "linewidth": 1.1, "linestyle": (0, (2.2, 1.4)), "zorder": 7, "path_effects": _halo(2.8)}
_RANGE = {"color": "black", "linewidth": 1.8, "solid_capstyle": "butt", "zorder": 7, "path_effects": _halo(3.6)}
_POINT = {
    "linestyle": "none",
    "marker": "*",
    "markersize": 9.5,
    "markerfacecolor": "white",
    "markeredgecolor": "black",
    "markeredgewidth": 0.9,
    "zorder": 9,
}
_WAY = {"color": "black", "linewidth": 0.9, "linestyle": (0, (1.0, 1.2)), "zorder": 6.5, "path_effects": _halo(2.6)}
_HIT = {
    "linestyle": "none",
    "marker": "X",
    "markersize": 5.6,
    "markerfacecolor": "black",
    "markeredgecolor": "white",
    "markeredgewidth": 0.8,
    "zorder": 8,
}
#: What is shown is enlarged below where it takes up less than this share of both axes; around it so much of its size.
_SMALL, _AROUND = 0.5, 0.35


def draw_margins(plane: StoredPlane, answer) -> Drawing:
    """Draw the map with what was found of a design point.

    Where all of it is small in the plane, a panel below enlarges it.

    Parameters
    ----------
    plane : StoredPlane
    answer : pipeline.analysis.margins.Answer

    Returns
    -------
    Drawing
    """
    window = _window(plane, answer, _hits(answer)) or _window(plane, answer, [])
    panels = [panel_of(plane)] + ([panel_of(plane, *window)] if window else [])
    below = ZOOM_HEIGHT + BETWEEN + lift(plane) if window else 0.0
    figure, main, labels = with_main_panel(plane, panels, below, False, _entries(answer))
    _mark(main, answer)
    if window:
        height = figure.get_figheight()
        titled(main, plane, "(a)")
        axes = figure.add_axes(shares_of(zoom_places(1, spare(plane))[0], height))
        fill(axes, panels[1], plane)
        titled(axes, plane, "(b)")
        axes.set(xlabel=labels[0], ylabel=labels[1], xlim=window[0], ylim=window[1])
        _mark(axes, answer)
        show_units(axes, plane, plane.plan.sweep.name, plane.plan.parameter.name)
        mark_window(main, window[0], "b", lift(plane) / (main.get_position().height * height))
    return figure


def _hits(answer) -> list[tuple[float, float]]:
    """Where the axes through the point meet the nearest boundaries."""
    design, sweep = answer.design, answer.plan.sweep.name
    shown = [one for one in answer.margins if not one.of_range and one.place is not None]
    return [
        (one.place, design.p) if one.name == sweep else (design.x, one.place)
        for one in shown
        if one.name in (sweep, answer.plan.parameter.name)
    ]


def _rectangles(answer) -> list[tuple[dict, tuple, tuple]]:
    """Style and both ranges of the rectangles."""
    design = answer.design
    found = [] if answer.box is None else [(_BOX, answer.box.x, answer.box.p)]
    if design.tolerance > 0.0 and design.low < design.high:
        p = design.p - design.tolerance, design.p + design.tolerance
        found.append((_TOLERANCE, (design.low, design.high), p))
    return found


def _window(plane: StoredPlane, answer, places) -> tuple[tuple[float, float], tuple[float, float]] | None:
    """The part that holds everything about the design and some places besides, if it is small; else None."""
    design, sides = answer.design, []
    rectangles = [ranges for _, *ranges in _rectangles(answer)]
    for i, (axis, ends) in enumerate(
        (
            (plane.plan.sweep, (design.low, design.high)),
            (plane.plan.parameter, (design.p - design.tolerance, design.p + design.tolerance)),
        )
    ):
        values = [*ends, *(end for ranges in rectangles for end in ranges[i]), *(place[i] for place in places)]
        low, high = min(values), max(values)
        around = max(_AROUND * (high - low), 0.03 * (axis.high - axis.low))
        sides.append((max(low - around, axis.low), min(high + around, axis.high)))
        if sides[-1][1] - sides[-1][0] > _SMALL * (axis.high - axis.low):
            return None
    return sides[0], sides[1]


def _mark(axes: Axes, answer) -> None:
    design = answer.design
    for style, x, p in _rectangles(answer):
        axes.add_patch(Rectangle((x[0], p[0]), x[1] - x[0], p[1] - p[0], **style))
    for x, p in _hits(answer):
        axes.plot([design.x, x], [design.p, p], **_WAY)
        axes.plot(x, p, **_HIT)
    if design.low < design.high:
        axes.plot([design.low, design.high], [design.p, design.p], **_RANGE)
    if design.tolerance > 0.0:
        axes.plot([design.x, design.x], [design.p - design.tolerance, design.p + design.tolerance], **_RANGE)
    axes.plot(design.x, design.p, **_POINT)


def _entries(answer) -> list[Entry]:
    """What the legend says of all this."""
    design = answer.design
    entries = [Entry(), Entry("design point", mark=_POINT)]
    if design.low < design.high or design.tolerance > 0.0:
        both = design.low < design.high and design.tolerance > 0.0
        text = "range and tolerance" if both else "operating range" if design.low < design.high else "tolerance"
        entries.append(Entry(text, line=_RANGE))
        entries += [Entry("range × tolerance", area=_TOLERANCE)] if both else []
    if _hits(answer):
        entries.append(Entry("nearest boundary", line=_WAY, mark=_HIT))
    if answer.box is not None:
        entries.append(Entry(f"largest box of {answer.label}", area=_BOX))
    verified = "not verified" if answer.doubts else "and integration"
    return [*entries, Entry(f"labels: {answer.known[0].source},"), Entry(verified)]
