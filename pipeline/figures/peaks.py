"""Resonance peaks of the stored rows."""

import numpy as np

from pipeline.figures.stored import StoredPlane

__all__ = ["resonance_peaks"]


def resonance_peaks(plane: StoredPlane, rows: np.ndarray) -> np.ndarray:
    """Where the stable amplitude is largest near each of the two natural frequencies.

    The geometric mean of the two frequencies separates their neighbourhoods. A largest value at the border of a
    neighbourhood or at the end of a branch, be it the plane's border or the amplitude ceiling, is no peak.

    Parameters
    ----------
    plane : StoredPlane
        Its rows run over omega.
    rows : (k,) int array
        Of the plane.

    Returns
    -------
    (k, 2, 2) array
        Frequency and amplitude of the lower and of the upper peak; nan where there is none.
    """
    peaks = np.full((rows.size, 2, 2), np.nan)
    for number, row in enumerate(rows):
        points = plane.row_points(row)
        position, amplitude, branch = points["position"], points["amplitude"], points["branch"]
        stable = np.zeros(position.size, dtype=bool)
        for piece in plane.pieces[row]:
            # With the fold at its end: the event point itself counts as neither stable nor unstable.
            stable[piece.slice] |= piece.stable
        ends = np.concatenate([np.flatnonzero(np.diff(branch, **{side: -1})) for side in ("prepend", "append")])
        above = position > np.sqrt(np.prod(plane.modes[row]))
        for mode, here in enumerate((~above & stable, above & stable)):
            inside = np.flatnonzero(here)
            if inside.size == 0:
                continue
            top = inside[np.argmax(amplitude[inside])]
            if top not in ends and position[inside].min() < position[top] < position[inside].max():
                around = slice(top - 1, top + 2)
                peaks[number, mode] = _summit(position[around], amplitude[around])
    return peaks


def _summit(position: np.ndarray, amplitude: np.ndarray) -> tuple[float, float]:
    """Vertex of the parabola through the largest of three points in a row and its neighbours; at a fold, that point."""
    (x0, x1, x2), (y0, y1, y2) = position, amplitude
    if (x1 - x0) * (x2 - x1) <= 0.0 or not y0 < y1 > y2:
        return x1, y1
    left, right = (y1 - y0) / (x1 - x0), (y2 - y1) / (x2 - x1)
    bend = (right - left) / (x2 - x0)
    slope = (left * (x2 - x1) + right * (x1 - x0)) / (x2 - x0)
    return x1 - 0.5 * slope / bend, y1 - 0.25 * slope**2 / bend
