"""The map of a plane as a Bokeh figure: exact regions and curves stay sharp at any zoom, and the pointer is told of."""

from collections.abc import Sequence

import numpy as np
from bokeh.core.properties import value
from bokeh.models import (
    ColorBar,
    ColumnDataSource,
    CustomJSHover,
    GlyphRenderer,
    HoverTool,
    Legend,
    LegendItem,
    LinearColorMapper,
    Range1d,
)
from bokeh.plotting import figure

from pipeline.explorer.layer_data import Layer, MapAxis
from pipeline.explorer.sources import Sources
from pipeline.explorer.styles import FONT, MARKERS, hatch_style, line_style
from pipeline.figures.palette import hex_colour, sequential_colours

__all__ = ["NO_VALUE", "add_layer", "encoded", "map_figure", "update_map"]

#: Codes of cells: classes in 8 bits and quantities in 16, the largest one where there is nothing.
_NO_CLASS, NO_VALUE = 255, 65535
_CLEAR = "rgba(0, 0, 0, 0)"
_TOOLS = "pan,wheel_zoom,box_zoom,reset,save"
#: How far the map can be moved beyond its ends, as a share of its axes.
_BEYOND = 0.04

#: Digits of corners after the first one of the length of an axis: a thousandth of what they are exact to.
_DIGITS = 9

#: What the hover tool writes of a place: the class below the pointer, the value of a quantity, or what is told of it.
_TELL = """
if (format == "class") return names[value] ?? "";
if (format == "value") return value == none ? "none" : (low + value / (none - 1) * (high - low)).toPrecision(4);
const [source, texts] = told[Number(format)], data = source.data;
const [[height, width]] = data.shape, [x0, x1, y0, y1] = data.ends[0];
const column = Math.floor((special_vars.x - x0) / (x1 - x0) * width);
const row = Math.floor((special_vars.y - y0) / (y1 - y0) * height);
if (column < 0 || row < 0 || column >= width || row >= height) return "";
return texts[data.codes[0][row * width + column]];
"""


def map_figure(layer: Layer, *, sources: Sources | None = None, legend: bool = True, **size):
    """A layer as a Bokeh figure.

    Parameters
    ----------
    layer : Layer
    sources : Sources, optional
        Of other figures on the same page: what several layers have in common is then sent once.
    legend : bool
        Whether the figure has its legend at the right.
    **size
        Further properties of the figure, such as `width`, `height`, `sizing_mode`, `x_range`, `y_range`.

    Returns
    -------
    bokeh.plotting.figure
        Named "map"; its renderers by what they show: "areas", "cells", "fold", ...
    """
    size = {"width": 860, "height": 520, "x_range": _range(layer.x), "y_range": _range(layer.y), "name": "map", **size}
    found = figure(tools=_TOOLS, active_scroll="wheel_zoom", toolbar_location="above", **size)
    found.toolbar.logo = None
    found.grid.visible = False
    found.outline_line_color = "#404040"
    found.title.update(text_font=FONT, text_font_size="14px")
    for axis in found.axis:
        axis.update(axis_label_text_font=FONT, axis_label_text_font_style="normal", major_label_text_font=FONT)
    add_layer(found, layer, sources, legend=legend)
    return found


def update_map(found, layer: Layer) -> None:
    """Show another layer in a figure of `map_figure`, in the window that is in sight."""
    legend = bool(found.select(Legend))
    found.renderers = []
    found.right = []
    found.tools = [tool for tool in found.tools if not isinstance(tool, HoverTool)]
    add_layer(found, layer, legend=legend)


def _range(axis: MapAxis) -> Range1d:
    room = _BEYOND * (axis.high - axis.low)
    return Range1d(axis.low, axis.high, bounds=(axis.low - room, axis.high + room))


def add_layer(found, layer: Layer, sources: Sources | None = None, *, legend: bool = True) -> None:
    """Draw a layer over what a figure shows; everything that is added has the layer's name among its tags.

    Parameters
    ----------
    found : bokeh.plotting.figure
        Of `map_figure`.
    layer, sources, legend
        As there.
    """
    sources, before = Sources() if sources is None else sources, set(_parts(found))
    found.title.text = layer.title
    found.xaxis.axis_label, found.yaxis.axis_label = layer.x.label, layer.y.label
    items = []
    pointed = _areas(found, layer, sources) if layer.exact else _cells(found, layer, sources)
    swatches = _swatches(found, layer)
    items += [
        LegendItem(label=value(_told(one.name, one.share)), renderers=[swatches], index=i)
        for i, one in enumerate(layer.classes)
        if one.share or layer.exact
    ]
    for shade in layer.shades:
        style = {"name": shade.name, **hatch_style(shade)}
        if shade.polygons:
            drawn = found.multi_polygons(source=sources.of(_nested([shade.polygons], layer)), **style)
        else:
            sides = dict(zip(("left", "right", "bottom", "top"), shade.boxes.T, strict=True))
            drawn = found.quad(source=sources.of(sides), **style)
        items.append(LegendItem(label=value(_told(shade.name, shade.share)), renderers=[drawn]))
    for kind in layer.lines:
        source = sources.of({"xs": [line[:, 0] for line in kind.lines], "ys": [line[:, 1] for line in kind.lines]})
        if kind.kind.startswith("mode"):
            # As in print, so that it is seen on any colour.
            found.multi_line(source=source, line_color="white", line_alpha=0.85, line_width=4.0, name="halo")
        drawn = found.multi_line(source=source, name=kind.kind, **line_style(kind.kind))
        items.append(LegendItem(label=value(kind.label), renderers=[drawn]))
    for kind in layer.marks:
        marker, pixels = MARKERS[kind.kind]
        source = sources.of({"x": kind.places[:, 0], "y": kind.places[:, 1]})
        drawn = found.scatter(
            source=source, marker=marker, size=pixels, fill_color="white", line_color="black", name=kind.kind
        )
        items.append(LegendItem(label=value(kind.label), renderers=[drawn]))
    _write(found, layer)
    found.add_tools(_hover(layer, pointed, sources))
    if legend:
        head = "n/I, share" if layer.exact else ""
        found.add_layout(
            Legend(
                items=items,
                title=head or None,
                label_text_font=FONT,
                title_text_font=FONT,
                label_text_font_size="12px",
                title_text_font_size="12px",
                spacing=1,
                padding=4,
                border_line_color=None,
            ),
            "right",
        )
    for one in set(_parts(found)) - before:
        one.tags = [layer.name]


def _parts(found) -> list:
    return [*found.renderers, *found.right, *found.tools]


def _told(name: str, share: str) -> str:
    return f"{name}   {share}" if share else name


def _nested(areas: Sequence[Sequence[np.ndarray]], layer: Layer) -> dict:
    """Areas of polygons as columns; polygons of one area are one path, so that neighbours have no seam.

    As lists of short numbers: many small arrays would take several times the room.
    """
    columns = {}
    for name, axis, place in (("xs", layer.x, 0), ("ys", layer.y, 1)):
        digits = int(_DIGITS - np.floor(np.log10(axis.high - axis.low)))
        columns[name] = [[[np.round(one[:, place], digits).tolist()] for one in polygons] for polygons in areas]
    return columns


def _areas(found, layer: Layer, sources: Sources) -> GlyphRenderer:
    count = len(layer.classes)
    data = _nested([one.polygons for one in layer.classes], layer)
    data |= {"colour": [one.colour for one in layer.classes], "code": np.arange(count)}
    return found.multi_polygons(source=sources.of(data), fill_color="colour", line_color=None, name="areas")


def encoded(layer: Layer) -> np.ndarray:
    """The values of cells as they are sent: places of classes in 8 bits, quantities evenly in 16 bits between their
    ends."""
    values = layer.cells.values
    if layer.ends is None:
        return np.where(values >= 0, values, _NO_CLASS).astype(np.uint8)
    (low, high), known = layer.ends, np.isfinite(values)
    share = np.where(known, (np.where(known, values, low) - low) / (high - low), 0.0)
    return np.where(known, np.rint(share * (NO_VALUE - 1)), NO_VALUE).astype(np.uint16)


def _cells(found, layer: Layer, sources: Sources) -> GlyphRenderer:
    if layer.ends is None:
        colours = [one.colour for one in layer.classes] or ["#ffffff"]
        mapper = LinearColorMapper(colours, low=-0.5, high=len(colours) - 0.5, high_color=_CLEAR)
    else:
        colours = [hex_colour(tuple(colour)) for colour in sequential_colours().tolist()]
        mapper = LinearColorMapper(colours, low=-0.5, high=NO_VALUE - 0.5, high_color=_CLEAR)
        bar = ColorBar(
            color_mapper=LinearColorMapper(colours, low=layer.ends[0], high=layer.ends[1]), width=14, name="bar"
        )
        found.add_layout(bar, "right")
    (x0, x1), (y0, y1) = layer.cells.x, layer.cells.y
    source = sources.of({"image": [encoded(layer)], "x": [x0], "y": [y0], "dw": [x1 - x0], "dh": [y1 - y0]})
    return found.image("image", "x", "y", "dw", "dh", source=source, color_mapper=mapper, name="cells")


def _swatches(found, layer: Layer) -> GlyphRenderer:
    """Nothing to be seen: what the legend takes the colours of classes from."""
    count = len(layer.classes)
    nowhere = np.full(count, np.nan)
    data = dict(left=nowhere, right=nowhere, bottom=nowhere, top=nowhere, colour=[one.colour for one in layer.classes])
    return found.quad(source=ColumnDataSource(data), fill_color="colour", line_color="#4d4d4d", name="swatches")


def _write(found, layer: Layer) -> None:
    led = [one for one in layer.written if one.leads_to is not None]
    if led:
        found.segment(
            [one.place[0] for one in led],
            [one.place[1] for one in led],
            [one.leads_to[0] for one in led],
            [one.leads_to[1] for one in led],
            line_color="black",
            line_width=1,
            name="leaders",
        )
        found.scatter(
            [one.leads_to[0] for one in led], [one.leads_to[1] for one in led], size=3, color="black", name="ends"
        )
    if layer.written:
        data = {
            "x": [one.place[0] for one in layer.written],
            "y": [one.place[1] for one in layer.written],
            "text": [one.text for one in layer.written],
            "ink": [one.ink for one in layer.written],
            "colour": [one.colour for one in layer.written],
            "edge": [1.0 if one.leads_to is not None else 0.0 for one in layer.written],
        }
        found.text(
            source=ColumnDataSource(data),
            text_color="ink",
            text_align="center",
            text_baseline="middle",
            text_font=value(FONT),
            text_font_size="12px",
            background_fill_color="colour",
            border_line_color="black",
            border_line_alpha="edge",
            padding=1,
            name="labels",
        )


def _hover(layer: Layer, pointed: GlyphRenderer, sources: Sources) -> HoverTool:
    field = "code" if layer.exact else "image"
    low, high = layer.ends or (0.0, 1.0)
    told = [
        (
            sources.of(
                {
                    "codes": [one.cells.values.astype(np.uint8 if len(one.texts) <= 256 else np.uint16).ravel()],
                    "shape": [one.cells.values.shape],
                    "ends": [(*one.cells.x, *one.cells.y)],
                }
            ),
            list(one.texts),
        )
        for one in layer.told
    ]
    tell = CustomJSHover(
        args=dict(names=[one.name for one in layer.classes], low=low, high=high, none=NO_VALUE, told=told), code=_TELL
    )
    shown = "value" if layer.ends is not None else "class"
    # Classes of attractors and verdicts are among what is told.
    said = layer.ends is None and any(one.name == "n/I" for one in layer.told)
    what = layer.name.replace("_", " ") if layer.ends is not None else "n/I"
    rows = [
        *(
            (_with_unit(axis.symbol, axis.unit), f"${letter}{{{_digits(axis)}}}")
            for letter, axis in (("x", layer.x), ("y", layer.y))
        ),
        *([] if said else [(_with_unit(what, layer.unit), f"@{field}{{{shown}}}")]),
        *((one.name, f"@{field}{{{number}}}") for number, one in enumerate(layer.told)),
    ]
    return HoverTool(renderers=[pointed], tooltips=rows, formatters={f"@{field}": tell}, point_policy="follow_mouse")


def _with_unit(name: str, unit: str) -> str:
    return f"{name} ({unit})" if unit else name


def _digits(axis: MapAxis) -> str:
    """How places on an axis are written: to about a ten-thousandth of its length."""
    decimals = int(np.clip(4 - np.floor(np.log10(axis.high - axis.low)), 0, 9))
    return f"0.{'0' * decimals}" if decimals else "0"
