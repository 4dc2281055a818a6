"""The compiled search for period doublings and Neimark-Sacker points along a branch; see
`solver.stability.bifurcations`.

Kernels see the parameters as one vector: those of the balance, then the packed ones of Hill's matrix, their number, and
whether the force is truncated before the stiffness multiplies it.
"""

import cmath
import math

import numpy as np
from numba import types

from solver.continuation.continuation import Event
from solver.continuation.curve_point import locate, point_size, state_at
from solver.continuation.setup import SETUP
from solver.harmonic.perturbation import COMPLEX_MATRIX
from solver.kernels.compile import ARRAY, FLAGS, MATRIX, kernel
from solver.stability.exponents import NODES, exponent, gathered_phase, place
from solver.stability.hill_determinant import HALF, WHOLE, determinant, fill_matrix, hill_of

__all__ = ["critical_shares", "half_order_matrix", "monitor", "scan"]

_I, _F, _C, _B = types.int64, types.float64, types.complex128, types.boolean
_COMPLEX = np.complex128
_FOLD, _DOUBLING, _NEIMARK_SACKER = int(Event.FOLD), int(Event.PERIOD_DOUBLING), int(Event.NEIMARK_SACKER)

# How far the determinant at z = 1/4 may turn between two points (rad) before their step is divided, and into how many.
_TURN = 1.5
_PARTS = 8
# Into how many parts the distance between two nodes is divided to see where on the axis the determinant is smallest.
_LOOKS = 12
# How far from the straight line between two points of a branch an exponent may be on its way, in units of the
# frequency.
_BEND = 0.01
# Windings are whole, or half next to a fold or a period doubling, up to rounding.
_CROSSED = 0.75


@kernel(types.UniTuple(ARRAY, 2)(ARRAY, ARRAY), inline=True)
def _packed(theta, direction):
    """The vectors of Hill's matrix among those of the kernels."""
    last = theta.shape[0] - 2
    first = last - int(theta[last])
    return theta[first:last], direction[first:last]


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))
def monitor(theta, direction, y, values, gradient):
    """values[0]: the real determinant over the half window at half the base frequency; its gradient is left at 0."""
    packed, along = _packed(theta, direction)
    n = y.shape[0] - 1
    matrix = np.empty((n - 1, n - 1), _COMPLEX)
    fill_matrix(hill_of(packed, along, y[:n], y[n], HALF, theta[-1] != 0.0), 0.5 + 0j, matrix)
    values[0] = determinant(matrix).real
    gradient[0, :] = 0.0


@kernel(types.void(ARRAY, ARRAY, ARRAY, _B, COMPLEX_MATRIX))
def half_order_matrix(theta, direction, y, truncated, matrix):
    """Hill's matrix over the half window at half the base frequency, for packed vectors."""
    n = y.shape[0] - 1
    fill_matrix(hill_of(theta, direction, y[:n], y[n], HALF, truncated), 0.5 + 0j, matrix)


@kernel(_C(ARRAY, ARRAY, ARRAY, _I, ARRAY), inner=True)
def _phases(theta, direction, y, window, phases):
    """`gathered_phase` of a motion y = (u, p)."""
    packed, along = _packed(theta, direction)
    n = y.shape[0] - 1
    matrix = np.empty((n - window, n - window), _COMPLEX)
    return gathered_phase(hill_of(packed, along, y[:n], y[n], window, theta[-1] != 0.0), window, matrix, phases)


@kernel(_C(ARRAY, ARRAY, ARRAY, _I, _C), inner=True)
def _exponent(theta, direction, y, window, z):
    """`exponent` of a motion y = (u, p)."""
    packed, along = _packed(theta, direction)
    n = y.shape[0] - 1
    matrix = np.empty((n - window, n - window), _COMPLEX)
    return exponent(hill_of(packed, along, y[:n], y[n], window, theta[-1] != 0.0), z, matrix)


@kernel(_C(ARRAY, ARRAY, ARRAY, _I, _C), inner=True)
def _exponent_about(theta, direction, y, window, z):
    """The exponent of a motion next to where its determinant is smallest on the axis, within a node's distance of z."""
    packed, along = _packed(theta, direction)
    n = y.shape[0] - 1
    matrix = np.empty((n - window, n - window), _COMPLEX)
    hill = hill_of(packed, along, y[:n], y[n], window, theta[-1] != 0.0)
    best, least = z, math.inf
    for i in range(-_LOOKS, _LOOKS + 1):
        trial = z + 0.25 * i / (_LOOKS * (NODES - 1))
        fill_matrix(hill, trial, matrix)
        size = abs(determinant(matrix))
        if size < least:
            best, least = trial, size
    return exponent(hill, best, matrix)


@kernel(_I(ARRAY, ARRAY, ARRAY, _B, _F, ARRAY))
def critical_shares(theta, direction, y, truncated, tolerance, found):
    """Fill `found` with the exponents on the imaginary axis, over the base frequency, some repeatedly; their number."""
    extended = np.concatenate((theta, np.array([float(theta.shape[0]), 1.0 if truncated else 0.0])))
    along = np.concatenate((direction, np.zeros(2)))
    count = 0
    for window in (WHOLE, HALF):
        for node in range(NODES):
            z = complex(place(window, 0.25 * (node + 0.5) / NODES), 0.0)
            root = _exponent(extended, along, y, window, z)
            inside = (root.real <= 0.25) == (window == WHOLE) and 1e-9 < root.real < 0.5 - 1e-9
            if abs(root.imag) <= tolerance and inside and count < found.shape[0]:
                found[count] = root.real
                count += 1
    return count


@kernel(_F(ARRAY, _C, ARRAY, _C), inline=True)
def _winding(phases, end, other_phases, other_end):
    """Turns of the determinant along the axis at one motion, on to another one at z = 1/4, and back."""
    across = cmath.phase(other_end * end.conjugate())
    return (phases[NODES - 1] + across - other_phases[NODES - 1]) / (2.0 * math.pi)


@kernel(_F(_I, ARRAY, ARRAY), inline=True)
def _suspect(window, phases, other_phases):
    """z about which the gathered phases of two motions come to differ."""
    node, most = 1, 0.0
    for j in range(1, NODES):
        change = abs((phases[j] - other_phases[j]) - (phases[j - 1] - other_phases[j - 1]))
        if change > most:
            node, most = j, change
    return place(window, 0.25 * (node - 0.5) / (NODES - 1))


@kernel(_F(SETUP, ARRAY, ARRAY, _F, _F, _F, _I, _F, ARRAY), inner=True)
def _pinpoint(setup, left, right, arc, low, high, window, guess, found):
    """Find where an exponent crosses the imaginary axis between two fractions of a step; the fraction, or -1."""
    n = setup.unknowns
    phases, middle_phases, other_phases = np.empty(NODES), np.empty(NODES), np.empty(NODES)
    ends = np.empty((2, n + 1))
    for side in range(2):
        if state_at(setup, left, right, arc, low if side == 0 else high, found) < 0:
            return -1.0
        ends[side, :] = found[: n + 1]
    g_low, g_high, z = 0.0, 0.0, complex(guess, 0.0)
    at_low, at_high, bracketed = z, z, False
    for _ in range(40):
        at_low = _exponent_about(setup.theta, setup.direction, ends[0], window, z)
        at_high = _exponent_about(setup.theta, setup.direction, ends[1], window, z)
        g_low, g_high = at_low.imag, at_high.imag
        if g_low * g_high < 0.0 and abs(at_low - at_high) < 0.02 and -0.01 < at_low.real < 0.51:
            bracketed = True
            break
        middle = 0.5 * (low + high)
        if state_at(setup, left, right, arc, middle, found) < 0:
            return -1.0
        end = _phases(setup.theta, setup.direction, ends[0], window, phases)
        middle_end = _phases(setup.theta, setup.direction, found[: n + 1], window, middle_phases)
        if abs(_winding(phases, end, middle_phases, middle_end)) > _CROSSED:
            high = middle
            ends[1, :] = found[: n + 1]
            z = complex(_suspect(window, phases, middle_phases), 0.0)
        else:
            low = middle
            ends[0, :] = found[: n + 1]
            _phases(setup.theta, setup.direction, ends[1], window, other_phases)
            z = complex(_suspect(window, middle_phases, other_phases), 0.0)
    if not bracketed:
        return -1.0
    side, x = 0, low
    for _ in range(80):
        x = (low * g_high - high * g_low) / (g_high - g_low)
        margin = 1e-3 * (high - low)
        x = min(max(x, low + margin), high - margin)
        if state_at(setup, left, right, arc, x, found) < 0:
            return -1.0
        # Another exponent may be close by: the path of this one is known at both ends of the bracket, and bends
        # between.
        expected = at_low + (x - low) / (high - low) * (at_high - at_low)
        z = _exponent(setup.theta, setup.direction, found[: n + 1], window, expected)
        if not math.isfinite(z.real) or abs(z - expected) > abs(at_high - at_low) + _BEND * (high - low) + 1e-6:
            return -1.0
        if abs(z.imag) <= 1e-13 or (high - low) * arc <= 1e-13:
            break
        if z.imag * g_high < 0.0:
            low, g_low, at_low = x, z.imag, z
            if side == -1:
                g_high *= 0.5
            side = -1
        else:
            high, g_high, at_high = x, z.imag, z
            if side == 1:
                g_low *= 0.5
            side = 1
    return x if abs(z.imag) <= 1e-9 else -1.0


@kernel(_F(SETUP, ARRAY, ARRAY, _F, _I, ARRAY, _C, ARRAY, _C, ARRAY), inner=True)
def _crossing(setup, left, right, arc, window, phases, end, other_phases, other_end, found):
    """Look for an exponent that crosses the axis between two points: the fraction, -1 without one, -2 if it is lost."""
    if abs(cmath.phase(other_end * end.conjugate())) <= _TURN:
        if abs(_winding(phases, end, other_phases, other_end)) <= _CROSSED:
            return -1.0
        x = _pinpoint(setup, left, right, arc, 0.0, 1.0, window, _suspect(window, phases, other_phases), found)
        return x if x >= 0.0 else -2.0
    last, last_end, now = phases.copy(), end, np.empty(NODES)
    for part in range(1, _PARTS + 1):
        now_end = other_end
        if part < _PARTS:
            if state_at(setup, left, right, arc, part / _PARTS, found) < 0:
                return -2.0
            now_end = _phases(setup.theta, setup.direction, found[: setup.unknowns + 1], window, now)
        else:
            now[:] = other_phases
        if abs(_winding(last, last_end, now, now_end)) > _CROSSED:
            guess = _suspect(window, last, now)
            x = _pinpoint(setup, left, right, arc, (part - 1) / _PARTS, part / _PARTS, window, guess, found)
            return x if x >= 0.0 else -2.0
        last[:], last_end = now, now_end
    return -1.0


@kernel(_I(_I, _I, _I, _F, ARRAY, _I, types.int64[::1], FLAGS, ARRAY, MATRIX, MATRIX), inline=True)
def _record(count, i, kind, x, found, n, after, kinds, fractions, points, tangents):
    """Write one located point behind point i of the branch; the new number of points."""
    if count < after.shape[0]:
        after[count], kinds[count], fractions[count] = i, kind, x
        points[count, :] = found[: n + 1]
        tangents[count, :] = found[n + 1 : 2 * n + 2]
        count += 1
    return count


@kernel(_I(SETUP, MATRIX, MATRIX, ARRAY, FLAGS, types.int64[::1], FLAGS, ARRAY, MATRIX, MATRIX))
def scan(setup, branch, branch_tangents, arclength, events, after, kinds, fractions, points, tangents):
    """Locate the bifurcations of a branch: fill the last five arrays; their number, or -1 - i if one near point i is
    lost.

    The search along the axis is repeated at every point of the branch but its folds, where the determinant over the
    whole window vanishes at its centre: the step across a fold is one step there, and its windings are halves.
    """
    n, theta, direction = setup.unknowns, setup.theta, setup.direction
    size, total = point_size(setup), branch.shape[0]
    left, right, found = np.zeros(size), np.zeros(size), np.zeros(size)
    phases, ends = np.empty((total, 2, NODES)), np.empty((total, 2), _COMPLEX)
    slot, count = 2 * n + 2, 0
    for i in range(total):
        left[:] = right
        right[: n + 1], right[n + 1 : 2 * n + 2] = branch[i], branch_tangents[i]
        setup.monitor(theta, direction, right[: n + 1], right[slot : slot + 1], setup.gradient)
        for window in (WHOLE, HALF):
            if window == HALF or events[i] != _FOLD:
                ends[i, window] = _phases(theta, direction, branch[i], window, phases[i, window])
        if i == 0:
            continue
        arc = arclength[i] - arclength[i - 1]
        if left[slot] * right[slot] < 0.0:
            x = locate(setup, left, right, arc, slot, left[: n + 1], 0.0, found)
            if x < 0.0:
                return -1 - i
            count = _record(count, i - 1, _DOUBLING, x, found, n, after, kinds, fractions, points, tangents)
        for window in (WHOLE, HALF):
            first = i - 1
            if window == WHOLE:
                if events[i] == _FOLD:
                    continue
                while first >= 0 and events[first] == _FOLD:
                    first -= 1
                if first < 0:
                    continue
            if first == i - 1:
                x = _crossing(
                    setup,
                    left,
                    right,
                    arc,
                    window,
                    phases[first, window],
                    ends[first, window],
                    phases[i, window],
                    ends[i, window],
                    found,
                )
                if x == -2.0:
                    return -1 - i
                if x >= 0.0:
                    count = _record(
                        count, i - 1, _NEIMARK_SACKER, x, found, n, after, kinds, fractions, points, tangents
                    )
                continue
            turns = _winding(phases[first, window], ends[first, window], phases[i, window], ends[i, window])
            if abs(turns) <= _CROSSED:
                continue
            guess = _suspect(window, phases[first, window], phases[i, window])
            located = False
            start, stop = np.zeros(size), np.zeros(size)
            for k in range(first, i):
                start[: n + 1], start[n + 1 : 2 * n + 2] = branch[k], branch_tangents[k]
                stop[: n + 1], stop[n + 1 : 2 * n + 2] = branch[k + 1], branch_tangents[k + 1]
                x = _pinpoint(setup, start, stop, arclength[k + 1] - arclength[k], 0.0, 1.0, window, guess, found)
                if x >= 0.0:
                    count = _record(count, k, _NEIMARK_SACKER, x, found, n, after, kinds, fractions, points, tangents)
                    located = True
                    break
            if not located:
                return -1 - i
    return count
