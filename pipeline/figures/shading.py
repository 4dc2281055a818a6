"""Areas marked so sparsely that the colour below stays what it is: thin parallel lines, or dots."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

__all__ = ["DOT", "UNSTABLE", "dot_places", "draw_dots", "draw_lines"]

#: Inches: from line to line, from dot to dot, from sample to sample along a line.
_LINES, _DOTS, _SAMPLE = 0.075, 0.06, 0.0025
_LINE = {"linewidths": 0.35, "zorder": 1.5}
DOT = {"color": "0.1", "linestyle": "none", "marker": "o", "markersize": 0.95, "markeredgewidth": 0.0, "zorder": 1.5}
#: Key of a legend.
UNSTABLE = {"facecolor": "white", "edgecolor": "0.15", "linewidth": 0.4, "hatch": "/////"}


def draw_lines(
    axes: Axes, marked: np.ndarray, x: tuple[float, float], y: tuple[float, float], colour: str = "0.15"
) -> None:
    """Draw parallel lines where a lattice over (x, y) is marked.

    Parameters
    ----------
    axes : Axes
        Of its final size.
    marked : (m, n) bool array
        Evenly over the panel.
    x, y : (low, high)
    colour : str
    """
    if not np.any(marked):
        return
    width, height = _inches(axes)
    segments = []
    # Lines of 45 degrees: across - up = offset.
    for offset in np.arange(-height, width, _LINES * np.sqrt(2.0)) + 0.5 * _LINES:
        first, last = max(offset, 0.0), min(width, height + offset)
        across = np.arange(first, last, _SAMPLE)
        if across.size < 2:
            continue
        here = np.concatenate([[False], _at(marked, across / width, (across - offset) / height), [False]])
        edges = np.flatnonzero(here[1:] != here[:-1])
        segments += [
            [(across[a], across[a] - offset), (across[b - 1], across[b - 1] - offset)]
            for a, b in zip(edges[::2], edges[1::2], strict=True)
            if b - a > 1
        ]
    if segments:
        ends = np.array(segments) / (width, height) * (x[1] - x[0], y[1] - y[0]) + (x[0], y[0])
        axes.add_collection(LineCollection(ends, colors=colour, **_LINE), autolim=False)


def draw_dots(
    axes: Axes, marked: np.ndarray, x: tuple[float, float], y: tuple[float, float], colour: str = "0.1"
) -> None:
    """Draw dots where a lattice is marked; as `draw_lines`."""
    if not np.any(marked):
        return
    width, height = _inches(axes)
    shares = dot_places(width, height) / (width, height)
    shares = shares[_at(marked, *shares.T)]
    if len(shares):
        places = x[0] + shares[:, 0] * (x[1] - x[0]), y[0] + shares[:, 1] * (y[1] - y[0])
        axes.plot(*places, **{**DOT, "color": colour})


def dot_places(width: float, height: float) -> np.ndarray:
    """Where the dots are in an area of so many inches, (k, 2): rows that are shifted by half a step in turn."""
    up = np.arange(0.5 * _DOTS, height, 0.5 * np.sqrt(3.0) * _DOTS)
    rows = [np.arange((0.5 if number % 2 else 0.0) * _DOTS + 0.25 * _DOTS, width, _DOTS) for number in range(up.size)]
    return np.concatenate(
        [np.column_stack([row, np.full(row.size, level)]) for row, level in zip(rows, up, strict=True)]
    )


def _inches(axes: Axes) -> np.ndarray:
    return axes.get_position().size * axes.figure.get_size_inches()


def _at(marked: np.ndarray, across: np.ndarray, up: np.ndarray) -> np.ndarray:
    rows, columns = marked.shape
    return marked[
        np.clip((up * rows).astype(int), 0, rows - 1), np.clip((across * columns).astype(int), 0, columns - 1)
    ]
