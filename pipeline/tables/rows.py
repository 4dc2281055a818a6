"""What one row of a stored plane shows at its two resonances, and reading all rows of a store block by block."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from pipeline.plan import Plan
from pipeline.store import COMPLETE
from pipeline.sweep import model_at
from pipeline.tables.peaks import Peak, resonance_peak
from pipeline.tables.pieces import Branches, Piece, multivalued_intervals, row_pieces
from solver import ImpactState, domain_label

__all__ = ["Raster", "Resonance", "RowAtResonance", "measure_row", "measure_rows", "resonances"]

_TOGETHER = (ImpactState.PERMANENT, ImpactState.MIRRORED_PERMANENT)


@dataclass(frozen=True)
class Resonance:
    """One of the two resonances: its name, linear natural frequency, and the part low <= omega < high it is given."""

    name: str
    natural: float
    low: float
    high: float

    def holds(self, omega):
        """Whether frequencies lie in its part of the axis."""
        return (self.low <= omega) & (omega < self.high)


@dataclass(frozen=True)
class Raster:
    """One row of a store's plane: arrays (X, solution) and (X,)."""

    amplitude: np.ndarray
    stable: np.ndarray
    impact: np.ndarray
    domain: np.ndarray
    open: np.ndarray

    @property
    def envelope(self) -> np.ndarray:
        """Largest stable amplitude, nan where nothing is stable, (X,)."""
        largest = np.max(np.where(self.stable == 1, self.amplitude, -np.inf), axis=1)
        return np.where(np.isfinite(largest), largest, np.nan)


@dataclass(frozen=True)
class RowAtResonance:
    """What one row shows at one resonance.

    Parameters
    ----------
    intervals : tuple of (float, float)
        Frequencies with more than one solution.
    peak : Peak or None
        None where no peak stands out.
    cells : int
        Columns of the region: from the first to the last one that belongs to the peak or to an interval.
    states : tuple of int
        Cells of the region with a stable solution in each `ImpactState`.
    labels : tuple of (str, int)
        n/I labels in the region and their cells.
    unstable, without_stable : int
        Cells of the region with an unstable solution, and without a stable one.
    anywhere : tuple of bool
        Whether a stable solution of the resonance's whole part of the axis is in each `ImpactState`.
    open : int
        Cells of that part where solutions above the amplitude ceiling are not excluded.
    """

    intervals: tuple[tuple[float, float], ...]
    peak: Peak | None
    cells: int
    states: tuple[int, ...]
    labels: tuple[tuple[str, int], ...]
    unstable: int
    without_stable: int
    anywhere: tuple[bool, ...]
    open: int

    @property
    def width(self) -> float:
        """Width of the widest interval, 0 without one."""
        return max((high - low for low, high in self.intervals), default=0.0)

    @property
    def linear(self) -> bool:
        """Whether no stable motion of the region ever parts the teeth."""
        return not any(count for state, count in enumerate(self.states) if state not in _TOGETHER)

    @property
    def contact_lost(self) -> bool:
        """Whether a stable motion of the resonance's part of the axis parts the teeth."""
        return any(met for state, met in enumerate(self.anywhere) if state not in _TOGETHER)

    @property
    def double_sided(self) -> bool:
        """Whether a stable motion of the resonance's part of the axis strikes both flanks."""
        return self.anywhere[ImpactState.DOUBLE_SIDED]


def resonances(plan: Plan) -> tuple[Resonance, Resonance]:
    """Lower (mesh-frequency) and upper (shaft-frequency) resonance; the axis is split at their geometric mean.

    The tables' parameters leave the linear system alone, so that one model stands for all rows.
    """
    lower, upper = model_at(plan, plan.parameter.low, plan.sweep.low).mesh_modes()
    split = float(np.sqrt(lower * upper))
    return (
        Resonance("mesh", lower, 0.0, split),
        Resonance("shaft", upper, split, np.inf),
    )


def measure_row(pieces: list[Piece], omega: np.ndarray, raster: Raster, resonance: Resonance) -> RowAtResonance:
    """Measure one row at one resonance; an interval belongs to the part of the axis in which its middle lies."""
    intervals = tuple(
        interval for interval in multivalued_intervals(pieces) if resonance.holds(sum(interval) / 2.0)
    )
    peak = resonance_peak(pieces, omega, raster.envelope, resonance.low, resonance.high)
    part = resonance.holds(omega)
    belongs = np.zeros(omega.size, dtype=bool)
    if peak:
        belongs[peak.start : peak.stop] = True
    for low, high in intervals:
        belongs |= part & (low <= omega) & (omega <= high)
    columns = np.flatnonzero(belongs)
    region = slice(columns[0], columns[-1] + 1) if columns.size else slice(0, 0)
    stable = raster.stable[region]
    labels = Counter(domain_label(int(code)) for code in raster.domain[region])
    return RowAtResonance(
        intervals, peak, len(stable),
        tuple(int(count) for count in np.sum(_in_state(raster, region), axis=0)), tuple(sorted(labels.items())),
        int(np.sum(np.any(stable == 0, axis=1))), int(np.sum(~np.any(stable == 1, axis=1))),
        tuple(bool(met) for met in np.any(_in_state(raster, part), axis=0)), int(np.sum(raster.open[part])),
    )  # fmt: skip


def _in_state(raster: Raster, columns) -> np.ndarray:
    """Whether some columns have a stable solution in each impact state, (columns, states)."""
    stable, impact = raster.stable[columns] == 1, raster.impact[columns]
    return np.stack([np.any(stable & (impact == state), axis=1) for state in ImpactState], axis=1)


def measure_rows(path: Path, plan: Plan) -> Iterator[tuple[RowAtResonance, RowAtResonance] | None]:
    """Measure every row of a store at both resonances, in order; None for a row that failed."""
    pair = resonances(plan)
    omega = plan.sweep.values
    # Blocks are the store's chunks: a plane larger than memory is read through once, piece by piece.
    with xr.open_zarr(path, chunks=None) as plane, xr.open_zarr(path, group="branches", chunks=None) as branches:
        for block in plan.blocks:
            rows = {plan.parameter.name: slice(block.start, block.stop)}
            status = plane["status"].isel(rows).values
            raster = {name: plane[name].isel(rows).values for name in Raster.__dataclass_fields__}
            points = {name: branches[name].isel(rows).values for name in Branches.__dataclass_fields__}
            counts = branches["n_points"].isel(rows).values
            for i, count in enumerate(counts):
                if status[i] != COMPLETE:
                    yield None
                    continue
                end_reason = points["end_reason"][i]
                curves = {name: value[i, :count] for name, value in points.items() if name != "end_reason"}
                pieces = row_pieces(Branches(**curves, end_reason=end_reason))
                here = Raster(**{name: value[i] for name, value in raster.items()})
                yield measure_row(pieces, omega, here, pair[0]), measure_row(pieces, omega, here, pair[1])
