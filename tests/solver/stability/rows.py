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
    y = problem.corrected(y, continuation.corrector, max_iterations=20)
    assert y is not None
    return problem, continuation.trace(problem, y, low, high, -1)
