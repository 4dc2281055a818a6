"""What the solver alone takes, in this process and on one thread, beside the two baselines.

Processor time, for solver and baselines alike: what else the machine does counts little.
"""

import time

import numpy as np

from benchmarks.baselines import fsolve_sweep, runge_kutta_sweep
from benchmarks.measurement import Baselines, Measurement, Sizes, timed
from pipeline.config.compose import compose
from pipeline.plan.numerics import balance_of, continuation_of, model_at, row_of, seeds_of
from pipeline.plan.plan import Plan
from pipeline.plan.planning import plan
from solver import first_order_problem
from solver.enumeration.solutions import enumerate_values
from solver.harmonic.describing_function import linear_solution

__all__ = ["measure_numerics"]


def measure_numerics(sizes: Sizes) -> tuple[list[Measurement], Baselines]:
    """Kernel, row, enumeration and a row of order 5, and what the baselines take per frequency."""
    first, fifth = (
        plan(compose(["plane=omega_fe", *solver, f"plane.sweep.num={sizes.columns}", "plane.parameter.num=2"]))
        for solver in ([], ["solver=hb"])
    )
    model, grid = model_at(first, 0.2, 1.0), first.sweep.values
    # Compiled here, so that it is not measured.
    runge_kutta_sweep(model, grid[:1], 2, 8)
    slow = {
        name: _once(lambda sweep=sweep: sweep(model, grid)) / (2 * grid.size)
        for name, sweep in (("fsolve", fsolve_sweep), ("runge_kutta", runge_kutta_sweep))
    }
    baselines = Baselines(**slow)
    per_point = {name: 1e6 * seconds for name, seconds in slow.items()}
    per_row = {name: 1e3 * seconds for name, seconds in baselines.of(sizes.columns).items()}
    return [
        _kernel(first, model, sizes, per_point),
        _enumeration(model, grid, sizes, per_point),
        _row("row", f"a row of {sizes.columns} columns with all that is stored of it", first, sizes, per_row),
        _row("row_order_5", f"the same of order 5 (solver=hb), {sizes.columns} columns", fifth, sizes, per_row),
    ], baselines


def _once(action) -> float:
    """Seconds of one call, the first."""
    begin = time.process_time()
    action()
    return time.process_time() - begin


def _kernel(planned: Plan, model, sizes: Sizes, baselines) -> Measurement:
    low, high = planned.sweep.low, planned.sweep.high
    problem, continuation = first_order_problem(model, "omega", low, high), continuation_of(planned.solver)
    unknowns = np.empty(3)
    linear_solution(problem.parameters, problem.parameter_slope, low, unknowns)
    start = np.append(unknowns + [model.b, 0.0, 0.0], low)
    points = len(continuation.trace(problem, start, low, high).points)
    values = timed(
        lambda: continuation.trace(problem, start, low, high), 10 * sizes.repeats, 1e6 / points, time.process_time
    )
    return Measurement("kernel", f"tracing, per accepted point of a curve of {points}", "us", values, baselines)


def _enumeration(model, grid: np.ndarray, sizes: Sizes, baselines) -> Measurement:
    values = timed(
        lambda: enumerate_values(model, "omega", grid, None, 100.0), sizes.repeats, 1e6 / grid.size, time.process_time
    )
    return Measurement("enumeration", "every solution at a point, proven", "us", values, baselines)


def _row(name: str, what: str, planned: Plan, sizes: Sizes, baselines) -> Measurement:
    settings = planned.solver
    parts = balance_of(settings), continuation_of(settings), seeds_of(settings)
    values = timed(lambda: row_of(planned, 0.2, *parts), sizes.repeats, 1e3, time.process_time)
    return Measurement(name, what, "ms", values, baselines)
