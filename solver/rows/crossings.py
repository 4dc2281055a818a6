"""Where the curves of a row meet its grid values."""

import numpy as np

from solver.continuation.continuation import Curve
from solver.continuation.on_curve import Crossings, Known, curve_crossings
from solver.rows.span import RowSpan

__all__ = ["Crossings", "Known", "crossings"]


def crossings(span: RowSpan, curve: Curve, grid: np.ndarray, known: Known | None = None) -> Crossings:
    """`solver.continuation.on_curve.curve_crossings` of one curve of a row.

    Parameters
    ----------
    span : RowSpan
    curve : Curve
        One of its branches.
    grid : (X,) array
        Ascending values of the axis.
    known : Known, optional
        Solutions at these values.
    """
    return curve_crossings(span.problem, curve, grid, span.continuation, known)
