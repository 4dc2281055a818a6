"""The rows of a boundary of a balance of any order, as kernels.

The unknowns are y = (u, x, p) with the motion u and the axes x and p; for Neimark-Sackers (u, kappa, x, p) with the
cosine of the angle of the critical multipliers. Rows are the balance, then what makes the motion special: the
determinant of its Jacobian, rows scaled (fold), the distance of an extreme of lambda from a flank (grazing), or a test
function of the monodromy matrix (`solver.boundaries.bifurcations`).

Like the monodromy matrix, dE/du depends on the motion through the angles of contact alone, each of which changes it by
a matrix of rank one: a force at the angle theta_c enters row k with

    -sigma/(2 pi) [A_k + B_k s(theta_c)] exp(-i k theta_c)

(twice that for k > 0, times the stiffness of the flank, impedances as in `solver.harmonic.impedance`), times d
lambda(theta_c) by the unknowns. So the slope of its determinant by an angle is one difference, exact, and only what the
axes change with the angles held takes central differences.
"""

import math

import numpy as np

from solver.boundaries.bifurcations import ANGLE, CONTACT_FLANK, SENSE, bifurcation_test, move_parameters
from solver.boundaries.problem import GRAZINGS, parameters_at
from solver.contact.spectrum import contact_arcs, displacement
from solver.continuation.continuation import Event
from solver.harmonic import galerkin_rows
from solver.harmonic.impedance import base_frequency, impedance, stiffness_phasor
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import eliminate
from solver.model.parameters import (
    BACK_CONTACT,
    BACK_GAP,
    BACK_STIFFNESS,
    EVENT,
    FRONT_CONTACT,
    FRONT_GAP,
    P_STEP,
    PERIOD,
    STIFFNESSES,
    X_STEP,
)

__all__ = ["harmonic_rows"]

_I, _F = types.int64, types.float64
_FOLD, _DOUBLING, _NEIMARK_SACKER = int(Event.FOLD), int(Event.PERIOD_DOUBLING), int(Event.NEIMARK_SACKER)
_GRAZED = tuple(int(event) for event in GRAZINGS)
_TURN = 2.0 * math.pi

# Columns of the switches of contact behind those of `bifurcations`: how the level of lambda there moves along x and p,
# and d lambda/d theta.
LEVEL_X, LEVEL_P, SLOPE, SWITCHES = range(3, 7)
_galerkin_rows, _margins = galerkin_rows.residual_and_jacobian, galerkin_rows.test_functions


@kernel(types.Tuple((_I, MATRIX))(ARRAY, ARRAY, ARRAY, ARRAY), inner=True)
def _switches_of(here, along_x, along_p, u):
    """The switches of contact of a motion.

    Parameters
    ----------
    here, along_x, along_p : arrays
        Packed parameters at a place (x, p), and what either axis adds to them there.
    u : (n,) array

    Returns
    -------
    zone : int
        Of contact at theta = 0: 1 front, 0 free, -1 back.
    switches : (k, SWITCHES) array
        By angle.
    """
    angles, zones = np.empty(2 * u.shape[0] + 8), np.empty(2 * u.shape[0] + 8, np.int64)
    count = contact_arcs(u, here[FRONT_GAP], here[BACK_GAP], angles, zones)
    switches = np.empty((count, SWITCHES))
    for i in range(count):
        before, after = zones[i - 1 if i > 0 else count - 1], zones[i]
        slot, flank = (FRONT_GAP, 1.0) if before + after > 0 else (BACK_GAP, -1.0)
        switches[i, ANGLE], switches[i, SENSE], switches[i, CONTACT_FLANK] = angles[i], abs(after) - abs(before), flank
        switches[i, LEVEL_X], switches[i, LEVEL_P] = flank * along_x[slot], flank * along_p[slot]
        switches[i, SLOPE] = displacement(u, angles[i])[1]
    return zones[max(count - 1, 0)], switches


@kernel(types.void(ARRAY, _F, ARRAY, _I), inner=True)
def _spread_slopes(switch, by_angle, row, unknowns):
    """Add to a row of a Jacobian over (u, ..., x, p) what a slope by the angle of one switch comes to."""
    rate, last = by_angle / switch[SLOPE], row.shape[0] - 1
    turn = complex(math.cos(switch[ANGLE]), math.sin(switch[ANGLE]))
    z = 1.0 + 0j
    row[0] -= rate
    for k in range(1, unknowns // 2 + 1):
        z *= turn
        row[2 * k - 1] -= rate * z.real
        row[2 * k] -= rate * z.imag
    row[last - 1] += rate * switch[LEVEL_X]
    row[last] += rate * switch[LEVEL_P]


@kernel(types.void(ARRAY, ARRAY, MATRIX), inner=True)
def _scaled_square(here, motion, square):
    """Fill in dE/du of the Galerkin balance, the rows of harmonic k divided by 1 + (k Omega/nu)^2."""
    n = square.shape[0]
    still, residual, part = np.zeros(here.shape[0]), np.empty(n), np.empty((n, n + 1))
    omega, _ = base_frequency(here, still, 0.0)
    _galerkin_rows(here, still, motion, residual, part)
    for i in range(n):
        rate = (i + 1) // 2 * omega
        for j in range(n):
            square[i, j] = part[i, j] / (1.0 + rate * rate)


@kernel(types.float64(ARRAY, ARRAY, ARRAY, ARRAY, ARRAY, MATRIX, ARRAY), inner=True)
def _static_determinant(parameters, here, along_x, along_p, motion, switches, gradient):
    """det dE/du of the Galerkin balance, rows scaled; fill in its gradient over (u, x, p).

    Rows of harmonic k are divided by 1 + (k Omega/nu)^2.
    """
    n = motion.shape[0] - 1
    still, period = np.zeros(here.shape[0]), int(here[PERIOD])
    omega, _ = base_frequency(here, still, 0.0)
    square, changed, dump = np.empty((n, n)), np.empty((n, n)), np.zeros(n)
    force, harmonics = np.empty(n), np.empty(n)
    _scaled_square(here, motion, square)
    for i in range(n):
        for j in range(n):
            changed[i, j] = square[i, j]
    value = eliminate(changed, dump)
    for j in range(n + 2):
        gradient[j] = 0.0
    for c in range(switches.shape[0]):
        angle, stiffness, largest = switches[c, ANGLE], 0.0, 0.0
        for l in range(1, int(here[STIFFNESSES]) + 1):
            turn = complex(math.cos(l * period * angle), math.sin(l * period * angle))
            stiffness += (stiffness_phasor(here, still, 0.0, l)[0] * turn).real
        for k in range(n // 2 + 1):
            (_, A, B, _), _ = impedance(here, still, 0.0, 1j * k * omega, 0j, 0 if k == 0 else -1)
            cosine, sine = math.cos(k * angle), math.sin(k * angle)
            row = (A + B * stiffness) * complex(cosine, -sine) / (1.0 + k * k * omega * omega)
            if k == 0:
                force[0], harmonics[0] = row.real, 1.0
            else:
                force[2 * k - 1], force[2 * k] = 2.0 * row.real, -2.0 * row.imag
                harmonics[2 * k - 1], harmonics[2 * k] = cosine, sine
            largest = max(largest, abs(row))
        if switches[c, CONTACT_FLANK] < 0.0:
            largest *= here[BACK_STIFFNESS]
            for i in range(n):
                force[i] *= here[BACK_STIFFNESS]
        factor = 1.0 / largest if largest > 0.0 else 1.0
        for i in range(n):
            for j in range(n):
                changed[i, j] = square[i, j] + factor * force[i] * harmonics[j]
        slope = (eliminate(changed, dump) - value) / factor
        _spread_slopes(switches[c], -switches[c, SENSE] * slope / _TURN, gradient, n)
    moved = np.empty(here.shape[0])
    for axis in range(2):
        along, step = (along_x, parameters[X_STEP]) if axis == 0 else (along_p, parameters[P_STEP])
        for side in (-1.0, 1.0):
            move_parameters(here, along, side * step, moved)
            _scaled_square(moved, motion, changed)
            gradient[n + axis] += side * eliminate(changed, dump) / (2.0 * step)
    return value


@kernel(types.UniTuple(_I, 2)(MATRIX), inner=True)
def _count_switches(switches):
    """Switches of contact at the front and at the back flank."""
    front = 0
    for c in range(switches.shape[0]):
        front += 1 if switches[c, CONTACT_FLANK] > 0.0 else 0
    return front, switches.shape[0] - front


@kernel(types.boolean(ARRAY, MATRIX, ARRAY), inner=True)
def _is_beyond(parameters, switches, residual):
    """Whether the motion has another contact than the one that the problem is confined to; the rows are nan then."""
    front, back = _count_switches(switches)
    if parameters[FRONT_CONTACT] < 0.0 or (front == parameters[FRONT_CONTACT] and back == parameters[BACK_CONTACT]):
        return False
    for i in range(residual.shape[0]):
        residual[i] = math.nan
    return True


@kernel(types.void(MATRIX, _I, MATRIX), inner=True)
def _copy_rows(part, column, jacobian):
    """Put the Jacobian (n, n + 1) of a balance over one axis into that of the plane, the axis in a column of it."""
    n = part.shape[0]
    for i in range(n):
        for j in range(n):
            jacobian[i, j] = part[i, j]
        if jacobian.shape[1] == n + 3:
            jacobian[i, n] = 0.0
        jacobian[i, column] = part[i, n]


@kernel(types.void(ARRAY, ARRAY, MATRIX, ARRAY, MATRIX), inner=True)
def _test_functions(parameters, motion, switches, values, gradient):
    """Size of the oscillation, and its gradient; for no event the switches of contact at either flank."""
    if parameters[EVENT] == 0.0:
        values[0], values[1] = _count_switches(switches)
        return
    size = 0.0
    for j in range(1, motion.shape[0] - 1):
        size += motion[j] * motion[j]
    values[0] = math.sqrt(size)
    for j in range(gradient.shape[1]):
        gradient[0, j] = 0.0
    for j in range(1, motion.shape[0] - 1):
        gradient[0, j] = motion[j] / values[0] if size > 0.0 else 0.0


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, ARRAY, _I, MATRIX, ARRAY, MATRIX), inner=True)
def _bifurcation_rows(parameters, here, along_x, along_p, y, zone, switches, residual, jacobian):
    """Fill in the row of a real multiplier, y = (u, x, p), or both of a Neimark-Sacker, y = (u, kappa, x, p)."""
    event, last = int(parameters[EVENT]), y.shape[0] - 1
    real = 0.0 if event == _NEIMARK_SACKER else -1.0 if event == _DOUBLING else 1.0
    number = 2 if real == 0.0 else 1
    n = last - number
    by_angle, by_axis = np.empty((2, switches.shape[0])), np.empty((2, 2))
    at = here, along_x, along_p
    values = bifurcation_test(parameters, *at, real, y[n], 0.0, zone, switches, by_angle, by_axis)
    for row in range(number):
        residual[n + row] = values[row]
        for j in range(n):
            jacobian[n + row, j] = 0.0
        jacobian[n + row, n] = values[2 + row]
        jacobian[n + row, last - 1], jacobian[n + row, last] = by_axis[row, 0], by_axis[row, 1]
        for c in range(switches.shape[0]):
            _spread_slopes(switches[c], by_angle[row, c], jacobian[n + row], n)


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))
def harmonic_rows(parameters, parameter_slope, y, values, gradient):
    """Rows and test functions of a problem: one kernel, as most of it takes seconds to compile.

    Where there is room for more than two values, the rows of the module. Otherwise the size of the oscillation and, for
    all but folds, det dE/du, which vanishes where the motion folds as well; for no event the switches of contact at the
    front and at the back flank.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Parameters at p = 0 and what p adds to them.
    y : (n + 2,) array
        (u, x, p).
    values, gradient : arrays
        Filled: (m,) and (m, n + 2).
    """
    here, along_x, along_p = parameters_at(parameters, parameter_slope, y)
    event, last = int(parameters[EVENT]), y.shape[0] - 1
    n = last - (2 if event == _NEIMARK_SACKER else 1)
    zone, switches = _switches_of(here, along_x, along_p, y[:n])
    motion = np.zeros(n + 1)
    for j in range(n):
        motion[j] = y[j]
    if values.shape[0] <= 2:
        _test_functions(parameters, motion, switches, values, gradient)
        if event != 0 and values.shape[0] == 2:
            if not (math.isfinite(y[last - 1]) and math.isfinite(y[last])):
                values[1] = math.nan
                return
            slopes = np.empty(n + 2)
            values[1] = _static_determinant(parameters, here, along_x, along_p, motion, switches, slopes)
            gradient[1, :] = 0.0
            for j in range(n):
                gradient[1, j] = slopes[j]
            gradient[1, last - 1], gradient[1, last] = slopes[n], slopes[n + 1]
        return
    if _is_beyond(parameters, switches, values):
        return
    part, margins, slopes = np.empty((n, n + 1)), np.empty(5), np.empty((5, n + 1))
    for axis in range(2):
        along = along_x if axis == 0 else along_p
        _galerkin_rows(here, along, motion, values[:n], part)
        _copy_rows(part, last - 1 + axis, gradient)
        if event in _GRAZED:
            _margins(here, along, motion, margins, slopes)
            values[n], gradient[n, n + axis] = margins[event - _FOLD], slopes[event - _FOLD, n]
    if event == _FOLD:
        values[n] = _static_determinant(parameters, here, along_x, along_p, motion, switches, gradient[n])
    elif event in _GRAZED:
        for j in range(n):
            gradient[n, j] = slopes[event - _FOLD, j]
    else:
        _bifurcation_rows(parameters, here, along_x, along_p, y, zone, switches, values, gradient)
