"""First-order balance with describing functions on the contact coordinate, of any system with one contact.

Unknowns (lambda_m, lambda_c, lambda_s) with lambda = lambda_m + lambda_c cos(Omega tau) + lambda_s sin(Omega tau), that
is Lambda_1 = lambda_c - i lambda_s. f is truncated to its mean f_0 and fundamental f_1 = N_a Lambda_1 *before* it is
multiplied by the stiffness ("describing function", docs/physics.md, section 4). With the numbers of
`solver.harmonic.condensed`,

    E_0 = D_0 lambda_m + c f_0 + Re(e conj f_1) - load
    E_1 = D Lambda_1 + A f_1 + P_1 f_0 + P_2 conj(f_1) - F

The rows are (E_0, Re E_1, -Im E_1), for which a statically stable solution has a positive Jacobian determinant.
Harmonics of the stiffness above the second and of the loads above the first do not reach this balance.
"""

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from solver.contact.dead_zone import contact_functions
from solver.continuation.problem import Problem
from solver.harmonic.condensed import CONDENSED, coefficients, gaps, system_coefficients
from solver.harmonic.contact_extrema import contacts
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import eliminate
from solver.model.checks import ParameterError, finite_array, finite_number, frequency, instance_of, number_array
from solver.model.contact_system import ContactSystem, refuse_cubic
from solver.model.gear_model import Model
from solver.model.packing import axis_vectors, bounded_change, check_axis, packed
from solver.model.parameters import B, number_at

__all__ = [
    "DescribingFunction",
    "evaluate",
    "first_order_problem",
    "linear_solution",
    "residual_and_jacobian",
    "system_linear_solution",
    "system_residual_and_jacobian",
    "system_test_functions",
    "test_functions",
]

_F = types.float64


@kernel(types.void(CONDENSED, ARRAY, ARRAY, MATRIX), inner=True)
def _fill_rows(condensed, y, residual, jacobian):
    """Residual (3,) and Jacobian (3, 4) of a condensed balance at y = (lambda_m, lambda_c, lambda_s, axis value)."""
    values, d_values, constants, d_constants = condensed
    D, A, P_1, P_2, F, e = values
    d_D, d_A, d_P_1, d_P_2, d_F, d_e = d_values
    c, load, front, back, ground, far = constants
    d_c, d_load, d_front, d_back, d_ground, _ = d_constants

    fundamental = complex(y[1], -y[2])
    amplitude = math.sqrt(y[1] * y[1] + y[2] * y[2])
    unit = 0j
    if amplitude > 0.0:
        unit = fundamental / amplitude
    f_0, gain, f_0_m, f_0_a, f_0_p, gain_m, gain_a, gain_p = contact_functions(
        y[0], amplitude, front, back, far, d_front, d_back
    )
    f_1 = gain * fundamental

    residual[0] = c * f_0 + (e * f_1.conjugate()).real - load + ground * y[0]
    row = D * fundamental + A * f_1 + P_1 * f_0 + P_2 * f_1.conjugate() - F
    residual[1], residual[2] = row.real, -row.imag

    # Columns lambda_m, lambda_c, lambda_s and the gaps: what each does to f_0, f_1 and Lambda_1.
    for column in range(4):
        if column == 0:
            d_f_0, d_f_1, d_fundamental = f_0_m, gain_m * unit, 0j
        elif column == 1:
            d_f_0, d_f_1, d_fundamental = f_0_a * unit.real, gain + gain_a * unit.real * unit, 1.0 + 0j
        elif column == 2:
            d_f_0, d_f_1, d_fundamental = -f_0_a * unit.imag, -1j * gain - gain_a * unit.imag * unit, -1j
        else:
            d_f_0, d_f_1, d_fundamental = f_0_p, gain_p * unit, 0j
        jacobian[0, column] = c * d_f_0 + (e * d_f_1.conjugate()).real
        row = D * d_fundamental + A * d_f_1 + P_1 * d_f_0 + P_2 * d_f_1.conjugate()
        jacobian[1, column], jacobian[2, column] = row.real, -row.imag
    jacobian[0, 0] += ground
    jacobian[0, 3] += d_c * f_0 + (d_e * f_1.conjugate()).real - d_load + d_ground * y[0]
    row = d_D * fundamental + d_A * f_1 + d_P_1 * f_0 + d_P_2 * f_1.conjugate() - d_F
    jacobian[1, 3] += row.real
    jacobian[2, 3] -= row.imag


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX), shared=True)
def residual_and_jacobian(parameters, parameter_slope, y, residual, jacobian):
    """Residual (3,) and Jacobian (3, 4) of a gear pair at y = (lambda_m, lambda_c, lambda_s, axis value); see the
    module.

    Parameters
    ----------
    parameters, parameter_slope : (34,) arrays
        Parameters at p = 0 and what p adds to them.
    y : (4,) array
        (lambda_m, lambda_c, lambda_s, p).
    residual, jacobian : (3,) and (3, 4) arrays
        Filled.
    """
    _fill_rows(coefficients(parameters, parameter_slope, y[3]), y, residual, jacobian)


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))
def system_residual_and_jacobian(parameters, parameter_slope, y, residual, jacobian):
    """`residual_and_jacobian` of a `ContactSystem`, for vectors of `solver.model.packing.packed`.

    Parameters
    ----------
    parameters, parameter_slope, y, residual, jacobian : arrays
        As there.
    """
    _fill_rows(system_coefficients(parameters, parameter_slope, y[3]), y, residual, jacobian)


@kernel(types.void(types.UniTuple(types.float64, 5), ARRAY, ARRAY, MATRIX), inner=True)
def _fill_tests(limits, y, values, gradient):
    """Amplitude and contact margins of gaps (front, back, their slopes, 1 if there is a back flank)."""
    front, back, d_front, d_back, far = limits
    amplitude = math.sqrt(y[1] * y[1] + y[2] * y[2])
    cosine, sine = 0.0, 0.0
    if amplitude > 0.0:
        cosine, sine = y[1] / amplitude, y[2] / amplitude
    values[0] = amplitude
    gradient[0, 0], gradient[0, 1], gradient[0, 2], gradient[0, 3] = 0.0, cosine, sine, 0.0
    for i in range(1, 5):
        extreme = -1.0 if i <= 2 else 1.0
        flank, gap, d_gap = (-1.0, front, d_front) if i % 2 == 1 else (1.0, back, d_back)
        if flank > 0.0 and far == 0.0:
            values[i] = 1.0
            gradient[i, :] = 0.0
            continue
        values[i] = y[0] + extreme * amplitude + flank * gap
        gradient[i, 0], gradient[i, 1], gradient[i, 2] = 1.0, extreme * cosine, extreme * sine
        gradient[i, 3] = flank * d_gap


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))
def test_functions(parameters, parameter_slope, y, values, gradient):
    """Amplitude and the four contact margins of a gear pair, with their gradients.

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
    b, d_b = number_at(parameters, parameter_slope, y[3], B)
    _fill_tests((b, b, d_b, d_b, 1.0), y, values, gradient)


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))
def system_test_functions(parameters, parameter_slope, y, values, gradient):
    """`test_functions` of a `ContactSystem`; without a back contact its margins are 1.

    Parameters
    ----------
    parameters, parameter_slope, y, values, gradient : arrays
        As there.
    """
    _fill_tests(gaps(parameters, parameter_slope, y[3]), y, values, gradient)


@kernel(types.float64(CONDENSED, _F, ARRAY), inner=True)
def _solve_linear(condensed, p, unknowns):
    """Solution of a condensed balance with f = lambda, and the determinant of its Jacobian."""
    values, d_values, (c, load, _, _, ground, _), d_constants = condensed
    y, residual, jacobian = np.zeros(4), np.empty(3), np.empty((3, 4))
    y[3] = p
    _fill_rows((values, d_values, (c, load, 0.0, 0.0, ground, 1.0), d_constants), y, residual, jacobian)
    square = jacobian[:, :3].copy()
    determinant = eliminate(square, residual)
    for i in range(3):
        unknowns[i] = -residual[i]
    return determinant


@kernel(_F(ARRAY, ARRAY, _F, ARRAY))
def linear_solution(parameters, parameter_slope, p, unknowns):
    """Solution of a gear pair's balance without backlash (b = 0, linear), and the determinant of its Jacobian.

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
    return _solve_linear(coefficients(parameters, parameter_slope, p), p, unknowns)


@kernel(_F(ARRAY, ARRAY, _F, ARRAY))
def system_linear_solution(parameters, parameter_slope, p, unknowns):
    """`linear_solution` of a `ContactSystem`; its sign is the degree where the force is a bounded change of a linear
    one.

    Parameters
    ----------
    parameters, parameter_slope, p, unknowns
        As there.
    """
    return _solve_linear(system_coefficients(parameters, parameter_slope, p), p, unknowns)


def first_order_problem(
    system: Model | ContactSystem, axis: str, low: float, high: float, omega: float | None = None
) -> Problem:
    """The balance as a curve over one axis.

    Parameters
    ----------
    system : Model or ContactSystem
    axis : str
        "omega" or a scalar parameter of the gear (`solver.model.packing.AXES`); for a ContactSystem one of
        `solver.model.packing.SYSTEM_AXES`.
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
    check_axis(system, axis, low, high, omega)
    refuse_cubic(system, "at first order: the balance of order H takes it")
    size = system.motion_size
    scale = np.array([size, size, size, 0.1 * (high - low)])
    if isinstance(system, Model):
        return Problem(residual_and_jacobian, test_functions, *axis_vectors(system, axis, omega), scale, test_count=5)
    vectors = packed(system, axis, omega, 1, 1)
    # A stop may be so stiff that curves have corners where contact begins.
    return Problem(
        system_residual_and_jacobian, system_test_functions, *vectors, scale, test_count=5, contacts=contacts
    )


#: What solves the balance without backlash, by the kernel of its rows.
_LINEAR = {residual_and_jacobian: linear_solution, system_residual_and_jacobian: system_linear_solution}


def _linear(problem: Problem):
    """What solves the balance of a problem without backlash; refuses what is none of `first_order_problem`."""
    if instance_of("problem", problem, Problem).residual_and_jacobian not in _LINEAR:
        raise ParameterError("problem", problem, "one of first_order_problem")
    return _LINEAR[problem.residual_and_jacobian]


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

    def problem(
        self, system: Model | ContactSystem, axis: str, low: float, high: float, omega: float | None = None
    ) -> Problem:
        """The balance as a curve over one axis.

        Parameters
        ----------
        system, axis, low, high, omega
            As for `first_order_problem`.

        Raises
        ------
        ParameterError
            If one of them is not allowed.
        """
        return first_order_problem(system, axis, low, high, omega)

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
        determinant = _linear(problem)(problem.parameters, problem.parameter_slope, p, unknowns)
        return float(np.sign(determinant)), unknowns

    def degree(self, problem: Problem, grid: np.ndarray) -> np.ndarray:
        """Degree of the balance at every axis value (X,): what the signs of det J add up to over all solutions.

        nan where the force is no bounded change of a linear one, as of a contact with one flank: no degree is known.

        Raises
        ------
        ParameterError
            If it is no problem of this balance, or a value is not finite.
        """
        linear, unknowns, grid = _linear(problem), np.empty(3), finite_array("grid", grid, (None,))
        if linear is system_linear_solution and not bounded_change(problem.parameters):
            return np.full(grid.size, np.nan)
        found = [linear(problem.parameters, problem.parameter_slope, p, unknowns) for p in grid.tolist()]
        return np.sign(np.array(found, dtype=float))


def evaluate(system: Model | ContactSystem, omega: float, unknowns) -> tuple[np.ndarray, np.ndarray]:
    """Residual and Jacobian of the balance at one motion (docs/physics.md, section 4.5).

    Parameters
    ----------
    system : Model or ContactSystem
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
    instance_of("system", system, Model, ContactSystem)
    y = np.append(finite_array("unknowns", unknowns, (3,)), frequency(omega))
    residual, jacobian = first_order_problem(system, "omega", 0.5 * y[3], 1.5 * y[3]).evaluated(y)
    return residual, jacobian[:, :3].copy()
