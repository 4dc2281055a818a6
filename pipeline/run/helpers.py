"""Two processes that are started early and load what is needed later, while this one computes.

For what takes less time than dask's workers take to start. They hold nothing that could be lost: a task whose helper
was ended is done here.
"""

import contextlib
import importlib
import multiprocessing
import os
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool

from pipeline.run.libraries import load_zarr
from pipeline.run.processes import deaf_to_interrupts, main_module_hidden

__all__ = ["COUNT", "Helpers", "load"]

COUNT = 2


#: In a helper, what those have in common that are started together.
_TURN = []


def load(modules: Iterable[str]) -> None:
    """In a helper or on a worker: import modules, zarr with its own defaults."""
    # One helper after the other: where there are two cores, one is ready early instead of two late.
    with contextlib.ExitStack() as held:
        for turn in _TURN:
            held.enter_context(turn)
        load_zarr()
        for module in modules:
            importlib.import_module(module)


def _begin(turn) -> None:
    """In a helper: end with the process that started it, which may be killed and ends nobody then."""
    _TURN.append(turn)

    def wait() -> None:
        multiprocessing.parent_process().join()
        os._exit(0)

    threading.Thread(target=wait, daemon=True).start()


class Helpers:
    """Processes that have loaded modules, or are at it.

    Parameters
    ----------
    modules : sequence of str
    """

    def __init__(self, modules: Iterable[str]):
        before = set(multiprocessing.active_children())
        spawn = multiprocessing.get_context("spawn")
        self._pool = ProcessPoolExecutor(COUNT, mp_context=spawn, initializer=_begin, initargs=(spawn.Lock(),))
        with deaf_to_interrupts(), main_module_hidden():
            # Each of the first tasks starts a process.
            for _ in range(COUNT):
                self._pool.submit(load, tuple(modules))
        self._processes = set(multiprocessing.active_children()) - before

    def run(self, function: Callable, tasks: Iterable[tuple]) -> Iterator[tuple[tuple, object]]:
        """Call `function(*task)` for every task; yields (task, result) in any order, or (task, exception)."""
        waiting = list(tasks)
        with contextlib.suppress(BrokenProcessPool):
            futures = {self._pool.submit(function, *task): task for task in waiting}
            for future in as_completed(futures):
                error = future.exception()
                if isinstance(error, BrokenProcessPool):
                    break
                waiting.remove(futures[future])
                yield futures[future], future.result() if error is None else error
        for task in waiting:
            try:
                yield task, function(*task)
            except Exception as error:  # as one that comes from a helper
                yield task, error

    def close(self) -> None:
        """End them, whatever they are at."""
        self._pool.shutdown(wait=False, cancel_futures=True)
        for process in self._processes:
            process.kill()
            process.join()
