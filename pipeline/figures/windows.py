"""Stretches of the sweep axis that deserve an enlargement: where several stable motions coexist."""

import numpy as np

from pipeline.plane.segments import BranchSegment, labels_at

__all__ = ["coexistence_windows"]

_SAMPLES = 4000
#: In shares of the sweep axis: gaps that do not separate, margin, least and largest width of a window.
_GAP, _MARGIN, _NARROWEST, _WIDEST = 0.05, 0.012, 0.05, 0.3
_MOST = 2


def coexistence_windows(segments: list[list[BranchSegment]], low: float, high: float) -> list[tuple[float, float]]:
    """The widest stretches of `low` ... `high` with two or more stable solutions in some row, at most two, ascending.

    One that takes up much of the axis anyway is left out.
    """
    borders = np.linspace(low, high, _SAMPLES + 1)
    _, n = labels_at(segments, 0.5 * (borders[1:] + borders[:-1]))
    several = np.flatnonzero(np.any(n >= 2, axis=0))
    if several.size == 0:
        return []
    groups = np.split(several, np.flatnonzero(np.diff(several) > _GAP * _SAMPLES) + 1)
    widest = sorted(groups, key=lambda group: group[0] - group[-1])[:_MOST]
    return sorted(
        _with_margin(borders[group[0]], borders[group[-1] + 1], low, high)
        for group in widest
        if group[-1] - group[0] < _WIDEST * _SAMPLES
    )


def _with_margin(left: float, right: float, low: float, high: float) -> tuple[float, float]:
    span = high - low
    half = max(0.5 * (right - left) + _MARGIN * span, 0.5 * _NARROWEST * span)
    middle = 0.5 * (left + right)
    return max(low, float(middle - half)), min(high, float(middle + half))
