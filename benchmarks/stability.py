"""Microseconds per motion of the stability analysis by both methods, one core: rows of the default plane, and order 5.

Run it in the repository root with ``python -m benchmarks.stability``.
"""

import os
import statistics
import time

# One core is what is measured; NumPy's eigenvalues must not take both.
os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")

import numpy as np

from solver import Continuation, all_solutions, sweep_row
from solver.harmonic.galerkin import Galerkin
from solver.stability import assess, assessment, hill_multipliers, multipliers, system_row, truncation_of
from tests.conftest import MODELS, published

GRID = np.linspace(0.05, 2.0, 400)
REPEATS = 7


def median_time(call) -> float:
    """Median of several calls, seconds."""
    times = []
    for _ in range(REPEATS):
        begin = time.perf_counter()
        call()
        times.append(time.perf_counter() - begin)
    return statistics.median(times)


def row_motions(model):
    """Axis values and first-order motions of a row over frequency."""
    row = sweep_row(model, "omega", GRID)
    present = row.stable >= 0
    return np.repeat(GRID, present.sum(axis=1)), np.stack([row.mean, row.cos, row.sin], axis=2)[present]


def curve_motions(model, balance):
    """Axis values and motions of a Galerkin curve, from the solution at the highest frequency down."""
    problem, high = balance.problem(model, "omega", GRID[0], GRID[-1]), GRID[-1]
    solutions = all_solutions(model, high)
    first = np.array([solutions.mean[0], solutions.cos[0], solutions.sin[0]])
    curve = Continuation().trace(problem, np.append(balance.lifted(first), high), GRID[0], high, heading=-1)
    return curve.points[:, -1].copy(), curve.points[:, :-1].copy()


def report(name, model, values, motions, balance):
    row, truncation = system_row(model, "omega", values), truncation_of(balance)
    found = multipliers(row, motions, truncation.period)

    def fresh():
        assessment.forget()
        assess(model, "omega", values, motions, balance=balance)

    calls = (
        lambda: multipliers(row, motions, truncation.period),
        lambda: hill_multipliers(row, motions, truncation, found),
        fresh,
        lambda: assess(model, "omega", values, motions, balance=balance),
    )
    times = (1e6 * median_time(call) / len(values) for call in calls)
    print(f"{name:<28}{len(values):>8}" + "".join(f"{t:>10.1f}" for t in times))


def main():
    print("microseconds per motion, median of", REPEATS)
    print(f"{'':<28}{'motions':>8}{'Floquet':>10}{'Hill':>10}{'both':>10}{'next row':>10}")
    for f_e in (0.1, 0.2, 0.4):
        model = published(f_e=f_e)
        report(f"first order, f_e = {f_e}", model, *row_motions(model), None)
    for order in (5, 11):
        for name, make in MODELS.items():
            balance = Galerkin(order)
            report(f"order {order}, {name}", make(), *curve_motions(make(), balance), balance)


if __name__ == "__main__":
    main()
