"""Boundaries of solution domains as curves: folds and grazings in the plane of two parameters."""

from solver.boundaries.coverage import missed_events
from solver.boundaries.curve import BoundaryCurve, SpecialPoint
from solver.boundaries.regions import RegionError, Regions, regions
from solver.boundaries.trace import boundary_curves, row_events

__all__ = [
    "BoundaryCurve",
    "RegionError",
    "Regions",
    "SpecialPoint",
    "boundary_curves",
    "missed_events",
    "regions",
    "row_events",
]
