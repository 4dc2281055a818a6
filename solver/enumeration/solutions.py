"""Every solution of the first-order balance at one parameter point, counted with proof.

The balance reduces to one equation for the gain t = N_a in [0, 1] (`solver.enumeration.reduction`, with the
derivation), of which a branch and bound in interval arithmetic finds all roots (`solver.enumeration.search`). As t = 1
- O(b/lambda_a) for large amplitudes and infinite amplitude is a regular point of that equation, the search has no
ceiling; `amplitude_max` only says which solutions are wanted, and what lies above is proven as well. The coefficients
are enclosed (`solver.enumeration.coefficients`): the proof holds for the model as given.
"""

import enum
from dataclasses import dataclass

import numpy as np

from solver.enumeration.certificates import (
    AMPLITUDE,
    GAIN_BOUNDS,
    MEAN,
    MOST,
    ROOT,
    STABLE,
    enumerate_point,
    enumerate_points,
    workspace,
)
from solver.model.checks import ParameterError
from solver.model.condensation import axis_vectors
from solver.model.gear_model import Model

__all__ = ["Above", "Proof", "RowSolutions", "Solutions", "all_solutions", "enumerate_row"]


class Proof(enum.IntEnum):
    """What is known about the number of solutions up to the amplitude ceiling."""

    UNDECIDED = 0
    PROVEN = 1
    CONTINUUM = 2
    CONTRADICTION = 3

    @property
    def sentence(self) -> str:
        """What it means."""
        return _PROOF_SENTENCES[self]


_PROOF_SENTENCES = {
    Proof.UNDECIDED: "Too close to a fold or another degeneracy: the solutions listed are proven, more may lie in the "
    "undecided boxes.",
    Proof.PROVEN: "Every solution listed is proven to exist and to be the only one in its box, and there is no other.",
    Proof.CONTINUUM: "Without mean load the teeth can move inside the gap and the mean of that motion is free: besides "
    "the solutions listed, which are proven, there is this continuum and nothing else.",
    Proof.CONTRADICTION: "Two proofs contradict each other: this is a defect of the program.",
}


class Above(enum.IntEnum):
    """What is known about solutions above the amplitude ceiling."""

    EMPTY = 0
    OCCUPIED = 1
    OPEN = 2

    @property
    def sentence(self) -> str:
        """What it means."""
        return _ABOVE_SENTENCES[self]


_ABOVE_SENTENCES = {
    Above.EMPTY: "It is proven that no solution lies above the amplitude ceiling, at any amplitude.",
    Above.OCCUPIED: "Solutions above the amplitude ceiling are proven to exist.",
    Above.OPEN: "Whether a solution lies above the amplitude ceiling is open: the linear system is nearly singular.",
}


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
    mean, cos, sin : (X, S) arrays
    radius : (X, S) array
        Bound of the error of each of the three.
    stable : (X, S) int8 array
    n_solutions : (X,) int array
    proof, above : (X,) int8 arrays
        `Proof` and `Above`.
    """

    mean: np.ndarray
    cos: np.ndarray
    sin: np.ndarray
    radius: np.ndarray
    stable: np.ndarray
    n_solutions: np.ndarray
    proof: np.ndarray
    above: np.ndarray

    @property
    def amplitude(self) -> np.ndarray:
        """lambda_a, (X, S)."""
        return np.hypot(self.cos, self.sin)


def all_solutions(model: Model, omega: float, *, amplitude_max: float = 100.0) -> Solutions:
    """Every solution of the first-order balance at one point, proven.

    Parameters
    ----------
    model : Model
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
        If the frequency or the ceiling is not allowed.
    ArithmeticError
        If two proofs contradict each other, which would be a defect of the program.
    """
    _check(amplitude_max, omega)
    theta, direction = axis_vectors(model, "omega")
    found, undecided, work = workspace()
    count, n_open, proof, above, visits = enumerate_point(
        theta, direction, float(omega), float(amplitude_max), found, undecided, work
    )
    proof = Proof(proof)
    if proof is Proof.CONTRADICTION:
        raise ArithmeticError(f"{proof.sentence} It happened at omega = {omega!r} for {model!r}.")
    boxes = found[:count, MEAN:AMPLITUDE].reshape(count, 3, 2).copy()
    motions = undecided[:n_open][:, [ROOT, ROOT + 1, MEAN, MEAN + 1, AMPLITUDE, AMPLITUDE + 1]]
    return Solutions(
        float(omega),
        *np.mean(boxes, axis=2).T,
        found[:count, STABLE].astype(np.int8),
        boxes,
        found[:count, GAIN_BOUNDS:MEAN].copy(),
        motions.reshape(n_open, 3, 2),
        proof,
        Above(above),
        visits,
    )


def enumerate_row(
    model: Model, axis: str, grid, *, omega: float | None = None, amplitude_max: float = 100.0
) -> RowSolutions:
    """Every solution at many values of one axis; per point this is `all_solutions` without its overhead.

    Parameters
    ----------
    model : Model
    axis : str
        "omega" or a scalar parameter of the gear; the model's own value of it is not used.
    grid : (X,) array_like
    omega : float, optional
        Needed unless it is the axis.
    amplitude_max : float

    Returns
    -------
    RowSolutions
        Points at which proofs contradict each other carry `Proof.CONTRADICTION`; nothing is raised for them.
    """
    grid = np.array(grid, dtype=float)
    _check(amplitude_max, *(grid if axis == "omega" else [omega]))
    theta, direction = axis_vectors(model, axis, omega)
    counts, proof, above = np.empty(grid.size, np.int64), np.empty(grid.size, np.int8), np.empty(grid.size, np.int8)
    unknowns = np.empty((grid.size, MOST, 3))
    radius, stable = np.empty((grid.size, MOST)), np.empty((grid.size, MOST), np.int8)
    enumerate_points(theta, direction, grid, float(amplitude_max), unknowns, radius, stable, counts, proof, above)
    most = max(int(counts.max(initial=0)), 1)
    return RowSolutions(
        *np.ascontiguousarray(np.moveaxis(unknowns[:, :most], 2, 0)),
        radius[:, :most].copy(),
        stable[:, :most].copy(),
        counts,
        proof,
        above,
    )


def _check(amplitude_max, *frequencies):
    for omega in frequencies:
        if omega is None or not 0.0 < omega < np.inf:
            raise ParameterError("omega", omega, "a finite number above 0")
    if not 0.0 < amplitude_max < np.inf:
        raise ParameterError("amplitude_max", amplitude_max, "a finite number above 0")
