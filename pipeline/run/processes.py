"""How processes are started: they run no script of the user's, and are ended by this process alone."""

import contextlib
import signal
import sys
import threading
from collections.abc import Iterator
from multiprocessing import resource_tracker

__all__ = ["deaf_to_interrupts", "main_module_hidden", "signals_left_alone"]


@contextlib.contextmanager
def main_module_hidden() -> Iterator[None]:
    """Processes started inside do not run the user's script again, as they would to find what is defined there.

    Workers are given functions of this package alone, and a script without `if __name__ == "__main__"` would start
    itself without end.
    """
    main = sys.modules["__main__"]
    kept = {name: vars(main).pop(name) for name in ("__spec__", "__file__") if name in vars(main)}
    main.__spec__ = None
    try:
        yield
    finally:
        vars(main).update(kept)


@contextlib.contextmanager
def deaf_to_interrupts() -> Iterator[None]:
    """Processes started inside do not hear what a terminal sends to all: stopping them is this process's business.

    They inherit that these signals are blocked. This process hears at the end what came meanwhile.
    """
    if threading.current_thread() is not threading.main_thread() or not hasattr(signal, "pthread_sigmask"):
        yield
        return
    numbers = (signal.SIGINT, signal.SIGHUP)
    # Where it starts its process, it unblocks them.
    resource_tracker.ensure_running()
    heard, before = [], signal.pthread_sigmask(signal.SIG_BLOCK, numbers)
    # Other threads do not block them: what one of them is given comes to the handler.
    handlers = {number: signal.getsignal(number) for number in numbers if callable(signal.getsignal(number))}
    for number in handlers:
        signal.signal(number, lambda number, _: heard.append(number))
    try:
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        if heard:
            signal.raise_signal(heard[0])


@contextlib.contextmanager
def signals_left_alone() -> Iterator[None]:
    """What is called within sets no handler of signals, whatever it tries: how a run is interrupted is decided here."""
    listen, signal.signal = signal.signal, lambda number, handler: handler
    try:
        yield
    finally:
        signal.signal = listen
