"""How far first order can be trusted, from the stores: dynamic stability everywhere, integration in one plane."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.analysis.attractors.queries import attractors_of
from pipeline.analysis.attractors.sheets import MEANINGS, label_lines, map_labels
from pipeline.analysis.attractors.wording import percents
from pipeline.plane.stored import read_stored
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
    """Per label of a plane with attractors, in how many cells the map is right; the last line for all of it."""
    found, plane = attractors_of(path), read_stored(path)
    lines = label_lines(map_labels(path, plane.plan, found), found.credibility.values)
    rows = [(line.label, str(line.cells), *percents(list(line.counts.values()))) for line in lines]
    headings = ("Label n/I", "Cells", *(kind.words.capitalize() for kind in MEANINGS))
    text = f"Labels of the plane, shares of cells; the last line is for all of it. {found.attrs['bound']}"
    return Grid(text, headings, tuple(rows))
