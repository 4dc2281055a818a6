"""Resonance peaks of rows."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipeline.plane.peaks import resonance_peak
from pipeline.plane.resonances import resonances_of
from pipeline.plane.row_curves import RowCurves

__all__ = ["resonance_peaks"]


def resonance_peaks(rows: Sequence[RowCurves], dynamic: bool = False) -> np.ndarray:
    """The peak at each of the two resonances, where one stands out.

    Parameters
    ----------
    rows : sequence of RowCurves
        Over omega.
    dynamic : bool
        Whether only dynamically stable motions count, instead of statically stable ones.

    Returns
    -------
    (k, 2, 2) array
        Frequency and amplitude of the lower and of the upper peak; nan where there is none.
    """
    peaks = np.full((len(rows), 2, 2), np.nan)
    for number, row in enumerate(rows):
        segments = row.segments
        if dynamic:
            segments = [
                replace(segment, stable=bool(lasts)) for segment, lasts in zip(segments, row.lasting, strict=True)
            ]
        if not segments:
            continue
        for mode, resonance in enumerate(resonances_of(*row.modes)):
            peak = resonance_peak(row.points, segments, resonance.low, resonance.high)
            if peak:
                peaks[number, mode] = peak.omega, peak.amplitude
    return peaks
