"""What a user sees of several planes: lines that name their plane, and one bar over all of them."""

from pipeline.run.progress import Reporter, RowProgress

__all__ = ["PlaneReporter", "StudyProgress"]


class StudyProgress:
    """Planes done of how many, rows done of how many; to be entered.

    Parameters
    ----------
    reporter : Reporter
    rows : dict of str to int
        Name of every plane -> rows that its sweep is going to compute; what other stages compute adds to them.
    """

    def __init__(self, reporter: Reporter, rows: dict[str, int]):
        self._planes, self._ended, self._swept = len(rows), 0, dict(rows)
        self._bar = RowProgress(reporter, sum(rows.values()))
        self._tell(self._bar.total)

    def __enter__(self):
        self._bar.__enter__()
        return self

    def __exit__(self, *error):
        self._bar.__exit__(*error)

    def begins(self, name: str, what: str, rows: int) -> RowProgress:
        """So many rows of a stage are due; the bar that counts them."""
        known = self._swept.pop(name, 0) if what == "sweep" else 0
        self._tell(self._bar.total + rows - known)
        return self._bar

    def ends(self, name: str) -> None:
        """A plane is done, or has failed."""
        self._ended += 1
        self._tell(self._bar.total - self._swept.pop(name, 0))

    def _tell(self, total: int) -> None:
        self._bar.retell(f"{self._ended}/{self._planes} planes", total)


class PlaneReporter(Reporter):
    """Lines of one plane, with its name before them; its log has them without.

    Parameters
    ----------
    reporter : Reporter
        Prints them.
    name : str
    progress : StudyProgress
    """

    def __init__(self, reporter: Reporter, name: str, progress: StudyProgress):
        super().__init__(reporter.stream)
        self._reporter, self._name, self._progress = reporter, name, progress

    def console(self):
        """None: there is one bar, over all planes."""
        return

    def count_in(self, what: str, total: int) -> RowProgress:
        """The bar over all planes."""
        return self._progress.begins(self._name, what, total)

    def line(self, text: str) -> None:
        self._reporter.line(self._named(text))
        self._write(text)

    def error(self, text: str) -> None:
        self._reporter.error(self._named(text))
        self._write(f"error: {text}")

    def _named(self, text: str) -> str:
        return text if text.startswith(f"{self._name}: ") else f"{self._name}: {text.lstrip()}"
