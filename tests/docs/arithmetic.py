"""Plain arithmetic for the tests of docs/physics.md: no array library and nothing of the solver."""

import cmath
import math

__all__ = [
    "angles",
    "average",
    "coefficient",
    "complex_number",
    "dead_zone",
    "describing",
    "determinant",
    "gain_of",
    "root",
    "slopes",
]

_POINTS = 4096
_TURN = 2.0 * math.pi


def dead_zone(displacement, b):
    """f of the gap |lambda| <= b."""
    return displacement - b if displacement > b else (displacement + b if displacement < -b else 0.0)


def coefficient(function, k):
    """Two-sided Fourier coefficient k of a function of period 2 pi, by the trapezoidal rule."""
    places = (_TURN * i / _POINTS for i in range(_POINTS))
    return sum(function(theta) * cmath.exp(-1j * k * theta) for theta in places) / _POINTS


def average(function):
    """Mean over the period."""
    return coefficient(function, 0).real


def slopes(function, point, step=1e-6):
    """Central differences of a function of several numbers: a column per number."""
    columns = []
    for i in range(len(point)):
        ends = []
        for sign in (1.0, -1.0):
            moved = list(point)
            moved[i] += sign * step
            ends.append(function(moved))
        columns.append([(high - low) / (2.0 * step) for high, low in zip(*ends, strict=True)])
    return [list(row) for row in zip(*columns, strict=True)]


def determinant(matrix):
    """Of a square matrix of numbers, by elimination with pivots."""
    rows, value = [list(row) for row in matrix], 1.0
    for i in range(len(rows)):
        pivot = max(range(i, len(rows)), key=lambda k: abs(rows[k][i]))
        if rows[pivot][i] == 0.0:
            return 0.0
        if pivot != i:
            rows[i], rows[pivot], value = rows[pivot], rows[i], -value
        value *= rows[i][i]
        for row in rows[i + 1 :]:
            factor = row[i] / rows[i][i]
            for j in range(i, len(rows)):
                row[j] -= factor * rows[i][j]
    return value


def root(function, low, high):
    """Where a function changes its sign between two numbers, by halving."""
    rising = function(low) < 0.0
    assert (function(high) < 0.0) != rising
    for _ in range(200):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        low, high = (middle, high) if (function(middle) < 0.0) == rising else (low, middle)
    return 0.5 * (low + high)


def angles(mean, amplitude, b):
    """theta_+ and theta_-: half the angle for which mean + amplitude cos(theta) is above b, and below -b."""
    return tuple(math.acos(min(max(cosine, -1.0), 1.0)) for cosine in ((b - mean) / amplitude, (b + mean) / amplitude))


def describing(mean, amplitude, b):
    """f_0 and N_a from the angles of contact; outside a flank's reach its angle is 0 or pi."""
    (near, far), total, gain = angles(mean, amplitude, b), 0.0, 0.0
    for angle, distance, sign in ((near, b - mean, 1.0), (far, b + mean, -1.0)):
        total += sign * (amplitude * math.sin(angle) - distance * angle) / math.pi
        gain += (angle - math.sin(angle) * math.cos(angle)) / math.pi
    return total, gain


def gain_of(phi, beta):
    """N of a motion of amplitude 1 with the mean force phi >= 0 and the half gap beta."""
    if phi >= 1.0:
        return 1.0
    nu = root(lambda place: describing(place, 1.0, beta)[0] - phi, 0.0, 1.0 + beta)
    return describing(nu, 1.0, beta)[1]


def complex_number(random):
    """Real and imaginary part uniform in [-1, 1]."""
    return complex(random.uniform(-1, 1), random.uniform(-1, 1))
