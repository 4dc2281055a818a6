"""What this program does as a process: how signals end it, and that nobody need read what it prints."""

import contextlib
import errno
import os
import signal
import socket
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

__all__ = ["Terminated", "ended_by_signals", "unread_output"]

#: Who reads has gone: a closed pipe, a closed terminal, a descriptor that was never open.
_UNREAD = (errno.EPIPE, errno.EIO, errno.EBADF)
#: Seconds until a signal has its effect, and then to tidy up.
_PATIENCE, _TIDY = 1.0, 10.0


class Terminated(KeyboardInterrupt):
    """A signal asked the process to end; whatever tidies up after Ctrl-C does so after this too."""

    def __init__(self, number: int):
        super().__init__(signal.Signals(number).name)
        self.number = number


@contextlib.contextmanager
def ended_by_signals(abruptly: Callable[[int], None]) -> Iterator[None]:
    """SIGINT, SIGTERM and SIGHUP raise `Terminated` within; one that is ignored, as below nohup, stays so.

    Python runs handlers of signals between its own instructions alone. While a compiled loop goes on there are none; so
    a thread hears of the signal too, and ends the process itself if nothing comes of it for a while.

    Parameters
    ----------
    abruptly : callable
        Takes the number of the signal; does in a moment what must be done before the process ends.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    numbers = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
    before = {number: signal.getsignal(number) for number in numbers}
    ours = [number for number in numbers if before[number] in (signal.SIG_DFL, signal.default_int_handler)]
    raised = threading.Event()

    def end(number, _):
        # Once: while the process tidies up, more of them change nothing.
        for other in ours:
            signal.signal(other, signal.SIG_IGN)
        raised.set()
        raise Terminated(number)

    with _heard(ours, raised, abruptly):
        for number in ours:
            signal.signal(number, end)
        try:
            yield
        finally:
            for number in ours:
                signal.signal(number, before[number])


@contextlib.contextmanager
def _heard(numbers: list[int], raised: threading.Event, abruptly: Callable[[int], None]) -> Iterator[None]:
    """A thread that is told of signals at once, whatever the main thread is at."""
    told, tells = socket.socketpair()
    tells.setblocking(False)

    def listen() -> None:
        while said := told.recv(1):
            if said[0] not in numbers:
                continue
            if not raised.wait(_PATIENCE) or not over.wait(_TIDY):
                abruptly(said[0])
                os._exit(128 + said[0])

    over = threading.Event()
    listener = threading.Thread(target=listen, name="signals", daemon=True)
    listener.start()
    # What is sent more often than it is read says nothing new.
    before = signal.set_wakeup_fd(tells.fileno(), warn_on_full_buffer=False)
    try:
        yield
    finally:
        signal.set_wakeup_fd(before)
        # What ended meanwhile by itself, whoever handled the signal, is not ended any more.
        over.set()
        raised.set()
        tells.close()
        listener.join()
        told.close()


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
