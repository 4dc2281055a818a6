"""Boundaries of a stored plane as curves: traced from the events of its rows, stored beside them, exported as CSV."""

from pipeline.analysis.boundaries.sheets import write_sheets
from pipeline.analysis.boundaries.tracing import Summary, layer_boundaries, stored_summary, summary_of, trace

__all__ = ["Summary", "layer_boundaries", "stored_summary", "summary_of", "trace", "write_sheets"]
