"""Resonance peaks of the stored rows."""

import numpy as np

from pipeline.plane.peaks import resonance_peak
from pipeline.plane.resonances import resonances_of
from pipeline.plane.stored import StoredPlane

__all__ = ["resonance_peaks"]


def resonance_peaks(plane: StoredPlane, rows: np.ndarray) -> np.ndarray:
    """The peak at each of the two resonances, where one stands out.

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
        for mode, resonance in enumerate(resonances_of(*plane.modes[row])):
            peak = resonance_peak(points, plane.pieces[row], resonance.low, resonance.high)
            if peak:
                peaks[number, mode] = peak.omega, peak.amplitude
    return peaks
