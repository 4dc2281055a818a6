"""Period doublings and Neimark-Sackers as extra rows of a curve problem: test functions of the monodromy matrix.

With P(z) = det(z I - M), a period doubling is P(-1) = det(M + I) = 0. A pair of multipliers exp(+-i phi) on the unit
circle are the roots of z^2 - 2 kappa z + 1, kappa = cos phi, so that the remainder r_0 + r_1 z of P on division by it
vanishes: two rows for one more unknown, kappa (the squared system of Kuznetsov, Elements of Applied Bifurcation Theory,
section 10.2, and Govaerts, section 4, on the characteristic polynomial). r_0 and r_1 are polynomials in kappa and the
entries of M, hence regular through kappa = 1 and kappa = -1, where the pair meets on the real axis: the resonances 1:1
and 1:2. Beyond, it is a real pair of product 1, which is no bifurcation.

M depends on the motion through the angles of contact alone. A contact that begins (sigma = 1) or ends (-1) at theta_c,
tau_c = theta_c nu/Omega, changes M by a matrix of rank one,

    dM = sigma (nu/Omega) [Phi(T, tau_c) (0, M^-1 (h + s h_v))] [w Phi(tau_c, 0)] dtheta_c
    dtheta_c = (d level - d lambda)/lambda'(theta_c)

and a determinant is affine along such a change, so that its slope is one difference of any length: exact. Only what
the axes change with the angles held takes central differences. lambda' vanishes where the motion grazes a flank: there
gradients are infinite, and curves have corners.
"""

import math

import numpy as np
from numba import types

from solver.boundaries.problem import EVENT, P_STEP, X_STEP
from solver.contact.spectrum import contact_arcs, displacement
from solver.continuation.continuation import Event
from solver.flow.switched_system import FREQUENCY, count_degrees, new_system, system_at
from solver.flow.taylor import carry_deviations, count_blocks, new_series
from solver.harmonic.layout import BACK, FRONT, OMEGA, PERIOD, STIFFNESSES
from solver.kernels.compile import ARRAY, MATRIX, kernel

__all__ = [
    "ANGLE",
    "FLANK",
    "SENSE",
    "bifurcation_rows",
    "characteristic_remainder",
    "move_parameters",
    "spread_slopes",
    "switches_of",
]

_I, _F, _B = types.int64, types.float64, types.boolean
_DOUBLING = int(Event.PERIOD_DOUBLING)
_TURN = 2.0 * math.pi

#: Columns of the switches of contact: angle, sigma, flank (1 front, -1 back), how the level of lambda there moves along
#: x and p, and d lambda/d theta.
ANGLE, SENSE, FLANK, LEVEL_X, LEVEL_P, SLOPE, SWITCHES = range(7)


@kernel(types.Tuple((_B, MATRIX))(ARRAY, ARRAY, ARRAY, ARRAY), inner=True)
def switches_of(here, along_x, along_p, u):
    """The switches of contact of a motion.

    Parameters
    ----------
    here, along_x, along_p : arrays
        Packed parameters at a place (x, p), and what either axis adds to them there.
    u : (n,) array

    Returns
    -------
    closed : bool
        Whether there is contact at theta = 0.
    switches : (k, SWITCHES) array
        By angle.
    """
    angles, zones = np.empty(2 * u.shape[0] + 8), np.empty(2 * u.shape[0] + 8, np.int64)
    count = contact_arcs(u, here[FRONT], here[BACK], angles, zones)
    found, k = np.empty((count, SWITCHES)), 0
    for i in range(count):
        before, after = zones[i - 1 if i > 0 else count - 1], zones[i]
        # From one flank to the other at once, as without backlash, is no switch.
        if abs(after) == abs(before):
            continue
        slot, flank = (FRONT, 1.0) if before + after > 0 else (BACK, -1.0)
        found[k, ANGLE], found[k, SENSE], found[k, FLANK] = angles[i], abs(after) - abs(before), flank
        found[k, LEVEL_X], found[k, LEVEL_P] = flank * along_x[slot], flank * along_p[slot]
        found[k, SLOPE] = displacement(u, angles[i])[1]
        k += 1
    return zones[max(count - 1, 0)] != 0, found[:k]


@kernel(types.void(ARRAY, _F, ARRAY, _I), inner=True)
def spread_slopes(switch, by_angle, row, unknowns):
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


@kernel(types.void(MATRIX), inner=True)
def _reduce(matrix):
    """Make a matrix upper Hessenberg by similarity, with elimination and pivoting."""
    n = matrix.shape[0]
    for k in range(1, n - 1):
        pivot = k
        for i in range(k + 1, n):
            if abs(matrix[i, k - 1]) > abs(matrix[pivot, k - 1]):
                pivot = i
        if matrix[pivot, k - 1] == 0.0:
            continue
        if pivot != k:
            for j in range(n):
                matrix[k, j], matrix[pivot, j] = matrix[pivot, j], matrix[k, j]
            for i in range(n):
                matrix[i, k], matrix[i, pivot] = matrix[i, pivot], matrix[i, k]
        for i in range(k + 1, n):
            factor = matrix[i, k - 1] / matrix[k, k - 1]
            for j in range(k - 1, n):
                matrix[i, j] -= factor * matrix[k, j]
            for j in range(n):
                matrix[j, k] += factor * matrix[j, i]


@kernel(types.UniTuple(_F, 4)(MATRIX, _F), inner=True)
def characteristic_remainder(matrix, kappa):
    """Remainder r_0 + r_1 z of det(z I - M) on division by z^2 - 2 kappa z + 1, and its derivative by kappa.

    Parameters
    ----------
    matrix : (n, n) array
        M; overwritten.
    kappa : float

    Returns
    -------
    r_0, r_1, d_r_0, d_r_1 : float

    Notes
    -----
    The recurrence of La Budde for the leading minors of a Hessenberg matrix (R. Rehman and I. C. F. Ipsen, SIAM J.
    Matrix Anal. Appl. 32 (2011) 90-114), every minor reduced by z^2 = 2 kappa z - 1: it neither divides nor needs the
    coefficients of P.
    """
    n = matrix.shape[0]
    _reduce(matrix)
    # a + b z, and its derivative by kappa.
    p = np.zeros((n + 1, 4))
    p[0, 0] = 1.0
    for k in range(1, n + 1):
        h, (a, b, d_a, d_b) = matrix[k - 1, k - 1], (p[k - 1, 0], p[k - 1, 1], p[k - 1, 2], p[k - 1, 3])
        p[k, 0], p[k, 1] = -h * a - b, a + (2.0 * kappa - h) * b
        p[k, 2], p[k, 3] = -h * d_a - d_b, d_a + (2.0 * kappa - h) * d_b + 2.0 * b
        product = 1.0
        for i in range(1, k):
            product *= matrix[k - i, k - i - 1]
            for j in range(4):
                p[k, j] -= matrix[k - 1 - i, k - 1] * product * p[k - 1 - i, j]
    return p[n, 0], p[n, 1], p[n, 2], p[n, 3]


@kernel(types.UniTuple(_F, 4)(MATRIX, _B, _F), inner=True)
def _tested(matrix, doubling, kappa):
    """The test functions, and their derivatives by kappa; `matrix` is overwritten."""
    r_0, r_1, d_r_0, d_r_1 = characteristic_remainder(matrix, kappa)
    return (r_0 - r_1, 0.0, 0.0, 0.0) if doubling else (r_0, r_1, d_r_0, d_r_1)


@kernel(_I(ARRAY), inner=True)
def _states(here):
    """2n, the number of multipliers of a motion."""
    return 2 * count_degrees(here, np.zeros(here.shape[0]), 0.0)


@kernel(_B(ARRAY, _B, MATRIX, MATRIX, MATRIX, MATRIX), inner=True)
def _carry(here, closed, switches, matrix, columns, rows):
    """Fill in M (2n, 2n), and the columns and rows (k, 2n) by which the first k switches change it; False if they are
    not finite."""
    size, count = matrix.shape[0], columns.shape[0]
    n = size // 2
    still, period = np.zeros(here.shape[0]), here[PERIOD]
    if _states(here) != size:
        return False
    system = new_system(n, int(here[STIFFNESSES]))
    system_at(here, still, 0.0, system)
    vectors = system.vectors
    series, states = new_series(n, size + count), np.zeros((count_blocks(size + count), size, 4))
    for i in range(size):
        states[i // 4, i, i % 4] = 1.0
    scale = period / system.numbers[FREQUENCY]
    begin, zone = 0.0, 1 if closed else 0
    for c in range(switches.shape[0] + 1):
        end = switches[c, ANGLE] if c < switches.shape[0] else _TURN
        if end > begin and not carry_deviations(system, zone, begin * scale, end * scale, states, series):
            return False
        if c == switches.shape[0]:
            break
        begin, zone = end, 1 if switches[c, SENSE] > 0.0 else 0
        if c >= count:
            continue
        stiffness = 0.0
        for l in range(system.variation.shape[0]):
            angle = (l + 1) * period * end
            stiffness += system.variation[l, 0] * math.cos(angle) - system.variation[l, 1] * math.sin(angle)
        block, column = (size + c) // 4, (size + c) % 4
        for i in range(n):
            states[block, n + i, column] = vectors[1, i] + stiffness * vectors[2, i]
        for j in range(size):
            rows[c, j] = 0.0
            for i in range(n):
                rows[c, j] += vectors[0, i] * states[j // 4, i, j % 4]
    for i in range(size):
        for j in range(size):
            matrix[i, j] = states[j // 4, i, j % 4]
        for c in range(count):
            columns[c, i] = states[(size + c) // 4, i, (size + c) % 4]
    return True


@kernel(types.void(ARRAY, ARRAY, _F, ARRAY), inner=True)
def move_parameters(here, along, step, moved):
    """Fill in the parameters a step further along an axis; the gaps, and with them the angles of contact, stay."""
    for i in range(here.shape[0]):
        moved[i] = here[i] + step * along[i]
    moved[FRONT], moved[BACK] = here[FRONT], here[BACK]


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, ARRAY, _B, MATRIX, ARRAY, MATRIX), inner=True)
def bifurcation_rows(theta, here, along_x, along_p, y, closed, switches, residual, jacobian):
    """Fill in the rows behind the n rows of a balance.

    One row for a period doubling, y = (u, x, p); two for a Neimark-Sacker, y = (u, kappa, x, p).

    Parameters
    ----------
    theta : array
        Of `solver.boundaries.problem`.
    here, along_x, along_p : arrays
        `parameters_at` y, of `solver.harmonic.layout.packed`.
    y : (n + 2,) or (n + 3,) array
    closed, switches
        Of the motion; see `switches_of`.
    residual : (n + 1,) or (n + 2,) array
    jacobian : (n + 1, n + 2) or (n + 2, n + 3) array
    """
    doubling, last = int(theta[EVENT]) == _DOUBLING, y.shape[0] - 1
    number = 1 if doubling else 2
    n = last - number
    kappa = -1.0 if doubling else y[n]
    size, count = _states(here), switches.shape[0]
    matrix, changed = np.empty((size, size)), np.empty((size, size))
    columns, rows = np.empty((count, size)), np.empty((count, size))
    if not _carry(here, closed, switches, matrix, columns, rows):
        for row in range(number):
            residual[n + row] = math.nan
        return
    largest = 0.0
    for i in range(size):
        for j in range(size):
            changed[i, j] = matrix[i, j]
            largest = max(largest, abs(matrix[i, j]))
    value = _tested(changed, doubling, kappa)
    for row in range(number):
        residual[n + row] = value[row]
        for j in range(last + 1):
            jacobian[n + row, j] = 0.0
        if not doubling:
            jacobian[n + row, n] = value[2 + row]
    for c in range(count):
        reach, width = 0.0, 0.0
        for i in range(size):
            reach, width = max(reach, abs(columns[c, i])), max(width, abs(rows[c, i]))
        if reach == 0.0 or width == 0.0:
            continue
        share = largest / (reach * width)
        for i in range(size):
            for j in range(size):
                changed[i, j] = matrix[i, j] + share * columns[c, i] * rows[c, j]
        moved = _tested(changed, doubling, kappa)
        factor = switches[c, SENSE] * here[PERIOD] / (here[OMEGA] * share)
        for row in range(number):
            spread_slopes(switches[c], factor * (moved[row] - value[row]), jacobian[n + row], n)
    beyond, nothing = np.empty(here.shape[0]), np.empty((0, size))
    for axis in range(2):
        along, step = (along_x, theta[X_STEP]) if axis == 0 else (along_p, theta[P_STEP])
        for side in (-1.0, 1.0):
            move_parameters(here, along, side * step, beyond)
            whole = _carry(beyond, closed, switches, changed, nothing, nothing)
            moved = _tested(changed, doubling, kappa)
            # Where a coupling vanishes the system has fewer coordinates, and no slope.
            weight = side / (2.0 * step) if whole else math.nan
            for row in range(number):
                jacobian[n + row, last - 1 + axis] += weight * moved[row]
