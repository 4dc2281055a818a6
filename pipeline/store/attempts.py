"""What became of earlier attempts at a row: a small file per block, written before each row, read when one is retried.

A row may take its process with it: it hangs, or memory runs out. So its number is written down before it begins, and
while it runs, a watchdog of the C library, which needs neither Python nor its lock, ends the process after `limit`
seconds and leaves the stack in the same file. Whoever gets the block next reads there which row it was.
"""

import contextlib
import faulthandler
import re
from collections.abc import Iterator

from pipeline.config.places import Place
from pipeline.store.files import Files, files_at

__all__ = ["MOST_ATTEMPTS", "AttemptLog", "forget_attempts"]

#: A row is tried this often, on different workers where there are several.
MOST_ATTEMPTS = 3

_LINE = re.compile(r"^(begin|end|raised) (\d+) ?(.*)$")
_TIMEOUT = "Timeout ("
#: Names of notes.
_NOTE = re.compile(r"[0-9]+")


def _notes(path: Place) -> Files:
    return files_at(path).beside("tries")


def forget_attempts(path: Place) -> None:
    """Remove the notes of all blocks of the store at `path`."""
    _notes(path).clear(_NOTE)


class AttemptLog:
    """The notes of one block.

    Parameters
    ----------
    path : Place
        The store.
    start : int
        The block's first row.
    limit : float or None
        Seconds that a row may take; None where there is no process that may be ended, as in a debugger.
    """

    def __init__(self, path: Place, start: int, limit: float | None):
        self.limit = limit
        self._log = _notes(path).log(str(start))
        self._failed: dict[int, list[str]] = {}
        self._read()

    def __enter__(self):
        self._log.open()
        return self

    def __exit__(self, *_):
        self._log.close()

    def _read(self) -> None:
        """Gather the attempts that did not end, with what ended them."""
        running = None
        for line in self._log.lines():
            found = _LINE.match(line)
            if found is None:
                if running is not None and line.startswith(_TIMEOUT):
                    self._add(running, f"it did not end within {self.limit or 0.0:g} s")
                    running = None
                continue
            what, row, text = found[1], int(found[2]), found[3]
            if what == "begin":
                if running is not None:
                    self._add(running, "its process was ended from outside, as happens when memory runs out")
                running = row
            else:
                if what == "raised":
                    self._add(row, text)
                running = None
        if running is not None:
            self._add(running, "its process was ended from outside, as happens when memory runs out")

    def _add(self, row: int, reason: str) -> None:
        self._failed.setdefault(row, []).append(reason)

    def count(self, row: int) -> int:
        """Attempts at a row that failed."""
        return len(self._failed.get(row, ()))

    def verdict(self, row: int) -> str | None:
        """Why a row is not tried again; None if it may be."""
        reasons = self._failed.get(row, [])
        return f"{reasons[-1]} ({len(reasons)} tries)" if len(reasons) >= MOST_ATTEMPTS else None

    @contextlib.contextmanager
    def attempt(self, row: int) -> Iterator[None]:
        """Around the computation of one row."""
        self._write(f"begin {row}")
        if self.limit is not None:
            faulthandler.dump_traceback_later(self.limit, exit=True, file=self._log)
        try:
            yield
        finally:
            if self.limit is not None:
                faulthandler.cancel_dump_traceback_later()
        self._write(f"end {row}")

    def raised(self, row: int, reason: str) -> None:
        """Note that a row raised."""
        self._write(f"raised {row} {' '.join(reason.split())}")
        self._add(row, reason)

    def forget(self) -> None:
        """The block is stored."""
        self._log.remove()

    def _write(self, line: str) -> None:
        self._log.write(line)
