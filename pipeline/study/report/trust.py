"""How far first order can be trusted, from the stores: dynamic stability everywhere, integration in one plane."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.analysis.verification import read_verification, region_lines
from pipeline.analysis.verification.credibility import Credibility
from pipeline.plane.stored import read_stored
from pipeline.study.numerals import percent
from pipeline.study.report.document import Grid
from solver.stability import Instability

__all__ = ["DynamicShares", "dynamic_shares", "verified_grid"]


@dataclass(frozen=True)
class DynamicShares:
    """Shares of a plane's cells by the worst that dynamic stability says of a motion that the label counts."""

    stable: float
    contradictory: float
    undecided: float
    unstable: float


def dynamic_shares(path: Path) -> DynamicShares:
    """Read a store block by block."""
    counts = np.zeros(4)
    for part in read_stored(path).parts:
        unstable, contradictory = part.unstable, part.contradictory & ~part.unstable
        undecided = np.any((part.stable == 1) & (part.instability == Instability.UNDECIDED), axis=-1)
        undecided &= ~unstable & ~contradictory
        stable = ~unstable & ~contradictory & ~undecided
        counts += [np.sum((part.domain != 0) & cells) for cells in (stable, contradictory, undecided, unstable)]
    return DynamicShares(*(counts / max(counts.sum(), 1.0)).tolist())


def verified_grid(path: Path) -> Grid:
    """Per label of a verified plane, in how many cells the map is right; the last line for all of it."""
    domain, found = read_stored(path).domain, read_verification(path)
    lines = region_lines(domain, found)
    kinds = [kind for kind in Credibility if any(line.classes[kind] for line in lines)]
    rows = []
    for line in lines:
        share = f"{percent(line.share)} ({percent(line.low)} to {percent(line.high)})" if line.samples else "–"
        rows.append((line.label, str(line.cells), share, *(percent(line.classes[kind]) for kind in kinds)))
    headings = ("Label n/I", "Cells", "Right by integration", *(kind.words.capitalize() for kind in kinds))
    return Grid("Labels of the verified plane, shares of cells; the last line is for all of it.", headings, tuple(rows))
