"""Where tasks run: in this process, on worker processes of this machine, or on a running dask scheduler.

Tasks are independent and write their own results; only small receipts come back, in any order.
"""

import contextlib
import importlib
import logging
import time
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from pipeline.cluster_settings import address_of, security_of, setting_of
from pipeline.errors import ConfigurationError
from pipeline.schema import Cluster

__all__ = ["Task", "WorkerLost", "Workforce"]

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


class Workforce:
    """Runs tasks; workers start when first needed and serve all planes of a run.

    Parameters
    ----------
    config : Cluster
        Checked by `pipeline.cluster_settings.check_cluster`.

    Examples
    --------
    >>> from pipeline.config import compose
    >>> with Workforce(compose(["cluster=none"]).config.cluster) as workforce:
    ...     list(workforce.run(pow, [(2, 3), (3, 2)]))
    [((2, 3), 8), ((3, 2), 9)]
    """

    def __init__(self, config: Cluster):
        self.config = config
        self._client = None
        self._open = contextlib.ExitStack()
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
        from distributed import Client

        from pipeline.local_cluster import local_cluster

        cluster = local_cluster(self.config.workers, self.config.memory, self.config.dashboard)
        self._client = Client(self._open.enter_context(cluster), set_as_default=False)
        self._open.enter_context(contextlib.closing(self._client))
        # Loading the kernels takes a worker a second, all of them at once here and not when the first rows are due.
        self._client.run(importlib.import_module, "solver")

    def _reach_scheduler(self) -> None:
        from distributed import Client

        address = address_of(self.config)
        security = security_of(self.config, address)
        try:
            self._client = Client(address, security=security, timeout=self.config.timeout, set_as_default=False)
        except (OSError, ValueError, KeyError, TimeoutError) as error:
            reason = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise ConfigurationError(
                f"{setting_of(self.config)} is not allowed: it must be that of a dask scheduler, "
                f"and none answered there within {self.config.timeout:g} s ({reason})"
            ) from None
        self._open.enter_context(contextlib.closing(self._client))

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
        self._client = None
        self._open.close()


def _silence() -> None:
    """Keep dask's log off the terminal: what the user needs to know of lost workers and schedulers is said here."""
    import distributed  # noqa: F401  (it gives its loggers their levels when it is imported)

    for name in ["distributed", *logging.root.manager.loggerDict]:
        if name.split(".")[0] == "distributed":
            logging.getLogger(name).setLevel(logging.CRITICAL)


def _attempt(function: Callable, task: tuple):
    """The result, or the exception that a worker would have sent back."""
    try:
        return function(*task)
    except Exception as error:  # the reason is kept: it is reported exactly as one that comes from a worker
        return error
