"""First exit from an interval, and Fourier integrals, of a polynomial over a step, from its powers.

The search marches over the step in pieces that a bound M of the second derivative settles: over a piece of length d the
polynomial leaves its chord by at most M d^2 / 8, and it is monotone where its slope exceeds M d. So a motion that
enters another zone and leaves it within one step is not overlooked.
"""

import math

import numpy as np

from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel

__all__ = ["add_fourier", "evaluate", "first_exit"]

#: Pieces are not divided below this share of a step: a visit to the other zone that short is below rounding errors.
_SMALLEST = 1e-8

_PAIR = types.UniTuple(types.float64, 2)

#: Nodes and weights on [-1, 1]; exact to degree 31, and pieces are so short that trigonometric factors are resolved.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)


@kernel(_PAIR(ARRAY, types.float64), inner=True)
def evaluate(coefficients, time):
    """Value and slope of sum_k coefficients[k] time^k."""
    value, slope = coefficients[-1], 0.0
    for k in range(coefficients.shape[0] - 2, -1, -1):
        slope = slope * time + value
        value = value * time + coefficients[k]
    return value, slope


@kernel(types.float64(ARRAY, types.float64), inner=True)
def _curvature(coefficients, step):
    """Bound of the second derivative over [0, step]."""
    total = 0.0
    for k in range(coefficients.shape[0] - 1, 1, -1):
        total = total * step + k * (k - 1.0) * abs(coefficients[k])
    return total


@kernel(types.float64(ARRAY, types.float64, types.float64, types.float64), inner=True)
def _root(coefficients, level, left, right):
    """Where the polynomial takes a level between two times, by Newton's method kept inside a bracket."""
    value, _ = evaluate(coefficients, left)
    rising = value < level
    time = 0.5 * (left + right)
    for _ in range(100):
        value, slope = evaluate(coefficients, time)
        if (value < level) == rising:
            left = time
        else:
            right = time
        previous = time
        time -= (value - level) / slope
        if not left < time < right:
            if previous == time or abs(time - previous) <= 4e-16 * abs(previous):
                return previous
            time = 0.5 * (left + right)
        if abs(time - previous) <= 4e-16 * abs(time):
            break
    return time


@kernel(types.Tuple((types.float64, types.int64))(ARRAY, types.float64, types.float64, types.float64), inner=True)
def first_exit(coefficients, step, low, high):
    """When a polynomial that starts within [low, high] first leaves it.

    Parameters
    ----------
    coefficients : (m,) array
    step : float
        The search covers [0, step].
    low, high : float
        May be infinite. A start outside by rounding counts as inside if the polynomial moves inwards.

    Returns
    -------
    time : float
        Of the exit, or `step`.
    side : int
        -1 through low, 1 through high, 0 for no exit.
    """
    bend = _curvature(coefficients, step)
    smallest = _SMALLEST * step
    left, width = 0.0, step
    value, slope = coefficients[0], coefficients[1]
    while left < step:
        right = left + width
        if right >= step:
            right, width = step, step - left
        after, slope_after = evaluate(coefficients, right)
        sag = 0.125 * bend * width * width
        clear = min(value, after) - sag >= low and max(value, after) + sag <= high
        if not clear:
            monotone = max(abs(slope), abs(slope_after)) > bend * width
            # Where the polynomial rests on a border, what it could add to its ends is lost in their rounding.
            if not (monotone or width <= smallest or sag <= 2e-16 * (abs(value) + abs(after))):
                width *= 0.5
                continue
            if after < low:
                return (_root(coefficients, low, left, right), -1) if value > low else (left, -1)
            if after > high:
                return (_root(coefficients, high, left, right), 1) if value < high else (left, 1)
        left, value, slope = right, after, slope_after
        width *= 2.0
    return step, 0


@kernel(types.void(*(ARRAY,) + (types.float64,) * 5, MATRIX), inner=True)
def add_fourier(powers, begin, end, half, middle, base, sums):
    """Add the integrals of a polynomial times cos and sin of k base tau over a step.

    Parameters
    ----------
    powers : (m,) array
        Coefficients of powers of u, at the time tau = middle + half u.
    begin, end : float
        The step, in u.
    half, middle, base : float
    sums : (H + 1, 2) array
        Added to: cosine and sine integrals of k = 0 ... H.
    """
    most = sums.shape[0] - 1
    pieces = 1 + int(max(most, 1) * base * half * (end - begin) / 4.0)
    reach = 0.5 * (end - begin) / pieces
    for piece in range(pieces):
        for node in range(_NODES.shape[0]):
            at = begin + (2 * piece + 1 + _NODES[node]) * reach
            value, _ = evaluate(powers, at)
            value *= half * reach * _WEIGHTS[node]
            phase = base * (middle + half * at)
            cosine, sine = math.cos(phase), math.sin(phase)
            c, s = 1.0, 0.0
            for k in range(most + 1):
                sums[k, 0] += value * c
                sums[k, 1] += value * s
                c, s = c * cosine - s * sine, s * cosine + c * sine
