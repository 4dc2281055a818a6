"""Two processes that compute and draw beside this one, loaded while this one gets ready.

For what takes less time than dask's workers take to start. They are forked from one process that has loaded what they
need, or load it themselves where the system does not fork. They hold nothing that could be lost: a task whose helper
was ended is done here.
"""

import contextlib
import gc
import importlib
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool

try:
    from multiprocessing import forkserver
except ImportError:  # nothing forks on this system
    forkserver = None

from pipeline.config.schema import Cluster
from pipeline.errors import WorkerLost
from pipeline.run.processes import deaf_to_interrupts, main_module_hidden

__all__ = ["COUNT", "Helpers", "helpers", "load"]

COUNT = 2

_FORKS = forkserver is not None and "forkserver" in multiprocessing.get_all_start_methods()


def load(modules: Iterable[str]) -> None:
    """In a helper or on a worker: import modules."""
    for module in modules:
        importlib.import_module(module)


def _begin(modules: Iterable[str]) -> None:
    """In a helper: end with the process that started it, which may be killed and ends nobody then; load modules."""

    def wait() -> None:
        multiprocessing.parent_process().join()
        os._exit(0)

    threading.Thread(target=wait, daemon=True).start()
    load(modules)
    # Nothing of what has been loaded is garbage, ever.
    gc.freeze()
    gc.enable()


def _end_server() -> None:
    """End what forks helpers, and what waits for it to fork one.

    It would end by itself, but not while it loads, and would keep what this process prints into open meanwhile. Python
    has no public way. Its lock is held over both steps: another thread would take a server that was killed for one
    that failed and start the next, and that one is not killed but waited for, as long as anything it forked lives.
    """
    server = forkserver._forkserver
    with server._lock:
        if server._forkserver_pid is None:
            return
        with contextlib.suppress(ProcessLookupError):
            os.kill(server._forkserver_pid, signal.SIGKILL)
        with contextlib.suppress(OSError):
            server._stop_unlocked()


@contextlib.contextmanager
def helpers(config: Cluster, modules: Iterable[str]) -> Iterator["Helpers | None"]:
    """`Helpers` with these modules; None where this process must do everything itself."""
    made = None
    if config.kind == "local" and (os.cpu_count() or 1) > 1:
        # Without a process to spare all is done here.
        with contextlib.suppress(OSError):
            made = Helpers(modules)
    with contextlib.nullcontext() if made is None else contextlib.closing(made):
        yield made


class Helpers:
    """Processes that load modules and then take tasks.

    Parameters
    ----------
    modules : sequence of str
        They are imported in a process that has no other threads, and forked: importing them must start none.
    """

    def __init__(self, modules: Iterable[str]):
        #: How many tasks they do at a time.
        self.count = COUNT
        modules, context = tuple(modules), multiprocessing.get_context("forkserver" if _FORKS else "spawn")
        self._pool = ProcessPoolExecutor(COUNT, mp_context=context, initializer=_begin, initargs=(modules,))
        self._processes, self._begun = set(), []
        # To fork a helper waits until all is loaded, for which nobody here has to wait.
        self._starter = ThreadPoolExecutor(1)
        self._ends_server = _FORKS and forkserver._forkserver._forkserver_pid is None
        if _FORKS:
            context.set_forkserver_preload(["pipeline.run.preloading", "pipeline.run.helpers", *modules])
            try:
                with deaf_to_interrupts(), main_module_hidden():
                    forkserver.ensure_running()
            except KeyboardInterrupt:
                self.close()
                raise
        # The first one tells when all is loaded.
        self._first = self._starter.submit(self._submit, load, [((),)] * (1 if _FORKS else COUNT))

    @property
    def is_ready(self) -> bool:
        """Whether a helper has loaded everything."""
        return self._first.done() and any(future.done() for _, future in self._first.result())

    def submit(self, function: Callable, arguments: tuple) -> Future | None:
        """Begin with one task, unless helpers are still loading or have been ended; see `outcome`."""
        begun = self._submit(function, [arguments]) if self.is_ready else []
        return begun[0][1] if begun else None

    @staticmethod
    def outcome(future: Future):
        """The result of a task, or its exception; `WorkerLost` where its helper was ended."""
        error = future.exception()
        if isinstance(error, BrokenProcessPool):
            return WorkerLost("its process was ended")
        return future.result() if error is None else error

    def begin(self, function: Callable, tasks: Iterable[tuple]) -> None:
        """Begin with tasks that `run` will be asked for, unless that has been done."""
        known = [(one, task) for one, tasks, _ in self._begun for task in tasks]
        fresh = [task for task in tasks if (function, task) not in known]
        self._begun.append((function, fresh, self._starter.submit(self._submit, function, fresh)))

    def run(self, function: Callable, tasks: Iterable[tuple]) -> Iterator[tuple[tuple, object]]:
        """Call `function(*task)` for every task; yields (task, result) in any order, or (task, exception)."""
        waiting = list(tasks)
        begun = [pair for one, _, started in self._begun if one == function for pair in started.result()]
        begun = [(task, future) for task, future in begun if task in waiting]
        known = [task for task, _ in begun]
        begun += self._submit(function, [task for task in waiting if task not in known])
        futures = {future: task for task, future in begun}
        for future in as_completed(futures):
            result = self.outcome(future)
            if isinstance(result, WorkerLost):
                continue
            waiting.remove(futures[future])
            yield futures[future], result
        for task in waiting:
            try:
                yield task, function(*task)
            except Exception as error:  # as one that comes from a helper
                yield task, error

    def _submit(self, function: Callable, tasks: Iterable[tuple]) -> list[tuple[tuple, Future]]:
        """Tasks with what will come of them, as far as helpers can be started."""
        before, begun = set(multiprocessing.active_children()), []
        # What forks them may have been ended, too.
        try:
            with contextlib.suppress(BrokenProcessPool, OSError, EOFError), deaf_to_interrupts(), main_module_hidden():
                for task in tasks:
                    begun.append((task, self._pool.submit(function, *task)))
        finally:
            self._processes |= set(multiprocessing.active_children()) - before
        return begun

    def close(self) -> None:
        """End them, whatever they are at."""
        if self._ends_server:
            _end_server()
        self._starter.shutdown(cancel_futures=True)
        if self._ends_server:  # once more: the starter may have found none and started one
            _end_server()
        self._pool.shutdown(wait=False, cancel_futures=True)
        self.kill()

    def kill(self) -> None:
        """End the processes there are: what is asked of them from now on is done here."""
        for process in self._processes:
            process.kill()
            process.join()
