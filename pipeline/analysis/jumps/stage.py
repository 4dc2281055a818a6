"""The stage jumps: attractors followed along rows, upwards and downwards."""

from time import perf_counter

import numpy as np

from pipeline.analysis.integration_options import check_jumps
from pipeline.run.job import Job, say_failures
from pipeline.run.progress import Reporter, RowProgress
from pipeline.run.stage import Stage
from pipeline.run.workforce import Workforce

__all__ = ["STAGE"]


def _run(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    from pipeline.analysis.jumps import running as jumps

    path, options = job.store_path, job.settings.config.jumps
    begin = perf_counter()
    with RowProgress(reporter, jumps.rows_of(job.plan, options).size, what="jumps") as bar:
        found, done = jumps.follow(path, job.plan, options, workforce.run, bar.advance)
    sheets = jumps.write_sheets(found, job.plan, job.settings.output_root / "jumps", job.settings.store_name)
    values = job.plan.parameter.values[found.rows]
    failures = [
        f"row {row} ({job.plan.parameter.name} = {value:.6g}) could not be followed: {text}"
        for row, value, text in zip(found.rows, values, found.messages, strict=True)
        if text
    ]
    say_failures(failures, reporter)
    widest = int(np.argmax(found.widths))
    end = f"are in {path} already, nothing to do" if done else f"into {path} ({perf_counter() - begin:.2f} s)"
    reporter.line(
        f"jumps: {found.rows.size} rows, {int(np.sum(found.widths > 0.0))} with hysteresis, at most "
        f"{found.widths[widest]:.4g} wide at {job.plan.parameter.name} = {values[widest]:.6g}, {end}"
    )
    reporter.line(f"jumps: {', '.join(sheet.name for sheet in sheets)} in {sheets[0].parent.resolve()}")
    return 1 if failures else 0


STAGE = Stage("jumps", _run, lambda job: check_jumps(job.settings.config.jumps, job.plan), on_workers=True, writes=True)
