"""A real `dask scheduler` on loopback with workers, all of them processes of their own."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

from distributed import Client

__all__ = ["Scheduler", "there", "wait_until"]

ROOT = Path(__file__).parents[2]


def wait_until(happens, seconds: float = 120.0) -> None:
    """Return when it happens."""
    deadline = time.monotonic() + seconds
    while not happens():
        assert time.monotonic() < deadline
        time.sleep(0.02)


def there(scheduler: "Scheduler", count: int) -> set[str]:
    """Wait until a scheduler has so many workers; their addresses."""
    with Client(scheduler.address, set_as_default=False) as onlooker:
        wait_until(lambda: len(onlooker.nthreads()) == count)
        return set(onlooker.nthreads())


class Scheduler:
    """What `dask scheduler` and `dask worker` start.

    Parameters
    ----------
    folder : Path
        Where the scheduler writes its file, which is read by those that want to find it.
    *options : str
        For the scheduler and its workers, such as those of TLS.
    **environment : str
        Of the scheduler alone.
    """

    def __init__(self, folder: Path, *options: str, **environment: str):
        self.file, self.options, self.processes = folder / "scheduler.json", options, []
        self.process = self._start("scheduler", "--host", "127.0.0.1", "--port", "0", sources=folder, **environment)
        wait_until(lambda: self.file.exists() and self.file.stat().st_size)
        self.address = json.loads(self.file.read_text())["address"]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.end_workers()
        self.process.kill()
        self.process.wait(30)

    def end_workers(self) -> None:
        """End those that were added."""
        for process in self.processes[1:]:
            process.kill()
            process.wait(30)
        del self.processes[1:]

    def add_worker(self, sources: Path = ROOT, **environment: str) -> subprocess.Popen:
        """One more worker, without a nanny that would start it again; its bevelmap is that of a folder."""
        return self._start("worker", "--nthreads", "1", "--no-nanny", sources=sources, **environment)

    def _start(self, what: str, *words: str, sources: Path = ROOT, **environment: str) -> subprocess.Popen:
        command = [sys.executable, "-m", f"distributed.cli.dask_{what}", "--scheduler-file", str(self.file)]
        process = subprocess.Popen(
            [*command, "--no-dashboard", *self.options, *words],
            cwd=sources,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "OMP_NUM_THREADS": "1", **environment},
        )
        self.processes.append(process)
        return process
