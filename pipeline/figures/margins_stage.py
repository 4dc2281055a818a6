"""The stage margins: how far a design point is from anything that changes its label, and the picture of the answer."""

from time import perf_counter

import numpy as np

from pipeline import figures
from pipeline.analysis import margins
from pipeline.errors import counted
from pipeline.figures import stage as figures_stage
from pipeline.run.job import Job, command
from pipeline.run.progress import Reporter
from pipeline.run.stage import Stage
from pipeline.run.workforce import Workforce

__all__ = ["STAGE"]


def _check(job: Job) -> None:
    margins.design_of(job.settings.config.margins, job.plan)
    # Its figure is drawn as the others are.
    figures_stage.STAGE.check(job)


def _run(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    from pipeline.figures.margins import draw_margins

    settings, path = job.settings, job.store_path
    name, options = settings.store_name, settings.config.figures
    begin = perf_counter()
    design = margins.design_of(settings.config.margins, job.plan)
    try:
        found = margins.answer(path, job.plan, design, command(settings, "stages=[attractors]"))
    except (ArithmeticError, ValueError, np.linalg.LinAlgError) as error:
        reporter.error(f"margins in {path} cannot be told: {' '.join(str(error).split())}")
        return 1
    for text in margins.lines(found):
        reporter.line(text)
    folder = settings.output_root / "margins"
    sheets = margins.write_sheets(found, folder, name)
    drawn = settings.output_root / "figures" / name
    paths = figures.draw_one(path, drawn, "margins", lambda plane: draw_margins(plane, found), options)
    for there, files in ((folder, sheets), (drawn, paths)):
        reporter.line(f"margins: {', '.join(file.name for file in files)} in {there.resolve()}")
    reporter.line(
        f"margins: {counted(len(found.margins), 'distance')}, {counted(len(found.corners), 'set')} of tolerances "
        f"({perf_counter() - begin:.2f} s)"
    )
    return 0


STAGE = Stage("margins", _run, _check)
