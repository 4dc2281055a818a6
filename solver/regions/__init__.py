"""Regions of equal label between boundary curves: their areas, thresholds and neighbours."""

from solver.regions.regions import RegionError, Regions, regions

__all__ = ["RegionError", "Regions", "regions"]
