"""A band of the row parameter at one resonance: what the regions and the rows show together."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.plane.labels import TRAITS, contact_lost, intervals, jumping, labels_with, share_of
from pipeline.plane.resonances import Resonance
from pipeline.study.tables.edges import Edge, edges
from pipeline.study.tables.lacking import Lacking
from pipeline.study.tables.rows import RowPeak
from solver import Event, ImpactState, label_parts
from solver.boundaries import SpecialPoint
from solver.regions import Regions
from solver.regions.bands import Band, Line, band, lines

__all__ = ["BandAtResonance", "band_at_resonance"]

#: A special point this close in the row parameter is where a jump begins.
_SAME = 1e-6


@dataclass(frozen=True)
class BandAtResonance:
    """What a band shows at one resonance.

    Parameters
    ----------
    resonance : Resonance
    region : Band
        The band's values of the row parameter and the share of every label in its region: of the area between them
        in the resonance's part of the axis, of a single value the length.
    lines : tuple of Line
        The first value, those of the plane's rows in the band, and the last value, ascending.
    jump_height : float
        Share of the band's height with a jump; of a single value 0 or 1.
    edges : dict of str to tuple of Edge
        For every trait, where it appears or ends in the whole plane.
    peaks : tuple of RowPeak
        The complete rows of the band.
    linear : tuple of bool
        Of every row with a peak, whether no stable motion of the resonance's part of the axis parts the teeth.
    lacking : Lacking
        The share of the region without a stable motion of one mesh period, dynamically or by integration.
    born : str
        What a jump that appears inside of the band begins with, in words; empty if none does.
    failed : int
        Rows of the band that failed.
    """

    resonance: Resonance
    region: Band
    lines: tuple[Line, ...]
    jump_height: float
    edges: dict[str, tuple[Edge, ...]]
    peaks: tuple[RowPeak, ...]
    linear: tuple[bool, ...]
    lacking: Lacking
    born: str
    failed: int

    @property
    def first(self) -> Line:
        """The row at the band's lower end."""
        return self.lines[0]

    @property
    def last(self) -> Line:
        """The row at the band's upper end."""
        return self.lines[-1]

    def jumps(self, line: Line) -> tuple[tuple[float, float], ...]:
        """Intervals of omega in which several motions are stable."""
        return intervals(line, jumping)

    @property
    def envelope(self) -> tuple[float, float]:
        """Lowest and highest frequency of all multivalued intervals of the lines, nan without one."""
        ends = [end for line in self.lines for interval in self.jumps(line) for end in interval]
        return (min(ends), max(ends)) if ends else (np.nan, np.nan)

    @property
    def intervals_per_line(self) -> int:
        """The largest number of multivalued intervals in one line."""
        return max(len(self.jumps(line)) for line in self.lines)

    @property
    def widths(self) -> tuple[float, ...]:
        """Widest multivalued interval of every line as a share of the natural frequency, 0 without one."""
        return tuple(
            max((high - low for low, high in self.jumps(line)), default=0.0) / self.resonance.natural
            for line in self.lines
        )

    @property
    def with_peak(self) -> tuple[RowPeak, ...]:
        """Rows in which a resonance peak stands out."""
        return tuple(row for row in self.peaks if row.peak)

    def state_share(self, state: ImpactState) -> float:
        """Share of the region in which a stable motion has an impact state."""
        return share_of(self.region.shares, lambda label: state in label_parts(label)[1])

    @property
    def several(self) -> float:
        """Share of the region in which several motions are stable."""
        return share_of(self.region.shares, jumping)


def band_at_resonance(
    regions: Regions,
    resonance: Resonance,
    low: float,
    high: float,
    peaks: Sequence[RowPeak],
    lacking: Lacking,
    failed: int,
    sign: str,
) -> BandAtResonance:
    """Measure a band.

    Parameters
    ----------
    regions : Regions
        Of the resonance's part of the axis and the whole range of the row parameter.
    resonance : Resonance
    low, high : float
        The band, within the plane; equal for a single value.
    peaks : sequence of RowPeak
        The complete rows of the band, ascending; of a single value the nearest row.
    lacking : Lacking
        Of the band.
    failed : int
        How many of the band's rows are not complete.
    sign : str
        Of the row parameter.
    """
    at_rows = lines(regions, [row.value for row in peaks])
    found = lines(regions, [low] if low == high else [low, high])
    found[1:1] = [line for line in at_rows if low < line.value < high]
    where = {name: regions.ranges(labels_with(regions.labels, trait)) for name, trait in TRAITS.items()}
    if low == high:
        height = float(any(map(jumping, found[0].labels)))
    else:
        height = sum(max(min(stop, high) - max(start, low), 0.0) for start, stop, _ in where["jump"]) / (high - low)
    found_edges = {name: edges(ranges, *regions.plane.p_range) for name, ranges in where.items()}
    return BandAtResonance(
        resonance,
        band(regions, low, high),
        tuple(found),
        height,
        found_edges,
        tuple(peaks),
        tuple(not any(map(contact_lost, line.labels)) for row, line in zip(peaks, at_rows, strict=True) if row.peak),
        lacking,
        _born(regions, [edge.value for edge in found_edges["jump"] if edge.appears and low < edge.value < high], sign),
        failed,
    )


def _born(regions: Regions, values: Sequence[float], sign: str) -> str:
    """What the first of some jumps begins with, by the special points of the fold curves; empty if there is none."""
    names = {SpecialPoint.ISOLA: "isola born", SpecialPoint.CUSP: "jump begins in a cusp"}
    for value in values:
        for curve in regions.curves:
            if curve.kind is Event.FOLD:
                special = curve.special[np.abs(curve.points[:, 4] - value) < _SAME]
                for point in map(SpecialPoint, special[special > 0].tolist()):
                    if point in names:
                        return f"{names[point]} at {sign} = {value:.3g}"
    return ""
