"""How processes are started: they run no script of the user's, and are ended by this process alone."""

import contextlib
import signal
import sys
import threading
from collections.abc import Iterator

__all__ = ["deaf_to_interrupts", "main_module_hidden"]


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
    """Processes started inside ignore what a terminal sends to all: stopping them is this process's business."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    numbers = [getattr(signal, name) for name in ("SIGINT", "SIGHUP") if hasattr(signal, name)]
    handlers = {number: signal.signal(number, signal.SIG_IGN) for number in numbers}
    try:
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
