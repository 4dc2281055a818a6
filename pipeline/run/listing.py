"""The stage list: which stores there are, and in what state."""

import shutil

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
    else:
        for text in columns(found, shutil.get_terminal_size().columns if reporter.on_terminal else None):
            reporter.line(text)
        reporter.line(f"list: {counted(len(found.entries), 'store')} in {root}")
    if found.foreign:
        reporter.line(f"list: no stores of this program: {', '.join(found.foreign)}")
    return 0


STAGE = Stage("list", _run, only_reads=lambda job: True, needs_plan=False)
