"""Legends as HTML, which flow in whatever room there is: what colours, patterns, lines and marks mean."""

import html
from collections.abc import Sequence

from pipeline.explorer.layer_data import Layer, Shade
from pipeline.explorer.styles import MARKERS, line_style

__all__ = ["Entry", "area_entry", "legend", "line_entry", "listed", "mark_entry"]

#: A key as SVG, its text, and the share that it has, empty where that is not told.
Entry = tuple[str, str, str]

#: Pixels of a key.
_WIDE, _HIGH = 26, 12
#: Patterns, drawn over twice the width of a key so that they reach its corners.
_PATTERNS = {
    "lines": "".join(f"M{x} {_HIGH} l{_HIGH} -{_HIGH} " for x in range(-_HIGH, _WIDE + 1, 6)),
    "crosses": "".join(f"M{x} {_HIGH} l{_HIGH} -{_HIGH} M{x} 0 l{_HIGH} {_HIGH} " for x in range(-_HIGH, _WIDE + 1, 8)),
    "dots": "".join(f"M{x} {y} h0.1 " for y in (3, 9) for x in range(3 + (y == 9) * 3, _WIDE, 6)),
}
_SHAPES = {
    "triangle": "M13 2 L17.5 10 L8.5 10 Z",
    "inverted_triangle": "M13 10 L17.5 2 L8.5 2 Z",
    "diamond": "M13 1.5 L16.5 6 L13 10.5 L9.5 6 Z",
    "square": "M9.5 2.5 H16.5 V9.5 H9.5 Z",
    "circle": "M13 2.5 a3.5 3.5 0 1 0 0.01 0 Z",
    "cross": "M13 2 V10 M9 6 H17",
    "x": "M10 3 L16 9 M16 3 L10 9",
    "star": "M13 1 L14.4 4.6 L18 4.8 L15.2 7.1 L16.2 10.8 L13 8.7 L9.8 10.8 L10.8 7.1 L8 4.8 L11.6 4.6 Z",
}


def legend(layer: Layer) -> str:
    """Of a layer, as HTML."""
    entries = [area_entry(one.name, one.colour, one.share) for one in layer.classes if one.share or layer.exact]
    entries += [(_framed(_pattern(one)), one.name, one.share) for one in layer.shades]
    for one in layer.lines:
        style = line_style(one.kind)
        entries.append(line_entry(one.label, style["line_color"], style["line_width"], style["line_dash"]))
    entries += [mark_entry(one.label, MARKERS[one.kind][0], "white") for one in layer.marks]
    return listed(entries) + "".join(f'<p class="quiet">{html.escape(note)}</p>' for note in layer.notes)


def listed(entries: Sequence[Entry]) -> str:
    """Entries as HTML."""
    spans = (
        f'<span class="entry">{key}<span>{html.escape(name)}</span>'
        f"{f' <span class=quiet>{html.escape(share)}</span>' if share else ''}</span>"
        for key, name, share in entries
    )
    return f'<div class="legend">{"".join(spans)}</div>'


def area_entry(text: str, colour: str, share: str = "") -> Entry:
    """Of an area of one colour."""
    return _framed(f'<rect width="{_WIDE}" height="{_HIGH}" fill="{colour}"/>'), text, share


def line_entry(text: str, colour: str, width: float, dash: str) -> Entry:
    """Of a line; `dash` is as Bokeh takes it."""
    dash = "" if dash in ("", "solid") else f' stroke-dasharray="{dash}"'
    drawn = f'<path d="M0 6 H{_WIDE}" stroke="{colour}" stroke-width="{max(width, 1.2)}"{dash} fill="none"/>'
    return _svg(drawn), text, ""


def mark_entry(text: str, marker: str, fill: str) -> Entry:
    """Of a marker, as Bokeh calls it."""
    return _svg(f'<path d="{_SHAPES[marker]}" stroke="black" fill="{fill}"/>'), text, ""


def _svg(drawn: str) -> str:
    return f'<svg width="{_WIDE}" height="{_HIGH}" aria-hidden="true">{drawn}</svg>'


def _framed(drawn: str) -> str:
    frame = f'<rect x="0.5" y="0.5" width="{_WIDE - 1}" height="{_HIGH - 1}" fill="none" stroke="#555"/>'
    return _svg(drawn + frame)


def _pattern(shade: Shade) -> str:
    width = 3 if shade.bold else 1.8 if shade.pattern == "dots" else 0.8
    return (
        f'<path d="{_PATTERNS[shade.pattern]}" stroke="{shade.colour}" stroke-width="{width}" stroke-linecap="round"/>'
    )
