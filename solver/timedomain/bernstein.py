"""Polynomials of degree 15 in Bernstein's basis: parts, bounds, first exit from a range, extremes.

The coefficients over an interval bound the polynomial, and it has at most as many roots there as they change sign, an
even number less at most (R. T. Farouki, Computer Aided Geometric Design 29 (2012) 379-419, sections 3.3 and 5.4): one
change is one root, which Halley's iteration finds from where the control polygon crosses. So nothing within an interval
is overlooked, however short. Where there are more changes the interval is halved.

The same polynomial is evaluated from its coefficients of powers of u, from -1 to 1 over the whole interval.
"""

import math

from solver.flow.zone_flows import COEFFICIENTS
from solver.kernels import types
from solver.kernels.compile import ARRAY, kernel
from solver.kernels.linear import copy_into

__all__ = ["first_exit_of_hull", "hull_within", "keep_left", "keep_right", "restrict", "widen_by_hull"]

_F, _I, _B = types.float64, types.int64, types.boolean

# Pieces are not divided below this share of an interval: a visit to the other zone that short is below rounding errors.
_SMALLEST = 1e-8


@kernel(types.void(ARRAY, _F), inner=True, shared=True)
def keep_right(hull, at):
    """Replace coefficients over [0, 1] by those over [at, 1] (de Casteljau)."""
    rest = 1.0 - at
    for level in range(COEFFICIENTS - 1, 0, -1):
        for j in range(level):
            hull[j] = rest * hull[j] + at * hull[j + 1]


@kernel(types.void(ARRAY, _F), inner=True, shared=True)
def keep_left(hull, at):
    """Replace coefficients over [0, 1] by those over [0, at]."""
    rest = 1.0 - at
    for level in range(1, COEFFICIENTS):
        for j in range(COEFFICIENTS - 1, level - 1, -1):
            hull[j] = rest * hull[j - 1] + at * hull[j]


@kernel(types.void(ARRAY, _F, _F, _F, _F, ARRAY), inner=True)
def restrict(hull, begin, end, left, right, piece):
    """Fill in the coefficients over [left, right], a part of [begin, end] that `hull` belongs to."""
    copy_into(piece, hull)
    if right < end:
        keep_left(piece, (right - begin) / (end - begin))
    if left > begin:
        keep_right(piece, (left - begin) / (right - begin))


@kernel(_B(ARRAY, _F, _F), inline=True)
def hull_within(hull, low, high):
    """Whether all coefficients lie within a range, and with them the polynomial; true where one is nan."""
    outside = False
    for j in range(hull.shape[0]):
        outside |= (hull[j] < low) | (hull[j] > high)
    return not outside


@kernel(types.Tuple((_I, _F))(ARRAY, _F, _F), inner=True)
def _crossings(hull, level, side):
    """How often the coefficients pass a level, and where the control polygon first does, as a share of the interval.

    The first coefficient counts as inside, which for side = 1 is below the level and for -1 above it. If it is on the
    border and the polynomial moves out of it at once, the place is 0.
    """
    count, place = 0, 0.0
    before, inside = min(side * (hull[0] - level), 0.0), True
    for j in range(1, COEFFICIENTS):
        value = side * (hull[j] - level)
        if (value <= 0.0) != inside:
            if count == 0:
                place = (j - 1.0 + before / (before - value)) / (COEFFICIENTS - 1.0)
            count += 1
            inside = not inside
        before = value
    return count, place


@kernel(_F(ARRAY, _F, _F, _F, _F, _F), inner=True)
def _root(powers, level, side, left, right, guess):
    """The one place where a polynomial crosses a level in the direction `side`, between two times."""
    time = guess
    for _ in range(60):
        value, slope, bend = powers[COEFFICIENTS - 1], 0.0, 0.0
        for j in range(COEFFICIENTS - 2, -1, -1):
            bend = bend * time + slope
            slope = slope * time + value
            value = value * time + powers[j]
        value -= level
        if side * value < 0.0:
            left = time
        else:
            right = time
        previous = time
        time -= value * slope / (slope * slope - value * bend)
        if not left <= time <= right:
            time = 0.5 * (left + right)
        # The iteration is of order three, and a motion feels an error of a switch by its square.
        elif abs(time - previous) <= 1e-5:
            break
        if right - left <= 1e-15:
            break
    return time


@kernel(types.Tuple((_F, _I))(ARRAY, ARRAY, _F, ARRAY, _F, ARRAY), inner=True)
def first_exit_of_hull(hull, powers, begin, limits, slack, piece):
    """Where a polynomial first leaves a range over [begin, 1].

    Parameters
    ----------
    hull : (16,) array
        Bernstein coefficients over [begin, 1].
    powers : (16,) array
    begin : float
        There the polynomial is inside, or on a border up to rounding.
    limits : (2,) array
        The range; an exit shorter and lower than `slack` beyond it is none.
    slack : float
    piece : (16,) array
        Overwritten.

    Returns
    -------
    time : float
        Of the exit, where the polynomial takes the limit; else 1.
    side : int
        -1 through the lower limit, 1 through the upper one, 0 for no exit.
    """
    left, width = begin, 1.0 - begin
    while left < 1.0:
        right = left + width
        if right >= 1.0:
            right, width = 1.0, 1.0 - left
        restrict(hull, begin, 1.0, left, right, piece)
        below = not hull_within(piece, limits[0] - slack, math.inf)
        above = not hull_within(piece, -math.inf, limits[1] + slack)
        if below or above:
            side = 1 if above else -1
            level = limits[1] if above else limits[0]
            count, place = _crossings(piece, level, float(side))
            if (below and above) or count > 1:
                if width > _SMALLEST:
                    width *= 0.5
                    continue
                if side * (piece[COEFFICIENTS - 1] - level) > slack:
                    return right, side
            elif count == 1:
                if place == 0.0:
                    return left, side
                return _root(powers, level, float(side), left, right, left + place * width), side
        left = right
        width *= 2.0
    return 1.0, 0


@kernel(_F(ARRAY, _F, _F, _F), inner=True)
def _turning_value(powers, left, right, guess):
    """The value at the one extreme of a polynomial between two times."""
    time = guess
    for _ in range(30):
        slope, bend, third = 0.0, 0.0, 0.0
        for j in range(COEFFICIENTS - 1, 0, -1):
            third = third * time + bend
            bend = bend * time + slope
            slope = slope * time + j * powers[j]
        previous = time
        time = min(max(time - slope * bend / (bend * bend - slope * third), left), right)
        # The value feels the square of an error of time.
        if not abs(time - previous) > 1e-4:
            break
    value = powers[COEFFICIENTS - 1]
    for j in range(COEFFICIENTS - 2, -1, -1):
        value = value * time + powers[j]
    return value


@kernel(types.void(ARRAY, ARRAY, _F, _F, _F, ARRAY, ARRAY), inner=True)
def widen_by_hull(hull, powers, begin, end, slack, extremes, piece):
    """Widen extremes (2,) to all values that a polynomial takes over [begin, end], where `hull` belongs to.

    What exceeds them by less than slack is left out.
    """
    last = COEFFICIENTS - 1
    extremes[0], extremes[1] = min(extremes[0], hull[0], hull[last]), max(extremes[1], hull[0], hull[last])
    left, width = begin, end - begin
    while left < end:
        right = left + width
        if right >= end:
            right, width = end, end - left
        restrict(hull, begin, end, left, right, piece)
        extremes[0], extremes[1] = min(extremes[0], piece[last]), max(extremes[1], piece[last])
        if not hull_within(piece, extremes[0] - slack, extremes[1] + slack):
            turns, place, rises = 0, 0.0, piece[1] > piece[0]
            for j in range(1, last):
                before, after = piece[j] - piece[j - 1], piece[j + 1] - piece[j]
                if (after > 0.0) != rises:
                    if turns == 0:
                        place = (j - 0.5 + before / (before - after)) / last
                    rises = not rises
                    turns += 1
            if turns > 1 and width > 1e-3:
                width *= 0.5
                continue
            value = _turning_value(powers, left, right, left + place * width)
            extremes[0], extremes[1] = min(extremes[0], value), max(extremes[1], value)
        left = right
        width *= 2.0
