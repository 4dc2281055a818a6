"""The stage figures: pictures of the stored plane; nothing is solved again."""

from pathlib import Path
from time import perf_counter

from pipeline.run.job import Job, note_unfinished
from pipeline.run.made import made_from, still_made, write_record
from pipeline.run.progress import Reporter
from pipeline.run.stage import Stage
from pipeline.run.workforce import Workforce

__all__ = ["STAGE"]


def _check_options(job: Job) -> None:
    from pipeline import figures

    figures.check_options(job.plan, job.settings.config.figures)


def _folder(job: Job) -> Path:
    return job.settings.output_root / "figures" / job.settings.store_name


def _tasks(job: Job) -> list[tuple]:
    """Arguments of `pipeline.figures.draw_named`, one figure each, what takes longest first."""
    from pipeline import figures

    options = job.settings.config.figures
    names = figures.names_of(job.store_path, options)
    return [(job.store_path, _folder(job), options, (name,)) for name in names]


def _begin(job: Job, workforce: Workforce) -> None:
    """Draw while the stages before this one are finished."""
    from pipeline import figures

    if job.plan.parameter2 is None:
        workforce.begin_beside(figures.draw_named, _tasks(job))


def _draw(job: Job, workforce: Workforce) -> list[Path]:
    """Draw all figures: side by side where workers of this machine run already, otherwise here."""
    from pipeline import figures

    if not workforce.has_local_workers or job.plan.parameter2 is not None:
        drawn = figures.draw_named(job.store_path, _folder(job), job.settings.config.figures, figures.NAMES)
        return [path for paths in drawn.values() for path in paths]
    drawn = {}
    for _, result in workforce.run_beside(figures.draw_named, _tasks(job)):
        if isinstance(result, Exception):
            raise result
        drawn |= result
    return [path for name in figures.NAMES for path in drawn.get(name, [])]


def _run(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    note_unfinished(job, reporter, "the figures leave them blank")
    begin = perf_counter()
    folder = _folder(job)
    record, origin = folder / ".figures.json", made_from(job.store_path, job.settings.config.figures)
    if (paths := still_made(record, origin)) is None:
        paths = _draw(job, workforce)
        write_record(record, origin, paths)
        took = f"{perf_counter() - begin:.2f} s"
    else:
        took = "up to date"
    names = ", ".join(path.name for path in paths)
    reporter.line(f"figures: {names} in {folder.resolve()} ({took})")
    return 0


STAGE = Stage("figures", _run, _check_options, of_volumes=True, tells_map=True, begin=_begin)
