"""Period doublings and Neimark-Sacker points of a branch: where a periodic motion loses stability unseen by its folds.

Both are seen by Hill's determinant at the order and truncation of the balance itself
(`solver.stability.hill_determinant`): over the half window it is real at half the base frequency and changes sign at a
period doubling; the phase that it gathers along the imaginary axis jumps by a turn where a pair of exponents crosses
the axis (`solver.stability.exponents`). What is bracketed so between two points of the branch is located on the branch
and becomes a point of its own.
"""

import dataclasses

import numpy as np

from solver.continuation.continuation import Continuation, Curve, Event
from solver.continuation.correctors import workspace_rows
from solver.continuation.problem import Balance, Problem
from solver.harmonic import layout
from solver.model.condensation import ALPHA, ALPHA_2, ALPHA_2_PHASE, ALPHA_PHASE, F_E, F_E_PHASE, OMEGA, B
from solver.stability.scan import critical_shares, half_order_matrix, monitor, scan

__all__ = ["BranchSwitchError", "critical_frequencies", "doubled", "hill_vectors", "with_bifurcations"]

_MOST = 256


class BranchSwitchError(ArithmeticError):
    """The branch of twice the period could not be reached; the message says why."""


def hill_vectors(balance: Balance, problem: Problem) -> tuple[np.ndarray, np.ndarray]:
    """`theta` and direction of `solver.harmonic.layout.packed` for the motions of a problem of a balance.

    A Galerkin problem carries them. The describing function feels two harmonics of the stiffness and one of the load,
    which its own vector of the model holds, and so does Hill's matrix truncated in the same way.
    """
    if not balance.truncated:
        return problem.theta, problem.direction
    vectors = []
    for model, constant in ((problem.theta, 1.0), (problem.direction, 0.0)):
        head = np.zeros(layout.PAIRS)
        head[[layout.HARMONICS, layout.PERIOD, layout.LOADS, layout.SIGN]] = constant
        head[layout.KIND], head[layout.STIFFNESSES] = layout.GEAR, 2.0 * constant
        head[[layout.OMEGA, layout.FRONT, layout.BACK]] = model[[OMEGA, B, B]]
        pairs, load = model[[ALPHA, ALPHA_PHASE, ALPHA_2, ALPHA_2_PHASE]], model[[F_E, F_E_PHASE]]
        vectors.append(np.concatenate([head, pairs, model, load]))
    return vectors[0], vectors[1]


def _watched(balance: Balance, problem: Problem) -> Problem:
    """The problem with the period doubling's determinant as its monitor; what that needs stands behind its theta."""
    theta, direction = hill_vectors(balance, problem)
    truncated = float(balance.truncated)
    return Problem(
        problem.balance,
        monitor,
        np.concatenate([problem.theta, theta, [theta.size, truncated]]),
        np.concatenate([problem.direction, direction, [0.0, 0.0]]),
        problem.scale,
        monitors=1,
    )


def with_bifurcations(balance: Balance, problem: Problem, curve: Curve, continuation: Continuation) -> Curve:
    """The same branch with its period doublings and Neimark-Sacker points located.

    Parameters
    ----------
    balance : DescribingFunction or Galerkin
        Which truncation the exponents are those of.
    problem : Problem
        `balance.problem(...)`.
    curve : Curve
        As traced for that problem.
    continuation : Continuation
        Whose corrector is used.

    Returns
    -------
    Curve
        With points of the events PERIOD_DOUBLING and NEIMARK_SACKER inserted, in place of those that it may have had;
        all else is as it was. Static stability of an inserted point is that of its piece.

    Raises
    ------
    ArithmeticError
        If a bifurcation is bracketed but cannot be located.

    Notes
    -----
    Two of one kind between two neighbouring points of the branch cancel and are not seen.
    """
    known = np.isin(curve.event, (Event.PERIOD_DOUBLING, Event.NEIMARK_SACKER))
    if np.any(known):
        names = ("points", "tangents", "arclength", "stable", "event")
        curve = dataclasses.replace(curve, **{name: getattr(curve, name)[~known] for name in names})
    if len(curve.points) < 2:
        return curve
    watched = _watched(balance, problem)
    size = problem.unknowns + 1
    after, kinds, fractions = np.empty(_MOST, np.int64), np.empty(_MOST, np.int8), np.empty(_MOST)
    points, tangents = np.empty((_MOST, size)), np.empty((_MOST, size))
    count = scan(
        watched.setup(continuation.corrector),
        curve.points,
        curve.tangents,
        curve.arclength,
        curve.event,
        after,
        kinds,
        fractions,
        points,
        tangents,
    )
    if count < 0:
        place = curve.points[-1 - count, -1]
        raise ArithmeticError(f"a bifurcation next to the axis value {place:.9g} is bracketed but cannot be located")
    if count == 0:
        return curve
    order = np.lexsort((fractions[:count], after[:count]))
    at, steps = after[order], np.diff(curve.arclength)
    # A fold's neighbour on the far side tells the stability of the piece behind it.
    piece = np.where(curve.event[at] != Event.FOLD, curve.stable[at], curve.stable[at + 1])
    return dataclasses.replace(
        curve,
        points=np.insert(curve.points, at + 1, points[order], axis=0),
        tangents=np.insert(curve.tangents, at + 1, tangents[order], axis=0),
        arclength=np.insert(curve.arclength, at + 1, curve.arclength[at] + fractions[order] * steps[at]),
        stable=np.insert(curve.stable, at + 1, piece),
        event=np.insert(curve.event, at + 1, kinds[order]),
    )


def critical_frequencies(balance: Balance, problem: Problem, y: np.ndarray, tolerance: float = 1e-5) -> np.ndarray:
    """Frequencies of the exponents of a motion that lie on the imaginary axis.

    Parameters
    ----------
    balance, problem
        As for `with_bifurcations`.
    y : (n + 1,) array
        The motion and its axis value.
    tolerance : float
        How far from the axis they may lie, in units of the base frequency.

    Returns
    -------
    (k,) array
        Ascending imaginary parts over the base frequency Omega/nu, in (0, 1/2).
    """
    theta, direction = hill_vectors(balance, problem)
    found = np.empty(64)
    count = critical_shares(theta, direction, np.asarray(y, dtype=float), balance.truncated, tolerance, found)
    shares = np.sort(found[:count])
    return shares[np.diff(shares, prepend=-1.0) > 1e-6]


def doubled(
    balance: Balance,
    problem: Problem,
    point: np.ndarray,
    continuation: Continuation | None = None,
    amplitude: float = 0.02,
) -> tuple[Balance, Problem, np.ndarray]:
    """Switch to the branch of twice the period at a period doubling.

    Parameters
    ----------
    balance, problem
        As for `with_bifurcations`.
    point : (n + 1,) array
        A period doubling (u, p) of it.
    continuation : Continuation, optional
        Whose corrector is used.
    amplitude : float
        Size of the subharmonics at the start, in units of lambda's size.

    Returns
    -------
    balance : Galerkin
        Of the same order on twice the period.
    problem : Problem
        Its problem over the same axis.
    start : (2 n,) array
        A motion (u, p) of it with subharmonics along the critical perturbation, next to the point.

    Raises
    ------
    BranchSwitchError
        If the corrector does not converge. (After the describing function: its period doubling need not be one of the
        Galerkin balance of order 1, which keeps more of the force.)

    Notes
    -----
    The null vector l of the matrix over the half window can be turned such that l_(-1-k) = conj l_k; the perturbation
    2 Re sum_k l_k exp(i (k + 1/2) Omega tau/nu) is then a motion's harmonic 2 k + 1 of Omega/(2 nu).
    """
    # Its kernels are many, and who only wants the events does without them.
    from solver.harmonic.galerkin import Galerkin

    corrector, point = (continuation or Continuation()).corrector, np.asarray(point, dtype=float)
    wide = Galerkin(balance.order, 2 * balance.period)
    theta, direction = (vector.copy() for vector in hill_vectors(balance, problem))
    n, harmonics = problem.unknowns, balance.harmonics
    matrix = np.empty((2 * harmonics, 2 * harmonics), dtype=complex)
    half_order_matrix(theta, direction, point, balance.truncated, matrix)
    null = np.linalg.svd(matrix)[2][-1].conj()
    mirrored = null[::-1].conj()
    turned = null + mirrored if np.linalg.norm(null + mirrored) > 1.0 else 1j * (null - mirrored)
    theta[[layout.HARMONICS, layout.PERIOD]] *= 2.0
    start, normal = np.zeros(2 * n), np.zeros(2 * n)
    k = np.arange(1, harmonics + 1)
    start[0], start[4 * k - 1], start[4 * k], start[-1] = point[0], point[2 * k - 1], point[2 * k], point[-1]
    odd = turned[harmonics:]
    normal[4 * k - 3], normal[4 * k - 2] = odd.real, -odd.imag
    normal /= np.linalg.norm(normal)
    scale = np.append(np.full(2 * n - 1, problem.scale[0]), problem.scale[-1])
    model = wide.balance_problem(theta, direction, scale)
    start += amplitude * normal * scale
    iterations = corrector.kernel(
        model.balance,
        model.theta,
        model.direction,
        scale,
        start,
        normal,
        corrector.tolerance,
        4 * corrector.max_iterations,
        np.empty((workspace_rows(2 * n - 1), 2 * n)),
    )
    if iterations < 0:
        raise BranchSwitchError(f"no motion of twice the period was found next to the axis value {point[-1]:.9g}")
    return wide, model, start
