"""`python -m benchmarks [quick] [FILE]` (make bench): figures of speed as a table, as JSON and in docs/speed.md."""

import os
import sys
import tempfile
import time
from pathlib import Path

# One core is what is measured and compared, except where a command starts its workers.
os.environ.update({f"{library}_NUM_THREADS": "1" for library in ("OMP", "MKL", "OPENBLAS", "NUMBA")})

from benchmarks.commands import measure_commands
from benchmarks.measurement import FULL, QUICK
from benchmarks.numerics import measure_numerics
from benchmarks.report import PAGE, document, fill, table, write

_FILE = Path("outputs/bench.json")


def main(arguments: list[str]) -> None:
    quick, files = "quick" in arguments, [argument for argument in arguments if argument != "quick"]
    file = Path(files[0]) if files else _FILE
    sizes, begin = QUICK if quick else FULL, time.perf_counter()
    with tempfile.TemporaryDirectory(prefix="bevelmap-bench-") as scratch:
        measurements, baselines = measure_numerics(sizes)
        measurements += measure_commands(Path(scratch), sizes, baselines)
    found = document(measurements, quick, time.perf_counter() - begin)
    write(found, file)
    print(table(found))
    print(f"\n{file.resolve()}")
    if not quick:
        fill(found, PAGE)
        print(PAGE.resolve())


if __name__ == "__main__":
    main(sys.argv[1:])
