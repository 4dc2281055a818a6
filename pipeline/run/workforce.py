"""Where tasks run: in this process, on worker processes of this machine, or on a running dask scheduler.

Tasks are independent and write their own results; only small receipts come back, in any order.
"""

import contextlib
import importlib
import importlib.util
import logging
import signal
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from pipeline.config.schema import Cluster
from pipeline.errors import ConfigurationError

__all__ = ["KINDS", "Task", "WorkerLost", "Workforce", "check_cluster"]

KINDS = ("local", "none", "scheduler")

#: One thread each for the libraries that would otherwise start one per core in every worker.
_ONE_THREAD = {
    f"{library}_NUM_THREADS": "1" for library in ("OMP", "MKL", "OPENBLAS", "NUMBA", "NUMEXPR", "VECLIB_MAXIMUM")
}

#: Tasks under way per thread: one is computed, one waits.
_AHEAD = 2
#: A task is done again after this many losses of its worker.
_MOST_LOST = 2
#: Seconds between two counts of the workers.
_COUNT_EVERY = 1.0


class WorkerLost(RuntimeError):
    """The process that ran a task ended before the task did."""


@dataclass(frozen=True)
class Task:
    """Arguments of one call, and the address of a worker that should not get it."""

    arguments: tuple
    avoid: str | None = None


def check_cluster(config: Cluster) -> None:
    """Raise ConfigurationError unless the cluster settings make sense; nothing is started."""
    if config.kind not in KINDS:
        raise ConfigurationError(f"cluster.kind = {config.kind!r} is not allowed: it must be one of {', '.join(KINDS)}")
    if config.kind == "local" and not 1 <= config.workers <= 1024:
        raise ConfigurationError(f"cluster.workers = {config.workers} is not allowed: it must be from 1 to 1024")
    if config.kind == "scheduler" and bool(config.address) == bool(config.scheduler_file):
        raise ConfigurationError(
            f"cluster.address = {config.address!r} is not allowed with "
            f"cluster.scheduler_file = {config.scheduler_file!r}: "
            "one of them must say where the scheduler is, such as tcp://host:8786"
        )
    if config.kind == "scheduler" and config.scheduler_file and not Path(config.scheduler_file).is_file():
        raise ConfigurationError(
            f"cluster.scheduler_file = {config.scheduler_file!r} is not allowed: "
            "it must be a file that dask scheduler wrote"
        )
    if not 0.0 < config.row_seconds <= 1e6:
        raise ConfigurationError(f"cluster.row_seconds = {config.row_seconds} is not allowed: it must be from 0 to 1e6")
    _check_memory(config.memory)
    if config.dashboard and importlib.util.find_spec("bokeh") is None:
        raise ConfigurationError("cluster.dashboard = True is not allowed here: it needs the package bokeh")
    if not 0.0 < config.timeout <= 3600.0:
        raise ConfigurationError(
            f"cluster.timeout = {config.timeout} is not allowed: it must be from 0 to 3600 seconds"
        )


def _check_memory(memory: str) -> None:
    if memory == "auto":
        return
    from dask.utils import parse_bytes

    try:
        known = parse_bytes(memory) > 0
    except ValueError:
        known = False
    if not known:
        raise ConfigurationError(f"cluster.memory = {memory!r} is not allowed: it must be auto or a size such as 4GB")


class Workforce:
    """Runs tasks; workers start when first needed and serve all planes of a run.

    Parameters
    ----------
    config : Cluster
        Checked by `check_cluster`.

    Examples
    --------
    >>> from pipeline.config.schema import Cluster
    >>> with Workforce(Cluster("none", 1, "auto", 60.0, False, None, None, 10.0)) as workforce:
    ...     list(workforce.run(pow, [(2, 3), (3, 2)]))
    [((2, 3), 8), ((3, 2), 9)]
    """

    def __init__(self, config: Cluster):
        self.config = config
        self._client = None
        self._cluster = None
        self._size = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def start(self) -> str:
        """Start or reach the workers, once; a sentence that says where tasks run.

        Raises
        ------
        ConfigurationError
            If a scheduler does not answer in time.
        """
        if self.config.kind == "none":
            return "tasks run in this process"
        if self._client is None:
            _silence()
            if self.config.kind == "local":
                self._start_local()
            else:
                self._reach_scheduler()
        dashboard = f", dashboard {self._client.dashboard_link}" if self.config.dashboard else ""
        if self.config.kind == "local":
            return f"tasks run on {self.config.workers} worker processes{dashboard}"
        address, threads = self._client.scheduler.address, self.size
        if not threads:
            return f"waiting for workers: the scheduler at {address} has none yet{dashboard}"
        return f"tasks run on the scheduler at {address}, {threads} threads at present{dashboard}"

    def _start_local(self) -> None:
        import dask
        from distributed import Client, LocalCluster

        settings = {
            "distributed.nanny.pre-spawn-environ": {
                **dask.config.get("distributed.nanny.pre-spawn-environ", {}),
                **_ONE_THREAD,
            },
            # Whoever gave a task decides whether it is done again after its worker was lost.
            "distributed.scheduler.allowed-failures": 0,
        }
        with dask.config.set(settings), _deaf_to_interrupts():
            self._cluster = LocalCluster(
                n_workers=self.config.workers,
                threads_per_worker=1,
                processes=True,
                memory_limit=self.config.memory,
                # Any free port: a fixed one would be taken by the next run.
                dashboard_address=":0",
                scheduler_kwargs={"dashboard": self.config.dashboard},
                silence_logs=logging.CRITICAL,
            )
        self._client = Client(self._cluster, set_as_default=False)
        # Loading the kernels takes a worker a second, all of them at once here and not when the first rows are due.
        self._client.run(importlib.import_module, "solver")

    def _reach_scheduler(self) -> None:
        from distributed import Client

        file = self.config.scheduler_file
        where = {"scheduler_file": file} if file else {"address": self.config.address}
        key = "cluster.scheduler_file" if file else "cluster.address"
        try:
            self._client = Client(**where, timeout=self.config.timeout, set_as_default=False)
        except (OSError, ValueError, KeyError, TimeoutError) as error:
            reason = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise ConfigurationError(
                f"{key} = {file or self.config.address!r} is not allowed: it must be that of a dask scheduler, "
                f"and none answered there within {self.config.timeout:g} s ({reason})"
            ) from None

    def run(self, function: Callable, tasks: Iterable[tuple]) -> Iterator[tuple[tuple, object]]:
        """Call `function(*task)` for every task; yields (task, result), or (task, exception) where it raised.

        A task whose worker was lost is done again, up to three times in all.

        Parameters
        ----------
        function : callable
            Importable on the workers.
        tasks : iterable of tuple
            Small, picklable arguments; taken as workers become free.
        """
        source, again, lost = iter(tasks), deque(), Counter()

        def take() -> Task | None:
            arguments = again.popleft() if again else next(source, None)
            return None if arguments is None else Task(arguments)

        for task, result in self.serve(function, take):
            if isinstance(result, WorkerLost) and lost[id(task.arguments)] < _MOST_LOST:
                lost[id(task.arguments)] += 1
                again.append(task.arguments)
            else:
                yield task.arguments, result

    def serve(self, function: Callable, take: Callable[[], Task | None]) -> Iterator[tuple[Task, object]]:
        """Call `function(*task.arguments)` for whatever `take` gives, until it gives None and nothing is under way.

        Only a few tasks per worker are under way at a time, so that the memory of this process does not depend on their
        number, and what becomes of one can decide what `take` gives next.

        Yields
        ------
        (Task, object)
            With the result, or the exception that was raised, which is `WorkerLost` where the worker's process ended.

        Raises
        ------
        OSError
            If the scheduler goes away.
        """
        if self.config.kind == "none":
            while (task := take()) is not None:
                yield task, _attempt(function, task.arguments)
            return
        from distributed import as_completed

        self.start()
        running, finished = {}, as_completed(loop=self._client.loop)
        try:
            while self._refill(function, take, running, finished):
                future = next(finished)
                task = running.pop(future)
                yield task, self._outcome(future)
                future.release()
        finally:
            with contextlib.suppress(Exception):  # a client whose scheduler has gone has nothing to cancel
                self._client.cancel(list(running))

    def _refill(self, function, take, running: dict, finished) -> bool:
        """Submit tasks until workers have enough to do; whether anything is under way."""
        try:
            most = _AHEAD * max(self.size, 1)
            while len(running) < most and (task := take()) is not None:
                others = [address for address in self._addresses() if address != task.avoid] if task.avoid else []
                where = {"workers": others, "allow_other_workers": True} if others else {}
                future = self._client.submit(function, *task.arguments, pure=False, retries=0, **where)
                running[future] = task
                finished.add(future)
        except OSError:
            raise self._gone() from None
        return bool(running)

    def _gone(self) -> ConnectionError:
        return ConnectionError(f"the scheduler at {self._client.scheduler.address} is gone")

    def _outcome(self, future) -> object:
        """The result of a future, or what went wrong."""
        from distributed import CancelledError, KilledWorker

        try:
            error = future.exception()
            result = future.result() if error is None else error
        except (CancelledError, OSError):
            # What a task raised is returned by `exception`: this is the connection.
            raise self._gone() from None
        if isinstance(result, CancelledError):
            raise self._gone()
        if isinstance(result, KilledWorker):
            return WorkerLost(
                "its worker was lost: the process was ended from outside, as happens when memory runs out"
            )
        return result

    @property
    def size(self) -> int:
        """Number of threads that run tasks; workers of a foreign scheduler may come and go."""
        if self.config.kind == "none":
            return 1
        now = time.monotonic()
        if self._size is None or now - self._size[0] > _COUNT_EVERY:
            self._size = now, sum(self._client.nthreads().values())
        return self._size[1]

    def _addresses(self) -> list[str]:
        return list(self._client.nthreads())

    def close(self) -> None:
        """Stop the workers that this object started; a foreign scheduler goes on."""
        for part in (self._client, self._cluster):
            if part is not None:
                part.close()
        self._client = self._cluster = None


def _silence() -> None:
    """Keep dask's log off the terminal: what the user needs to know of lost workers and schedulers is said here."""
    import distributed  # noqa: F401  (it gives its loggers their levels when it is imported)

    for name in ["distributed", *logging.root.manager.loggerDict]:
        if name.split(".")[0] == "distributed":
            logging.getLogger(name).setLevel(logging.CRITICAL)


@contextlib.contextmanager
def _deaf_to_interrupts() -> Iterator[None]:
    """Processes started inside ignore Ctrl-C, which a terminal sends to all: stopping is this process's business."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    handler = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)


def _attempt(function: Callable, task: tuple):
    """The result, or the exception that a worker would have sent back."""
    try:
        return function(*task)
    except Exception as error:  # the reason is kept: it is reported exactly as one that comes from a worker
        return error
