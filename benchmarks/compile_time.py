"""`python -m benchmarks.compile_time`: what compiling kernels takes, from an empty cache, one process, one core.

Seconds of processor time depend on the machine and on what else it does. Each set is therefore compared with one fixed
function, which numba compiles in the same process again and again while the set is compiled: the ratio is what can be
compared between versions of the program.
"""

import json
import os
import pkgutil
import statistics
import subprocess
import sys
import tempfile
import time

import solver
from pipeline.run.kernels import kernels_for

__all__ = ["SETS", "measured"]

#: Sets by name: modules or kernels.
SETS = {
    "rows": kernels_for(["sweep"], "describing_function"),
    "plane": kernels_for(["sweep", "boundaries", "figures"], "describing_function"),
    "rows_hb": kernels_for(["sweep"], "galerkin"),
    "all": [module.name for module in pkgutil.walk_packages(solver.__path__, "solver.") if not module.ispkg],
}


def _reference(x, values, matrix):
    """A function of an ordinary kernel's size; it must stay as it is, or ratios of two versions cannot be compared."""
    total = 0.0
    for i in range(values.shape[0]):
        y = x
        for j in range(matrix.shape[1]):
            y += matrix[i, j] * values[j] - 0.5 * y * y
            if y > 10.0:
                y = 10.0 / (1.0 + y)
            elif y < -10.0:
                y = -y
        values[i] = y
        total += y
    for i in range(values.shape[0]):
        for j in range(i):
            matrix[i, j] = (values[i] - values[j]) / (1.0 + abs(total))
            if matrix[i, j] > 0.0:
                total -= matrix[i, j] ** 2
    return total


def _compile_reference() -> float:
    """Seconds of processor time."""
    import numba

    begin = time.process_time()
    numba.njit("float64(float64, float64[::1], float64[:, ::1])", error_model="numpy")(_reference)
    return time.process_time() - begin


def _measure(names: list[str]) -> dict:
    """In this process, which must have compiled nothing yet."""
    from solver.kernels.warm import kernels_of, warm

    kernels = kernels_of(names)
    # The first one makes numba load what every compilation needs.
    _compile_reference()
    references, seconds = [_compile_reference()], {}
    for kernel in kernels:
        begin = time.process_time()
        warm([kernel])
        seconds[f"{kernel.__module__}.{kernel.__name__}"] = time.process_time() - begin
        references.append(_compile_reference())
    return {"seconds": seconds, "reference": statistics.median(references)}


def measured(names: list[str]) -> dict:
    """Seconds of processor time by kernel, in the order of compiling, and those of the reference; a new process."""
    with tempfile.TemporaryDirectory(prefix="bevelmap-bench-") as cache:
        code = f"import json\nfrom benchmarks.compile_time import _measure\nprint(json.dumps(_measure({names!r})))"
        environment = {**os.environ, "NUMBA_CACHE_DIR": cache}
        done = subprocess.run(
            [sys.executable, "-c", code], env=environment, stdout=subprocess.PIPE, check=True, text=True
        )
        return json.loads(done.stdout)


def main(arguments: list[str]) -> None:
    """A table of the sets that are named, or of all, or of one set's kernels with `-v`."""
    for name in [argument for argument in arguments if argument != "-v"] or SETS:
        found = measured(SETS[name])
        total = sum(found["seconds"].values())
        print(
            f"{name:8} {len(found['seconds']):3} kernels {total:7.1f} s  {total / found['reference']:6.0f} references"
        )
        for kernel, seconds in sorted(found["seconds"].items(), key=lambda item: -item[1]) if "-v" in arguments else ():
            print(f"  {seconds:7.2f} s {seconds / found['reference']:6.1f}  {kernel}")


if __name__ == "__main__":
    main(sys.argv[1:])
