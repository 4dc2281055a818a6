"""First-order balance with describing functions on the condensed mesh coordinate.

Unknowns (lambda_m, lambda_c, lambda_s) with lambda = lambda_m + lambda_c cos(Omega tau) + lambda_s sin(Omega tau), that
is Lambda_1 = lambda_c - i lambda_s. f is truncated to its mean f_0 and fundamental f_1 = N_a Lambda_1 *before* it is
multiplied by the stiffness ("describing function", docs/physics.md, section 4). With S_l = alpha_l exp(i Phi_kl):

    E_0 = c (f_0 + eps_r Re(S_1 conj f_1)/2) - f_pm
    E_1 = D Lambda_1 + (c - T) f_1 + (c eps_r - T eps_t)(S_1 f_0 + S_2 conj(f_1)/2) - F_1
    D = -Omega^2 + 2i Omega (c xi_h - U),    F_1 = f_pv + f_e Omega^2 exp(i Phi_1)

The rows are (E_0, Re E_1, -Im E_1), for which a statically stable solution has a positive Jacobian determinant.
Harmonics of the stiffness above the second and of the transmission error above the first do not reach this balance.
"""

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from solver.contact.dead_zone import describing_functions
from solver.continuation.problem import Problem
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import eliminate
from solver.model.checks import ParameterError, finite_array, finite_number, frequency, instance_of, number_array
from solver.model.condensation import mesh_receptance, phasor, rotation_coupling
from solver.model.gear_model import Model
from solver.model.packing import axis_vectors, check_axis
from solver.model.parameters import (
    ALPHA,
    ALPHA_2,
    F_E,
    F_PM,
    F_PV,
    OMEGA,
    VARIATION_R,
    VARIATION_T,
    XI_MESH,
    B,
    number_at,
)

__all__ = [
    "DescribingFunction",
    "residual_and_jacobian",
    "coefficients",
    "evaluate",
    "first_order_problem",
    "linear_degree",
    "linear_solution",
    "test_functions",
]


_C, _F = types.UniTuple(types.complex128, 6), types.UniTuple(types.float64, 3)


@kernel(types.Tuple((_C, _C, _F, _F))(ARRAY, ARRAY, types.float64), inner=True, shared=True)
def coefficients(parameters, parameter_slope, p):
    """The numbers that the balance depends on at one axis value, and their derivatives along the axis.

    Parameters
    ----------
    parameters, parameter_slope : (34,) arrays
    p : float
        Axis value.

    Returns
    -------
    values, d_values : 6 complex numbers each
        D, c - T, P_1 = (c eps_r - T eps_t) S_1, P_2 = (c eps_r - T eps_t) S_2/2, F_1 and e = c eps_r S_1/2.
    constants, d_constants : 3 floats each
        c, f_pm and b.
    """
    omega, d_omega = number_at(parameters, parameter_slope, p, OMEGA)
    T, U, d_T, d_U = mesh_receptance(parameters, parameter_slope, p, 1j * omega, 1j * d_omega)
    c, d_c = rotation_coupling(parameters, parameter_slope, p)
    xi, d_xi = number_at(parameters, parameter_slope, p, XI_MESH)
    eps_t, d_eps_t = number_at(parameters, parameter_slope, p, VARIATION_T)
    eps_r, d_eps_r = number_at(parameters, parameter_slope, p, VARIATION_R)
    S_1, d_S_1 = phasor(parameters, parameter_slope, p, ALPHA)
    S_2, d_S_2 = phasor(parameters, parameter_slope, p, ALPHA_2)
    error, d_error = phasor(parameters, parameter_slope, p, F_E)
    damping, d_damping = c * xi - U, d_c * xi + c * d_xi - d_U
    rotating, d_rotating = c * eps_r, d_c * eps_r + c * d_eps_r
    varying, d_varying = rotating - T * eps_t, d_rotating - d_T * eps_t - T * d_eps_t
    return (
        (
            -omega * omega + 2j * omega * damping,
            c - T,
            varying * S_1,
            0.5 * varying * S_2,
            parameters[F_PV] + p * parameter_slope[F_PV] + error * omega * omega,
            0.5 * rotating * S_1,
        ),
        (
            -2.0 * omega * d_omega + 2j * (d_omega * damping + omega * d_damping),
            d_c - d_T,
            d_varying * S_1 + varying * d_S_1,
            0.5 * (d_varying * S_2 + varying * d_S_2),
            parameter_slope[F_PV] + d_error * omega * omega + 2.0 * error * omega * d_omega,
            0.5 * (d_rotating * S_1 + rotating * d_S_1),
        ),
        (c, parameters[F_PM] + p * parameter_slope[F_PM], parameters[B] + p * parameter_slope[B]),
        (d_c, parameter_slope[F_PM], parameter_slope[B]),
    )


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX), shared=True)
def residual_and_jacobian(parameters, parameter_slope, y, residual, jacobian):
    """Residual (3,) and Jacobian (3, 4) at y = (lambda_m, lambda_c, lambda_s, axis value); see the module.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Parameters at p = 0 and what p adds to them.
    y : (4,) array
        (lambda_m, lambda_c, lambda_s, p).
    residual, jacobian : (3,) and (3, 4) arrays
        Filled.
    """
    values, d_values, constants, d_constants = coefficients(parameters, parameter_slope, y[3])
    D, A, P_1, P_2, F, e = values
    d_D, d_A, d_P_1, d_P_2, d_F, d_e = d_values
    c, f_pm, b = constants
    d_c, d_f_pm, d_b = d_constants

    fundamental = complex(y[1], -y[2])
    amplitude = math.sqrt(y[1] * y[1] + y[2] * y[2])
    unit = 0j
    if amplitude > 0.0:
        unit = fundamental / amplitude
    f_0, gain, f_0_m, f_0_a, f_0_b, gain_m, gain_a, gain_b = describing_functions(y[0], amplitude, b)
    f_1 = gain * fundamental

    residual[0] = c * f_0 + (e * f_1.conjugate()).real - f_pm
    row = D * fundamental + A * f_1 + P_1 * f_0 + P_2 * f_1.conjugate() - F
    residual[1], residual[2] = row.real, -row.imag

    # Columns lambda_m, lambda_c, lambda_s and the gap b: what each does to f_0, f_1 and Lambda_1.
    for column in range(4):
        if column == 0:
            d_f_0, d_f_1, d_fundamental = f_0_m, gain_m * unit, 0j
        elif column == 1:
            d_f_0, d_f_1, d_fundamental = f_0_a * unit.real, gain + gain_a * unit.real * unit, 1.0 + 0j
        elif column == 2:
            d_f_0, d_f_1, d_fundamental = -f_0_a * unit.imag, -1j * gain - gain_a * unit.imag * unit, -1j
        else:
            d_f_0, d_f_1, d_fundamental = f_0_b * d_b, gain_b * unit * d_b, 0j
        jacobian[0, column] = c * d_f_0 + (e * d_f_1.conjugate()).real
        row = D * d_fundamental + A * d_f_1 + P_1 * d_f_0 + P_2 * d_f_1.conjugate()
        jacobian[1, column], jacobian[2, column] = row.real, -row.imag
    jacobian[0, 3] += d_c * f_0 + (d_e * f_1.conjugate()).real - d_f_pm
    row = d_D * fundamental + d_A * f_1 + d_P_1 * f_0 + d_P_2 * f_1.conjugate() - d_F
    jacobian[1, 3] += row.real
    jacobian[2, 3] -= row.imag


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))
def test_functions(parameters, parameter_slope, y, values, gradient):
    """Amplitude and the four contact margins with their gradients.

    values (5,) = lambda_a, lambda_min - b, lambda_min + b, lambda_max - b, lambda_max + b; gradient (5, 4). A zero of a
    margin is a grazing: the motion just touches a flank or just leaves it.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Parameters at p = 0 and what p adds to them.
    y : (4,) array
        (lambda_m, lambda_c, lambda_s, p).
    values, gradient : (m,) and (m, 4) arrays
        Filled.
    """
    b, d_b = parameters[B] + y[3] * parameter_slope[B], parameter_slope[B]
    amplitude = math.sqrt(y[1] * y[1] + y[2] * y[2])
    cosine, sine = 0.0, 0.0
    if amplitude > 0.0:
        cosine, sine = y[1] / amplitude, y[2] / amplitude
    values[0] = amplitude
    gradient[0, 0], gradient[0, 1], gradient[0, 2], gradient[0, 3] = 0.0, cosine, sine, 0.0
    for i in range(1, 5):
        extreme = -1.0 if i <= 2 else 1.0
        flank = -1.0 if i % 2 == 1 else 1.0
        values[i] = y[0] + extreme * amplitude + flank * b
        gradient[i, 0], gradient[i, 1], gradient[i, 2] = 1.0, extreme * cosine, extreme * sine
        gradient[i, 3] = flank * d_b


@kernel(types.float64(ARRAY, ARRAY, types.float64, ARRAY))
def linear_solution(parameters, parameter_slope, p, unknowns):
    """Solution of the balance without backlash (b = 0, linear), and the determinant of its Jacobian.

    As the dead zone differs from the linear force by at most b, the determinant's sign is the topological degree of the
    balance for every b: the signs of det J over all solutions add up to it.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Parameters at p = 0 and what p adds to them.
    p : float
        Axis value.
    unknowns : (3,) array
        Filled.
    """
    base, along = parameters.copy(), parameter_slope.copy()
    base[B], along[B] = 0.0, 0.0
    y, residual, jacobian = np.zeros(4), np.empty(3), np.empty((3, 4))
    y[3] = p
    residual_and_jacobian(base, along, y, residual, jacobian)
    square = jacobian[:, :3].copy()
    determinant = eliminate(square, residual)
    for i in range(3):
        unknowns[i] = -residual[i]
    return determinant


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY))
def linear_degree(parameters, parameter_slope, grid, signs):
    """Fill `signs` with the degree at every axis value of `grid`: the sign of the determinant of `linear_solution`.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Parameters at p = 0 and what p adds to them.
    grid : (X,) array
        Axis values.
    signs : (X,) array
        Filled.
    """
    unknowns = np.empty(3)
    for i in range(grid.shape[0]):
        signs[i] = np.sign(linear_solution(parameters, parameter_slope, grid[i], unknowns))


def first_order_problem(model: Model, axis: str, low: float, high: float, omega: float | None = None) -> Problem:
    """The balance of one gear pair as a curve over one axis.

    Parameters
    ----------
    model : Model
    axis : str
        "omega" or a scalar parameter of the gear (`solver.model.packing.AXES`).
    low, high : float
        Range of the axis, for scaling.
    omega : float, optional
        The frequency; needed unless it is the axis.

    Returns
    -------
    Problem

    Raises
    ------
    ParameterError
        If the axis is unknown, its ends do not ascend or are not allowed, or the frequency is missing.

    Notes
    -----
    The balance is that of docs/physics.md, section 4.5.
    """
    check_axis(instance_of("model", model, Model), axis, low, high, omega)
    parameters, parameter_slope = axis_vectors(model, axis, omega)
    size = model.motion_size
    scale = np.array([size, size, size, 0.1 * (high - low)])
    return Problem(residual_and_jacobian, test_functions, parameters, parameter_slope, scale, test_count=5)


def _check(problem: Problem) -> None:
    """Refuse what is no problem of `first_order_problem`."""
    if instance_of("problem", problem, Problem).residual_and_jacobian is not residual_and_jacobian:
        raise ParameterError("problem", problem, "one of first_order_problem")


@dataclass(frozen=True)
class DescribingFunction:
    """The article's first order: the force is truncated to its mean and fundamental before the stiffness multiplies it.

    What a balance is asked by rows and seeds, here and in `solver.harmonic.galerkin.Galerkin`.
    """

    order: ClassVar[int] = 1
    period: ClassVar[int] = 1
    harmonics: ClassVar[int] = 1
    unknowns: ClassVar[int] = 3
    truncated: ClassVar[bool] = True
    fundamental: ClassVar[tuple[int, int]] = (1, 2)

    def problem(self, model: Model, axis: str, low: float, high: float, omega: float | None = None) -> Problem:
        """The balance as a curve over one axis.

        Parameters
        ----------
        model, axis, low, high, omega
            As for `first_order_problem`.

        Raises
        ------
        ParameterError
            If one of them is not allowed.
        """
        return first_order_problem(model, axis, low, high, omega)

    def extremes(self, motions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest lambda over the period of motions (..., 3): two (...) arrays.

        Raises
        ------
        ParameterError
            If they are no numbers of that shape.
        """
        motions = number_array("motions", motions, last=3)
        size = np.hypot(motions[..., 1], motions[..., 2])
        return motions[..., 0] - size, motions[..., 0] + size

    def linear_solution(self, problem: Problem, p: float) -> tuple[float, np.ndarray]:
        """Degree of the balance and solution (3,) without backlash at one axis value.

        Raises
        ------
        ParameterError
            If it is no problem of this balance, or a value is not finite.
        """
        p, unknowns = finite_number("p", p), np.empty(3)
        _check(problem)
        return float(np.sign(linear_solution(problem.parameters, problem.parameter_slope, p, unknowns))), unknowns

    def degree(self, problem: Problem, grid: np.ndarray) -> np.ndarray:
        """Degree of the balance at every axis value (X,): what the signs of det J add up to over all solutions.

        Raises
        ------
        ParameterError
            If it is no problem of this balance, or a value is not finite.
        """
        _check(problem)
        grid = finite_array("grid", grid, (None,))
        signs = np.empty(grid.size)
        linear_degree(problem.parameters, problem.parameter_slope, grid, signs)
        return signs


def evaluate(model: Model, omega: float, unknowns) -> tuple[np.ndarray, np.ndarray]:
    """Residual and Jacobian of the balance at one motion (docs/physics.md, section 4.5).

    Parameters
    ----------
    model : Model
    omega : float
        Frequency, > 0.
    unknowns : (3,) array_like
        lambda_m, lambda_c, lambda_s.

    Returns
    -------
    residual : (3,) array
    jacobian : (3, 3) array

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    parameters, parameter_slope = axis_vectors(instance_of("model", model, Model), "omega")
    residual, jacobian = np.empty(3), np.empty((3, 4))
    y = np.append(finite_array("unknowns", unknowns, (3,)), frequency(omega))
    residual_and_jacobian(parameters, parameter_slope, y, residual, jacobian)
    return residual, jacobian[:, :3].copy()
