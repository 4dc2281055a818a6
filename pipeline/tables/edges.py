"""Where something appears or ends from row to row of a plane."""

from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["Edge", "band_edges", "edges", "nearest_edge"]


@dataclass(frozen=True)
class Edge:
    """Between two neighbouring rows something appears, or ends, with growing parameter.

    Parameters
    ----------
    appears : bool
    low, high : float
        Parameter values of the two rows.
    place : {"inside", "below", "above"}
        Where it lies, seen from a band.
    """

    appears: bool
    low: float
    high: float
    place: str = "inside"

    @property
    def value(self) -> float:
        """The middle."""
        return (self.low + self.high) / 2.0

    @property
    def resolution(self) -> float:
        """Half the distance of the two rows."""
        return (self.high - self.low) / 2.0


def edges(values: Sequence[float], flags: Sequence[bool | None]) -> tuple[Edge, ...]:
    """Every change of a flag from row to row; failed rows, where it is None, are passed over and widen the bracket."""
    known = [(value, flag) for value, flag in zip(values, flags, strict=True) if flag is not None]
    return tuple(
        Edge(after, float(low), float(high))
        for (low, before), (high, after) in zip(known[:-1], known[1:], strict=True)
        if before != after
    )


def band_edges(all_edges: Sequence[Edge], first: float, last: float) -> tuple[Edge, ...]:
    """The edges between rows of a band, or else the nearest one on either side of it."""
    inside = [edge for edge in all_edges if edge.low >= first and edge.high <= last]
    if inside:
        return tuple(inside)
    below = [edge for edge in all_edges if edge.low < first][-1:]
    above = [edge for edge in all_edges if edge.low >= first][:1]
    return tuple(
        Edge(edge.appears, edge.low, edge.high, place)
        for place, found in (("below", below), ("above", above))
        for edge in found
    )


def nearest_edge(found: Sequence[Edge], appears: bool, first: float, last: float) -> Edge | None:
    """Of the edges of one kind, the first within the band or else the one closest to it."""
    same = [edge for edge in found if edge.appears == appears]
    return min(same, key=lambda edge: (max(first - edge.value, edge.value - last, 0.0), edge.value), default=None)
