"""The stage page: the stored plane as one HTML file to mail."""

import importlib.metadata
from pathlib import Path
from time import perf_counter

from pipeline.config.compose import Settings
from pipeline.config.typed import key_of
from pipeline.explorer.stage import check_installed
from pipeline.figures.options import check_quantity, check_units
from pipeline.run.job import Job, command, note_unfinished
from pipeline.run.made import made_from, still_made, write_record
from pipeline.run.progress import Reporter
from pipeline.run.sheets import write_files
from pipeline.run.stage import Stage
from pipeline.run.workforce import Workforce

__all__ = ["STAGE"]

#: Sections of the configuration that are nothing to whoever gets a page, and keys of theirs that are.
_OF_THE_MACHINE = ("output", "store", "cluster", "debug", "explore")
_OF_THE_PLANE = ("store.name", "store.max_solutions", "store.max_branches", "store.max_points")


def _check(job: Job) -> None:
    check_installed()
    check_units(job.plan, job.settings.config.figures.units)
    for name in job.settings.config.page.quantities:
        check_quantity(job.plan, "page.quantities", name)


def _options(job: Job) -> dict:
    """The settings of a page as `pipeline.explorer.page.page_of` takes them."""
    page, figures = job.settings.config.page, job.settings.config.figures
    return {
        "physical": figures.units == "physical",
        "rows": page.rows,
        "quantities": tuple(page.quantities),
        "of": figures.of,
        "command": _command_to_mail(job.settings),
    }


def _command_to_mail(settings: Settings) -> str:
    """What makes the page, without what is of this machine alone: where stores are, who computes them."""
    typed = map(key_of, settings.overrides)
    own = [key for key in typed if key.partition(".")[0] in _OF_THE_MACHINE and key not in _OF_THE_PLANE]
    return command(settings, *(f"{key}=" for key in own), "stages=[page]")


def _run(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    note_unfinished(job, reporter, "the page leaves them blank")
    begin, name, folder = perf_counter(), job.settings.store_name, job.settings.output_root / "page"
    options, record = _options(job), folder / f".{name}.json"
    origin = made_from(job.store_path, options, importlib.metadata.version("bokeh"))
    paths, took = still_made(record, origin), "up to date"
    if paths is None:
        paths = _write(job, folder / f"{name}.html", options)
        write_record(record, origin, paths)
        took = f"{perf_counter() - begin:.2f} s"
    size = sum(path.stat().st_size for path in paths) / 1e6
    reporter.line(f"page: {', '.join(path.name for path in paths)} in {folder.resolve()}, {size:.1f} MB ({took})")
    return 0


def _write(job: Job, path: Path, options: dict) -> list[Path]:
    # Here, because it takes a second to import.
    from pipeline.explorer.page import page_of
    from pipeline.plane.stored import read_stored

    return write_files(path.parent, {path.name: page_of(read_stored(job.store_path), **options)})


STAGE = Stage("page", _run, _check, tells_map=True)
