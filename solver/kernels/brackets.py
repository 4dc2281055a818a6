"""Where numbers lie in a sorted array.

NumPy's own search takes numba a second to compile: it orders nan and complex numbers too.
"""

from solver.kernels import types
from solver.kernels.compile import ARRAY, kernel

__all__ = ["first_above", "first_not_below"]


@kernel(types.int64(ARRAY, types.float64), inner=True)
def first_not_below(values, limit):
    """Index of the first of ascending values that is at least `limit`; their number where there is none."""
    low, high = 0, values.shape[0]
    while low < high:
        middle = (low + high) // 2
        if values[middle] < limit:
            low = middle + 1
        else:
            high = middle
    return low


@kernel(types.int64(ARRAY, types.float64), inner=True)
def first_above(values, limit):
    """Index of the first of ascending values that is above `limit`; their number where there is none."""
    low, high = 0, values.shape[0]
    while low < high:
        middle = (low + high) // 2
        if values[middle] <= limit:
            low = middle + 1
        else:
            high = middle
    return low
