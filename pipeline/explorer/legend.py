"""Legends below figures, as wide as there is room: what colours, patterns, lines and marks mean."""

import html

from bokeh.models import Legend, LegendItem

from pipeline.explorer.layer_data import Layer
from pipeline.explorer.styles import line_style

__all__ = ["legend", "taken_out"]

_SAMPLE = '<svg width="{width}" height="11">{drawn}</svg>'
_DASHES = {"solid": "", "dashed": "6 3", "dotted": "2 3", "dashdot": "6 3 2 3", "dotdash": "2 3 6 3"}
_PATTERNS = {
    "lines": '<path d="M0 11 L11 0 M7 11 L18 0 M-7 11 L4 0" stroke="{0}" stroke-width="1"/>',
    "dots": '<circle cx="4" cy="4" r="1.3" fill="{0}"/><circle cx="12" cy="4" r="1.3" fill="{0}"/>'
    '<circle cx="8" cy="9" r="1.3" fill="{0}"/>',
    "crosses": '<path d="M0 11 L11 0 M0 0 L11 11 M7 11 L18 0 M7 0 L18 11" stroke="{0}" stroke-width="0.8"/>',
}


def legend(layer: Layer) -> str:
    """Of a layer, as HTML."""
    entries = [
        (_box(f'<rect width="16" height="11" fill="{one.colour}"/>'), one.name, one.share)
        for one in layer.classes
        if one.share or layer.exact
    ]
    entries += [(_box(_PATTERNS[one.pattern].format(one.colour)), one.name, one.share) for one in layer.shades]
    entries += [(_line(one.kind), one.label, "") for one in layer.lines]
    entries += [("", one.label, "") for one in layer.marks]
    spans = (
        f'<span class="entry">{sample}{html.escape(name)}'
        f"{f' <span class=quiet>{html.escape(share)}</span>' if share else ''}</span>"
        for sample, name, share in entries
    )
    notes = f"<p class='quiet'>{html.escape('; '.join(layer.notes))}</p>" if layer.notes else ""
    return f'<div class="legend">{"".join(spans)}</div>{notes}'


def taken_out(figure) -> str:
    """The legend of a Bokeh figure as HTML, taken out of it: below, it has the room that it needs."""
    spans = []
    for one in figure.select(Legend):
        spans += [f'<span class="entry">{_sample(item)}{html.escape(item.label.value)}</span>' for item in one.items]
    figure.below = [one for one in figure.below if not isinstance(one, Legend)]
    return f'<div class="legend">{"".join(spans)}</div>'


def _sample(item: LegendItem) -> str:
    drawn = item.renderers[0]
    style = {name: _value(drawn, getattr(drawn.glyph, name, None), item.index or 0) for name in _STYLES}
    if style["marker"] is None:
        return _stroke(style["line_color"], style["line_dash"])
    return f'<span style="margin-right:4px">{_MARKS.get(style["marker"], "•")}</span>'


_STYLES = ("line_color", "line_dash", "marker")
_MARKS = {"circle": "●", "diamond": "◇", "square": "□", "inverted_triangle": "▽", "star": "☆", "x": "×"}


def _value(drawn, found, index: int):
    """A property of a glyph: itself, or that of one line."""
    column = getattr(found, "field", None) or (found.get("field") if isinstance(found, dict) else None)
    if column is None and isinstance(found, str) and found in drawn.data_source.data:
        column = found
    if column is not None:
        return drawn.data_source.data[column][index]
    return getattr(found, "value", found)


def _box(drawn: str) -> str:
    frame = '<rect x="0.5" y="0.5" width="15" height="10" fill="none" stroke="#555"/>'
    return _SAMPLE.format(width=16, drawn=drawn + frame)


def _line(kind: str) -> str:
    style = line_style(kind)
    return _stroke(style["line_color"], style["line_dash"], style["line_width"])


def _stroke(colour: str, dash, width: float = 1.8) -> str:
    dash = " ".join(map(str, dash)) if isinstance(dash, list | tuple) else _DASHES.get(dash, dash)
    return _SAMPLE.format(
        width=26,
        drawn=f'<line x1="0" y1="5.5" x2="26" y2="5.5" stroke="{colour}" stroke-width="{max(width, 1)}" '
        f'stroke-dasharray="{dash}"/>',
    )
