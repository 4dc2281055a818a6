"""Where tasks run: in this process, on worker processes of this machine, or on a running dask scheduler.

Tasks are independent and write their own results; only small receipts come back, in any order.
"""

import contextlib
import importlib
import importlib.util
import logging
import signal
import threading
from collections.abc import Callable, Iterator, Sequence

from pipeline.errors import ConfigurationError
from pipeline.schema import Cluster

__all__ = ["KINDS", "Workforce", "check_cluster"]

KINDS = ("local", "none", "scheduler")

#: One thread each for the libraries that would otherwise start one per core in every worker.
_ONE_THREAD = {
    f"{library}_NUM_THREADS": "1" for library in ("OMP", "MKL", "OPENBLAS", "NUMBA", "NUMEXPR", "VECLIB_MAXIMUM")
}


def check_cluster(config: Cluster) -> None:
    """Raise ConfigurationError unless the cluster settings make sense; nothing is started."""
    if config.kind not in KINDS:
        raise ConfigurationError(f"cluster.kind = {config.kind!r} is not allowed: it must be one of {', '.join(KINDS)}")
    if config.kind == "local" and not 1 <= config.workers <= 1024:
        raise ConfigurationError(f"cluster.workers = {config.workers} is not allowed: it must be from 1 to 1024")
    if config.kind == "scheduler" and not config.address:
        raise ConfigurationError(
            f"cluster.address = {config.address!r} is not allowed: it must be a scheduler's, such as tcp://host:8786"
        )
    if config.dashboard and importlib.util.find_spec("bokeh") is None:
        raise ConfigurationError("cluster.dashboard = True is not allowed here: it needs the package bokeh")
    if not 0.0 < config.timeout <= 3600.0:
        raise ConfigurationError(f"cluster.timeout = {config.timeout} is not allowed: it must be from 0 to 3600 seconds")


class Workforce:
    """Runs tasks; workers start when first needed and serve all planes of a run.

    Parameters
    ----------
    config : Cluster
        Checked by `check_cluster`.

    Examples
    --------
    >>> from pipeline.schema import Cluster
    >>> with Workforce(Cluster("none", 1, False, None, 10.0)) as workforce:
    ...     list(workforce.run(pow, [(2, 3), (3, 2)]))
    [((2, 3), 8), ((3, 2), 9)]
    """

    def __init__(self, config: Cluster):
        self.config = config
        self._client = None
        self._cluster = None

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
            # Losing a connection while closing is not worth a page of log.
            for name in ("distributed", "distributed.nanny", "distributed.worker", "distributed.comm"):
                logging.getLogger(name).setLevel(logging.CRITICAL)
            if self.config.kind == "local":
                self._start_local()
            else:
                self._reach_scheduler()
        dashboard = f", dashboard {self._client.dashboard_link}" if self.config.dashboard else ""
        if self.config.kind == "local":
            return f"tasks run on {self.config.workers} worker processes{dashboard}"
        return f"tasks run on the scheduler at {self.config.address}{dashboard}"

    def _start_local(self) -> None:
        import dask
        from distributed import Client, LocalCluster

        environment = {**dask.config.get("distributed.nanny.pre-spawn-environ", {}), **_ONE_THREAD}
        with dask.config.set({"distributed.nanny.pre-spawn-environ": environment}), _deaf_to_interrupts():
            self._cluster = LocalCluster(
                n_workers=self.config.workers,
                threads_per_worker=1,
                processes=True,
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

        try:
            self._client = Client(self.config.address, timeout=self.config.timeout, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            reason = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise ConfigurationError(
                f"cluster.address = {self.config.address!r} is not allowed: it must be that of a dask scheduler, "
                f"and none answered there within {self.config.timeout:g} s ({reason})"
            ) from None

    def run(self, function: Callable, tasks: Sequence[tuple]) -> Iterator[tuple[tuple, object]]:
        """Call `function(*task)` for every task; yields (task, result), or (task, exception) where it raised.

        Parameters
        ----------
        function : callable
            Importable on the workers.
        tasks : sequence of tuple
            Small, picklable arguments.
        """
        if self.config.kind == "none":
            for task in tasks:
                yield task, _attempt(function, task)
            return
        from distributed import as_completed

        self.start()
        futures = {self._client.submit(function, *task, pure=False, retries=0): task for task in tasks}
        try:
            for future in as_completed(list(futures), loop=self._client.loop):
                error = future.exception()
                yield futures.pop(future), future.result() if error is None else error
                future.release()
        finally:
            self._client.cancel(list(futures))

    def close(self) -> None:
        """Stop the workers that this object started; a foreign scheduler goes on."""
        for part in (self._client, self._cluster):
            if part is not None:
                part.close()
        self._client = self._cluster = None


@contextlib.contextmanager
def _deaf_to_interrupts() -> Iterator[None]:
    """Processes started inside ignore Ctrl-C, which a terminal sends to all of them: stopping is this process's business."""
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
