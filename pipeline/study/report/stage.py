"""The stage report: the published study against what is computed here, as one page."""

from time import perf_counter

from pipeline.config.typed import key_of
from pipeline.errors import ConfigurationError, StoreError
from pipeline.run.job import Job, command
from pipeline.run.progress import Reporter
from pipeline.run.stage import Stage
from pipeline.run.workforce import Workforce

__all__ = ["STAGE"]


def _check(job: Job) -> None:
    from pipeline.study import report

    gear = job.settings.choices["gear"]
    if gear != "published":
        raise ConfigurationError(
            f"gear = {gear!r} is not allowed with stages=[report]: it compares the published gear with the study"
        )
    for override in job.settings.overrides:
        if (key := key_of(override)).startswith("gear."):
            raise ConfigurationError(
                f"{key} is not allowed with stages=[report]: it compares the published gear with the study"
            )
    if job.settings.config.report.run or job.asks("sweep"):
        return
    gaps = [f"{text} ({source.command})" for source, text in report.missing(_sources(job))]
    if gaps:
        raise StoreError(f"the report needs planes that are not there, report.run=true makes them: {'; '.join(gaps)}")


def _sources(job: Job):
    from pipeline.study import report

    return report.sources_of(job.settings.overrides, job.settings.config_dir)


def _run(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    from pipeline.run.preparation import prepare, run_plane_stages
    from pipeline.study import report

    status, begin, sources = 0, perf_counter(), _sources(job)
    for source, text in report.missing(sources):
        if not job.settings.config.report.run:
            raise StoreError(
                f"the report needs planes that are not there, report.run=true makes them: {text} ({source.command})"
            )
        reporter.line(f"report: {text}: {source.command}")
        status = max(status, run_plane_stages(prepare(source.settings), workforce, reporter))
    reporter.log = None
    folder = job.settings.output_root / "report"
    page, text, *pictures = report.write(sources, folder, command(job.settings, "stages=[report]", "report.run="))
    reporter.line(
        f"report: {page.name}, {text.name} and {len(pictures)} figures in {folder.resolve()} "
        f"({perf_counter() - begin:.2f} s)"
    )
    return status


STAGE = Stage("report", _run, _check, on_workers=True)
