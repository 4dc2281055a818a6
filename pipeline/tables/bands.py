"""A band of rows at one resonance: what the rows show together."""

from collections import Counter
from dataclasses import dataclass

import numpy as np

from pipeline.tables.edges import Edge, edges
from pipeline.tables.rows import Resonance, RowAtResonance
from solver import ImpactState

__all__ = ["BandAtResonance", "band_at_resonance"]


@dataclass(frozen=True)
class BandAtResonance:
    """All complete rows of a band at one resonance, at least one.

    Parameters
    ----------
    resonance : Resonance
    values : tuple of float
        Parameter values of the rows, ascending.
    rows : tuple of RowAtResonance
    failed : int
        Rows of the band that failed and are not among `rows`.
    jump_edges, contact_loss_edges, double_sided_edges : tuple of Edge
        Where jumps, loss of contact and double-sided impact appear or end, in the whole plane.
    """

    resonance: Resonance
    values: tuple[float, ...]
    rows: tuple[RowAtResonance, ...]
    failed: int
    jump_edges: tuple[Edge, ...]
    contact_loss_edges: tuple[Edge, ...]
    double_sided_edges: tuple[Edge, ...]

    @property
    def envelope(self) -> tuple[float, float]:
        """Lowest and highest frequency of all multivalued intervals, nan without one."""
        ends = [end for row in self.rows for interval in row.intervals for end in interval]
        return (min(ends), max(ends)) if ends else (np.nan, np.nan)

    @property
    def jump_rows(self) -> int:
        """Rows with a multivalued interval."""
        return sum(bool(row.intervals) for row in self.rows)

    @property
    def intervals_per_row(self) -> int:
        """The largest number of multivalued intervals in one row."""
        return max(len(row.intervals) for row in self.rows)

    @property
    def widths(self) -> tuple[float, ...]:
        """Widest interval of every row as a share of the natural frequency, 0 without one."""
        return tuple(row.width / self.resonance.natural for row in self.rows)

    @property
    def peak_rows(self) -> tuple[RowAtResonance, ...]:
        """Rows in which a resonance peak stands out."""
        return tuple(row for row in self.rows if row.peak)

    @property
    def shifts(self) -> tuple[float, ...]:
        """Peak against natural frequency, as a share of it, of the rows that have a peak."""
        return tuple(row.peak.omega / self.resonance.natural - 1.0 for row in self.peak_rows)

    @property
    def cells(self) -> int:
        """Cells of the resonance region, all rows together."""
        return sum(row.cells for row in self.rows)

    def share(self, count: int) -> float:
        """A number of cells as a share of the region, nan without a region."""
        return count / self.cells if self.cells else np.nan

    @property
    def states(self) -> tuple[int, ...]:
        """Cells with a stable solution in each `ImpactState`."""
        return tuple(sum(row.states[state] for row in self.rows) for state in ImpactState)

    @property
    def labels(self) -> tuple[tuple[str, int], ...]:
        """n/I labels and their cells, the most frequent first."""
        counts = Counter()
        for row in self.rows:
            counts.update(dict(row.labels))
        return tuple(sorted(counts.items(), key=lambda item: (-item[1], item[0])))

    @property
    def unstable(self) -> int:
        """Cells of the region with an unstable solution."""
        return sum(row.unstable for row in self.rows)

    @property
    def without_stable(self) -> int:
        """Cells of the region without a stable solution."""
        return sum(row.without_stable for row in self.rows)

    @property
    def open(self) -> int:
        """Cells where solutions above the amplitude ceiling are not excluded."""
        return sum(row.open for row in self.rows)


def band_at_resonance(
    resonance: Resonance,
    values: np.ndarray,
    rows: list[RowAtResonance | None],
    band: np.ndarray,
) -> BandAtResonance:
    """Gather the rows of a band; edges are looked for in the whole plane.

    Parameters
    ----------
    resonance : Resonance
    values : (P,) array
        Parameter values of all rows of the plane.
    rows : list of RowAtResonance or None
        All rows of the plane; None where a row failed.
    band : array of int
        The band's rows, at least one of them complete.
    """
    complete = [int(row) for row in band if rows[row] is not None]

    def found(flag) -> tuple[Edge, ...]:
        return edges(values, [None if row is None else flag(row) for row in rows])

    return BandAtResonance(
        resonance, tuple(float(values[row]) for row in complete), tuple(rows[row] for row in complete),
        len(band) - len(complete), found(lambda row: bool(row.intervals)), found(lambda row: row.contact_lost),
        found(lambda row: row.double_sided),
    )  # fmt: skip
