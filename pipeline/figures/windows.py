"""Stretches of the sweep axis that deserve an enlargement: where several stable motions coexist."""

import numpy as np

from pipeline.plane.division import stored_division
from pipeline.plane.labels import jumping
from pipeline.plane.segments import labels_at
from pipeline.plane.stored import StoredPlane
from solver import domain_label
from solver.regions.labelling import static_code

__all__ = ["coexistence_windows"]

_SAMPLES = 4000
#: In shares of the sweep axis: gaps that do not separate, margin, least and largest width of a window.
_GAP, _MARGIN, _NARROWEST, _WIDEST = 0.05, 0.012, 0.05, 0.3
_MOST = 2


def coexistence_windows(plane: StoredPlane) -> list[tuple[float, float]]:
    """The widest stretches of the sweep axis with two or more statically stable motions in some row, at most two,
    ascending.

    One that takes up much of the axis anyway is left out.
    """
    low, high = plane.plan.sweep.low, plane.plan.sweep.high
    borders = np.linspace(low, high, _SAMPLES + 1)
    several = np.flatnonzero(np.any(_coexisting(plane, 0.5 * (borders[1:] + borders[:-1])), axis=0))
    if several.size == 0:
        return []
    groups = np.split(several, np.flatnonzero(np.diff(several) > _GAP * _SAMPLES) + 1)
    widest = sorted(groups, key=lambda group: group[0] - group[-1])[:_MOST]
    return sorted(
        _with_margin(borders[group[0]], borders[group[-1] + 1], low, high)
        for group in widest
        if group[-1] - group[0] < _WIDEST * _SAMPLES
    )


def _coexisting(plane: StoredPlane, x: np.ndarray) -> np.ndarray:
    """Where several stable motions coexist in the rows of the plane, (P, k) bool."""
    division = stored_division(plane)
    if division is None:
        return labels_at(plane.segments, x)[1] >= 2
    codes = static_code(division.codes_at(x, plane.rows[plane.complete]))
    return np.isin(codes, [code for code in np.unique(codes) if jumping(domain_label(int(code)))])


def _with_margin(left: float, right: float, low: float, high: float) -> tuple[float, float]:
    span = high - low
    half = max(0.5 * (right - left) + _MARGIN * span, 0.5 * _NARROWEST * span)
    middle = 0.5 * (left + right)
    return max(low, float(middle - half)), min(high, float(middle + half))
