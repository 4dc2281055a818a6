"""Rows of first order are ready once this is imported, and in every process that is forked from one that did so."""

import pipeline.run.rows  # noqa: F401
from pipeline.run.kernels import ready_for_rows

__all__ = []

ready_for_rows("describing_function")
