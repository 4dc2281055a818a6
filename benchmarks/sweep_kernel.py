"""Microseconds per accepted point of a first-order curve, one thread; and the same curve by SciPy, as most write it.

Run it in the repository root with ``python -m benchmarks.sweep_kernel``.
"""

import statistics
import time

import numpy as np

from benchmarks.baselines import fsolve_sweep
from pipeline.config.compose import compose
from pipeline.plan.numerics import continuation_of, model_at
from pipeline.plan.planning import plan
from solver import Event, first_order_problem, sweep_row
from solver.harmonic.describing_function import linear_solution

LOW, HIGH, REPEAT = 0.05, 2.0, 200
GRID = np.linspace(LOW, HIGH, 400)


def medians(action, repeat: int) -> float:
    """Median seconds of one call."""
    action()
    times = []
    for _ in range(repeat):
        begin = time.perf_counter()
        action()
        times.append(time.perf_counter() - begin)
    return statistics.median(times)


def main() -> None:
    print(
        f"{'gear':12s} {'points':>7s} {'events':>7s} {'us/point':>9s} {'us/point Broyden':>17s} {'ms/row':>8s} "
        f"{'fsolve ms/row':>14s} {'ratio':>7s}"
    )
    for gear in ("published", "consistent", "antiphase"):
        planned = plan(compose([f"gear={gear}", "plane=omega_b"]))
        model = model_at(planned, 1.0, 1.0)
        problem = first_order_problem(model, "omega", LOW, HIGH)
        unknowns = np.empty(3)
        linear_solution(problem.parameters, problem.parameter_slope, LOW, unknowns)
        start = np.append(unknowns + [model.b, 0.0, 0.0], LOW)
        per_point = {}
        for corrector in ("newton", "broyden"):
            continuation = continuation_of({**planned.solver, "corrector": corrector})
            curve = continuation.trace(problem, start, LOW, HIGH)
            seconds = medians(lambda c=continuation: c.trace(problem, start, LOW, HIGH), REPEAT)
            per_point[corrector] = 1e6 * seconds / len(curve.points)
            if corrector == "newton":
                points, events = len(curve.points), int(np.sum(curve.event != Event.NONE))
        row = medians(lambda: sweep_row(model, "omega", GRID), REPEAT)
        plain = medians(lambda: fsolve_sweep(model, GRID), 1)
        print(
            f"{gear:12s} {points:7d} {events:7d} {per_point['newton']:9.2f} {per_point['broyden']:17.2f} "
            f"{1e3 * row:8.2f} {1e3 * plain:14.0f} {plain / row:7.0f}"
        )


if __name__ == "__main__":
    main()
