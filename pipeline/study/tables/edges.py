"""Where something appears or ends in the row parameter, from the boundary curves."""

from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["Edge", "band_edges", "edges", "nearest_edge"]


@dataclass(frozen=True)
class Edge:
    """With growing parameter something appears, or ends.

    Parameters
    ----------
    appears : bool
    value : float
        Of the row parameter.
    place : {"inside", "below", "above"}
        Where it lies, seen from a band.
    """

    appears: bool
    value: float
    place: str = "inside"


def edges(ranges: Sequence[tuple[float, float, float]], low: float, high: float) -> tuple[Edge, ...]:
    """Ends of unbroken ranges (appears, ends, share), ascending; at the borders of a plane nothing appears or ends."""
    return tuple(
        Edge(appears, value)
        for start, stop, _ in ranges
        for appears, value in ((True, start), (False, stop))
        if low < value < high
    )


def band_edges(all_edges: Sequence[Edge], first: float, last: float) -> tuple[Edge, ...]:
    """The edges in a band, or else the nearest one on either side of it."""
    inside = [edge for edge in all_edges if first <= edge.value <= last]
    if inside:
        return tuple(inside)
    below = [edge for edge in all_edges if edge.value < first][-1:]
    above = [edge for edge in all_edges if edge.value > last][:1]
    return tuple(
        Edge(edge.appears, edge.value, place) for place, found in (("below", below), ("above", above)) for edge in found
    )


def nearest_edge(found: Sequence[Edge], appears: bool, first: float, last: float) -> Edge | None:
    """Of the edges of one kind, the first within the band or else the one closest to it."""
    same = [edge for edge in found if edge.appears == appears]
    return min(same, key=lambda edge: (max(first - edge.value, edge.value - last, 0.0), edge.value), default=None)
