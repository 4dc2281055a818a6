"""Resonance peaks of a row, from its branches alone: no grid enters."""

from dataclasses import dataclass

import numpy as np

from pipeline.plane.segments import BranchSegment
from solver import Event, Model, enumerate_row

__all__ = ["HALF_POWER", "Peak", "resonance_peak", "solved"]

#: A peak counts where the largest stable amplitude falls below this share of it on both sides.
HALF_POWER = 0.5**0.5

# A stable solution higher than the peak, inside its half-power band, makes it a shoulder of something else.
_SAME_PEAK = 1e-3
# Distances of the three frequencies through which a peak's parabola goes: the last one leaves an error of about 1e-8.
_STEPS = (1e-3, 1e-4, 3e-5)
_MOST_MOVES = 50
# A solution whose amplitude differs more than this share from the peak's is another one.
_SAME_SOLUTION = 1e-2


@dataclass(frozen=True)
class Peak:
    """Largest stable amplitude of a resonance: where, how high, and whether it stands on a fold."""

    omega: float
    amplitude: float
    fold: bool


def resonance_peak(
    points: dict[str, np.ndarray], segments: list[BranchSegment], low: float, high: float
) -> Peak | None:
    """The highest peak between two frequencies that stands out, None where there is none.

    Parameters
    ----------
    points : dict
        Name -> (point,) array of one row's branches: position (the frequency), amplitude, branch, event.
    segments : list of BranchSegment
        Of the same row.
    low, high : float
        The part low <= omega < high of the axis that belongs to the resonance.
    """
    omega, envelope = _envelope(points, segments)
    part = np.flatnonzero((low <= omega) & (omega < high))
    if part.size == 0:
        return None
    candidates = [peak for peak in _crests(points, segments) if low <= peak.omega < high]
    for peak in sorted(candidates, key=lambda peak: -peak.amplitude):
        first, last = _run(omega, envelope, part, peak.omega, HALF_POWER * peak.amplitude)
        inside = envelope[first : last + 1]
        if first > part[0] and last < part[-1] and not np.any(inside > peak.amplitude * (1.0 + _SAME_PEAK)):
            return peak
    return None


def solved(model: Model, peak: Peak) -> Peak:
    """A peak solved for: the vertex of ever narrower parabolas through enumerated solutions, in place of branch points.

    A peak on a fold is one of the branches' events and exact already.
    """
    if peak.fold:
        return peak
    omega, amplitude = peak.omega, peak.amplitude
    for step in _STEPS:
        for _ in range(_MOST_MOVES):
            found = enumerate_row(model, "omega", omega + step * np.array([-1.0, 0.0, 1.0]))
            distance = np.where(found.stable == 1, np.abs(found.amplitude - amplitude), np.inf)
            nearest = np.argmin(distance, axis=1)
            if np.any(distance[np.arange(3), nearest] > _SAME_SOLUTION * amplitude):
                # A fold is closer than this step.
                break
            left, middle, right = found.amplitude[np.arange(3), nearest]
            bend = left - 2.0 * middle + right
            shift = 0.5 * (left - right) / bend if bend < 0.0 else np.copysign(1.0, right - left)
            shift = float(np.clip(shift, -1.0, 1.0))
            omega, amplitude = omega + shift * step, float(middle + 0.5 * (right - left + bend * shift) * shift)
            if abs(shift) < 0.5:
                break
    return Peak(float(omega), amplitude, False)


def _envelope(points: dict[str, np.ndarray], segments: list[BranchSegment]) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies of all branch points, ascending, and the largest stable amplitude there, nan where nothing is."""
    omega = np.unique(points["position"])
    envelope = np.full(omega.size, np.nan)
    for segment in segments:
        if not segment.stable:
            continue
        place, height = points["position"][segment.slice], points["amplitude"][segment.slice]
        order = np.argsort(place)
        here = slice(*np.searchsorted(omega, [place[order[0]], place[order[-1]]], side="left") + np.array([0, 1]))
        envelope[here] = np.fmax(envelope[here], np.interp(omega[here], place[order], height[order]))
    return omega, envelope


def _crests(points: dict[str, np.ndarray], segments: list[BranchSegment]) -> list[Peak]:
    """Local maxima of the stable amplitude along the branches: at folds, and between points by a parabola."""
    position, amplitude, branch = points["position"], points["amplitude"], points["branch"]
    stable = np.zeros(position.size, dtype=bool)
    for segment in segments:
        # With the fold at its end: the event point itself counts as neither stable nor unstable.
        stable[segment.slice] |= segment.stable
    before, after = np.arange(-1, position.size - 1), np.arange(1, position.size + 1)
    for first, last in zip(*(np.flatnonzero(np.diff(branch, **{s: -1})) for s in ("prepend", "append")), strict=True):
        closed = last > first + 2 and (position[first], amplitude[first]) == (position[last], amplitude[last])
        # A closed curve is not cut by where it happened to be started.
        before[first], after[last] = (last - 1, first + 1) if closed else (-1, -1)
    inner = np.flatnonzero(stable & (before >= 0) & (after >= 0))
    left, right, fold = before[inner], after[inner], points["event"][inner] == Event.FOLD
    along = amplitude[inner] >= amplitude[np.where(stable[left], left, right)]
    over = (amplitude[inner] >= amplitude[left]) & (amplitude[inner] > amplitude[right]) & stable[left] & stable[right]
    crests = []
    for i in np.flatnonzero(np.where(fold, along, over)):
        three = [left[i], inner[i], right[i]]
        place, height = (position[inner[i]], amplitude[inner[i]])
        if not fold[i]:
            place, height = _vertex(position[three], amplitude[three])
        crests.append(Peak(float(place), float(height), bool(fold[i])))
    return crests


def _vertex(x: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """Vertex of the parabola through three points in a row, the middle one the highest."""
    left, right = (y[1] - y[0]) / (x[1] - x[0]), (y[2] - y[1]) / (x[2] - x[1])
    bend = (right - left) / (x[2] - x[0])
    slope = (left * (x[2] - x[1]) + right * (x[1] - x[0])) / (x[2] - x[0])
    if bend >= 0.0:
        return float(x[1]), float(y[1])
    return float(x[1] - 0.5 * slope / bend), float(y[1] - 0.25 * slope**2 / bend)


def _run(omega, envelope, part, place: float, level: float) -> tuple[int, int]:
    """First and last point around a place up to which the envelope reaches a level, without a gap."""
    after = int(np.clip(np.searchsorted(omega, place), part[0], part[-1]))
    before = max(after - 1, part[0])
    start = after if envelope[after] >= level else before
    reached = np.append(envelope >= level, False)
    first = last = start
    while first > part[0] and reached[first - 1]:
        first -= 1
    while last < part[-1] and reached[last + 1]:
        last += 1
    return first, last
