"""One steady motion at one frequency, from a guess that need not be near it: Newton's method, also with shorter steps.

Where full steps do not lead to a solution they are shortened until the next one would be shorter, measured as the
method itself moves: the length of J^-1 E for the Jacobian at hand, which does not depend on how equations are scaled
(P. Deuflhard, Newton Methods for Nonlinear Problems, Springer 2004, section 3.3). At a corner of the force no share of
a step may do that; then the full one is taken.
"""

from dataclasses import dataclass

import numpy as np

from solver.continuation.correctors import Newton
from solver.continuation.problem import Balance, Problem
from solver.explained import Explained
from solver.harmonic.describing_function import DescribingFunction
from solver.harmonic.galerkin import Galerkin
from solver.model.checks import ParameterError, finite_array, frequency, has_methods, instance_of, whole_number
from solver.model.contact_system import ContactSystem
from solver.model.gear_model import Model

__all__ = ["SolveStatus", "SteadyMotion", "solve"]

# Length of the last step, in scaled unknowns; Newton's method has squared the error by then. Jacobians beyond the
# condition are singular to rounding. Shares of a step that are tried; the last one is taken whatever it leads to.
_TOLERANCE, _CONDITION = 1e-9, 1e14
_SHARES = (*0.5 ** np.arange(11), 1.0)


class SolveStatus(Explained):
    """How a search for a steady motion ended."""

    CONVERGED = 0, "The motion solves the balance."
    SINGULAR = 1, "The Jacobian is singular where the search came to: without contact nothing holds the mean."
    NOT_SETTLED = 2, "Newton's method did not settle, neither by full steps nor by shorter ones."


@dataclass(frozen=True)
class SteadyMotion:
    """A solution of a harmonic balance, or why none was found.

    Parameters
    ----------
    motion : (n,) array
        (Lambda_0, c_1, s_1, ...) of lambda; nan unless the status is CONVERGED.
    stable : bool
        Static stability, det J > 0; False unless the status is CONVERGED.
    distance : float
        How far the motion is from the guess: the largest change of an unknown; nan unless the status is CONVERGED.
    status : SolveStatus
    """

    motion: np.ndarray
    stable: bool
    distance: float
    status: SolveStatus


def solve(
    system: Model | ContactSystem, guess, omega: float, *, balance: Balance | None = None, max_iterations: int = 50
) -> SteadyMotion:
    """The steady motion that Newton's method reaches from a guess, or the reason why it reaches none.

    Parameters
    ----------
    system : Model or ContactSystem
    guess : (n,) or (3,) array_like
        (Lambda_0, c_1, s_1, ...) of lambda, in units of b_c; a first-order motion (3,) is a guess for every order.
    omega : float
        The forcing frequency, > 0, in units of Omega_n.
    balance : Balance, optional
        Unless given, of three numbers for a gear pair the describing function of first order, else the `Galerkin`
        balance of as many harmonics as the guess has.
    max_iterations : int
        At most so many full steps, and then so many that may be shortened.

    Returns
    -------
    SteadyMotion
        Which solution a guess leads to where there are several is not told by which one is nearest. All first-order
        solutions are found by `solver.all_solutions`.

    Raises
    ------
    ParameterError
        If the guess has not the unknowns of the balance or is not finite, or another argument is not allowed.

    Examples
    --------
    >>> import solver
    >>> spring = solver.ContactSystem([[1.0]], [[0.1]], [[0.0]], [1.0], [1.0], 1.0, 1.0, load=[[0.5], [0.3]])
    >>> found = solver.solve(spring, [1.5, 0.0, 0.0], 0.6)
    >>> found.status.name, found.motion.round(6).tolist(), found.stable
    ('CONVERGED', [1.5, 0.464666, 0.043562], True)
    >>> solver.solve(spring, [0.0, 0.1, 0.0], 0.6).status.sentence
    'The Jacobian is singular where the search came to: without contact nothing holds the mean.'
    """
    instance_of("system", system, Model, ContactSystem)
    omega, max_iterations = frequency(omega), whole_number("max_iterations", max_iterations, 1, 10_000)
    guess = finite_array("guess", guess, (None,))
    if guess.size < 3 or guess.size % 2 == 0:
        raise ParameterError("guess", guess.tolist(), "an odd number of numbers, three or more")
    if balance is None:
        first = guess.size == 3 and isinstance(system, Model)
        balance = DescribingFunction() if first else Galerkin(guess.size // 2)
    elif has_methods("balance", balance, "problem", "extremes").truncated and not isinstance(system, Model):
        raise ParameterError("balance", balance, "of a Galerkin kind for a ContactSystem")
    if guess.size == 3 and balance.unknowns > 3:
        guess = balance.lifted(guess)
    if guess.size != balance.unknowns:
        raise ParameterError("guess", guess.tolist(), f"3 or {balance.unknowns} numbers")
    problem = balance.problem(system, "omega", 0.5 * omega, 1.5 * omega)
    return _settled(problem, np.append(guess, omega), max_iterations)


def _settled(problem: Problem, start: np.ndarray, max_iterations: int) -> SteadyMotion:
    """Full steps from y = (u, p) at constant p; where they lead nowhere, from there again, shortened ones."""
    n, scale, status = problem.unknowns, problem.scale[: problem.unknowns], SolveStatus.NOT_SETTLED
    y = problem.corrected(start, Newton(), max_iterations=max_iterations)
    y = start.copy() if y is None else y
    residual, jacobian = problem.evaluated(y)
    for _ in range(max_iterations):
        matrix = jacobian[:, :n] * scale
        size = np.sum(np.abs(matrix), axis=1)
        if not np.all(np.isfinite(size)) or np.min(size) == 0.0 or np.linalg.cond(matrix / size[:, None]) > _CONDITION:
            status = SolveStatus.SINGULAR
            break
        step = -np.linalg.solve(matrix, residual)
        length = np.linalg.norm(step)
        if length <= _TOLERANCE:
            y[:n] += step * scale
            stable = bool(np.linalg.slogdet(jacobian[:, :n])[0] > 0.0)
            return SteadyMotion(y[:n], stable, float(np.max(np.abs(y - start))), SolveStatus.CONVERGED)
        for share in _SHARES:
            trial = y.copy()
            trial[:n] += share * step * scale
            residual, jacobian = problem.evaluated(trial)
            if np.linalg.norm(np.linalg.solve(matrix, residual)) <= (1.0 - 0.25 * share) * length:
                break
        y = trial
    return SteadyMotion(np.full(n, np.nan), False, np.nan, status)
