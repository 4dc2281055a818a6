"""The resonance peak of a row and the frequencies around it that count as the resonance's region."""

from dataclasses import dataclass

import numpy as np

from pipeline.tables.pieces import Piece

__all__ = ["HALF_POWER", "REGION_LEVEL", "Peak", "resonance_peak"]

#: A peak counts where the largest stable amplitude falls below this share of it on both sides.
HALF_POWER = 0.5**0.5
#: The region reaches as far as the largest stable amplitude is at least this share of the peak.
REGION_LEVEL = 0.5

# A stable solution higher than the peak, inside its half-power band, makes it a shoulder of something else.
_SAME_PEAK = 1e-3


@dataclass(frozen=True)
class Peak:
    """Largest stable amplitude of a resonance: where, how high, and the columns start ... stop - 1 of its region."""

    omega: float
    amplitude: float
    start: int
    stop: int


def resonance_peak(
    pieces: list[Piece], omega: np.ndarray, envelope: np.ndarray, low: float, high: float
) -> Peak | None:
    """The highest peak between two frequencies that stands out, None where there is none.

    Parameters
    ----------
    pieces : list of Piece
    omega : (X,) array
        Frequencies of the row's grid.
    envelope : (X,) array
        Largest stable amplitude at each of them, nan where nothing is stable.
    low, high : float
        The part low <= omega < high of the axis that belongs to the resonance.
    """
    columns = np.flatnonzero((low <= omega) & (omega < high))
    if columns.size == 0:
        return None
    candidates = [peak for piece in pieces if piece.stable for peak in _crests(piece) if low <= peak[0] < high]
    for place, amplitude in sorted(candidates, key=lambda peak: -peak[1]):
        band = _run(omega, envelope, columns, place, HALF_POWER * amplitude)
        inside = envelope[slice(*band)]
        bounded = band[0] > columns[0] and band[1] <= columns[-1]
        if bounded and not np.any(inside > amplitude * (1.0 + _SAME_PEAK)):
            return Peak(place, amplitude, *_run(omega, envelope, columns, place, REGION_LEVEL * amplitude))
    return None


def _crests(piece: Piece) -> list[tuple[float, float]]:
    """Local maxima (omega, amplitude) of a piece: at a fold that ends it, or inside, between points by a parabola."""
    a = piece.amplitude
    crests = []
    for end, neighbour, fold in ((0, 1, piece.folds[0]), (-1, -2, piece.folds[1])):
        if fold and a[end] >= a[neighbour]:
            crests.append((float(piece.omega[end]), float(a[end])))
    inner = np.arange(1, a.size - 1)
    for i in inner[(a[inner] >= a[inner - 1]) & (a[inner] > a[inner + 1])]:
        crests.append(_vertex(*(values[i - 1 : i + 2] for values in (piece.arclength, piece.omega, a))))
    return crests


def _vertex(s: np.ndarray, omega: np.ndarray, amplitude: np.ndarray) -> tuple[float, float]:
    """Maximum of the parabola through three points of the arc, and the frequency there."""
    before, after = s[0] - s[1], s[2] - s[1]
    if before == 0.0 or after == 0.0:
        return float(omega[1]), float(amplitude[1])
    slope, bend = _parabola(before, after, amplitude)
    if bend >= 0.0:
        return float(omega[1]), float(amplitude[1])
    t = min(max(-slope / (2.0 * bend), before), after)
    slope_omega, bend_omega = _parabola(before, after, omega)
    return float(omega[1] + (slope_omega + bend_omega * t) * t), float(amplitude[1] + (slope + bend * t) * t)


def _parabola(before: float, after: float, values: np.ndarray) -> tuple[float, float]:
    """Slope and half the curvature at the middle one of three points."""
    left, right = (values[0] - values[1]) / before, (values[2] - values[1]) / after
    bend = (right - left) / (after - before)
    return float(right - bend * after), float(bend)


def _run(omega, envelope, columns, place: float, level: float) -> tuple[int, int]:
    """Columns start ... stop - 1 around a place in which the envelope reaches a level, without a gap."""
    after = int(np.clip(np.searchsorted(omega, place), columns[0], columns[-1]))
    around = [column for column in (after - 1, after) if columns[0] <= column <= columns[-1]]
    nearest = min(around, key=lambda column: abs(omega[column] - place))
    # Beside a fold the nearest column may lie where the peak's solution no longer exists: the other one has it.
    start = max(around, key=lambda column: (envelope[column] >= level, column == nearest))
    reached = envelope >= level
    if not reached[start]:
        return start, start + 1
    left = right = start
    while left > columns[0] and reached[left - 1]:
        left -= 1
    while right < columns[-1] and reached[right + 1]:
        right += 1
    return left, right + 1
