"""The first-order balance on the angles of contact, over two parameters, with the gradient of its Jacobian determinant.

Along a boundary the derivatives of the describing functions are not smooth: near a grazing they vary with the square
root of the margin, which stops Newton's method and makes second derivatives infinite. The square root is that of
1 - mu^2 with mu = (+-b - lambda_m)/lambda_a. With the angles of contact as unknowns of their own,

    lambda_a sin phi_f = b - lambda_m,    lambda_a sin phi_b = -b - lambda_m,    -pi/2 <= phi <= pi/2,

everything is a trigonometric polynomial in them (f front flank, the drive side; b back flank; docs/physics.md,
sections 4 and 5):

    f_0 = lambda_m + [(b - lambda_m) phi_f + lambda_a cos phi_f - (-b - lambda_m) phi_b - lambda_a cos phi_b]/pi
    N_a = 1 - [phi_f + sin phi_f cos phi_f - phi_b - sin phi_b cos phi_b]/pi

Of unequal gaps the front one stands in phi_f and the back one in phi_b. Without a back flank its terms are left out and
lambda_m - b has the factor 1/2: f_0 = (lambda_m - b)/2 + [(b - lambda_m) phi_f + lambda_a cos phi_f]/pi.

A flank is grazed where its angle is +-pi/2. Beyond, where the motion does not cross the flank, f_0 and N_a hold with
the angle clamped there, and the unknown measures the distance instead, with the size s of lambda:
+-b - lambda_m = +-[lambda_a + s (|phi| - pi/2)]. Each of the nine combinations (below, crossed, above for each flank)
is a smooth problem of its own, and the grazings are the walls between them.

The unknowns are y = (lambda_m, lambda_c, lambda_s, phi_f, phi_b, x, p) with the axes x and p. Kernels see the vectors
of `solver.boundaries.problem`; the balance reads the model's numbers among the parameters.
"""

import math

import numpy as np

from solver.boundaries.problem import parameters_at
from solver.harmonic.condensed import CONSTANTS, VALUES, coefficients, system_coefficients
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.model.parameters import BACK_CONTACT, FRONT_CONTACT, LENGTH_SCALE, gear_numbers

__all__ = [
    "BACK",
    "COEFFICIENTS",
    "FRONT",
    "TEST_COUNT",
    "P",
    "X",
    "angle_rows",
    "determinant",
    "plane_coefficients",
    "system_plane_coefficients",
]

# Slots of y.
FRONT, BACK, X, P = range(3, 7)

#: Test functions of a boundary: the amplitude, and on grazing curves det dE/du.
TEST_COUNT = 2

_THREE = types.UniTuple(types.float64, 3)
#: Coefficients of the balance, their derivatives by x and by p; then the same for its constants.
COEFFICIENTS = types.Tuple((types.UniTuple(VALUES, 3), types.UniTuple(CONSTANTS, 3)))
_RIGHT = 0.5 * math.pi


@kernel(COEFFICIENTS(ARRAY, ARRAY, ARRAY), inner=True, shared=True)
def plane_coefficients(parameters, parameter_slope, y):
    """What `solver.harmonic.condensed.coefficients` gives of a gear pair at (x, p), with the derivatives by both.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        As `solver.boundaries.problem.parameters_at` takes them.
    y : array
        Unknowns of the boundary, with x and p last.
    """
    here, along_x, along_p = parameters_at(parameters, parameter_slope, y)
    gear = gear_numbers(here, here)
    values, by_x, constants, constants_x = coefficients(gear, gear_numbers(here, along_x), 0.0)
    _, by_p, _, constants_p = coefficients(gear, gear_numbers(here, along_p), 0.0)
    return (values, by_x, by_p), (constants, constants_x, constants_p)


@kernel(COEFFICIENTS(ARRAY, ARRAY, ARRAY), inner=True, shared=True)
def system_plane_coefficients(parameters, parameter_slope, y):
    """`plane_coefficients` of a `ContactSystem`.

    Parameters
    ----------
    parameters, parameter_slope, y : arrays
        As there.
    """
    here, along_x, along_p = parameters_at(parameters, parameter_slope, y)
    values, by_x, constants, constants_x = system_coefficients(here, along_x, 0.0)
    _, by_p, _, constants_p = system_coefficients(here, along_p, 0.0)
    return (values, by_x, by_p), (constants, constants_x, constants_p)


@kernel(types.UniTuple(types.float64, 4)(types.float64, types.float64), inline=True)
def _clamped(zone, angle):
    """Angle, sine and cosine that the force feels, and 1 where it feels the angle at all."""
    if zone == 0.0:
        return angle, math.sin(angle), math.cos(angle), 1.0
    return zone * _RIGHT, zone, 0.0, 0.0


@kernel(_THREE(VALUES, CONSTANTS, types.float64, types.complex128, types.float64, types.complex128), inline=True)
def _rows(values, constants, mean, fundamental, place, displacement):
    """The part of (E_0, Re E_1, -Im E_1) that is linear in f_0, f_1, lambda_m and Lambda_1."""
    D, A, P_1, P_2, _, e = values
    row = D * displacement + A * fundamental + P_1 * mean + P_2 * fundamental.conjugate()
    force = constants[0] * mean + (e * fundamental.conjugate()).real + constants[4] * place
    return force, row.real, -row.imag


@kernel(types.void(COEFFICIENTS, ARRAY, ARRAY, ARRAY, MATRIX), inner=True, shared=True)
def angle_rows(known, parameters, y, residual, jacobian):
    """Balance and angles: fill the first five rows of residual and jacobian (., 7) at y (7,).

    Parameters
    ----------
    known : COEFFICIENTS
        From `plane_coefficients` at y.
    parameters : array
    y, residual, jacobian : arrays
    """
    (values, by_x, by_p), (constants, constants_x, constants_p) = known
    _, _, front_gap, back_gap, _, far = constants
    mean, displacement = y[0], complex(y[1], -y[2])
    amplitude = math.sqrt(y[1] * y[1] + y[2] * y[2])
    unit = displacement / amplitude
    front, front_sin, front_cos, front_on = _clamped(parameters[FRONT_CONTACT], y[FRONT])
    back, back_sin, back_cos, back_on = _clamped(parameters[BACK_CONTACT], y[BACK])
    ahead, behind, share = front_gap - mean, -back_gap - mean, 0.5 * (1.0 + far)

    f_0 = share * mean - 0.5 * (front_gap - far * back_gap)
    f_0 += (ahead * front + amplitude * front_cos - far * behind * back - far * amplitude * back_cos) / math.pi
    gain = share - (front + front_sin * front_cos - far * back - far * back_sin * back_cos) / math.pi
    f_1 = gain * displacement
    force = _rows(values, constants, f_0, f_1, mean, displacement)
    residual[0] = force[0] - constants[1]
    residual[1], residual[2] = force[1] - values[4].real, force[2] + values[4].imag

    f_0_a = (front_cos - far * back_cos) / math.pi
    for column in range(7):
        d_f_0, d_f_1, d_place, d_displacement = 0.0, 0j, 0.0, 0j
        if column == 0:
            d_f_0, d_place = share - (front - far * back) / math.pi, 1.0
        elif column == 1:
            d_f_0, d_f_1, d_displacement = f_0_a * unit.real, gain + 0j, 1.0 + 0j
        elif column == 2:
            d_f_0, d_f_1, d_displacement = -f_0_a * unit.imag, -1j * gain, -1j
        elif column == FRONT:
            d_f_0 = front_on * (ahead - amplitude * front_sin) / math.pi
            d_f_1 = -2.0 / math.pi * front_cos * front_cos * displacement
        elif column == BACK:
            d_f_0 = far * back_on * (amplitude * back_sin - behind) / math.pi
            d_f_1 = far * 2.0 / math.pi * back_cos * back_cos * displacement
        else:
            constant = constants_x if column == X else constants_p
            d_f_0 = (front * constant[2] + far * back * constant[3]) / math.pi
            d_f_0 -= 0.5 * (constant[2] - far * constant[3])
        change = _rows(values, constants, d_f_0, d_f_1, d_place, d_displacement)
        for i in range(3):
            jacobian[i, column] = change[i]
    for column in range(X, P + 1):
        slope, constant = (by_x, constants_x) if column == X else (by_p, constants_p)
        change = _rows(slope, constant, f_0, f_1, mean, displacement)
        jacobian[0, column] += change[0] - constant[1]
        jacobian[1, column] += change[1] - slope[4].real
        jacobian[2, column] += change[2] + slope[4].imag

    for row in range(3, 5):
        flank, gap = (1.0, 2) if row == FRONT else (-1.0, 3)
        sine, cosine = (front_sin, front_cos) if row == FRONT else (back_sin, back_cos)
        zone, reach = parameters[FRONT_CONTACT if row == FRONT else BACK_CONTACT], amplitude * sine
        slope = amplitude * cosine
        if zone != 0.0:
            slope = parameters[LENGTH_SCALE]
            reach += slope * (y[row] - zone * _RIGHT)
        residual[row] = reach - flank * constants[gap] + mean
        for column in range(7):
            jacobian[row, column] = 0.0
        jacobian[row, 0] = 1.0
        jacobian[row, 1], jacobian[row, 2] = sine * unit.real, -sine * unit.imag
        jacobian[row, row] = slope
        jacobian[row, X], jacobian[row, P] = -flank * constants_x[gap], -flank * constants_p[gap]


@kernel(
    types.void(
        VALUES, CONSTANTS, types.float64, types.complex128, types.float64, types.complex128, MATRIX, types.int64
    ),
    inline=True,
)
def _put(values, constants, mean, fundamental, place, displacement, matrix, column):
    """Write one column of dE/du or of its derivative."""
    change = _rows(values, constants, mean, fundamental, place, displacement)
    for i in range(3):
        matrix[i, column] = change[i]


@kernel(types.float64(MATRIX, MATRIX), inline=True)
def _contract(left, right):
    """Sum of the products of the entries of two 3 x 3 matrices."""
    total = 0.0
    for i in range(3):
        for j in range(3):
            total += left[i, j] * right[i, j]
    return total


@kernel(types.float64(COEFFICIENTS, ARRAY, ARRAY, ARRAY, MATRIX), inner=True, shared=True)
def determinant(known, parameters, y, gradient, square):
    """det dE/du, its derivatives by y, and dE/du itself.

    Along the direction (v_m, V), V = v_c - i v_s, of u the balance feels, with v_a = Re(conj(unit) V),

        d f_0 = n_0 v_m + g_0 v_a,    d f_1 = N_a V + unit (q_m v_m + q_a v_a),
        n_0 = 1 - (phi_f - phi_b)/pi,    g_0 = (cos phi_f - cos phi_b)/pi,
        q_m = 2 g_0,    q_a = (sin 2 phi_f - sin 2 phi_b)/pi,

    so that dE/du depends on y through the angles, the direction unit = Lambda_1/lambda_a and the coefficients alone.
    The determinant's derivatives follow from Jacobi's formula, d det J = sum cofactor_ij dJ_ij.

    Parameters
    ----------
    known : COEFFICIENTS
        From `plane_coefficients` at y.
    parameters : array
    y : (7,) array
    gradient : (7,) array
        Filled with the derivatives by y.
    square : (3, 3) array
        Filled with dE/du.
    """
    (values, by_x, by_p), (constants, constants_x, constants_p) = known
    displacement = complex(y[1], -y[2])
    amplitude = math.sqrt(y[1] * y[1] + y[2] * y[2])
    unit = displacement / amplitude
    front, front_sin, front_cos, front_on = _clamped(parameters[FRONT_CONTACT], y[FRONT])
    back, back_sin, back_cos, back_on = _clamped(parameters[BACK_CONTACT], y[BACK])
    far = constants[5]
    share = 0.5 * (1.0 + far)
    n_0, g_0 = share - (front - far * back) / math.pi, (front_cos - far * back_cos) / math.pi
    q_m, q_a = 2.0 * g_0, 2.0 / math.pi * (front_sin * front_cos - far * back_sin * back_cos)
    gain = share - (front + front_sin * front_cos - far * back - far * back_sin * back_cos) / math.pi

    # d f_0 and d f_1 along lambda_m, lambda_c and lambda_s; Lambda_1 itself moves by 0, 1 and -i.
    d_f_0 = (n_0, g_0 * unit.real, -g_0 * unit.imag)
    d_f_1 = (q_m * unit, gain + q_a * unit.real * unit, -1j * gain - q_a * unit.imag * unit)
    places, moves = (1.0, 0.0, 0.0), (0j, 1.0 + 0j, -1j)
    for column in range(3):
        _put(values, constants, d_f_0[column], d_f_1[column], places[column], moves[column], square, column)

    cofactor, change = np.empty((3, 3)), np.empty((3, 3))
    for i in range(3):
        i_1, i_2 = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            j_1, j_2 = (j + 1) % 3, (j + 2) % 3
            cofactor[i, j] = square[i_1, j_1] * square[i_2, j_2] - square[i_1, j_2] * square[i_2, j_1]

    gradient[0] = 0.0
    for slot in range(1, 3):
        # Along lambda_c and lambda_s the unit vector turns.
        turn = 1j * unit * (unit.conjugate() * moves[slot]).imag / amplitude
        for column in range(3):
            along, along_turn = (unit.conjugate() * moves[column]).real, (turn.conjugate() * moves[column]).real
            v_m = 1.0 if column == 0 else 0.0
            d_d_f_1 = turn * (q_m * v_m + q_a * along) + unit * q_a * along_turn
            _put(values, constants, g_0 * along_turn, d_d_f_1, 0.0, 0j, change, column)
        gradient[slot] = _contract(cofactor, change)
    for slot in range(FRONT, BACK + 1):
        sign, sine, cosine = (front_on, front_sin, front_cos) if slot == FRONT else (-far * back_on, back_sin, back_cos)
        d_n_0, d_g_0, d_gain = -sign / math.pi, -sign * sine / math.pi, -sign * 2.0 / math.pi * cosine * cosine
        d_q_m, d_q_a = 2.0 * d_g_0, sign * 2.0 / math.pi * (cosine * cosine - sine * sine)
        for column in range(3):
            along = (unit.conjugate() * moves[column]).real
            v_m = 1.0 if column == 0 else 0.0
            d_d_f_1 = d_gain * moves[column] + unit * (d_q_m * v_m + d_q_a * along)
            _put(values, constants, d_n_0 * v_m + d_g_0 * along, d_d_f_1, 0.0, 0j, change, column)
        gradient[slot] = _contract(cofactor, change)
    for slot in range(X, P + 1):
        slope, constant = (by_x, constants_x) if slot == X else (by_p, constants_p)
        for column in range(3):
            _put(slope, constant, d_f_0[column], d_f_1[column], places[column], moves[column], change, column)
        gradient[slot] = _contract(cofactor, change)
    return square[0, 0] * cofactor[0, 0] + square[0, 1] * cofactor[0, 1] + square[0, 2] * cofactor[0, 2]
