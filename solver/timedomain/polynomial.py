"""First exit from an interval, extremes and Fourier integrals of a polynomial over a step.

Both searches march over the step in pieces that a bound M of the second derivative settles: over a piece of length d
the polynomial leaves its chord by at most M d^2 / 8, and it is monotone where its slope exceeds M d. So a motion that
enters another zone and leaves it within one step is not overlooked.
"""

import math

import numpy as np

from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel

__all__ = ["evaluate", "first_exit", "fourier", "widen"]

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


@kernel(types.float64(ARRAY, types.float64, types.float64), inner=True)
def _turning_point(coefficients, left, right):
    """Where the slope changes sign between two times, by Newton's method kept inside a bracket."""
    _, slope = evaluate(coefficients, left)
    rising = slope < 0.0
    time = 0.5 * (left + right)
    for _ in range(60):
        slope, curvature = 0.0, 0.0
        for k in range(coefficients.shape[0] - 1, 0, -1):
            curvature = curvature * time + slope
            slope = slope * time + k * coefficients[k]
        if (slope < 0.0) == rising:
            left = time
        else:
            right = time
        previous = time
        time -= slope / curvature
        if not left < time < right:
            time = 0.5 * (left + right)
        # The value at a turning point feels the square of an error of time.
        if abs(time - previous) <= 1e-9 * (right + abs(time)):
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


@kernel(_PAIR(ARRAY, types.float64, types.float64, types.float64), inner=True)
def widen(coefficients, step, lowest, highest):
    """The range [lowest, highest], widened to all values that the polynomial takes over [0, step]."""
    bend = _curvature(coefficients, step)
    smallest = 1e-6 * step
    left, width = 0.0, step
    value, slope = coefficients[0], coefficients[1]
    lowest, highest = min(lowest, value), max(highest, value)
    while left < step:
        right = left + width
        if right >= step:
            right, width = step, step - left
        after, slope_after = evaluate(coefficients, right)
        lowest, highest = min(lowest, after), max(highest, after)
        sag = 0.125 * bend * width * width
        inside = min(value, after) - sag >= lowest and max(value, after) + sag <= highest
        if not inside and not max(abs(slope), abs(slope_after)) > bend * width and width > smallest:
            if slope * slope_after < 0.0:
                turn, _ = evaluate(coefficients, _turning_point(coefficients, left, right))
                lowest, highest = min(lowest, turn), max(highest, turn)
                inside = min(value, after) - sag >= lowest and max(value, after) + sag <= highest
            # What two turning points within so short a piece could add is below rounding errors.
            if not inside and width > (0.1 if slope * slope_after < 0.0 else 1e-3) * step:
                width *= 0.5
                continue
        left, value, slope = right, after, slope_after
        width *= 2.0
    return lowest, highest


@kernel(types.void(ARRAY, types.float64, types.float64, types.float64, MATRIX), inner=True)
def fourier(coefficients, step, time, base, sums):
    """Add the integrals of the polynomial times cos and sin of k base (time + t) over t in [0, step].

    Parameters
    ----------
    coefficients : (m,) array
    step, time, base : float
    sums : (H + 1, 2) array
        Added to: cosine and sine integrals of k = 0 ... H.
    """
    most = sums.shape[0] - 1
    pieces = 1 + int(max(most, 1) * base * step / 4.0)
    half = 0.5 * step / pieces
    for piece in range(pieces):
        middle = (2 * piece + 1) * half
        for node in range(_NODES.shape[0]):
            local = middle + half * _NODES[node]
            value, _ = evaluate(coefficients, local)
            value *= half * _WEIGHTS[node]
            cosine, sine = math.cos(base * (time + local)), math.sin(base * (time + local))
            c, s = 1.0, 0.0
            for k in range(most + 1):
                sums[k, 0] += value * c
                sums[k, 1] += value * s
                c, s = c * cosine - s * sine, s * cosine + c * sine
