"""How far given points lie from a traced boundary: it is traced once, however many rows have met it."""

import math

import numpy as np

from solver.continuation.continuation import Continuation, Curve, Problem
from solver.continuation.hermite import cubic, cubic_value
from solver.continuation.setup import SETUP, STRAND
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import copy_into, dot

__all__ = ["distances"]

_F = types.float64


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, ARRAY, _F, ARRAY, _F, ARRAY), inline=True)
def _foot(left, right, leave, arrive, scale, arc, factors, level, seed):
    """Fill `seed` with where the cubic between two points meets factors . y = level, or with its nearer end."""
    size = scale.shape[0]
    first, last, departs, arrives = -level, -level, 0.0, 0.0
    for j in range(size):
        first += factors[j] * left[j]
        last += factors[j] * right[j]
        departs += factors[j] * arc * leave[j] * scale[j]
        arrives += factors[j] * arc * arrive[j] * scale[j]
    a, b = cubic(first, last, departs, arrives)
    low, high = 0.0, 1.0
    if first * last >= 0.0:
        low = high = 0.0 if abs(first) <= abs(last) else 1.0
    x = low
    for _ in range(41):
        if low == high:
            break
        x = 0.5 * (low + high)
        if (cubic_value(a, b, departs, first, x) < 0.0) == (first < 0.0):
            low = x
        else:
            high = x
    for j in range(size):
        out, into = arc * leave[j] * scale[j], arc * arrive[j] * scale[j]
        a, b = cubic(left[j], right[j], out, into)
        seed[j] = cubic_value(a, b, out, left[j], x)


@kernel(_F(ARRAY, ARRAY, ARRAY, types.boolean[::1]), inline=True)
def _apart(left, right, scale, seen):
    """Largest difference of two y in the components that are seen, in scaled unknowns."""
    largest = 0.0
    for j in range(scale.shape[0]):
        if seen[j]:
            largest = max(largest, abs(left[j] - right[j]) / scale[j])
    return largest


@kernel(types.void(SETUP, STRAND, MATRIX, types.boolean[::1], _F, ARRAY))
def _distances(setup, strand, targets, seen, asked, nearest):
    n, scale = setup.unknowns, setup.scale
    points, tangents, arclength = strand.points, strand.tangents, strand.arclength
    factors, normal, seed, foot = np.empty(n + 1), np.empty(n + 1), np.empty(n + 1), np.empty(n + 1)
    last = points.shape[0] - 1
    far = np.empty(last + 1)
    for k in range(targets.shape[0]):
        target = targets[k]
        vertex = 0
        for i in range(last + 1):
            far[i] = 0.0
            for j in range(n + 1):
                if seen[j]:
                    far[i] += ((points[i, j] - target[j]) / scale[j]) ** 2
            if far[i] < far[vertex]:
                vertex = i
        nearest[k] = _apart(points[vertex], target, scale, seen)
        for i in range(last):
            if nearest[k] <= asked:
                break
            arc = arclength[i + 1] - arclength[i]
            # The nearest point may be one of another strand, which runs closer by than its points follow each other.
            if i != vertex and i + 1 != vertex and min(far[i], far[i + 1]) > arc * arc:
                continue
            end = i if far[i] <= far[i + 1] else i + 1
            # The target's own angles of contact and the like are not asked for: the hyperplane is one of what is seen.
            level, length = 0.0, 0.0
            for j in range(n + 1):
                normal[j] = tangents[end, j] if seen[j] else 0.0
                factors[j] = normal[j] / scale[j]
                level += factors[j] * target[j]
                length += normal[j] * normal[j]
            if length == 0.0:
                continue
            length = math.sqrt(length)
            for j in range(n + 1):
                normal[j] /= length
            _foot(points[i], points[i + 1], tangents[i], tangents[i + 1], scale, arc, factors, level, seed)
            apart = _apart(seed, target, scale, seen)
            # The cubic errs by some arc * turn^3/400.
            turn = math.sqrt(2.0 * max(0.0, 1.0 - dot(tangents[i], tangents[i + 1])))
            if apart + arc * turn**3 <= asked:
                nearest[k] = apart
                break
            # How far what the corrector finds may lie from here: further off it may belong to another curve.
            reach = 0.1 * arc + 1e-9
            if asked > 0.0 and apart - reach > asked:
                continue
            copy_into(foot, seed)
            iterations = setup.corrector(
                setup.residual_and_jacobian,
                setup.parameters,
                setup.parameter_slope,
                scale,
                foot,
                normal,
                setup.tolerance,
                setup.limit,
                setup.work,
            )
            if iterations < 0:
                continue
            moved = 0.0
            for j in range(n + 1):
                moved = max(moved, abs(foot[j] - seed[j]) / scale[j])
            if moved <= reach:
                nearest[k] = min(nearest[k], _apart(foot, target, scale, seen))


def distances(
    problem: Problem, curve: Curve, targets: np.ndarray, seen, continuation: Continuation, asked: float = 0.0
) -> np.ndarray:
    """Distance of points from a traced curve, across it.

    Parameters
    ----------
    problem, curve
        The curve, and the problem that it was traced for.
    targets : (k, n + 1) array
    seen : sequence of int
        The components of y that count; those of the targets that do not are not looked at.
    continuation : Continuation
        Whose corrector is used.
    asked : float
        If it is not 0, only which distances are larger than this is asked: that takes less.

    Returns
    -------
    (k,) array
        In scaled unknowns (largest component). Exact where the curve passes within a step; further off, the distance
        from the closest of the curve's own points.
    """
    mask = np.zeros(problem.unknowns + 1, dtype=np.bool_)
    mask[list(seen)] = True
    nearest = np.full(len(targets), np.inf)
    if len(targets):
        setup = problem.setup(continuation.corrector)
        _distances(setup, curve.strand, np.ascontiguousarray(targets, dtype=float), mask, asked, nearest)
    return nearest
