"""Threads for what spends most of its time in kernels: these let other threads go on meanwhile."""

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor

__all__ = ["side_by_side"]

#: More of them would wait for each other between two kernels.
_MOST_THREADS = 4


def side_by_side(function: Callable, tasks: Iterable) -> Iterator:
    """What a function makes of every task, in their order.

    Parameters
    ----------
    function : callable
        Of one task. It is called in several threads at a time.
    tasks : iterable

    Yields
    ------
    object
        An exception is raised in its turn; what has not begun by then, or when nobody asks for more, is left.
    """
    tasks = list(tasks)
    threads = min(os.cpu_count() or 1, _MOST_THREADS, len(tasks))
    if threads < 2:
        yield from map(function, tasks)
        return
    with ThreadPoolExecutor(threads) as pool:
        try:
            yield from pool.map(function, tasks)
        finally:
            pool.shutdown(cancel_futures=True)
