"""The resonance peaks of a stored plane's rows, read block by block."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from pipeline.plan.numerics import model_at
from pipeline.plan.plan import Plan
from pipeline.plane.peaks import Peak, resonance_peak, solved
from pipeline.plane.resonances import resonances
from pipeline.plane.segments import pieces_of_row
from pipeline.store import COMPLETE
from solver import EndReason

__all__ = ["RowPeak", "row_peaks"]

_ARRAYS = ("mean", "amplitude", "stable", "impact", "branch", "event")


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


def row_peaks(path: Path, plan: Plan, rows: np.ndarray) -> dict[int, tuple[RowPeak, RowPeak]]:
    """Some rows at the mesh and at the shaft resonance; rows that are not complete are left out.

    Parameters
    ----------
    path : Path
    plan : Plan
        Of the store, over omega.
    rows : (k,) int array
        Ascending.
    """
    found = {}
    with xr.open_zarr(path, chunks=None) as plane, xr.open_zarr(path, group="branches", chunks=None) as branches:
        # Blocks are the store's chunks: a plane larger than memory is read through once, piece by piece.
        for block in plan.blocks:
            wanted = rows[(rows >= block.start) & (rows < block.stop)]
            if wanted.size == 0:
                continue
            here = {plan.parameter.name: slice(block.start, block.stop)}
            status, counts = plane["status"].isel(here).values, branches["n_points"].isel(here).values
            points = {name: branches[name].isel(here).values for name in _ARRAYS}
            points["position"] = branches[plan.sweep.name].isel(here).values
            ends = branches["end_reason"].isel(here).values
            for row in wanted:
                i = row - block.start
                if status[i] == COMPLETE:
                    curves = {name: array[i, : counts[i]] for name, array in points.items()}
                    found[int(row)] = _at_both(plan, float(plan.parameter.values[row]), curves, ends[i])
    return found


def _at_both(plan: Plan, value: float, points: dict[str, np.ndarray], ends: np.ndarray) -> tuple[RowPeak, RowPeak]:
    model = model_at(plan, value, plan.sweep.low)
    pieces = pieces_of_row(points, np.full(points["position"].size, model.b))
    branch, last = points["branch"], points["branch"].size - 1
    first = [np.searchsorted(branch, number) for number in range(int(branch.max(initial=-1)) + 1)]
    places = np.array([[start, stop] for start, stop in zip(first, [*(i - 1 for i in first[1:]), last], strict=True)])
    escapes = points["position"][places[ends[: len(places)] == EndReason.AMPLITUDE_CEILING]]

    def at(resonance) -> RowPeak:
        peak = resonance_peak(points, pieces, resonance.low, resonance.high)
        escaped = np.any((resonance.low <= escapes) & (escapes < resonance.high))
        return RowPeak(value, resonance.natural, peak and solved(model, peak), bool(escaped))

    mesh, shaft = map(at, resonances(plan, value))
    return mesh, shaft
