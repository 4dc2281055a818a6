"""Every solution of the first-order balance at one parameter point, counted with proof.

The balance reduces to one equation for the gain t = N_a in [0, 1] (`solver.reduction`, with the derivation), of which a
branch and bound in interval arithmetic finds all roots (`solver.gain_search`). As t = 1 - O(b/lambda_a) for large
amplitudes and infinite amplitude is a regular point of that equation, the search has no ceiling; `amplitude_max`
only says which solutions are wanted, and what lies above is proven as well. The coefficients are enclosed
(`solver.harmonic.enclosed`): the proof holds for the model as given.
"""

import enum
from dataclasses import dataclass

import numpy as np
from numba import types

from solver.compiled import ARRAY, FLAGS, MATRIX, kernel
from solver.condensation import axis_vectors
from solver.errors import ParameterError
from solver.gain_search import CONTRADICTION, FREE_MOTION, narrow, search
from solver.interval import exact
from solver.model import Model
from solver.reduction import GAP, ROWS, determinant_over, motion_over, numerators_at, reduce_balance

__all__ = ["Above", "Proof", "RowSolutions", "Solutions", "all_solutions", "enumerate_row"]

_I, _F = types.int64, types.float64


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
    Above.OPEN: "Whether a solution lies above the amplitude ceiling is open: the linear system is too close to singular.",
}

# Columns of what the kernels record about one box: pairs (low, high) of the gains that hold no other root, the unknowns, the
# amplitude and the gain itself, then stability.
_GAIN, _MEAN, _COS, _SIN, _AMPLITUDE, _ROOT, _STABLE, _COLUMNS = 0, 2, 4, 6, 8, 10, 12, 13
_ROOTS, _UNDECIDED, _STACK = 32, 16, 256


@kernel(types.void(MATRIX, _F, _F, _F, ARRAY))
def _describe(reduced, left, right, near, box):
    """Fill one box with the motions of gain between left and right."""
    mean, cosine, sine, amplitude = motion_over(reduced, left, right, near)
    box[_GAIN], box[_GAIN + 1] = 0.0, 1.0
    box[_ROOT], box[_ROOT + 1] = left, right
    box[_MEAN], box[_MEAN + 1] = mean
    box[_COS], box[_COS + 1] = cosine
    box[_SIN], box[_SIN + 1] = sine
    box[_AMPLITUDE], box[_AMPLITUDE + 1] = amplitude
    box[_STABLE] = 0.0


@kernel(types.boolean(ARRAY, _F))
def _alone(box, b):
    """Do all motions within the bounds of the unknowns have gains within the bounds of the gain (so that one is a solution)?

    N is 1 where |lambda_m| - b >= lambda_a. Else it changes by at most (2/pi)/lambda_a times the change of lambda_m plus the
    same times that of lambda_a, as the weights w of `solver.backlash` are at most 2/pi and mu w at most 1/pi.
    """
    least = max(max(box[_MEAN], -box[_MEAN + 1]), 0.0)
    largest = max(abs(box[_COS]), abs(box[_COS + 1])) + max(abs(box[_SIN]), abs(box[_SIN + 1]))
    if box[_GAIN + 1] == 1.0 and (b == 0.0 or least - b > largest):
        return True
    spread = box[_MEAN + 1] - box[_MEAN] + box[_COS + 1] - box[_COS] + box[_SIN + 1] - box[_SIN]
    smallest = box[_AMPLITUDE] - spread
    if not smallest > 0.0:
        return False
    change = spread / smallest
    return (box[_GAIN] == 0.0 or box[_ROOT] - change > box[_GAIN]) and (
        box[_GAIN + 1] == 1.0 or box[_ROOT + 1] + change < box[_GAIN + 1]
    )


@kernel(types.void(MATRIX, _I))
def _settle(found, last):
    """Move row `last` down to where it belongs: ascending amplitude."""
    while last > 0 and found[last - 1, _AMPLITUDE] > found[last, _AMPLITUDE]:
        for j in range(_COLUMNS):
            found[last - 1, j], found[last, j] = found[last, j], found[last - 1, j]
        last -= 1


@kernel(types.UniTuple(_I, 5)(ARRAY, ARRAY, _F, _F, MATRIX, MATRIX, MATRIX))
def _enumerate(theta, direction, p, ceiling, found, undecided, work):
    """All solutions at one axis value.

    found (32, 13) and undecided (48, 13) are filled with boxes; work has ROWS + 32 + 16 + 256 rows of 5.
    Returns the numbers of both, `Proof`, `Above` and the number of intervals looked at.
    """
    reduced = work[:ROWS]
    roots, boxes, stack = work[ROWS : ROWS + _ROOTS], work[ROWS + _ROOTS : ROWS + _ROOTS + _UNDECIDED], work[-_STACK:]
    if not reduce_balance(theta, direction, p, reduced):
        undecided[0, :] = np.nan
        undecided[0, _ROOT], undecided[0, _ROOT + 1] = 0.0, 1.0
        return 0, 1, 0, 2, 0
    n_roots, n_boxes, flags, visits = search(reduced, roots, boxes, stack)
    count, n_open, above, degree = 0, 0, 0, 0
    for i in range(n_roots):
        roots[i, 0], roots[i, 1], roots[i, 2], roots[i, 3] = narrow(reduced, roots[i, 0], roots[i, 1])
    for i in range(n_roots):
        left, right, sign = roots[i, 0], roots[i, 1], roots[i, 2]
        _describe(reduced, left, right, roots[i, 3], found[count])
        # Every root lies in one of the intervals, so between the neighbours there is no other; a free motion has gain 0.
        if flags & FREE_MOTION:
            found[count, _GAIN] = 1e-300
        for j in range(n_roots + n_boxes):
            low, high = (roots[j, 0], roots[j, 1]) if j < n_roots else (boxes[j - n_roots, 0], boxes[j - n_roots, 1])
            if j != i and high <= left:
                found[count, _GAIN] = max(found[count, _GAIN], high)
            elif j != i:
                found[count, _GAIN + 1] = min(found[count, _GAIN + 1], low)
        q = determinant_over(reduced, left, right)
        if sign == 0.0 or not (q[0] > 0.0 or q[1] < 0.0) or not _alone(found[count], reduced[GAP, 0]):
            # A root whose motion may be infinite, or whose box is so coarse that it may reach to another solution.
            if found[count, _AMPLITUDE] > ceiling:
                above = 2
            else:
                undecided[n_open, :] = found[count]
                n_open += 1
            continue
        stable = (sign < 0.0) == (q[0] > 0.0)
        degree += 1 if stable else -1
        if found[count, _AMPLITUDE] > ceiling:
            above = max(above, 1)
            continue
        found[count, _STABLE] = 1.0 if stable else 0.0
        _settle(found, count)
        count += 1
    decided = n_open == 0 and above != 2
    for i in range(n_boxes):
        decided = False
        if n_open == undecided.shape[0]:
            break
        _describe(reduced, boxes[i, 0], boxes[i, 1], np.nan, undecided[n_open])
        if undecided[n_open, _AMPLITUDE] > ceiling:
            above = 2
        else:
            n_open += 1
    proof = 1
    if flags & FREE_MOTION:
        proof = 2
    if n_open > 0:
        proof = 0
    # The signs of det J over all solutions add up to that of the linear system.
    q = numerators_at(reduced, exact(1.0))[1]
    if decided and proof == 1 and ((q[0] > 0.0 and degree != 1) or (q[1] < 0.0 and degree != -1)):
        proof = 3
    if flags & CONTRADICTION:
        proof = 3
    return count, n_open, proof, above, visits


@kernel(
    types.void(
        ARRAY, ARRAY, ARRAY, _F, types.float64[:, :, ::1], MATRIX, types.int8[:, ::1], types.int64[::1], FLAGS, FLAGS
    )
)  # fmt: skip
def enumerate_points(theta, direction, grid, ceiling, unknowns, radius, stable, counts, proof, above):
    """All solutions at many axis values.

    Parameters
    ----------
    theta, direction : (34,) arrays
    grid : (X,) array
        Axis values.
    ceiling : float
        Amplitude ceiling.
    unknowns : (X, S, 3) array
        Filled with (lambda_m, lambda_c, lambda_s), ascending amplitude; nan beyond their number.
    radius : (X, S) array
        Filled with what bounds the error of each unknown.
    stable : (X, S) int8 array
        Filled with 1, 0, or -1 beyond the number of solutions.
    counts : (X,) int array
        Filled with the numbers of solutions, also those beyond S.
    proof, above : (X,) int8 arrays
        Filled with `Proof` and `Above`.
    """
    found, undecided = np.empty((_ROOTS, _COLUMNS)), np.empty((_UNDECIDED + _ROOTS, _COLUMNS))
    work = np.empty((ROWS + _ROOTS + _UNDECIDED + _STACK, 5))
    unknowns[:], radius[:], stable[:] = np.nan, np.nan, -1
    for i in range(grid.shape[0]):
        counts[i], _open, proof[i], above[i], _visits = _enumerate(
            theta, direction, grid[i], ceiling, found, undecided, work
        )
        for k in range(min(counts[i], unknowns.shape[1])):
            radius[i, k] = 0.0
            for j in range(3):
                low, high = found[k, _MEAN + 2 * j], found[k, _MEAN + 2 * j + 1]
                unknowns[i, k, j] = 0.5 * (low + high)
                # Twice the half width covers the rounding of the middle.
                radius[i, k] = max(radius[i, k], high - low)
            stable[i, k] = 1 if found[k, _STABLE] == 1.0 else 0


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
    found, undecided = np.empty((_ROOTS, _COLUMNS)), np.empty((_UNDECIDED + _ROOTS, _COLUMNS))
    work = np.empty((ROWS + _ROOTS + _UNDECIDED + _STACK, 5))
    count, n_open, proof, above, visits = _enumerate(
        theta, direction, float(omega), float(amplitude_max), found, undecided, work
    )
    proof = Proof(proof)
    if proof is Proof.CONTRADICTION:
        raise ArithmeticError(f"{proof.sentence} It happened at omega = {omega!r} for {model!r}.")
    boxes = found[:count, _MEAN:_AMPLITUDE].reshape(count, 3, 2).copy()
    return Solutions(
        float(omega), *np.mean(boxes, axis=2).T, found[:count, _STABLE].astype(np.int8), boxes,
        found[:count, _GAIN:_MEAN].copy(),
        undecided[:n_open][:, [_ROOT, _ROOT + 1, _MEAN, _MEAN + 1, _AMPLITUDE, _AMPLITUDE + 1]].reshape(n_open, 3, 2),
        proof, Above(above), visits,
    )  # fmt: skip


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
    grid = np.ascontiguousarray(grid, dtype=float)
    _check(amplitude_max, *(grid if axis == "omega" else [omega]))
    theta, direction = axis_vectors(model, axis, omega)
    counts, proof, above = np.empty(grid.size, np.int64), np.empty(grid.size, np.int8), np.empty(grid.size, np.int8)
    unknowns = np.empty((grid.size, _ROOTS, 3))
    radius, stable = np.empty((grid.size, _ROOTS)), np.empty((grid.size, _ROOTS), np.int8)
    enumerate_points(
        theta, direction, grid, float(amplitude_max), unknowns, radius, stable, counts, proof, above
    )  # fmt: skip
    most = max(int(counts.max(initial=0)), 1)
    return RowSolutions(
        *np.ascontiguousarray(np.moveaxis(unknowns[:, :most], 2, 0)), radius[:, :most].copy(),
        stable[:, :most].copy(), counts, proof, above,
    )  # fmt: skip


def _check(amplitude_max, *frequencies):
    for omega in frequencies:
        if omega is None or not 0.0 < omega < np.inf:
            raise ParameterError("omega", omega, "a finite number above 0")
    if not 0.0 < amplitude_max < np.inf:
        raise ParameterError("amplitude_max", amplitude_max, "a finite number above 0")
