"""Branches of any balance over the mesh frequency, cheaply: from the first-order motion at the upper end."""

import numpy as np

from solver import Continuation, LinearSeeds, sweep_row
from solver.harmonic.describing_function import DescribingFunction

LOW, HIGH = 0.3, 2.0


def branch(model, balance, continuation=None, low=LOW, high=HIGH):
    """Problem and main branch of a balance."""
    continuation = continuation or Continuation()
    first = sweep_row(model, "omega", np.linspace(low, high, 20), seeds=LinearSeeds()).curves[0]
    problem = balance.problem(model, "omega", low, high)
    if isinstance(balance, DescribingFunction):
        return problem, first
    start = first.points[0] if first.points[0, 3] == high else first.points[-1]
    y = np.append(balance.lifted(start[:3]), high)
    count = continuation.corrector.kernel(
        problem.balance,
        problem.theta,
        problem.direction,
        problem.scale,
        y,
        np.eye(y.size)[-1],
        1e-8,
        20,
        np.empty((3 * problem.unknowns + 6, y.size)),
    )
    assert count > 0
    y[-1] = high
    return problem, continuation.trace(problem, y, low, high, -1)
