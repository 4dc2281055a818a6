"""Colours of n/I labels and impact states.

The hue says which impact states coexist: 0, 1 and 2 are blue, yellow and red, and a set of states has the hue that
these paints mix to (0-1 green, 0-2 violet, 1-2 orange). The lightness says how many stable motions there are: pale is
one. The numbers were fitted so that all sixteen labels with n <= 3 and states 0, 1, 2 keep a CIE distance of at least
13 for normal and red-green blind eyes alike, the eleven of the four reference planes at least 17.
"""

import math
from functools import cache

import numpy as np

__all__ = ["NOT_COMPUTED", "hex_colour", "label_colour", "sequential_colours", "state_colour", "text_colour"]

Colour = tuple[int, int, int]

NOT_COMPUTED: Colour = (255, 255, 255)

#: Impact states as they stand in a label, in the order of their codes.
_STATES = ("0", "1", "2", "f", "1m", "0m")

#: Set of states -> hue (degrees), chroma, and what is added to the lightness.
_FAMILIES = {
    "0": (252.0, 39.8, 0.2),
    "1": (101.0, 71.9, 7.5),
    "2": (26.0, 59.6, -9.0),
    "0-1": (161.2, 48.0, -3.2),
    "0-2": (299.7, 75.0, -12.8),
    "1-2": (67.9, 52.9, -0.8),
    "0-1-2": (246.2, 14.6, -8.3),
}
#: Lightness and relative chroma for n = 1 ... 8.
_LEVELS = (
    (88.9, 0.376),
    (66.8, 1.063),
    (38.0, 0.70),
    (31.0, 0.60),
    (27.0, 0.50),
    (23.0, 0.42),
    (19.0, 0.36),
    (15.0, 0.30),
)
#: Lines need more contrast with paper than areas, and differ in grey: state -> lightness, chroma, hue.
_LINES = {
    "0": (50.0, 45.0, 255.0),
    "1": (63.0, 68.0, 80.0),
    "2": (36.0, 62.0, 30.0),
    "f": (20.0, 0.0, 0.0),
    "1m": (60.0, 45.0, 150.0),
    "0m": (45.0, 55.0, 310.0),
}

#: Nodes of lightness, chroma and hue along the colours of a quantity.
_SEQUENTIAL = (
    ((0.0, 96.0), (1.0, 34.0)),
    ((0.0, 24.0), (0.3, 30.0), (0.8, 30.0), (1.0, 36.0)),
    ((0.0, 102.0), (1.0, 285.0)),
)


def label_colour(label: str) -> Colour:
    """Colour of an n/I label, the same in every plane.

    Parameters
    ----------
    label : str
        As stored, "2/0-1"; the empty label of cells that are not computed is white.

    Returns
    -------
    tuple of int
        Red, green, blue, 0 to 255.

    Examples
    --------
    >>> label_colour("1/0"), label_colour("2/0-1")
    ((199, 228, 251), (33, 175, 123))
    """
    if not label:
        return NOT_COMPUTED
    n, states = label.split("/")
    if n == "0":
        return (120, 120, 120)
    lightness, relative = _LEVELS[min(int(n), len(_LEVELS)) - 1]
    hue, chroma, offset = _FAMILIES[states] if states in _FAMILIES else _rare_family(states)
    return _rgb(lightness + offset, relative * chroma, hue)


def state_colour(symbol: str) -> Colour:
    """Colour of curves in the impact state that labels write as `symbol`."""
    return _rgb(*_LINES[symbol])


@cache
def sequential_colours() -> np.ndarray:
    """Colours of a quantity from its lowest to its highest value, (256, 3) uint8: from pale yellow to dark blue.

    Lightness falls evenly, so that it reads the same in grey, and so do all CIE distances between neighbours.
    """
    share = np.linspace(0.0, 1.0, 4001)
    lightness, chroma, hue = (np.interp(share, *np.transpose(nodes)) for nodes in _SEQUENTIAL)
    places = np.column_stack([lightness, chroma * np.cos(np.radians(hue)), chroma * np.sin(np.radians(hue))])
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))])
    even = np.interp(np.linspace(0.0, along[-1], 256), along, share)
    parts = (np.interp(even, share, part) for part in (lightness, chroma, hue))
    return np.array([_rgb(*place) for place in zip(*parts, strict=True)], dtype=np.uint8)


def text_colour(colour: Colour) -> str:
    """Black or white, whichever is read more easily on a colour."""
    red, green, blue = (part / 255.0 for part in colour)
    return "black" if 0.2126 * red**2.2 + 0.7152 * green**2.2 + 0.0722 * blue**2.2 > 0.2 else "white"


def hex_colour(colour: Colour) -> str:
    """A colour as matplotlib reads it."""
    return "#{:02x}{:02x}{:02x}".format(*colour)


def _rare_family(states: str) -> tuple[float, float, float]:
    """Sets with a contact-free or mirrored state: hues by the golden angle, so that no two sets share one."""
    mask = sum(1 << _STATES.index(state) for state in states.split("-"))
    return (mask * 137.508) % 360.0, 45.0, (-6.0, 0.0, 6.0)[mask % 3]


@cache
def _rgb(lightness: float, chroma: float, hue: float) -> Colour:
    """CIE LCh (D65) as sRGB; what the screen cannot show is brought in by lowering the chroma."""
    for part in np.linspace(1.0, 0.0, 41):
        linear = _linear_rgb(lightness, part * chroma, hue)
        if np.all((linear >= -0.003) & (linear <= 1.003)):
            break
    linear = linear.clip(0.0, 1.0)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    red, green, blue = (255.0 * encoded).round().astype(int).tolist()
    return red, green, blue


def _linear_rgb(lightness: float, chroma: float, hue: float) -> np.ndarray:
    middle = (lightness + 16.0) / 116.0
    angle = math.radians(hue)
    steps = np.array([middle + chroma * math.cos(angle) / 500.0, middle, middle - chroma * math.sin(angle) / 200.0])
    xyz = np.where(steps > 6 / 29, steps**3, 3 * (6 / 29) ** 2 * (steps - 4 / 29)) * (0.95047, 1.0, 1.08883)
    return _XYZ_TO_RGB @ xyz


_XYZ_TO_RGB = np.array(
    [[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560], [0.0556434, -0.2040259, 1.0572252]]
)
