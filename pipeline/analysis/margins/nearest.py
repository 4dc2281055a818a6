"""The nearest changes of label along both axes, of any point of a plane."""

from pipeline.analysis.margins.answer import line_through
from pipeline.analysis.margins.curves import P, X, boundaries_of
from pipeline.analysis.margins.distances import Margin, margins_of_axis
from pipeline.analysis.margins.options import Design
from pipeline.plane.stored import StoredPlane

__all__ = ["nearest_margins"]


def nearest_margins(plane: StoredPlane, x: float, p: float) -> tuple[Margin, ...]:
    """Changes of label met from a point along either axis and in either direction, the nearest first.

    Parameters
    ----------
    plane : StoredPlane
        With boundaries.
    x, p : float
    """
    plan, design = plane.plan, Design(x, p, x, x)
    arcs = boundaries_of(plane.boundaries.curves)
    row, column = (line_through(arcs, plan, design, axis) for axis in (P, X))
    found = [margin for margin in margins_of_axis(row, column, plan, design) if margin.place is not None]
    widths = {axis.name: axis.high - axis.low for axis in (plan.sweep, plan.parameter)}
    return tuple(sorted(found, key=lambda margin: margin.distance / widths[margin.name]))
