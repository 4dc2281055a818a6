"""Boundaries of solution domains as curves: folds, grazings and bifurcations in the plane of two parameters."""

from solver.boundaries.curve import BoundaryCurve
from solver.boundaries.problem import BIFURCATIONS, FOLDS_AND_GRAZINGS, SPECTRAL
from solver.boundaries.special_points import SpecialPoint
from solver.boundaries.tracer import boundary_curves, row_events

__all__ = [
    "BIFURCATIONS",
    "FOLDS_AND_GRAZINGS",
    "SPECTRAL",
    "BoundaryCurve",
    "SpecialPoint",
    "boundary_curves",
    "row_events",
]
