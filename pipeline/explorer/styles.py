"""How lines, patterns and marks of the printed map look on a screen."""

from matplotlib.colors import to_hex

from pipeline.explorer.layer_data import Shade
from pipeline.figures.map_legend import LINES, mode_style

__all__ = ["FONT", "MARKERS", "hatch_style", "line_style", "screen_dashes"]

FONT = "Arial, Helvetica, sans-serif"
#: Pixels that a point of print is drawn with.
_PIXELS = 1.75
#: Pattern of a shade -> what Bokeh draws.
_HATCHES = {
    "lines": {"hatch_pattern": "/", "hatch_scale": 16.0, "hatch_weight": 0.7, "hatch_alpha": 0.6},
    "dots": {"hatch_pattern": ".", "hatch_scale": 7.0, "hatch_weight": 1.0, "hatch_alpha": 0.6},
    "crosses": {"hatch_pattern": "x", "hatch_scale": 14.0, "hatch_weight": 0.7, "hatch_alpha": 0.6},
}
#: Of patterns whose colour counts as much as the one below.
_BOLD = {"hatch_scale": 11.0, "hatch_weight": 2.4, "hatch_alpha": 1.0}
#: Marked points: marker and size.
MARKERS = {"CUSP": ("triangle", 9), "FOLD_GRAZING": ("diamond", 9), "ISOLA": ("circle", 7), "MERGER": ("cross", 9)}


def hatch_style(shade: Shade) -> dict:
    """Pattern of a shade, as properties of a Bokeh area."""
    # Without a fill, were it one that is not seen, Bokeh draws no pattern either.
    fill = {"fill_color": "#ffffff", "fill_alpha": 1.0 if shade.covers else 1e-3, "line_color": None}
    return {**fill, "hatch_color": shade.colour, **_HATCHES[shade.pattern], **(_BOLD if shade.bold else {})}


def line_style(kind: str) -> dict:
    """Colour, width and dashes of a line of the map, as properties of a Bokeh line."""
    style = mode_style(int(kind.removeprefix("mode "))) if kind.startswith("mode") else LINES[kind][0]
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
