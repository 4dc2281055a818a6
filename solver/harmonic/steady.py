"""One steady motion at one frequency, from a guess that need not be near it: Newton's method, also with shorter steps.

Where full steps do not lead to a solution they are shortened until the next one would be shorter, measured as the
method itself moves: the length of J^-1 E for the Jacobian at hand, which does not depend on how equations are scaled
(P. Deuflhard, Newton Methods for Nonlinear Problems, Springer 2004, section 3.3). At a corner of the force no fraction
of a step may do that; then the full one is taken.

A motion that hits a stiff stop differs from one that misses it, or goes through it, by more than this method bridges.
Where it fails, the contact is softened by powers of ten until it does not, and stiffened again step by step: the depth
of a hit is proportional to the compliance 1/k of a stiff stop, along which the motion is extrapolated.
"""

import dataclasses
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
# condition are singular to rounding. Fractions of a step that are tried; the last is taken whatever it leads to.
_TOLERANCE, _CONDITION = 1e-9, 1e14
_FRACTIONS = (*0.5 ** np.arange(11), 1.0)
# Of the contact's stiffness: the softest that is tried, the first factor by which it is raised, the largest and least.
_SOFTEST, _FIRST, _LARGEST, _LEAST = 1e-8, 10.0, 100.0, 1.01


class SolveStatus(Explained):
    """How a search for a steady motion ended."""

    CONVERGED = 0, "The motion solves the balance."
    SINGULAR = 1, "The Jacobian is singular where the search came to: without contact nothing holds the mean."
    NOT_SETTLED = 2, "Newton's method did not settle, by full or shorter steps, nor from a softer contact."


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

    Of a `ContactSystem` that is stiff the method may start from a softer contact: see the module.

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
        At most so many full steps, and then so many that may be shortened, at each stiffness of the contact.

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
    else:
        has_methods("balance", balance, "problem", "extremes")
    if guess.size == 3 and balance.unknowns > 3:
        guess = balance.lifted(guess)
    if guess.size != balance.unknowns:
        raise ParameterError("guess", guess.tolist(), f"3 or {balance.unknowns} numbers")

    def settled(this: Model | ContactSystem, start: np.ndarray) -> SteadyMotion:
        problem = balance.problem(this, "omega", 0.5 * omega, 1.5 * omega)
        return _settled(problem, np.append(start, omega), max_iterations)

    result = settled(system, guess)
    if result.status is SolveStatus.NOT_SETTLED and isinstance(system, ContactSystem):
        result = _stiffened(system, guess, settled) or result
    if result.status is SolveStatus.CONVERGED:
        result = dataclasses.replace(result, distance=float(np.max(np.abs(result.motion - guess))))
    return result


def _softened(system: ContactSystem, stiffness: float) -> ContactSystem:
    """The system with the contact's stiffness multiplied by a number."""
    return dataclasses.replace(system, force=stiffness * system.force, varying_force=stiffness * system.varying_force)


def _stiffened(system: ContactSystem, guess: np.ndarray, settled) -> SteadyMotion | None:
    """The motion that a guess leads to with a softer contact, followed to the contact's own stiffness; None if it ends.

    Parameters
    ----------
    system : ContactSystem
    guess : (n,) array
    settled : callable
        The `SteadyMotion` of a system that Newton's method reaches from a start (n,).
    """
    stiffness, result = 1.0, None
    while result is None or result.status is not SolveStatus.CONVERGED:
        stiffness *= 0.1
        if stiffness < _SOFTEST:
            return None
        try:
            result = settled(_softened(system, stiffness), guess)
        except ParameterError:
            # The contact holds up what is unstable without it, and has to be as stiff as that.
            return None
    factor, softer = _FIRST, None
    while stiffness < 1.0:
        stiffer = min(stiffness * factor, 1.0)
        this, starts = _softened(system, stiffer), [result.motion]
        if softer is not None:
            before, motion = softer
            along = (1.0 / stiffer - 1.0 / stiffness) / (1.0 / stiffness - 1.0 / before)
            starts.insert(0, result.motion + along * (result.motion - motion))
        attempts = (settled(this, start) for start in starts)
        reached = next((one for one in attempts if one.status is SolveStatus.CONVERGED), None)
        if reached is not None:
            softer, stiffness, result, factor = (stiffness, result.motion), stiffer, reached, min(factor**1.5, _LARGEST)
            continue
        factor = factor**0.5
        if factor < _LEAST:
            return None
    return result


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
            return SteadyMotion(y[:n], stable, np.nan, SolveStatus.CONVERGED)
        for fraction in _FRACTIONS:
            trial = y.copy()
            trial[:n] += fraction * step * scale
            residual, jacobian = problem.evaluated(trial)
            if np.linalg.norm(np.linalg.solve(matrix, residual)) <= (1.0 - 0.25 * fraction) * length:
                break
        y = trial
    return SteadyMotion(np.full(n, np.nan), False, np.nan, status)
