"""Slices of basins at single places: initial states in lambda and its speed, coloured by what they end on."""

import numpy as np

from pipeline.analysis.attractors.wording import attractor_name
from pipeline.figures.attractors import CLASSES, class_of
from pipeline.figures.drawing import Drawing
from pipeline.figures.layout import BOTTOM, LEFT, enlarged, shares_of
from pipeline.figures.map_legend import Entry, draw_legend, legend_height
from pipeline.figures.naming import symbol
from pipeline.figures.palette import hex_colour
from pipeline.plane.stored import StoredPlane

__all__ = ["basin_colours", "draw_basins"]

#: Inches of a panel, of its legend, between panels, and above each.
_SIDE, _BESIDE, _BETWEEN, _ABOVE = 2.5, 1.9, 0.62, 0.3
#: Places that are drawn.
_MOST = 6
_UNKNOWN = (255, 255, 255)


def draw_basins(plane: StoredPlane, found) -> Drawing:
    """Draw the slices of the first six places, each with its legend.

    Parameters
    ----------
    plane : StoredPlane
    found : xarray.Dataset
        The group `places`, with slices.

    Returns
    -------
    Drawing
    """
    count = min(found.sizes["place"], _MOST)
    legends = [_entries(found.isel(place=i)) for i in range(count)]
    talls = [max(_SIDE, legend_height(entries)) + _ABOVE for entries in legends]
    height = BOTTOM + sum(talls) + (count - 1) * _BETWEEN
    figure, top = Drawing((LEFT + _SIDE + 0.25 + _BESIDE, height)), height
    names = (plane.plan.sweep.name, plane.plan.parameter.name)
    for i, (entries, tall) in enumerate(zip(legends, talls, strict=True)):
        place, bottom = found.isel(place=i), top - tall
        inches = (LEFT, bottom + tall - _ABOVE - _SIDE, _SIDE, _SIDE)
        axes = figure.add_axes(shares_of(inches, height, figure.get_figwidth()))
        x, y = place.slice_displacement.values, place.slice_speed.values
        if np.all(np.isfinite(x)):
            axes.imshow(
                enlarged(_colours(place)),
                extent=(*slice_ends(x), *slice_ends(y)),
                origin="lower",
                aspect="auto",
                interpolation="none",
            )
        at = ", ".join(f"{symbol(name)} = {float(place[f'place_{name}']):.4g}" for name in names)
        axes.set_title(at)
        axes.set(xlabel="$λ$ at $τ$ = 0", ylabel="$λ'$ at $τ$ = 0")
        draw_legend(figure, entries, LEFT + _SIDE + 0.15, bottom + tall - _ABOVE, 1.85)
        top = bottom - _BETWEEN
    return figure


def slice_ends(values: np.ndarray) -> tuple[float, float]:
    """Outer borders of cells around the states of a slice, along one of its sides."""
    half = 0.5 * (values[-1] - values[0]) / max(values.size - 1, 1)
    return float(values[0] - half), float(values[-1] + half)


def basin_colours(kinds: np.ndarray) -> list[tuple[int, int, int]]:
    """Colour of every attractor: that of its kind, darker for each further one of the same class."""
    classes, colours = class_of(kinds), []
    for slot, number in enumerate(classes.tolist()):
        before = int(np.sum(classes[:slot] == number))
        colour = np.array(CLASSES[number][1] if number >= 0 else _UNKNOWN) * 0.62**before
        colours.append(tuple(colour.round().astype(int).tolist()))
    return colours


def _colours(place) -> np.ndarray:
    table = np.array([*basin_colours(place.kind.values), _UNKNOWN], dtype=np.uint8)
    return table[place.slice.values]


def _entries(place) -> list[Entry]:
    kinds, impacts = place.kind.values, place.impact.values
    colours, filled = basin_colours(kinds), np.flatnonzero(kinds)
    share = 100.0 * np.array([np.mean(place.slice.values == slot) for slot in filled])
    entries = [Entry("initial states end on", "slice")]
    for slot, part in zip(filled.tolist(), share.tolist(), strict=True):
        area = {"facecolor": hex_colour(colours[slot]), "edgecolor": "0.3", "linewidth": 0.4}
        entries.append(Entry(attractor_name(int(kinds[slot]), int(impacts[slot])), f"{part:.1f} %", area=area))
    if np.any(place.slice.values < 0):
        area = {"facecolor": "white", "edgecolor": "0.3", "linewidth": 0.4}
        entries.append(Entry("not known", f"{100.0 * np.mean(place.slice.values < 0):.1f} %", area=area))
    entries += [Entry(), Entry(f"of {int(place.starts)} random starts", "95 % range")]
    for slot in filled.tolist():
        name = attractor_name(int(kinds[slot]), int(impacts[slot]))
        low, high = 100.0 * float(place.share_low[slot]), 100.0 * float(place.share_high[slot])
        entries.append(Entry(name, f"{low:.1f} to {high:.1f} %"))
    return [*entries, Entry(), Entry("other coordinates at rest")]
