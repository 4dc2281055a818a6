"""How lines, patterns and marks of the printed map look on a screen."""

from matplotlib.colors import to_hex

from pipeline.figures.map_legend import LINES, MODES

__all__ = ["FONT", "HATCHES", "MARKERS", "line_style", "screen_dashes"]

FONT = "Arial, Helvetica, sans-serif"
#: Pixels that a point of print is drawn with.
_PIXELS = 1.75
#: Of a fill that is not seen, yet not left out: without one Bokeh draws no pattern either.
_UNSEEN = {"fill_alpha": 1e-3}
#: Pattern of a shade -> what Bokeh draws.
HATCHES = {
    "lines": {**_UNSEEN, "hatch_pattern": "/", "hatch_scale": 16.0, "hatch_weight": 0.7, "hatch_alpha": 0.6},
    "stripes": {**_UNSEEN, "hatch_pattern": "/", "hatch_scale": 11.0, "hatch_weight": 4.0, "hatch_alpha": 1.0},
    "dots": {**_UNSEEN, "hatch_pattern": ".", "hatch_scale": 7.0, "hatch_weight": 1.0, "hatch_alpha": 0.6},
    "crosses": {**_UNSEEN, "hatch_pattern": "x", "hatch_scale": 14.0, "hatch_weight": 0.7, "hatch_alpha": 0.6},
    "blank": {"fill_alpha": 1.0},
}
#: Marked points: marker and size.
MARKERS = {"CUSP": ("triangle", 9), "FOLD_GRAZING": ("diamond", 9), "ISOLA": ("circle", 7), "MERGER": ("cross", 9)}


def line_style(kind: str) -> dict:
    """Colour, width and dashes of a line of the map, as properties of a Bokeh line."""
    style = MODES[int(kind[-1]) - 1] if kind.startswith("mode") else LINES[kind][0]
    width = _PIXELS * style["linewidth"]
    return {
        "line_color": to_hex(style["color"]),
        "line_width": round(width, 2),
        "line_dash": screen_dashes(style["linestyle"], width),
        "line_join": "round",
    }


def screen_dashes(style, width: float) -> str:
    """Dashes of a matplotlib line style in pixels, for a line of this width.

    Examples
    --------
    >>> screen_dashes("solid", 2.0), screen_dashes((0, (3.0, 1.6)), 2.0)
    ('solid', '6 3')
    """
    return style if isinstance(style, str) else " ".join(str(max(round(part * width), 1)) for part in style[1])
