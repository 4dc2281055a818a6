"""Does the sweep stage scale: memory, time and size over the size of the plane, and two workers against one.

    python -m benchmarks.scale memory 400x200 2000x1000 4000x2000 [--seconds 300]
    python -m benchmarks.scale workers [--rows 200] [--repeats 5]

`memory` sweeps each plane by the command line, samples the resident memory of the client and of its largest worker, and
stops a sweep that takes longer than --seconds, whose rows so far are counted. `workers` gives the same rows to one
worker and to two in turn, and compares the seconds that the rows took on the workers with workers times the wall clock.
"""

import argparse
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import psutil

ROOT = Path(__file__).resolve().parents[1]


def family(process: subprocess.Popen) -> tuple[float, float]:
    """Resident megabytes of the client and of its largest other process."""
    try:
        client = psutil.Process(process.pid)
        others = [child.memory_info().rss for child in client.children(recursive=True)]
        return client.memory_info().rss / 1e6, max(others, default=0) / 1e6
    except psutil.NoSuchProcess:
        return 0.0, 0.0


def measure(folder: Path, columns: int, rows: int, layers: int | None, limit: float) -> str:
    """Sweep one plane or volume; a line of the table."""
    name = "x".join(str(size) for size in (columns, rows, layers) if size)
    plane = ["plane=omega_b_fe", f"plane.parameter2.num={layers}"] if layers else ["plane=omega_fe"]
    command = [
        sys.executable,
        "-m",
        "pipeline",
        *plane,
        f"plane.sweep.num={columns}",
        f"plane.parameter.num={rows}",
        f"store.name={name}",
        "store.max_points=4096",
        "stages=[sweep]",
        "cluster.workers=2",
    ]
    # Into a file: a pipe that nobody reads would stop the run.
    with (folder / f"{name}.log").open("w") as log:
        process = subprocess.Popen(command, cwd=folder, env={**os.environ, "PYTHONPATH": str(ROOT)}, stdout=log)
    begin, samples = time.monotonic(), []
    while process.poll() is None and time.monotonic() - begin < limit:
        samples.append((time.monotonic() - begin, *family(process)))
        time.sleep(0.25)
    stopped = process.poll() is None
    if stopped:
        workers = psutil.Process(process.pid).children(recursive=True)
        process.terminate()
        for worker in psutil.wait_procs(workers, timeout=10.0)[1]:
            worker.kill()
    process.wait()
    said = (folder / f"{name}.log").read_text()
    found = re.search(r"sweep: (\d+) rows, \d+ branch points in ([\d.]+) s", said)
    counts = re.findall(r"(\d+)/\d+ rows, (\d+) rows/s", said)
    done, seconds = (int(found[1]), float(found[2])) if found else (int(counts[-1][0]) if counts else 0, limit)
    # Of the last three quarters, what the second half adds: memory that grows with rows would show here.
    steady = samples[len(samples) // 4 :]
    middle = len(steady) // 2
    halves = steady[:middle], steady[middle:]
    growth = [max(s[i] for s in halves[1]) - max(s[i] for s in halves[0]) for i in (1, 2)] if middle else [0, 0]
    size = sum(file.stat().st_size for file in (folder / "outputs/store" / f"{name}.zarr").rglob("*") if file.is_file())
    return (
        f"{name:>14} {done:>7} rows{' (stopped)' if stopped else '':10} {seconds:7.1f} s {done / seconds:7.1f} rows/s "
        f"{1e3 * seconds / max(done, 1):7.1f} ms/row {1e6 * seconds / max(done * columns, 1):6.1f} us/cell  "
        f"client {max(s[1] for s in samples):5.0f} MB ({growth[0]:+.0f})  "
        f"worker {max(s[2] for s in samples):5.0f} MB ({growth[1]:+.0f})  {size / max(done * columns, 1):6.1f} B/cell"
    )


@dataclass(frozen=True)
class Effort:
    """Seconds for some rows: of the wall clock, of the rows by their receipts, of the processor, workers and client."""

    wall: float
    rows: float
    workers: float
    client: float


def processor_seconds() -> tuple[float, float]:
    """Used so far by the children of this process, which are the workers, and by itself, with the scheduler in it."""
    own = psutil.Process()
    children = [child.cpu_times() for child in own.children(recursive=True)]
    return sum(child.user + child.system for child in children), time.process_time()


def crew(folder: Path, workers: int, rows: int) -> Effort:
    """What rows cost on so many workers that are warm."""
    from pipeline import store
    from pipeline.config.compose import compose
    from pipeline.plan.planning import plan
    from pipeline.run.dispatch import dispatch
    from pipeline.run.workforce import Workforce

    settings = compose([f"cluster.workers={workers}", f"plane.parameter.num={rows}"])
    planned = plan(settings)
    with Workforce(settings.config.cluster) as workforce:
        workforce.start()
        for name in ("warm", "measured"):
            path = folder / f"{name}-{workers}-{time.monotonic_ns()}.zarr"
            store.create(path, planned, name, "benchmark\n")
            begin, before = time.perf_counter(), processor_seconds()
            receipts = [receipt for _, receipt in dispatch(path, planned, planned.blocks, workforce)]
            wall = time.perf_counter() - begin
            used = [late - early for late, early in zip(processor_seconds(), before, strict=True)]
    return Effort(wall, sum(receipt.seconds for receipt in receipts), *used)


def compare(rows: int, repeats: int) -> None:
    """One worker and two in turn; medians.

    On a machine that others use, the wall clock says little: twice the workers get twice the share of a busy processor,
    or not. So there is a second efficiency, from what does not depend on others: the processor time of the workers for
    the same rows, and the share of their time in which they had a row to work on.
    """
    efforts = {1: [], 2: []}
    with tempfile.TemporaryDirectory() as scratch:
        for _ in range(repeats):
            for workers in (1, 2):
                effort = crew(Path(scratch), workers, rows)
                efforts[workers].append(effort)
                print(
                    f"  {workers} workers: {effort.wall:6.2f} s, "
                    f"{1.0 - busy_share(effort, workers):5.1%} not in rows, "
                    f"processor {effort.workers:.2f} s workers, {effort.client:.2f} s client and scheduler, "
                    f"load {os.getloadavg()[0]:.1f}",
                    flush=True,
                )
    pairs = list(zip(efforts[1], efforts[2], strict=True))
    by_wall = statistics.median(one.wall / (2 * two.wall) for one, two in pairs)
    by_work = statistics.median(
        one.workers / two.workers * busy_share(two, 2) / busy_share(one, 1) for one, two in pairs
    )
    print(
        f"{rows} rows, {repeats} pairs: efficiency of two workers {by_wall:.2f} by the wall clock, "
        f"{by_work:.2f} by work and waiting"
    )
    for workers in (1, 2):
        idle = statistics.median(1.0 - busy_share(effort, workers) for effort in efforts[workers])
        client = statistics.median(effort.client / effort.workers for effort in efforts[workers])
        print(
            f"on {workers}: {idle:.1%} of workers x wall clock not in rows; client and scheduler use {client:.1%} of "
            f"the workers' processor time"
        )


def busy_share(effort: Effort, workers: int) -> float:
    """Of the workers' time, the share in which they computed rows."""
    return effort.rows / (workers * effort.wall)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    modes = parser.add_subparsers(dest="mode", required=True)
    memory, workers = modes.add_parser("memory"), modes.add_parser("workers")
    memory.add_argument("sizes", nargs="+", help="columns x rows, or columns x rows x layers")
    memory.add_argument("--seconds", type=float, default=600.0)
    workers.add_argument("--rows", type=int, default=200)
    workers.add_argument("--repeats", type=int, default=5)
    given = parser.parse_args()
    if given.mode == "workers":
        compare(given.rows, given.repeats)
        return
    with tempfile.TemporaryDirectory() as scratch:
        for size in given.sizes:
            numbers = [int(number) for number in size.split("x")]
            columns, rows, layers = [*numbers, None][:3]
            print(measure(Path(scratch), columns, rows, layers, given.seconds), flush=True)


if __name__ == "__main__":
    main()
