"""How many workers one client and one scheduler can keep busy: tasks that sleep, and receipts as of real rows.

    python -m benchmarks.cluster_limits [--threads 200 1000] [--block 0.05] [--rounds 8]

A scheduler and workers of many threads are started on this machine. The sweep's own loop gives them blocks that only
sleep, in batches as for rows, so that every thread stands for a core of a cluster. What one task costs the client and
the scheduler is their processor time, which hardly depends on what else the machine does; from it follows how many
cores they can keep busy. Three lines for every number of threads: tasks of a second, tasks as the program sizes them,
and the same shared out to planes of a study.
"""

import argparse
import importlib
import os
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import psutil

ROOT = Path(__file__).resolve().parents[1]
#: Threads of one worker process: more would wait for one another in Python.
_THREADS = 250
#: Blocks of a plane of 400 x 200.
_PLANE = 34


@dataclass(frozen=True)
class Costs:
    """What some tasks took: seconds of the wall clock and of the processor of client and scheduler."""

    tasks: int
    asleep: float
    wall: float
    client: float
    scheduler: float


def pretend(path: str, plan, blocks, limit: float):
    """What a worker does: sleep as long as `path` says for every block, and send the receipts of real ones."""
    from pipeline.run.admission import worker_address
    from pipeline.run.rows import Outcome, Receipt

    time.sleep(float(Path(path).name) * len(blocks))
    return Outcome(tuple(Receipt(block, (), 5000, float(Path(path).name)) for block in blocks), worker_address())


@contextmanager
def started(threads: int, folder: Path):
    """A scheduler with workers of so many threads in all: its file and its process."""
    file, environment = folder / "scheduler.json", {**os.environ, "PYTHONPATH": str(ROOT)}
    quiet = dict(stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment)

    def start(what: str, *words: str) -> subprocess.Popen:
        command = [sys.executable, "-m", f"distributed.cli.dask_{what}", "--scheduler-file", str(file), *words]
        process = subprocess.Popen(command, **quiet)
        ended.callback(process.wait, 30)
        ended.callback(process.terminate)
        return process

    with ExitStack() as ended:
        scheduler = start("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard")
        while not file.exists():
            time.sleep(0.1)
        for count in [_THREADS] * (threads // _THREADS) + [threads % _THREADS] * (threads % _THREADS > 0):
            start("worker", "--nthreads", str(count), "--nworkers", "1", "--no-nanny", "--no-dashboard")
        yield file, psutil.Process(scheduler.pid)


def measured(workforce, scheduler: psutil.Process, block: float, seconds: float | None, planes: int, rounds: int):
    """Give out blocks for so many rounds of tasks on every thread; tasks as the program sizes them, or of `seconds`."""
    from pipeline.config.compose import compose
    from pipeline.multirun.turns import run_side_by_side
    from pipeline.plan.plan import Block
    from pipeline.plan.planning import plan
    from pipeline.run import dispatch

    # Of this process alone. Workers find it by its name, which of a script is another one.
    dispatch.sweep_blocks = importlib.import_module("benchmarks.cluster_limits").pretend
    planned, tasks = plan(compose([])), []
    held = workforce.task_seconds if seconds is None else seconds
    total = int(rounds * workforce.size * held / block)
    blocks = [Block(number, number + 1) for number in range(-(-total // planes))]

    def give(shared) -> None:
        for _, result in dispatch.dispatch(Path(str(block)), planned, blocks, shared, tasks.append):
            if isinstance(result, Exception):
                raise result

    fixed = workforce if seconds is None else _Sized(workforce, seconds)
    begin, client, before = time.perf_counter(), time.process_time(), scheduler.cpu_times()
    if planes == 1:
        give(fixed)
    else:
        run_side_by_side(workforce, [give] * planes)
    wall, client, after = time.perf_counter() - begin, time.process_time() - client, scheduler.cpu_times()
    used = after.user + after.system - before.user - before.system
    return Costs(len(tasks), block * len(blocks) * planes, wall, client, used)


class _Sized:
    """A workforce whose tasks hold so many seconds."""

    def __init__(self, workforce, seconds: float):
        self._workforce, self.task_seconds = workforce, seconds

    def __getattr__(self, name: str):
        return getattr(self._workforce, name)


def line(what: str, threads: int, costs: Costs) -> str:
    """A line of the table."""
    client, scheduler = costs.client / costs.tasks, costs.scheduler / costs.tasks
    held = costs.asleep / costs.tasks
    return (
        f"{threads:>6} {what:<26} {costs.tasks:>6} tasks of {held:5.2f} s  {costs.tasks / costs.wall:6.0f} tasks/s  "
        f"{costs.asleep / (threads * costs.wall):5.0%} busy  client {1e3 * client:5.2f} ms a task, "
        f"{costs.client / costs.wall:4.0%} of a core  scheduler {1e3 * scheduler:5.2f} ms, "
        f"{costs.scheduler / costs.wall:4.0%}  limit {held / max(client, scheduler):7.0f} cores"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--threads", type=int, nargs="+", default=[200, 1000])
    parser.add_argument("--block", type=float, default=0.05, help="seconds of a block")
    parser.add_argument("--rounds", type=int, default=8, help="tasks for every thread")
    given = parser.parse_args()
    from pipeline.config.compose import compose
    from pipeline.run.workforce import Workforce

    for threads in given.threads:
        with tempfile.TemporaryDirectory() as scratch, started(threads, Path(scratch)) as (file, scheduler):
            words = ["cluster=scheduler", f"cluster.scheduler_file={file}", "cluster.timeout=60"]
            config = replace(compose(words).config.cluster, row_seconds=60.0)
            with Workforce(config, print) as workforce:
                workforce.start()
                while workforce.size < threads:
                    time.sleep(0.5)
                planes = max(2, int(given.rounds * threads * workforce.task_seconds / given.block) // _PLANE)
                for what, seconds, count in (
                    ("tasks of a second", 1.0, 1),
                    ("tasks as they are sized", None, 1),
                    (f"{planes} planes", None, planes),
                ):
                    costs = measured(workforce, scheduler, given.block, seconds, count, given.rounds)
                    print(line(what, threads, costs), flush=True)


if __name__ == "__main__":
    main()
