"""Compiling kernels ahead of their first call, in one process or in several that share the work."""

import importlib
from collections.abc import Callable, Iterable

from solver.kernels.compile import Kernel

__all__ = ["kernels_of", "warm"]


def kernels_of(names: Iterable[str]) -> list[Kernel]:
    """Kernels by name, and those of modules that Python calls or hands on, each once and in the order of the names.

    Parameters
    ----------
    names : iterable of str
        Such as `solver.continuation.arclength` or `solver.continuation.correctors._newton`.
    """
    kernels = {}
    for name in names:
        parent, _, own = name.rpartition(".")
        one = getattr(importlib.import_module(parent), own, None) if parent else None
        if isinstance(one, Kernel):
            kernels[one] = None
            continue
        members = vars(importlib.import_module(name)).values()
        kernels |= {k: None for k in members if isinstance(k, Kernel) and k.__module__ == name and not k.inner}
    return list(kernels)


def warm(kernels: Iterable[Kernel], report: Callable[[str, int, int], None] = lambda *_: None) -> None:
    """Compile kernels, or read those that are kept, so that their first call does not wait.

    Processes that are given the same kernels at the same time share the work: each one leaves to the others what they
    are at, and reads it from the cache in the end.

    Parameters
    ----------
    kernels : iterable of Kernel
        Such as `kernels_of` gives. Those that take longest should come first if several processes share them.
    report : callable, optional
        Called as report(name, done, total): before each kernel, and with an empty name in the end.
    """
    waiting = list(kernels)
    total, done = len(waiting), 0
    for wait in (False, True):
        left = []
        for kernel in waiting:
            report(f"{kernel.__module__}.{kernel.__name__}", done, total)
            if kernel.prepare(wait):
                done += 1
            else:
                left.append(kernel)
        waiting = left
    report("", done, total)
