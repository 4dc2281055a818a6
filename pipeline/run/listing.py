"""The stage list: which stores there are, and in what state."""

from pipeline.errors import counted
from pipeline.run.job import Job
from pipeline.run.progress import Reporter
from pipeline.run.stage import Stage
from pipeline.run.workforce import Workforce

__all__ = ["STAGE"]


def _run(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    from pipeline.store.listing import columns, listing

    root = job.settings.store_root.resolve()
    found = listing(root)
    if not found.entries:
        reporter.line(f"list: no stores in {root}")
    elif reporter.on_terminal:
        _table(found, reporter)
    else:
        for text in columns(found):
            reporter.line(text)
    if found.entries:
        reporter.line(f"list: {counted(len(found.entries), 'store')} in {root}")
    if found.foreign:
        reporter.line(f"list: no stores of this program: {', '.join(found.foreign)}")
    return 0


def _table(found, reporter: Reporter) -> None:
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    from pipeline.store.listing import TITLES

    table = Table(box=None, header_style="bold", pad_edge=False)
    # Names are what one types: other columns give way first.
    widths = [min(max(len(entry.name) for entry in found.entries), 24), *[None] * (len(TITLES) - 1)]
    for title, width in zip(TITLES, widths, strict=True):
        table.add_column(title, overflow="fold", min_width=width)
    for entry in found.entries:
        # As text, so that nothing in a name is taken for markup.
        table.add_row(*map(Text, entry.cells))
    Console(file=reporter.stream).print(table)


STAGE = Stage("list", _run, only_reads=lambda job: True, needs_plan=False)
