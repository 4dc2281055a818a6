"""Correctors: from a predicted point back to the solution curve, on the hyperplane through the prediction.

Both solve the bordered system E(y) = 0, normal . (y - y_predicted)/scale = 0 in scaled unknowns. A corrector is a
frozen object that names its compiled kernel; continuation calls the kernel and never asks which one it is.
"""

import math
from dataclasses import dataclass

from solver.kernels import types
from solver.kernels.compile import ARRAY, CORRECTOR, MATRIX, RESIDUAL_AND_JACOBIAN, kernel
from solver.kernels.linear import eliminate
from solver.model.checks import finite_number, whole_number

__all__ = ["Broyden", "Newton", "advance", "bordered", "correct_all", "workspace_rows"]

_F = types.float64
_SIGNATURE = types.int64(RESIDUAL_AND_JACOBIAN, ARRAY, ARRAY, ARRAY, ARRAY, ARRAY, types.float64, types.int64, MATRIX)


def workspace_rows(unknowns: int) -> int:
    """Rows of the (rows, unknowns + 1) work array that the kernels of this module need."""
    return 3 * unknowns + 6


@kernel(types.void(RESIDUAL_AND_JACOBIAN, ARRAY, ARRAY, ARRAY, ARRAY, ARRAY, MATRIX, ARRAY, MATRIX), inner=True)
def bordered(residual_and_jacobian, parameters, parameter_slope, scale, y, border, jacobian, residual, matrix):
    """Fill `matrix` (n+1, n+1) with the Jacobian in scaled unknowns above row `border`, `residual` (n,) with E(y).

    Parameters
    ----------
    residual_and_jacobian : kernel
        The curve's equations.
    parameters, parameter_slope : arrays
        Parameters at p = 0 and what p adds to them.
    scale : (n + 1,) array
        Typical size of every unknown and of p.
    y : (n + 1,) array
        (u, p).
    border : (n + 1,) array
        Last row of the matrix, in scaled unknowns.
    jacobian : (n, n + 1) array
        Filled with the Jacobian.
    residual : (n,) array
        Filled with the residual.
    matrix : (n + 1, n + 1) array
        Filled with the bordered matrix.
    """
    n = y.shape[0] - 1
    residual_and_jacobian(parameters, parameter_slope, y, residual, jacobian)
    for i in range(n):
        for j in range(n + 1):
            matrix[i, j] = jacobian[i, j] * scale[j]
    for j in range(n + 1):
        matrix[n, j] = border[j]


@kernel(types.float64(ARRAY, ARRAY, ARRAY), inline=True)
def advance(y, scale, step):
    """Add a scaled step to y; its length, or nan if it is not finite.

    Parameters
    ----------
    y : (n + 1,) array
        Moved by the step.
    scale : (n + 1,) array
        Typical size of every unknown and of p.
    step : (n + 1,) array
        In scaled unknowns.
    """
    length = 0.0
    for j in range(y.shape[0]):
        length += step[j] * step[j]
    if not math.isfinite(length):
        return math.nan
    for j in range(y.shape[0]):
        y[j] += step[j] * scale[j]
    return math.sqrt(length)


@kernel(types.boolean(_F, _F, _F), inline=True)
def _settled(length, previous, tolerance):
    """Is the error left after this step below the tolerance?

    Steps that shrink by a factor q leave less than q/(1 - q) times the last one, and both methods shrink faster from
    step to step; this spares the step that would only confirm.
    """
    return length <= tolerance or (length < 0.1 * previous and length * length <= 0.5 * tolerance * previous)


@kernel(_SIGNATURE)
def _newton(residual_and_jacobian, parameters, parameter_slope, scale, y, normal, tolerance, max_iterations, work):
    n = y.shape[0] - 1
    jacobian, matrix = work[0:n], work[n : 2 * n + 1]
    residual, step = work[2 * n + 1][:n], work[2 * n + 2]
    previous = 0.0
    for iteration in range(1, max_iterations + 1):
        bordered(residual_and_jacobian, parameters, parameter_slope, scale, y, normal, jacobian, residual, matrix)
        for i in range(n):
            step[i] = -residual[i]
        step[n] = 0.0
        determinant = eliminate(matrix, step)
        if determinant == 0.0:
            return -1
        length = advance(y, scale, step)
        if math.isnan(length):
            return -1
        if _settled(length, previous, tolerance):
            return iteration
        previous = length
    return -1


@kernel(_SIGNATURE)
def _broyden(residual_and_jacobian, parameters, parameter_slope, scale, y, normal, tolerance, max_iterations, work):
    n = y.shape[0] - 1
    jacobian, secant, matrix = work[0:n], work[n : 2 * n + 1], work[2 * n + 1 : 3 * n + 2]
    residual, step, right = work[3 * n + 2][:n], work[3 * n + 3], work[3 * n + 4]
    bordered(residual_and_jacobian, parameters, parameter_slope, scale, y, normal, jacobian, residual, secant)
    size, last = math.inf, 0.0
    for iteration in range(1, max_iterations + 1):
        for i in range(n + 1):
            for j in range(n + 1):
                matrix[i, j] = secant[i, j]
        for i in range(n):
            step[i] = -residual[i]
            right[i] = -residual[i]
        step[n] = 0.0
        determinant = eliminate(matrix, step)
        if determinant == 0.0:
            return -1
        length = advance(y, scale, step)
        if math.isnan(length):
            return -1
        if _settled(length, last, tolerance):
            return iteration
        last = length
        # The true Jacobian costs the same as a residual here; the update is kept for what it is: the article's method.
        residual_and_jacobian(parameters, parameter_slope, y, residual, jacobian)
        previous, size = size, 0.0
        for i in range(n):
            size = max(size, abs(residual[i]))
        if size > 0.25 * previous:
            bordered(residual_and_jacobian, parameters, parameter_slope, scale, y, normal, jacobian, residual, secant)
            size = math.inf
            continue
        # J s = -E(y_old), so that J + (y - J s) s^T/(s^T s) with y = E(y_new) - E(y_old) adds E(y_new) s^T/(s^T s).
        for i in range(n):
            for j in range(n + 1):
                secant[i, j] += residual[i] * step[j] / (length * length)
    return -1


@kernel(types.void(CORRECTOR, RESIDUAL_AND_JACOBIAN, ARRAY, ARRAY, ARRAY, MATRIX, ARRAY, _F, types.int64, MATRIX))
def correct_all(
    corrector,
    residual_and_jacobian,
    parameters,
    parameter_slope,
    scale,
    guesses,
    normal,
    tolerance,
    max_iterations,
    work,
):
    """Correct every row of `guesses` (k, n + 1) across one normal; those that do not settle are filled with nan.

    Parameters
    ----------
    corrector, residual_and_jacobian : kernels
    parameters, parameter_slope : arrays
        Parameters at p = 0 and what p adds to them.
    scale : (n + 1,) array
        Typical size of every unknown and of p.
    guesses : (k, n + 1) array
        Overwritten with what the corrector reaches; nan where it does not converge.
    normal : (n + 1,) array
        Across the hyperplanes, in scaled unknowns.
    tolerance : float
        Of the corrector.
    max_iterations : int
    work : (workspace_rows(n), n + 1) array
        Overwritten.
    """
    for i in range(guesses.shape[0]):
        y = guesses[i]
        if (
            corrector(
                residual_and_jacobian, parameters, parameter_slope, scale, y, normal, tolerance, max_iterations, work
            )
            < 0
        ):
            for j in range(y.shape[0]):
                y[j] = math.nan


@dataclass(frozen=True)
class _Corrector:
    tolerance: float = 1e-8
    max_iterations: int = 6

    def __post_init__(self):
        finite_number("tolerance", self.tolerance, above=0.0, at_most=1e-6)
        whole_number("max_iterations", self.max_iterations, 2, 100)


@dataclass(frozen=True)
class Newton(_Corrector):
    """Newton's method with the analytic Jacobian.

    Parameters
    ----------
    tolerance : float
        Bound of the error left, in scaled unknowns, as the contraction of the steps shows it. Continuation squares it
        once more when it computes the tangent.
    max_iterations : int
        A point that needs more is refused, and the step is halved.

    Raises
    ------
    ParameterError
        If the tolerance is not above 0 and at most 1e-6, or max_iterations is not a whole number from 2 to 100.
    """

    @property
    def kernel(self):
        """The compiled corrector, of the signature `solver.kernels.compile.CORRECTOR`."""
        return _newton


@dataclass(frozen=True)
class Broyden(_Corrector):
    """The article's update J <- J + (y - J s) s^T/(s^T s), from the analytic Jacobian at the prediction.

    It restarts from the analytic Jacobian at the current point whenever the residual falls by less than four.

    Parameters
    ----------
    tolerance, max_iterations
        As for `Newton`; convergence is superlinear, so that more iterations are allowed by default.

    Raises
    ------
    ParameterError
        As `Newton`.

    Notes
    -----
    C. G. Broyden, "A class of methods for solving nonlinear simultaneous equations", Mathematics of Computation 19
    (1965) 577-593.
    """

    max_iterations: int = 12

    @property
    def kernel(self):
        """The compiled corrector, of the signature `solver.kernels.compile.CORRECTOR`."""
        return _broyden
