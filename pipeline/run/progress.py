"""What a user sees of a run: a bar on a terminal, plain lines elsewhere, and the same lines in the run's log."""

import os
import re
import sys
import time
from datetime import UTC, datetime
from pathlib import Path

from pipeline.errors import shown

__all__ = ["Reporter", "RowProgress", "SilentReporter"]

#: Characters of a line: it may quote anything, a store or a message of a library.
_LONGEST = 4000


class Reporter:
    """Prints lines and keeps them for the log of a run; notes go into the log alone.

    Parameters
    ----------
    stream : text stream, optional
        Standard output unless given.
    """

    def __init__(self, stream=None):
        self.stream = stream or sys.stdout
        self.log: Path | None = None
        #: Where a bar is drawn at present: lines go above it.
        self.drawn_on = None

    @property
    def on_terminal(self) -> bool:
        """Whether somebody watches what is printed."""
        return self.stream.isatty()

    def console(self):
        """A `rich.console.Console` to draw a bar on; None where plain lines are better."""
        if not self.on_terminal:
            return None
        from rich.console import Console

        return Console(file=self.stream)

    def line(self, text: str) -> None:
        """One line for the reader, with its time in the log."""
        text = shown(text, _LONGEST)
        if self.drawn_on is None:
            print(_as_typed_here(text), file=self.stream, flush=True)
        else:
            self.drawn_on.print(_as_typed_here(text), markup=False, highlight=False, soft_wrap=True)
        self._write(text)

    def count_in(self, what: str, total: int) -> "RowProgress | None":
        """The bar in which so many rows of a stage are counted, where it has none of its own."""
        return None

    def note(self, text: str) -> None:
        """One line for the log alone."""
        self._write(shown(f"info {text}", _LONGEST))

    def error(self, text: str) -> None:
        """One line on standard error."""
        text = shown(text, _LONGEST)
        print(f"error: {_as_typed_here(text)}", file=sys.stderr, flush=True)
        self._write(f"error: {text}")

    def _write(self, text: str) -> None:
        if self.log is None:
            return
        try:
            with self.log.open("a", encoding="utf-8") as file:
                file.write(f"{datetime.now(UTC).isoformat(timespec='milliseconds')} {text}\n")
        except OSError as error:
            # What is wrong with the disk is for the stage to say, if it is the worse for it.
            self.log = None
            print(f"note: the log cannot be written any more: {error}", file=sys.stderr, flush=True)


def _as_typed_here(text: str) -> str:
    """A line with the paths inside the current folder as one types them there; a log has them whole."""
    try:
        here = str(Path.cwd()).rstrip(os.sep)
    except OSError:
        # The folder was removed.
        return text
    return re.sub(rf"(?<![\w./:-]){re.escape(here + os.sep)}(?=\S)", "", text) if here else text


class SilentReporter(Reporter):
    """Says nothing and keeps errors; draws bars in a notebook and on a terminal, or as told.

    Parameters
    ----------
    bars : bool, optional
    """

    def __init__(self, bars: bool | None = None):
        super().__init__()
        self.bars, self.errors = bars, []

    def console(self):
        from rich.console import Console

        console = Console()
        wanted = console.is_jupyter or console.is_terminal if self.bars is None else self.bars
        return console if wanted else None

    def line(self, text: str) -> None:
        self._write(text)

    def error(self, text: str) -> None:
        self.errors.append(text)
        self._write(f"error: {text}")


class RowProgress:
    """Rows done, rate, time left and failures.

    Parameters
    ----------
    reporter : Reporter or None
        None counts in silence.
    total : int
        Rows to do.
    every : float
        Seconds between plain lines; what takes less has none.
    what : str
        The stage.
    unit : str
        What is counted.
    """

    def __init__(
        self, reporter: Reporter | None, total: int, every: float = 5.0, what: str = "sweep", unit: str = "rows"
    ):
        self.reporter, self.total, self.every = reporter, total, every
        self.what, self.unit = what, unit
        self.done = self.failed = 0
        self._begin = self._said = time.monotonic()
        self._bar = self._task = self._counted_in = None
        self._before = ""

    def __enter__(self):
        if self.reporter is not None and self.unit == "rows":
            self._counted_in = self.reporter.count_in(self.what, self.total)
        console = None if self.reporter is None or self._counted_in is not None else self.reporter.console()
        if console is not None:
            from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

            self._bar = Progress(
                TextColumn("{task.description}"),
                BarColumn(),
                TextColumn(f"{{task.completed:.0f}}/{{task.total:.0f}} {self.unit}"),
                TextColumn("{task.fields[rate]}"),
                TimeRemainingColumn(),
                TextColumn("{task.fields[failed]} failed"),
                console=console,
            )
            self._task = self._bar.add_task(self.what, total=self.total, rate="", failed=0)
            self._bar.start()
            self.reporter.drawn_on = console
        return self

    def __exit__(self, *_):
        if self._bar is not None:
            self._bar.stop()
            self.reporter.drawn_on = None

    def retell(self, what: str, total: int) -> None:
        """Say from now on what is done, and how many rows there are."""
        self.what, self.total, self._before = what, total, f"{what}, "
        if self._bar is not None:
            self._bar.update(self._task, description=what, total=total)

    def advance(self, rows: int, failed: int) -> None:
        """Count `rows` more as done, `failed` of them failed."""
        if self._counted_in is not None:
            self._counted_in.advance(rows, failed)
            return
        self.done, self.failed = self.done + rows, self.failed + failed
        now = time.monotonic()
        elapsed = max(now - self._begin, 1e-9)
        rate = self.done / elapsed
        if self._bar is not None:
            self._bar.update(self._task, completed=self.done, rate=_rate(rate, self.unit), failed=self.failed)
        elif self.reporter is not None and 0 < self.done < self.total and now - self._said >= self._pause(elapsed):
            # The last one is the stage's own to say.
            self._said = now
            failed = f", {self.failed} failed" if self.failed else ""
            self.reporter.line(
                f"  {self._before}{self.done}/{self.total} {self.unit}, {_rate(rate, self.unit)}, "
                f"{(self.total - self.done) / rate:.0f} s left{failed}"
            )

    def _pause(self, elapsed: float) -> float:
        """Seconds between lines: more and more, up to a minute, so that a long run has no page of them."""
        return max(self.every, min(0.1 * elapsed, 60.0))


def _rate(rate: float, unit: str) -> str:
    """How fast it goes, with two digits at least.

    Examples
    --------
    >>> _rate(110.4, "rows"), _rate(1.34, "rows"), _rate(0.05, "rows")
    ('110 rows/s', '1.3 rows/s', '20 s a row')
    """
    if rate >= 0.5:
        return f"{rate:.0f} {unit}/s" if rate >= 10.0 else f"{rate:.2g} {unit}/s"
    return f"{1.0 / rate:.2g} s a {unit.removesuffix('s')}" if rate > 0.0 else ""
