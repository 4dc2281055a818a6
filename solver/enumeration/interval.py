"""Interval arithmetic for proofs: every result contains the exact value for every choice within the operands.

An interval is a pair (low, high) of floats, a complex interval a pair (real, imaginary) of intervals. Instead of
switching the rounding mode, each result is widened outwards by 2.3e-16 of itself plus 1e-300, which is at least one
unit in the last place and more than the half unit by which +, -, *, / and sqrt may be off (IEEE 754; S. M. Rump, Acta
Numerica 19, 2010, section 5). sin and cos are widened by 4.5e-16, twice what the C library promises to keep. Bounds
that are nan or infinite are never proofs: whoever decides by an interval must ask for what is to hold ("low > 0"), not
for its opposite. Operands are taken to be finite; `solver.enumeration.reduction` sees to that.
"""

import math

from solver.kernels import types
from solver.kernels.compile import kernel

__all__ = [
    "COMPLEX",
    "INTERVAL",
    "above",
    "absolute",
    "add",
    "below",
    "complex_add",
    "complex_conjugate",
    "complex_multiply",
    "complex_reciprocal",
    "complex_scale",
    "complex_subtract",
    "cosine",
    "divide",
    "exact",
    "hull",
    "intersect",
    "length",
    "multiply",
    "phasor",
    "sine",
    "square",
    "subtract",
    "symmetric",
    "times",
]

INTERVAL = types.UniTuple(types.float64, 2)
COMPLEX = types.UniTuple(INTERVAL, 2)

_F = types.float64
_ULP = 2.3e-16
_TINY = 1e-300
_LIBRARY = 4.5e-16


@kernel(_F(_F), inline=True)
def below(value):
    """A float that lies below whatever rounded to `value`."""
    return value - (_ULP * abs(value) + _TINY)


@kernel(_F(_F), inline=True)
def above(value):
    """A float that lies above whatever rounded to `value`."""
    return value + (_ULP * abs(value) + _TINY)


@kernel(INTERVAL(_F), inline=True)
def exact(value):
    """The interval of one float, without margin."""
    return value, value


@kernel(INTERVAL(_F), inline=True)
def symmetric(radius):
    """[-radius, radius]."""
    return -radius, radius


@kernel(INTERVAL(INTERVAL, INTERVAL), inline=True)
def hull(x, y):
    """The smallest interval that contains both."""
    return min(x[0], y[0]), max(x[1], y[1])


@kernel(INTERVAL(INTERVAL, INTERVAL), inline=True)
def add(x, y):
    """x + y."""
    return below(x[0] + y[0]), above(x[1] + y[1])


@kernel(INTERVAL(INTERVAL, INTERVAL), inline=True)
def subtract(x, y):
    """x - y."""
    return below(x[0] - y[1]), above(x[1] - y[0])


@kernel(INTERVAL(INTERVAL, INTERVAL), inline=True)
def multiply(x, y):
    """x y."""
    a, b, c, d = x[0] * y[0], x[0] * y[1], x[1] * y[0], x[1] * y[1]
    return below(min(min(a, b), min(c, d))), above(max(max(a, b), max(c, d)))


@kernel(INTERVAL(_F, INTERVAL), inline=True)
def times(t, x):
    """t x for an exact t >= 0."""
    return below(t * x[0]), above(t * x[1])


@kernel(INTERVAL(INTERVAL, INTERVAL), inline=True)
def intersect(x, y):
    """What lies in both of two intervals that are known to meet."""
    return max(x[0], y[0]), min(x[1], y[1])


@kernel(INTERVAL(INTERVAL, INTERVAL), inline=True)
def divide(x, y):
    """x / y; nan bounds where y contains 0."""
    if not (y[0] > 0.0 or y[1] < 0.0):
        return math.nan, math.nan
    a, b, c, d = x[0] / y[0], x[0] / y[1], x[1] / y[0], x[1] / y[1]
    return below(min(min(a, b), min(c, d))), above(max(max(a, b), max(c, d)))


@kernel(INTERVAL(INTERVAL), inline=True)
def absolute(x):
    """|x|."""
    if x[0] >= 0.0:
        return x
    if x[1] <= 0.0:
        return -x[1], -x[0]
    return 0.0, max(-x[0], x[1])


@kernel(INTERVAL(INTERVAL), inline=True)
def square(x):
    """x^2."""
    low, high = absolute(x)
    return max(below(low * low), 0.0), above(high * high)


@kernel(INTERVAL(INTERVAL, INTERVAL), inline=True)
def length(x, y):
    """sqrt(x^2 + y^2)."""
    low, high = add(square(x), square(y))
    return max(below(math.sqrt(max(low, 0.0))), 0.0), above(math.sqrt(high))


@kernel(INTERVAL(INTERVAL), inner=True)
def cosine(x):
    """cos x; the width of x enters as it is, so this is meant for narrow x."""
    middle = 0.5 * (x[0] + x[1])
    margin = above(max(x[1] - middle, middle - x[0])) + _LIBRARY
    value = math.cos(middle)
    return value - margin, value + margin


@kernel(INTERVAL(INTERVAL), inner=True)
def sine(x):
    """sin x; as `cosine`."""
    middle = 0.5 * (x[0] + x[1])
    margin = above(max(x[1] - middle, middle - x[0])) + _LIBRARY
    value = math.sin(middle)
    return value - margin, value + margin


@kernel(COMPLEX(COMPLEX, COMPLEX), inline=True)
def complex_add(x, y):
    """x + y."""
    return add(x[0], y[0]), add(x[1], y[1])


@kernel(COMPLEX(COMPLEX, COMPLEX), inline=True)
def complex_subtract(x, y):
    """x - y."""
    return subtract(x[0], y[0]), subtract(x[1], y[1])


@kernel(COMPLEX(COMPLEX, COMPLEX), inner=True)
def complex_multiply(x, y):
    """x y."""
    return (subtract(multiply(x[0], y[0]), multiply(x[1], y[1])), add(multiply(x[0], y[1]), multiply(x[1], y[0])))


@kernel(COMPLEX(INTERVAL, COMPLEX), inline=True)
def complex_scale(factor, x):
    """factor x for a real factor."""
    return multiply(factor, x[0]), multiply(factor, x[1])


@kernel(COMPLEX(COMPLEX), inline=True)
def complex_conjugate(x):
    """The conjugate."""
    return x[0], (-x[1][1], -x[1][0])


@kernel(COMPLEX(COMPLEX), inner=True)
def complex_reciprocal(x):
    """1 / x; nan bounds where x contains 0."""
    size = add(square(x[0]), square(x[1]))
    conjugate = complex_conjugate(x)
    return divide(conjugate[0], size), divide(conjugate[1], size)


@kernel(COMPLEX(INTERVAL, _F), inline=True)
def phasor(amplitude, phase):
    """amplitude exp(i phase), the phase a number."""
    return multiply(amplitude, cosine(exact(phase))), multiply(amplitude, sine(exact(phase)))
