"""Boundaries of solution domains as curves: folds and grazings in the plane of two parameters."""

from solver.boundaries.curve import BoundaryCurve, SpecialPoint
from solver.boundaries.trace import BoundaryError, boundary_curves, row_events

__all__ = ["BoundaryCurve", "BoundaryError", "SpecialPoint", "boundary_curves", "row_events"]
