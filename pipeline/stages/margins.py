"""The stage margins: how far a design point is from anything that changes its label."""

from pipeline.cluster import Workforce
from pipeline.progress import Reporter
from pipeline.stages import figures
from pipeline.stages.job import Job
from pipeline.stages.stage import Stage

__all__ = ["STAGE"]


def _check(job: Job) -> None:
    from pipeline.margins.options import design_of

    design_of(job.settings.config.margins, job.plan)
    # Its figure is drawn as the others are.
    figures.STAGE.check(job)


def _run(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    from pipeline import margins

    return margins.run(job, reporter)


STAGE = Stage("margins", _run, _check)
