"""The stage debug: one row computed again in this process, with a trace of its continuation; no store is touched."""

from time import perf_counter

from pipeline.errors import ConfigurationError, counted
from pipeline.run.job import Job
from pipeline.run.progress import Reporter
from pipeline.run.stage import Stage
from pipeline.run.warmup import warm_up_for
from pipeline.run.workforce import Workforce

__all__ = ["STAGE"]


def _check(job: Job) -> None:
    row, rows = job.settings.config.debug.row, job.plan.rows
    if row is None or not 0 <= row < rows:
        raise ConfigurationError(
            f"debug.row = {'null' if row is None else row} is not allowed: "
            f"it must be from 0 to {rows - 1}, a row of this plane"
        )


def _run(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    from pipeline.run import trace_log

    warm_up_for(job, reporter)
    begin, row = perf_counter(), job.settings.config.debug.row
    found = trace_log.row_trace(job.store_path, job.plan, row)
    sheets = trace_log.write_sheets(found, job.settings.output_root / "debug" / job.settings.store_name)
    for text in found.failed:
        reporter.line(f"debug: row {row} fails: {text}")
    reporter.line(
        f"debug: {job.plan.row_text(row)}, {counted(found.steps, 'step')} in {counted(len(found.traces), 'trace')} "
        f"({perf_counter() - begin:.2f} s)"
    )
    reporter.line(f"debug: {', '.join(sheet.name for sheet in sheets)} in {sheets[0].parent.resolve()}")
    return 0


STAGE = Stage("debug", _run, _check)
