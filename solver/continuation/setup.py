"""What compiled kernels are told about a curve: its problem and corrector, the bounds of steps, its points.

They are named tuples. A kernel that takes `SETUP`, `LIMITS` or `STRAND` takes them as one argument each, from Python
and from other kernels alike.
"""

from collections import namedtuple

from solver.kernels import types
from solver.kernels.compile import ARRAY, CORRECTOR, FLAGS, MATRIX, RESIDUAL_AND_JACOBIAN, TEST_FUNCTIONS, kernel

__all__ = ["CONTACTS", "CONTACT_ROW", "LIMITS", "SETUP", "STRAND", "Limits", "Setup", "Strand", "no_contacts"]

_I, _F = types.int64, types.float64

#: contacts(parameters, parameter_slope, y, rows) -> count: every local extremum of lambda against every flank that it
#: may touch, one a row: `CONTACT_ROW` numbers, then the gradient of the margin, (n + 1,).
CONTACTS = types.FunctionType(_I(ARRAY, ARRAY, ARRAY, MATRIX))

#: Slots of such a row: phase angle of the extremum, flank (1 front, -1 back), sense (1 maximum, -1 minimum) and margin,
#: lambda there less the flank's. A maximum touches where its margin is positive, a minimum where it is negative.
ANGLE, FLANK, SENSE, MARGIN, CONTACT_ROW = range(5)


@kernel(_I(ARRAY, ARRAY, ARRAY, MATRIX))
def no_contacts(parameters, parameter_slope, y, rows):
    """The contacts of a problem whose force is smooth, or soft enough to be stepped over: none.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Parameters at p = 0 and what p adds to them.
    y : (n + 1,) array
        (u, p).
    rows : (k, CONTACT_ROW + n + 1) array
        Not touched.
    """
    return 0


#: A curve and how points of it are corrected. unknowns = n, test_count = m; work has `workspace_rows(n)` rows of n + 1,
#: gradient is (m, n + 1).
Setup = namedtuple(
    "Setup",
    "corrector tolerance limit residual_and_jacobian test_functions contacts parameters parameter_slope scale "
    "unknowns test_count work gradient",
)
SETUP = types.NamedTuple(
    (CORRECTOR, _F, _I, RESIDUAL_AND_JACOBIAN, TEST_FUNCTIONS, CONTACTS, ARRAY, ARRAY, ARRAY, _I, _I, MATRIX, MATRIX),
    Setup,
)

#: How far steps may go, and where a curve ends: step lengths and the largest turn of `Continuation`, the longest move
#: of p, the largest amplitude, and the box from low to high (n + 1,), infinite where a component is free.
Limits = namedtuple("Limits", "first largest smallest angle distance parameter growth ceiling low high")
LIMITS = types.NamedTuple((_F, _F, _F, _F, _F, _F, _F, _F, ARRAY, ARRAY), Limits)

#: Points of a curve in order: points and tangents (k, n + 1), arclength, stable and event (k,).
Strand = namedtuple("Strand", "points tangents arclength stable event")
STRAND = types.NamedTuple((MATRIX, MATRIX, ARRAY, FLAGS, FLAGS), Strand)
