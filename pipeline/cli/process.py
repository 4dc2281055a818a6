"""What this program does as a process: how signals end it, and that nobody need read what it prints."""

import contextlib
import errno
import os
import signal
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

__all__ = ["Terminated", "ended_by_signals", "unread_output"]

#: Who reads has gone: a closed pipe, a closed terminal, a descriptor that was never open.
_UNREAD = (errno.EPIPE, errno.EIO, errno.EBADF)


class Terminated(KeyboardInterrupt):
    """A signal asked the process to end; whatever cleans up after Ctrl-C does so after this too."""

    def __init__(self, number: int):
        super().__init__(signal.Signals(number).name)
        self.number = number


@contextlib.contextmanager
def ended_by_signals() -> Iterator[None]:
    """SIGTERM and SIGHUP raise `Terminated` within; one that is ignored, as below nohup, stays so."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    names = [name for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    before = {number: signal.getsignal(number) for number in (getattr(signal, name) for name in names)}

    def end(number, _):
        # Once: while the process tidies up, more of them change nothing.
        for other in before:
            signal.signal(other, signal.SIG_IGN)
        raise Terminated(number)

    for number, handler in before.items():
        if handler is signal.SIG_DFL:
            signal.signal(number, end)
    try:
        yield
    finally:
        for number, handler in before.items():
            # None: it was not set from Python.
            if handler is not None:
                signal.signal(number, handler)


class _Unread:
    """A text stream whose reader may go away; what is written then is lost, which is no error."""

    def __init__(self, stream):
        self._stream = stream

    def __getattr__(self, name: str):
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        self._try(self._stream.write, text)
        return len(text)

    def flush(self) -> None:
        self._try(self._stream.flush)

    def _try(self, call, *arguments) -> None:
        try:
            call(*arguments)
        except OSError as error:
            if error.errno not in _UNREAD:
                raise
            # What Python has not written yet goes the same way, now and when it ends.
            with Path(os.devnull).open("w") as nowhere:
                os.dup2(nowhere.fileno(), self._stream.fileno())


@contextlib.contextmanager
def unread_output() -> Iterator[None]:
    """Standard output and standard error may be closed, or their reader may leave: nothing within minds."""
    before = sys.stdout, sys.stderr
    with contextlib.ExitStack() as opened:
        sys.stdout, sys.stderr = (
            _Unread(opened.enter_context(Path(os.devnull).open("w")) if stream is None else stream) for stream in before
        )
        try:
            yield
            sys.stdout.flush()
            sys.stderr.flush()
        finally:
            sys.stdout, sys.stderr = before
