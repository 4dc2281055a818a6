"""Where no motion of one mesh period is stable: by integration where a plane has attractors, else dynamically."""

from dataclasses import dataclass

import numpy as np

from pipeline.analysis.margins.integration import cells_in, integrated
from pipeline.errors import StoreError
from pipeline.plan.plan import Block
from pipeline.plane.stability import region_stability, together
from pipeline.plane.stored import StoredPlane
from pipeline.study.numerals import percent

__all__ = ["Lacking", "lacking_in"]

#: Of the plane's height: a single value of the row parameter is looked at as a band so high.
_LINE = 1e-6


@dataclass(frozen=True)
class Lacking:
    """The share of a region without a stable motion of one mesh period.

    Parameters
    ----------
    share : float
        Nan where nothing is known.
    source : str
        "integration", or "dynamic stability" at the order of the balance.
    """

    share: float
    source: str

    @property
    def text(self) -> str:
        """For a cell of a table."""
        return f"no stable motion of one period in {percent(self.share)}" if self.share else "stable motions everywhere"


def lacking_in(plane: StoredPlane, x: tuple[float, float], p: tuple[float, float]) -> Lacking:
    """The share of a rectangle; of a single value of the row parameter, of its row.

    By integration in the cells, where all of them were integrated; else dynamically from the boundary curves, or where
    none are stored in the cells.
    """
    found = integrated(plane.path, plane.plan, x, p)
    if found is not None and 0 < found.cells == found.looked_at:
        without = sum(cells for motions, cells in found.motions.items() if "1T/" not in motions)
        return Lacking(without / found.cells, "integration")
    if plane.boundaries is not None:
        axis = plane.plan.parameter
        line = _LINE * (axis.high - axis.low)
        rows = p if p[0] < p[1] else (max(p[0] - line, axis.low), min(p[1] + line, axis.high))
        try:
            return Lacking(together(region_stability(plane, x, rows).values()).none_stable, "dynamic stability")
        except StoreError:
            # Boundaries that do not divide the plane.
            pass
    rows, columns = cells_in(plane.plan.parameter, *p), cells_in(plane.plan.sweep, *x)
    if not (rows.size and columns.size):
        return Lacking(np.nan, "no row of the plane")
    part = StoredPlane(plane.path, plane.plan, block=Block(int(rows[0]), int(rows[-1]) + 1), dynamic=True)
    known = (part.domain != 0)[:, columns]
    without = known & (part.n_stable == 0)[:, columns]
    return Lacking(float(without.sum() / max(known.sum(), 1)), "dynamic stability")
