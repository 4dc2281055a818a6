"""The resonance peaks of a stored plane's rows, read block by block."""

from dataclasses import dataclass

import numpy as np

from pipeline.plan.numerics import model_at
from pipeline.plane.peaks import Peak, resonance_peak, solved
from pipeline.plane.resonances import resonances
from pipeline.plane.stored import StoredPlane
from solver import EndReason

__all__ = ["RowPeak", "row_peaks"]


@dataclass(frozen=True)
class RowPeak:
    """One complete row at one resonance.

    Parameters
    ----------
    value : float
        Of the row parameter.
    natural : float
        Linear natural frequency of the row.
    peak : Peak or None
        None where no peak stands out.
    open : bool
        Whether a branch leaves through the amplitude ceiling in the resonance's part of the axis.
    """

    value: float
    natural: float
    peak: Peak | None
    open: bool

    @property
    def shift(self) -> float:
        """Peak against natural frequency, as a share of it."""
        return self.peak.omega / self.natural - 1.0


def row_peaks(plane: StoredPlane, rows: np.ndarray) -> dict[int, tuple[RowPeak, RowPeak]]:
    """Some rows at the mesh and at the shaft resonance; rows that are not complete are left out.

    Parameters
    ----------
    plane : StoredPlane
        Over omega.
    rows : (k,) int array
        Ascending.
    """
    found = {}
    for part in plane.parts:
        for row in rows[(rows >= part.block.start) & (rows < part.block.stop)]:
            if part.complete[row - part.block.start]:
                found[int(row)] = _at_both(part, row - part.block.start)
    return found


def _at_both(part: StoredPlane, row: int) -> tuple[RowPeak, RowPeak]:
    value, points, segments = float(part.rows[row]), part.row_points(row), part.row_segments(row)
    model = model_at(part.plan, value, part.plan.sweep.low)
    branch, last = points["branch"], points["branch"].size - 1
    first = [np.searchsorted(branch, number) for number in range(int(branch.max(initial=-1)) + 1)]
    places = np.array([[start, stop] for start, stop in zip(first, [*(i - 1 for i in first[1:]), last], strict=True)])
    escapes = points["position"][places[part.end_reason[row][: len(places)] == EndReason.AMPLITUDE_CEILING]]

    def at(resonance) -> RowPeak:
        peak = resonance_peak(points, segments, resonance.low, resonance.high)
        escaped = np.any((resonance.low <= escapes) & (escapes < resonance.high))
        return RowPeak(value, resonance.natural, peak and solved(model, peak), bool(escaped))

    mesh, shaft = map(at, resonances(part.plan, value))
    return mesh, shaft
