"""The direction of a boundary from one of its points."""

import numpy as np

from solver.continuation.continuation import Problem

__all__ = ["curve_tangent"]


def curve_tangent(problem: Problem, y: np.ndarray) -> np.ndarray:
    """Unit tangent in scaled unknowns, towards growing p."""
    n = problem.unknowns
    jacobian = np.empty((n, n + 1))
    problem.balance(problem.theta, problem.direction, y, np.empty(n), jacobian)
    jacobian *= problem.scale
    # The rows differ by orders of magnitude next to grazings.
    size = np.linalg.norm(jacobian, axis=1, keepdims=True)
    tangent = np.linalg.svd(jacobian / np.where(size > 0.0, size, 1.0))[2][-1]
    return tangent if tangent[-1] >= 0.0 else -tangent
