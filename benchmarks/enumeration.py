"""Time per point of the certified enumeration: the three parameter sets over frequency, one core.

Run it in the repository root with ``python -m benchmarks.enumeration``.
"""

import time

import numpy as np

from solver import Proof, all_solutions
from solver.enumeration.solutions import enumerate_values
from tests.conftest import MODELS

POINTS = 400


def kernel_times(model) -> np.ndarray:
    """Seconds per point of the compiled kernels alone, the best of five runs each."""
    times = np.full(POINTS, np.inf)
    for i, omega in enumerate(np.linspace(0.05, 2.0, POINTS)):
        for _ in range(5):
            start = time.perf_counter()
            enumerate_values(model, "omega", np.array([omega]), None, 100.0)
            times[i] = min(times[i], time.perf_counter() - start)
    return times


def call_times(model) -> tuple[np.ndarray, int]:
    """Seconds per call of `all_solutions`, and the number of points proven."""
    times, proven = np.empty(POINTS), 0
    for i, omega in enumerate(np.linspace(0.05, 2.0, POINTS)):
        start = time.perf_counter()
        result = all_solutions(model, omega)
        times[i] = time.perf_counter() - start
        proven += result.proof is Proof.PROVEN
    return times, proven


def main():
    print(f"{POINTS} points over omega = 0.05 ... 2, microseconds per point")
    print(f"{'set':<12} {'kernel median':>14} {'worst':>8} {'mean':>8} {'call median':>14} {'worst':>8} {'proven':>8}")
    for name, make in MODELS.items():
        model = make()
        kernel, (call, proven) = 1e6 * kernel_times(model), call_times(model)
        call = 1e6 * call
        print(
            f"{name:<12} {np.median(kernel):>14.1f} {kernel.max():>8.1f} {kernel.mean():>8.1f}"
            f" {np.median(call):>14.1f} {call.max():>8.1f} {proven:>8}"
        )


if __name__ == "__main__":
    main()
