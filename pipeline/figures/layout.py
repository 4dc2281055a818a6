"""How pictures of a plane are laid out: a panel with its legend beside it, enlargements of narrow stretches below."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

__all__ = [
    "BETWEEN",
    "BOTTOM",
    "HEIGHT",
    "LEFT",
    "LEGEND",
    "PANEL",
    "RIGHT",
    "TOP",
    "WIDTH",
    "ZOOM_HEIGHT",
    "enlarged",
    "from_zero",
    "keys_below",
    "mark_window",
    "shares_of",
    "show_window",
    "zoom_places",
]

#: Inches.
WIDTH, LEFT, PANEL, RIGHT, TOP, BOTTOM = 7.2, 0.56, 4.82, 0.1, 0.36, 0.42
HEIGHT, ZOOM_HEIGHT, BETWEEN, _BESIDE, LEGEND = 3.0, 2.5, 0.72, 0.25, 5.54
#: Images are enlarged to at least this many pixels, so that no viewer blurs the cells of a small plane.
_PIXELS = 400
#: An axis that begins below this share of its end is drawn from 0.
_NEXT_TO_ZERO = 0.1
#: A window this narrow, as a share of the values in it, writes what its ticks have in common once.
_NARROW = 1e-3


def shares_of(inches: tuple[float, ...], height: float, width: float = WIDTH) -> tuple[float, ...]:
    """Left, bottom, width and height as matplotlib wants them, in a figure of this height and width."""
    return tuple(size / whole for size, whole in zip(inches, (width, height, width, height), strict=True))


def zoom_places(count: int, spare: float = 0.0) -> list[tuple[float, float, float, float]]:
    """Left, bottom, width and height in inches of the enlargements at a figure's foot, `spare` inches off the right."""
    width = (WIDTH - LEFT - RIGHT - spare - _BESIDE * (count - 1)) / max(count, 1)
    return [(LEFT + i * (width + _BESIDE), BOTTOM, width, ZOOM_HEIGHT) for i in range(count)]


def from_zero(ends: tuple[float, float]) -> tuple[float, float]:
    """Limits of an axis: from zero where what it shows begins next to it."""
    return (0.0, ends[1]) if 0.0 < ends[0] <= _NEXT_TO_ZERO * ends[1] else ends


def keys_below(figure: Figure, keys: Mapping[str, object], columns: int) -> None:
    """The legend at the foot of a figure: text -> what it stands beside."""
    foot = (0.5, 0.05 / figure.get_figheight())
    figure.legend(keys.values(), keys.keys(), loc="lower center", ncols=columns, bbox_to_anchor=foot, columnspacing=1.4)


def show_window(axes: Axes, window: Sequence[float]) -> None:
    """Limit axes to a part of the plane, (x low, x high, p low, p high), with ticks that have room."""
    axes.set(xlim=window[:2], ylim=window[2:])
    axes.locator_params(axis="x", nbins=5)
    for axis, low, high in ((axes.xaxis, *window[:2]), (axes.yaxis, *window[2:])):
        # Ticks of a narrow window share most of their digits, and there is no room for them.
        axis.get_major_formatter().set_useOffset(high - low < _NARROW * max(abs(low), abs(high)))


def enlarged(image: np.ndarray) -> np.ndarray:
    """An image (P, X, ...) with each cell a block of whole pixels."""
    for axis in (0, 1):
        image = np.repeat(image, -(-_PIXELS // image.shape[axis]), axis=axis)
    return image


def mark_window(axes: Axes, x: tuple[float, float], letter: str, lift: float = 0.0) -> None:
    """A bar above the panel, `lift` of its height further up, over the stretch that another panel enlarges."""
    above = axes.get_xaxis_transform()
    axes.plot(
        x,
        [1.022 + lift, 1.022 + lift],
        transform=above,
        color="black",
        linewidth=1.6,
        clip_on=False,
        solid_capstyle="butt",
    )
    axes.text(0.5 * (x[0] + x[1]), 1.035 + lift, f"({letter})", transform=above, ha="center", va="bottom", fontsize=8)
