"""Exponents of a motion near the imaginary axis: the phase of Hill's determinant along it, and single exponents.

Between two motions of a branch an exponent has crossed the imaginary axis where the phase that the determinant gathers
along it has jumped by a full turn (the argument principle, on the loop along the axis at one motion and back at the
other). Exponents are in units of i times the base frequency, z = s/(i Omega/nu): the axis is real z, a window is
followed from its centre to z = 1/4, where the other one takes over.
"""

import cmath
import math

import numpy as np

from solver.harmonic.perturbation import COMPLEX_MATRIX
from solver.kernels import types
from solver.kernels.compile import ARRAY, kernel
from solver.stability.hill_determinant import HILL, determinant, fill_matrix

__all__ = ["NODES", "exponent", "gathered_phase", "place"]

_I, _F, _C, _B = types.int64, types.float64, types.complex128, types.boolean

#: Places from the centre of a window to z = 1/4 at which the gathered phase is kept.
NODES = 9
_EDGE = 0.25
_DEPTH = 16
_CAUTION = 4.0
_STEPS = 25
_SETTLED, _STALLED = 1e-12, 1e-9


@kernel(_F(_I, _F), inline=True)
def place(window, distance):
    """z at a distance from the centre of a window."""
    return distance if window == 0 else 0.5 - distance


@kernel(_C(HILL, _C, COMPLEX_MATRIX), inner=True)
def _value(hill, z, matrix):
    """The determinant, with the phase of its poles taken away."""
    phase = fill_matrix(hill, z, matrix)
    return determinant(matrix) * phase


@kernel(_F(_C, _C), inline=True)
def _clearance(left, right):
    """Distance of the origin from the segment between two complex numbers."""
    step = right - left
    length = step.real * step.real + step.imag * step.imag
    if length == 0.0:
        return abs(left)
    x = -(left.real * step.real + left.imag * step.imag) / length
    return abs(left + min(max(x, 0.0), 1.0) * step)


@kernel(_F(_C, _C), inline=True)
def _turn(left, right):
    """Angle from one complex number to another, in (-pi, pi]."""
    return cmath.phase(right * left.conjugate())


@kernel(_C(HILL, _I, COMPLEX_MATRIX, ARRAY), inner=True)
def gathered_phase(hill, window, matrix, phases):
    """Follow the determinant along the imaginary axis; its value at z = 1/4.

    Parameters
    ----------
    hill : Hill
        Of the motion over the window; see `solver.stability.hill_determinant.hill_of`.
    window : {WHOLE, HALF}
    matrix : (size, size) complex array
        Workspace of the window's size.
    phases : (NODES,) array
        Filled with the phase gathered from the centre of the window, at evenly spaced distances from it.

    Notes ----- A piece is taken for straight once the determinant at its middle is `_CAUTION` times closer to its chord
    than the chord is to 0. A parabola would stay clear of 0 even with a fourth of that; but next to an exponent close
    to the axis the determinant may make a loop between the places that are looked at, which only closer ones show.
    """
    ends, values = np.empty(_DEPTH + 2), np.empty(_DEPTH + 2, np.complex128)
    left = 0.0
    at_left = _value(hill, complex(place(window, left), 0.0), matrix)
    # At the centre the determinant is real.
    at_left = complex(at_left.real, 0.0)
    phases[0] = 0.0
    pieces = (NODES - 1) // 2
    for piece in range(pieces):
        depth = 1
        ends[0] = _EDGE * (piece + 1) / pieces
        values[0] = _value(hill, complex(place(window, ends[0]), 0.0), matrix)
        gathered, halfway = phases[2 * piece], 0.5 * (left + ends[0])
        while depth > 0:
            right, at_right = ends[depth - 1], values[depth - 1]
            middle = 0.5 * (left + right)
            z = complex(place(window, middle), 0.0)
            at_middle = _value(hill, z, matrix)
            bend = abs(at_middle - 0.5 * (at_left + at_right))
            clear = min(_clearance(at_left, at_middle), _clearance(at_middle, at_right))
            if _CAUTION * bend > clear and depth < _DEPTH:
                ends[depth], values[depth] = middle, at_middle
                depth += 1
                continue
            if middle == halfway:
                phases[2 * piece + 1] = gathered + _turn(at_left, at_middle)
            gathered += _turn(at_left, at_middle) + _turn(at_middle, at_right)
            left, at_left = right, at_right
            if left == halfway:
                phases[2 * piece + 1] = gathered
            depth -= 1
        phases[2 * piece + 2] = gathered
    return at_left


@kernel(_C(HILL, _C, COMPLEX_MATRIX), inner=True)
def exponent(hill, z, matrix):
    """The exponent next to z, by the secant method in the complex plane; nan if there is none nearby."""
    old, new = z, z + complex(1e-6, 1e-6)
    fill_matrix(hill, old, matrix)
    at_old = determinant(matrix)
    length = math.inf
    for _ in range(_STEPS):
        fill_matrix(hill, new, matrix)
        at_new = determinant(matrix)
        change = at_new - at_old
        if change == 0.0:
            return new if abs(new - old) < 1e-9 else complex(math.nan, math.nan)
        step = -at_new * (new - old) / change
        length, previous = abs(step), length
        if not math.isfinite(length):
            return complex(math.nan, math.nan)
        if length > 0.1:
            step *= 0.1 / length
        old, at_old, new = new, at_new, new + step
        # Rounding may keep the steps from falling further.
        if length <= _SETTLED or (length <= _STALLED and length >= 0.5 * previous):
            return new
    return complex(math.nan, math.nan)
