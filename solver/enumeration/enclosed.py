"""The condensed first-order balance at one point as intervals: what enumeration reads, whatever system it is of.

Rows (low, high) of an array (SLOTS, 2). First D, A, P_1, P_2, F and e of `solver.harmonic.condensed`, real part and
imaginary part of each; then c and the mean load; the half gap and what lambda_m is counted from; whether D and A are
real and a common factor is left out (`solver.enumeration.reduction`); and the law of `solver.enumeration.contact_law`:
one row with kappa and the bound of its error, one with the stiffness of the far flank, twice. Last, whether all of this
is of the motion -lambda: the back flank is the stiffer one.

With gaps front and back, lambda - (front - back)/2 feels a symmetric dead zone of half width (front + back)/2, and of a
contact with one flank lambda - front feels none: the mean load is less by D_0 times that.
"""

from solver.enumeration.contact_law import LAW
from solver.enumeration.interval import COMPLEX, INTERVAL
from solver.kernels import types
from solver.kernels.compile import MATRIX, kernel

__all__ = [
    "FACTORED",
    "HALF_GAP",
    "LAW_ROW",
    "MEAN_GAIN",
    "MEAN_LOAD",
    "MIRRORED",
    "SHIFT",
    "SLOTS",
    "complex_of",
    "interval_of",
    "law_of",
    "put",
    "put_complex",
]

MEAN_GAIN, MEAN_LOAD, HALF_GAP, SHIFT, FACTORED, LAW_ROW = range(12, 18)
MIRRORED, SLOTS = 19, 20

_I = types.int64


@kernel(INTERVAL(MATRIX, _I), inline=True)
def interval_of(rows, row):
    """A row of an array of intervals."""
    return rows[row, 0], rows[row, 1]


@kernel(COMPLEX(MATRIX, _I), inline=True)
def complex_of(rows, row):
    """Two rows of an array of intervals, real and imaginary part."""
    return interval_of(rows, row), interval_of(rows, row + 1)


@kernel(types.void(MATRIX, _I, INTERVAL), inline=True)
def put(rows, row, value):
    """Write a row of an array of intervals."""
    rows[row, 0], rows[row, 1] = value[0], value[1]


@kernel(types.void(MATRIX, _I, COMPLEX), inline=True)
def put_complex(rows, row, value):
    """Write real and imaginary part as two rows."""
    put(rows, row, value[0])
    put(rows, row + 1, value[1])


@kernel(LAW(MATRIX, _I), inline=True)
def law_of(rows, row):
    """The contact law in two rows from `row` on."""
    return rows[row, 0], rows[row, 1], rows[row + 1, 0]
