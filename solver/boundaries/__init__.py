"""Boundaries of solution domains as curves: folds and grazings in the plane of two parameters."""

from solver.boundaries.coverage import missed_events
from solver.boundaries.curve import BoundaryCurve, SpecialPoint
from solver.boundaries.trace import boundary_curves, row_events

__all__ = ["BoundaryCurve", "SpecialPoint", "boundary_curves", "missed_events", "row_events"]
