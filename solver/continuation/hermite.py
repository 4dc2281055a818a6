"""The cubic through two values with given slopes (Hermite): between two points of a curve it is what is known of it."""

from solver.kernels import types
from solver.kernels.compile import kernel

__all__ = ["cubic", "cubic_slope", "cubic_value", "fraction_at"]

_F = types.float64


@kernel(types.UniTuple(_F, 2)(_F, _F, _F, _F), inline=True)
def cubic(start, end, leave, arrive):
    """Coefficients a and b of ((a x + b) x + leave) x + start, which at x = 1 is `end` with the slope `arrive`.

    Parameters
    ----------
    start, end : float
        Values at 0 and at 1.
    leave, arrive : float
        Slopes there.
    """
    return 2.0 * (start - end) + leave + arrive, 3.0 * (end - start) - 2.0 * leave - arrive


@kernel(_F(_F, _F, _F, _F, _F), inline=True)
def cubic_value(a, b, leave, start, x):
    """The cubic at x.

    Parameters
    ----------
    a, b : float
        From `cubic`.
    leave, start : float
        Slope and value at 0.
    x : float
        Where, from 0 to 1.
    """
    return ((a * x + b) * x + leave) * x + start


@kernel(_F(_F, _F, _F, _F), inline=True)
def cubic_slope(a, b, leave, x):
    """Its derivative at x.

    Parameters
    ----------
    a, b : float
        From `cubic`.
    leave : float
        Slope at 0.
    x : float
        Where, from 0 to 1.
    """
    return (3.0 * a * x + 2.0 * b) * x + leave


@kernel(_F(_F, _F, _F, _F, _F, _F), inner=True)
def fraction_at(start, end, leave, arrive, level, tolerance):
    """Where a monotone cubic takes a level between its ends, to a tolerance.

    Parameters
    ----------
    start, end : float
        Values at 0 and at 1.
    leave, arrive : float
        Slopes there.
    level : float
        The value that is met.
    tolerance : float
        Of the fraction.
    """
    a, b = cubic(start, end, leave, arrive)
    low, high, x = 0.0, 1.0, (level - start) / (end - start)
    # Newton's method in a bracket: next to a fold the cubic is only just monotone.
    for _ in range(40):
        ahead = cubic_value(a, b, leave, start, x) - level
        if (ahead < 0.0) == (start < end):
            low = x
        else:
            high = x
        moved = x - ahead / cubic_slope(a, b, leave, x)
        if not low < moved < high:
            moved = 0.5 * (low + high)
        if abs(moved - x) < tolerance:
            break
        x = moved
    return x
