"""Bifurcations as extra rows of a curve problem: test functions of the monodromy matrix.

With P(z) = det(z I - M), a period doubling is P(-1) = det(M + I) = 0, and a multiplier passes +1 where P(1) = 0. A pair
of multipliers exp(+-i phi) on the unit circle are the roots of z^2 - 2 kappa z + 1, kappa = cos phi, so that the
remainder r_0 + r_1 z of P on division by it vanishes: two rows for one more unknown, kappa. This is the squared system
for Neimark-Sackers (W. J. F. Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria, SIAM 2000; Y. A.
Kuznetsov, Elements of Applied Bifurcation Theory, Springer 2004) on the characteristic polynomial. r_0 and r_1 are
polynomials in kappa and the entries of M, hence regular through kappa = 1 and kappa = -1, where the pair meets on the
real axis: the resonances 1:1 and 1:2. Beyond, it is a real pair of product 1, which is no bifurcation.

M depends on the motion through the angles of contact alone. A contact that begins (sigma = 1) or ends (-1) at theta_c,
tau_c = theta_c nu/Omega, changes M by a matrix of rank one,

    dM = sigma (nu/Omega) [Phi(T, tau_c) (v, r M^-1 (h + s h_v) - D v)] [w Phi(tau_c, 0)] dtheta_c,  v = r c_c M^-1 h
    dtheta_c = (d level - d lambda)/lambda'(theta_c)

(r is 1 at the front flank and D that of the zone behind the switch; v is what a damper of touching teeth makes of it)
and a determinant is affine along such a change, so that its slope is one difference of any length: exact. Only what
the axes change with the angles held takes central differences. lambda' vanishes where the motion grazes a flank: there
gradients are infinite, and curves have corners.
"""

import math

import numpy as np
from numpy.polynomial import chebyshev

from solver.continuation.continuation import Problem
from solver.flow.deviations import carry_deviations, change_contact, count_blocks, new_block_series
from solver.flow.switched_system import (
    DASHPOT,
    FREQUENCY,
    NUMBERS,
    SWITCHED_SYSTEM,
    count_degrees,
    new_system,
    strength_of,
    system_at,
)
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.model.parameters import BACK_GAP, FRONT_GAP, MESH_FREQUENCY, P_STEP, PERIOD, STIFFNESSES, X_STEP
from solver.stability.multipliers import hessenberg

__all__ = [
    "ANGLE",
    "CONTACT_FLANK",
    "SENSE",
    "bifurcation_test",
    "characteristic_remainder",
    "critical_cosines",
    "move_parameters",
]

_I, _F, _B = types.int64, types.float64, types.boolean
_TURN = 2.0 * math.pi

#: Columns of the switches of contact: angle theta_c, sigma, 1 where contact begins and -1 where it ends, and the flank,
#: 1 front and -1 back.
ANGLE, SENSE, CONTACT_FLANK = range(3)

# Degree of the test functions in kappa, for seven coordinates; by how much, as a share of their size, they may miss 0
# at a start of a Neimark-Sacker.
_DEGREE, _CRITICAL = 7, 1e-4


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
    The recurrence of La Budde for the leading minors of a Hessenberg matrix (R. Rehman, I. C. F. Ipsen, "La Budde's
    method for computing characteristic polynomials", arXiv:1104.3769, 2011), every minor reduced by
    z^2 = 2 kappa z - 1: it neither divides nor needs the coefficients of P.
    """
    n = matrix.shape[0]
    hessenberg(matrix, n)
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


@kernel(types.UniTuple(_F, 4)(MATRIX, _F, _F), inner=True)
def _tested(matrix, real, kappa):
    """The test functions, and their derivatives by kappa; `matrix` is overwritten."""
    r_0, r_1, d_r_0, d_r_1 = characteristic_remainder(matrix, kappa if real == 0.0 else real)
    return (r_0, r_1, d_r_0, d_r_1) if real == 0.0 else (r_0 + real * r_1, 0.0, 0.0, 0.0)


@kernel(_B(ARRAY, SWITCHED_SYSTEM), inner=True)
def _fill_system(here, system):
    """Fill in the system of a place; False if it has another number of coordinates."""
    still = np.zeros(here.shape[0])
    if count_degrees(here, still, 0.0) != system.vectors.shape[1]:
        return False
    system_at(here, still, 0.0, system)
    return True


@kernel(_B(MATRIX, MATRIX), inner=True)
def _equal(left, right):
    """Whether two matrices of one size hold the same numbers."""
    for i in range(left.shape[0]):
        for j in range(left.shape[1]):
            if left[i, j] != right[i, j]:
                return False
    return True


@kernel(_B(SWITCHED_SYSTEM, SWITCHED_SYSTEM), inner=True)
def _alike(left, right):
    """Whether deviations obey the same equations in two systems of one size."""
    numbers = left.numbers.reshape(1, NUMBERS), right.numbers.reshape(1, NUMBERS)
    matrices, vectors = _equal(left.matrices, right.matrices), _equal(left.vectors, right.vectors)
    return matrices and vectors and _equal(*numbers) and _equal(left.variation, right.variation)


@kernel(_B(SWITCHED_SYSTEM, _F, _F, _I, MATRIX, MATRIX, MATRIX, MATRIX), inner=True)
def _carry(system, period, start, zone, switches, matrix, columns, rows):
    """Fill in M (2n, 2n) from an angle on, and the columns and rows (k, 2n) by which the first k switches change it;
    False if they are not finite, or a switch is out of the period by more than a turn."""
    size, count = matrix.shape[0], columns.shape[0]
    n, vectors = size // 2, system.vectors
    for c in range(switches.shape[0]):
        # A corrector that is lost may ask for any angle: the motion is carried there and all the way back.
        if not -_TURN <= switches[c, ANGLE] - start <= 2.0 * _TURN:
            return False
    series, states = new_block_series(n, size + count), np.zeros((count_blocks(size + count), size, 4))
    for i in range(size):
        states[i // 4, i, i % 4] = 1.0
    scale, none = period / system.numbers[FREQUENCY], np.empty(0)
    # Contacts at once: two where one begins and another ends at the same angle.
    begin, front, back = start, 1.0 if zone > 0 else 0.0, 1.0 if zone < 0 else 0.0
    for c in range(switches.shape[0] + 1):
        end = switches[c, ANGLE] if c < switches.shape[0] else start + _TURN
        # The series are not asked how far they reach backwards; one unit of time is less than that.
        parts = 1 if end > begin else int(math.ceil((begin - end) * scale))
        for part in range(parts):
            left, right = begin + (end - begin) * part / parts, begin + (end - begin) * (part + 1) / parts
            if not carry_deviations(system, zone, left * scale, right * scale, none, states, series):
                return False
        if c == switches.shape[0]:
            break
        flank = 1 if switches[c, CONTACT_FLANK] > 0.0 else -1
        if flank > 0:
            front += switches[c, SENSE]
        else:
            back += switches[c, SENSE]
        before, begin, zone = zone, end, 1 if front > 0.0 else (-1 if back > 0.0 else 0)
        change_contact(system, before, zone, states)
        if c >= count:
            continue
        stiffness = 0.0
        for l in range(system.variation.shape[0]):
            angle = (l + 1) * period * end
            stiffness += system.variation[l, 0] * math.cos(angle) - system.variation[l, 1] * math.sin(angle)
        block, column = (size + c) // 4, (size + c) % 4
        strength = strength_of(system, flank)
        dashpot, damping = strength * system.numbers[DASHPOT], 3 * n + n * (zone % 3)
        for i in range(n):
            value = strength * (vectors[1, i] + stiffness * vectors[2, i])
            if dashpot != 0.0:
                states[block, i, column] = dashpot * vectors[1, i]
                for j in range(n):
                    value -= dashpot * system.matrices[damping + i, j] * vectors[1, j]
            states[block, n + i, column] = value
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
    """Fill in the parameters a step further along an axis; the gaps, and with them the angles of contact, stay.

    Parameters
    ----------
    here, along : arrays
        Parameters, and what an axis adds to them.
    step : float
        How far along the axis.
    moved : array
        Filled with the parameters there.
    """
    for i in range(here.shape[0]):
        moved[i] = here[i] + step * along[i]
    moved[FRONT_GAP], moved[BACK_GAP] = here[FRONT_GAP], here[BACK_GAP]


@kernel(
    types.UniTuple(_F, 4)(ARRAY, ARRAY, ARRAY, ARRAY, _F, _F, _F, _I, MATRIX, MATRIX, MATRIX), inner=True, shared=True
)
def bifurcation_test(parameters, here, along_x, along_p, real, kappa, start, zone, switches, by_angle, by_axis):
    """The test functions of a motion, and how they change.

    Parameters
    ----------
    parameters : array
        Of `solver.boundaries.problem`: holds the steps of differences.
    here, along_x, along_p : arrays
        `parameters_at` a place (x, p), of `solver.model.packing.packed`.
    real : float
        The real multiplier that is tested for, -1 (period doubling) or 1; 0 for the pair of a Neimark-Sacker.
    kappa : float
        Of the pair.
    start : float
        Angle at which the period starts; the multipliers do not depend on it.
    zone : int
        Of contact at the start: 1 front, 0 free, -1 back.
    switches : (k, at least 3) array
        ANGLE, SENSE and CONTACT_FLANK of every switch of contact, in order. One that lies before the last, by less than
        a time of order 1, is gone back to: the functions go on smoothly where two have just passed each other.
    by_angle : (2, k) array
        Filled with the derivatives by the angles.
    by_axis : (2, 2) array
        Filled with the derivatives by x and by p, the angles held.

    Returns
    -------
    values, by_kappa : 2 floats each
        Of a real multiplier the first value counts. nan where M is not finite, or a switch is out of the period by more
        than a turn.
    """
    degrees, stiffnesses = count_degrees(here, np.zeros(here.shape[0]), 0.0), int(here[STIFFNESSES])
    system, size, count = new_system(degrees, stiffnesses), 2 * degrees, switches.shape[0]
    matrix, changed = np.empty((size, size)), np.empty((size, size))
    columns, rows = np.empty((count, size)), np.empty((count, size))
    if not (_fill_system(here, system) and _carry(system, here[PERIOD], start, zone, switches, matrix, columns, rows)):
        return math.nan, math.nan, math.nan, math.nan
    largest = 0.0
    for i in range(size):
        for j in range(size):
            changed[i, j] = matrix[i, j]
            largest = max(largest, abs(matrix[i, j]))
    value = _tested(changed, real, kappa)
    for c in range(count):
        reach, width = 0.0, 0.0
        for i in range(size):
            reach, width = max(reach, abs(columns[c, i])), max(width, abs(rows[c, i]))
        weight = largest / (reach * width) if reach * width > 0.0 else 1.0
        for i in range(size):
            for j in range(size):
                changed[i, j] = matrix[i, j] + weight * columns[c, i] * rows[c, j]
        moved = _tested(changed, real, kappa)
        factor = switches[c, SENSE] * here[PERIOD] / (here[MESH_FREQUENCY] * weight)
        by_angle[0, c], by_angle[1, c] = factor * (moved[0] - value[0]), factor * (moved[1] - value[1])
    beyond, nothing = np.empty(here.shape[0]), np.empty((0, size))
    further = new_system(degrees, stiffnesses)
    for axis in range(2):
        along, step = (along_x, parameters[X_STEP]) if axis == 0 else (along_p, parameters[P_STEP])
        by_axis[0, axis], by_axis[1, axis] = 0.0, 0.0
        move_parameters(here, along, -step, beyond)
        whole = _fill_system(beyond, system)
        move_parameters(here, along, step, beyond)
        # Where a coupling vanishes the system has fewer coordinates, and no slope.
        whole &= _fill_system(beyond, further)
        # Deviations feel neither a load nor, with the angles held, the gaps.
        if whole and _alike(system, further):
            continue
        for side in (-1.0, 1.0):
            moved_system = system if side < 0.0 else further
            whole = whole and _carry(moved_system, here[PERIOD], start, zone, switches, changed, nothing, nothing)
            moved = _tested(changed, real, kappa)
            weight = side / (2.0 * step) if whole else math.nan
            by_axis[0, axis] += weight * moved[0]
            by_axis[1, axis] += weight * moved[1]
    return value


def critical_cosines(problem: Problem, y: np.ndarray) -> list[float]:
    """kappa of the pairs of multipliers next to the unit circle, the nearest first.

    Parameters
    ----------
    problem : Problem
        Of a Neimark-Sacker.
    y : (..., kappa, x, p) array
        A motion; its kappa does not matter.
    """

    def remainder(kappa: float) -> np.ndarray:
        here = y.copy()
        here[-3] = kappa
        return problem.evaluated(here)[0][-2:]

    nodes = chebyshev.chebpts1(_DEGREE + 1)
    values = np.array([remainder(kappa) for kappa in nodes])
    size = np.max(np.abs(values))
    if not np.isfinite(size):
        return []
    # Both polynomials vanish there; one of them may do so twice.
    roots = [
        chebyshev.chebroots(chebyshev.chebtrim(c, 1e-12 * size)) for c in chebyshev.chebfit(nodes, values, _DEGREE).T
    ]
    roots = np.concatenate(roots)
    near = np.unique(np.clip(roots.real[np.abs(roots.imag) < _CRITICAL], -1.0, 1.0))
    misses = np.array([np.max(np.abs(remainder(kappa))) for kappa in near])
    return near[np.argsort(misses, kind="stable")][np.sort(misses) < _CRITICAL * size].tolist()
