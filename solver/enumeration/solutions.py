"""Every solution of the first-order balance at one parameter point, counted with proof.

The balance reduces to one equation for the gain t = N_a in [0, 1] (`solver.enumeration.reduction`, with the
derivation), of which a branch and bound in interval arithmetic finds all roots (`solver.enumeration.search`). As t = 1
- O(b/lambda_a) for large amplitudes and infinite amplitude is a regular point of that equation, the search has no
ceiling; `amplitude_max` only says which solutions are wanted, and what lies above is proven as well. The numbers of the
condensed balance are enclosed (`solver.enumeration.condensed`): the proof holds for the system as given.
"""

import dataclasses
from dataclasses import dataclass

import numpy as np

from solver.enumeration.certificates import (
    AMPLITUDE,
    GAIN_BOUNDS,
    MEAN,
    ROOT,
    STABLE,
    enumerate_point,
    enumerate_points,
    workspace,
)
from solver.enumeration.condensed import condensed_over
from solver.explained import Explained
from solver.model.checks import ParameterError, finite_array, finite_number, frequency, number_array
from solver.model.contact_system import ContactSystem
from solver.model.gear_model import Model
from solver.model.packing import check_values

__all__ = ["Above", "Proof", "RowSolutions", "Solutions", "all_solutions", "enumerate_row", "enumerate_values"]


class Proof(Explained):
    """What is known about the number of solutions up to the amplitude ceiling."""

    UNDECIDED = 0, "Too close to a degeneracy, like a fold: what is listed is proven, more may lie in undecided boxes."
    PROVEN = 1, "Every solution listed is proven to exist and to be the only one in its box, and there is no other."
    CONTINUUM = 2, "Without mean load the mean of a motion inside the gap is free: a continuum besides what is proven."
    CONTRADICTION = 3, "Two proofs contradict each other: this is a defect of the program."


class Above(Explained):
    """What is known about solutions above the amplitude ceiling."""

    EMPTY = 0, "It is proven that no solution lies above the amplitude ceiling, at any amplitude."
    OCCUPIED = 1, "Solutions above the amplitude ceiling are proven to exist."
    OPEN = 2, "Whether a solution lies above the amplitude ceiling is open: the linear system is nearly singular."


@dataclass(frozen=True)
class Solutions:
    """All solutions at one point, ascending amplitude; n is their number.

    Parameters
    ----------
    omega : float
    mean, cos, sin : (n,) arrays
        lambda_m, lambda_c, lambda_s.
    stable : (n,) int8 array
        1 where det J > 0, else 0; proven.
    boxes : (n, 3, 2) array
        Bounds (low, high) of the three unknowns, which are proven to hold exactly one solution.
    gain : (n, 2) array
        Bounds of N_a: no other motion with a gain between them is a solution. All motions in the box have such gains.
    undecided : (k, 3, 2) array
        Bounds of gain, mean and amplitude of the motions that are neither proven nor excluded.
    proof : Proof
        What is known about the number of solutions up to the ceiling.
    above : Above
        What is known about solutions above it.
    visits : int
        Intervals that the search looked at.
    """

    omega: float
    mean: np.ndarray
    cos: np.ndarray
    sin: np.ndarray
    stable: np.ndarray
    boxes: np.ndarray
    gain: np.ndarray
    undecided: np.ndarray
    proof: Proof
    above: Above
    visits: int

    @property
    def amplitude(self) -> np.ndarray:
        """lambda_a, (n,)."""
        return np.hypot(self.cos, self.sin)

    @property
    def sentence(self) -> str:
        """What is known, for the reader of a log."""
        return f"{self.proof.sentence} {self.above.sentence}"


@dataclass(frozen=True)
class RowSolutions:
    """All solutions at X values of an axis, S at most at one; ascending amplitude, nan (or -1) beyond their number.

    Parameters
    ----------
    motions : (X, S, 3) array
        lambda_m, lambda_c, lambda_s.
    radius : (X, S) array
        Bound of the error of each of the three.
    stable : (X, S) int8 array
        1 where det J > 0, else 0; proven.
    n_solutions : (X,) int array
    proof, above : (X,) int8 arrays
        `Proof` and `Above`.
    """

    motions: np.ndarray
    radius: np.ndarray
    stable: np.ndarray
    n_solutions: np.ndarray
    proof: np.ndarray
    above: np.ndarray

    @property
    def mean(self) -> np.ndarray:
        """lambda_m, (X, S)."""
        return self.motions[:, :, 0]

    @property
    def cos(self) -> np.ndarray:
        """lambda_c, (X, S)."""
        return self.motions[:, :, 1]

    @property
    def sin(self) -> np.ndarray:
        """lambda_s, (X, S)."""
        return self.motions[:, :, 2]

    @property
    def amplitude(self) -> np.ndarray:
        """lambda_a, (X, S)."""
        return np.hypot(self.cos, self.sin)

    def take(self, indices: np.ndarray) -> "RowSolutions":
        """Those at some of the values, by their indices.

        Raises
        ------
        ParameterError
            If they are no whole numbers, or there is no such value.
        """
        indices = number_array("indices", indices, kind=int).astype(np.int64)
        if indices.ndim != 1 or np.any((indices < 0) | (indices >= len(self.stable))):
            raise ParameterError("indices", indices, f"a vector of indices from 0 to {len(self.stable) - 1}")
        return RowSolutions(*(getattr(self, part.name)[indices] for part in dataclasses.fields(self)))


def all_solutions(system: Model | ContactSystem, omega: float, *, amplitude_max: float = 100.0) -> Solutions:
    """Every solution of the first-order balance at one point, proven.

    Parameters
    ----------
    system : Model or ContactSystem
    omega : float
        Frequency, > 0.
    amplitude_max : float
        Solutions of larger amplitude are not listed; `Solutions.above` says whether there are any.

    Returns
    -------
    Solutions

    Raises
    ------
    ParameterError
        If the system, the frequency or the ceiling is not allowed, or nothing can be proven about such a system.
    ArithmeticError
        If two proofs contradict each other, which would be a defect of the program.

    Notes
    -----
    An interval without a zero of an enclosure holds no root; one on which the slope keeps its sign holds exactly one if
    the signs at its ends differ (intermediate value theorem), which R. E. Moore's interval Newton step then narrows
    (docs/physics.md, section 4.7).
    """
    check_values(system, "omega", np.array([frequency(omega)]), None)
    omega, ceiling = float(omega), finite_number("amplitude_max", amplitude_max, above=0.0)
    enclosed = condensed_over(system, "omega", np.array([omega]), None)
    solutions, undecided, work = workspace()
    count, n_open, proof, above, visits = enumerate_point(enclosed[0], ceiling, solutions, undecided, work)
    proof = Proof(proof)
    if proof is Proof.CONTRADICTION:
        raise ArithmeticError(f"{proof.sentence} It happened at omega = {omega!r} for {system!r}.")
    boxes = solutions[:count, MEAN:AMPLITUDE].reshape(count, 3, 2).copy()
    motions = undecided[:n_open][:, [ROOT, ROOT + 1, MEAN, MEAN + 1, AMPLITUDE, AMPLITUDE + 1]]
    return Solutions(
        omega,
        *np.mean(boxes, axis=2).T,
        solutions[:count, STABLE].astype(np.int8),
        boxes,
        solutions[:count, GAIN_BOUNDS:MEAN].copy(),
        motions.reshape(n_open, 3, 2),
        proof,
        Above(above),
        visits,
    )


def enumerate_row(
    system: Model | ContactSystem, axis: str, grid, *, omega: float | None = None, amplitude_max: float = 100.0
) -> RowSolutions:
    """Every solution at many values of one axis; per point this is `all_solutions` without its overhead.

    Parameters
    ----------
    system : Model or ContactSystem
    axis : str
        One of `solver.model.packing.AXES`, or of `SYSTEM_AXES` for a ContactSystem; its own value is not used.
    grid : (X,) array_like
    omega : float, optional
        Needed unless it is the axis.
    amplitude_max : float

    Returns
    -------
    RowSolutions
        Points at which proofs contradict each other carry `Proof.CONTRADICTION`; nothing is raised for them.

    Raises
    ------
    ParameterError
        If an argument is not allowed, or nothing can be proven about such a system.
    """
    grid = finite_array("grid", grid, (None,))
    check_values(system, axis, grid, omega)
    ceiling = finite_number("amplitude_max", amplitude_max, above=0.0)
    return enumerate_values(system, axis, grid, None if axis == "omega" else float(omega), ceiling)


def enumerate_values(
    system: Model | ContactSystem, axis: str, grid: np.ndarray, omega: float | None, ceiling: float
) -> RowSolutions:
    """`enumerate_row` for callers that have checked what they ask for.

    Parameters
    ----------
    system, axis, omega
        As for `enumerate_row`.
    grid : (X,) array
    ceiling : float
        `amplitude_max`.

    Raises
    ------
    ParameterError
        If nothing can be proven about such a system.
    """
    return RowSolutions(*enumerate_points(condensed_over(system, axis, grid, omega), float(ceiling)))
