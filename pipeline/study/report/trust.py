"""How far first order can be trusted, from the stores: dynamic stability everywhere, integration in one plane."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from pipeline.analysis.verification import read_labels, read_verification, region_lines
from pipeline.analysis.verification.credibility import Credibility
from pipeline.plan.plan import Plan
from pipeline.study.numerals import percent
from pipeline.study.report.document import Grid
from solver.stability import Instability

__all__ = ["DynamicShares", "dynamic_shares", "verified_grid"]

_UNSTABLE = (Instability.FOLD, Instability.PERIOD_DOUBLING, Instability.NEIMARK_SACKER)


@dataclass(frozen=True)
class DynamicShares:
    """Shares of a plane's cells by the worst that dynamic stability says of a motion that the label counts."""

    stable: float
    contradictory: float
    undecided: float
    unstable: float


def dynamic_shares(path: Path, plan: Plan) -> DynamicShares:
    """Read a store block by block."""
    counts = np.zeros(4)
    with xr.open_zarr(path, chunks=None) as plane:
        for block in plan.blocks:
            rows = {plan.parameter.name: slice(block.start, block.stop)}
            counted = plane["stable"].isel(rows).values == 1
            kind = plane["instability"].isel(rows).values
            unstable = np.any(counted & np.isin(kind, _UNSTABLE), axis=-1)
            contradictory = np.any(counted & (kind == Instability.CONTRADICTORY), axis=-1) & ~unstable
            undecided = np.any(counted & (kind == Instability.UNDECIDED), axis=-1) & ~unstable & ~contradictory
            known = plane["domain"].isel(rows).values != 0
            stable = ~unstable & ~contradictory & ~undecided
            counts += [np.sum(known & cells) for cells in (stable, contradictory, undecided, unstable)]
    return DynamicShares(*(counts / max(counts.sum(), 1.0)).tolist())


def verified_grid(path: Path) -> Grid:
    """Per label of a verified plane, in how many cells the map is right; the last line for all of it."""
    (domain, _), found = read_labels(path), read_verification(path)
    lines = region_lines(domain, found)
    kinds = [kind for kind in Credibility if any(line.classes[kind] for line in lines)]
    rows = []
    for line in lines:
        share = f"{percent(line.share)} ({percent(line.low)} to {percent(line.high)})" if line.samples else "–"
        rows.append((line.label, str(line.cells), share, *(percent(line.classes[kind]) for kind in kinds)))
    headings = ("Label n/I", "Cells", "Right by integration", *(kind.words.capitalize() for kind in kinds))
    return Grid("Labels of the verified plane, shares of cells; the last line is for all of it.", headings, tuple(rows))
