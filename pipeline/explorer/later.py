"""Work of a page that takes its time: done in a thread, shown in the page's own turn."""

import contextlib
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import panel as pn

__all__ = ["Later"]

#: Of all pages together; most of them wait, for kernels or for one another.
_THREADS = ThreadPoolExecutor(8, thread_name_prefix="explorer")


class Later:
    """Of one page. Of each kind of work only the last that was asked for is shown.

    Parameters
    ----------
    document : bokeh.document.Document or None
        Of the page; without one, as in a notebook, everything is done at once.
    """

    def __init__(self, document=None):
        self._document, self._asked = document, {}
        self._waiting: list[Callable] | None = None if document is None else []

    def begin(self) -> None:
        """The page is there: what was asked for until now is done, and from now on at once.

        What a thread shows before a session has its document would be lost.
        """
        waiting, self._waiting = self._waiting or [], None
        for run in waiting:
            _THREADS.submit(run)

    def ask(self, kind: str, work: Callable[[], object], then: Callable[[object], None], failed: Callable) -> None:
        """Do some work, then show its result.

        Parameters
        ----------
        kind : str
            What it is: it replaces what was asked of the same kind before.
        work : callable
            Without the page.
        then : callable
            then(result) shows it.
        failed : callable
            failed(error) says why there is none.
        """
        number = self._asked[kind] = self._asked.get(kind, 0) + 1

        def done(result: object, error: Exception | None) -> None:
            if self._asked[kind] == number:
                then(result) if error is None else failed(error)

        def run() -> None:
            if self._asked[kind] != number:
                return
            result = _tried(work)
            # A page that was closed has nobody to show it to.
            with contextlib.suppress(Exception):
                self.turn(lambda: done(*result))

        if self._document is None:
            done(*_tried(work))
        elif self._waiting is not None:
            self._waiting.append(run)
        else:
            _THREADS.submit(run)

    def turn(self, show: Callable[[], None]) -> None:
        """Show something in the page's own turn: handlers of widgets may run while another one changes the page."""
        document = self._document
        if document is None:
            show()
            return

        def shown() -> None:
            # All that changes goes to the browser as one message.
            with pn.io.hold(document):
                show()

        document.add_next_tick_callback(shown)

    def forget(self, kind: str) -> None:
        """What was asked of a kind is not shown any more."""
        self._asked[kind] = self._asked.get(kind, 0) + 1


def _tried(work: Callable[[], object]) -> tuple[object, Exception | None]:
    try:
        return work(), None
    except Exception as error:  # whatever it is, the page says it in one line
        return None, error
