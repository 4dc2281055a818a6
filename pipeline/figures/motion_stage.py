"""The stage motion: every motion at one point of the plane, as a figure and as tables."""

from pathlib import Path
from time import perf_counter

import numpy as np

from pipeline.analysis.attractors.options import check_box
from pipeline.plan.points import point_on
from pipeline.run.job import Job
from pipeline.run.progress import Reporter
from pipeline.run.sheets import write_files
from pipeline.run.stage import Stage
from pipeline.run.warmup import warm_up_for
from pipeline.run.workforce import Workforce

__all__ = ["STAGE"]


def _check(job: Job) -> None:
    from pipeline.figures import stage as figures_stage

    config = job.settings.config
    point_on("motion.at", config.motion.at, job.plan)
    check_box(config.attractors.box)
    # Its figure is drawn as the others are.
    figures_stage.STAGE.check(job)


def _run(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    from pipeline.analysis.motion.motions import motions_at
    from pipeline.analysis.motion.sheets import contents, lines
    from solver import RowError

    settings, plan, begin = job.settings, job.plan, perf_counter()
    x, p = point_on("motion.at", settings.config.motion.at, plan)
    warm_up_for(job, reporter)
    try:
        found = motions_at(plan, x, p, settings.config.attractors)
    except (RowError, ArithmeticError, ValueError, np.linalg.LinAlgError) as error:
        reporter.error(f"motions of {job.store_path} cannot be told: {' '.join(str(error).split())}")
        return 1
    for text in lines(found, plan):
        reporter.line(f"motion: {text}")
    folder = settings.output_root / "motion" / settings.store_name
    paths = write_files(folder, contents(found, plan, settings.store_name)) + _draw(job, found, folder)
    took = f"{perf_counter() - begin:.2f} s"
    reporter.line(f"motion: {', '.join(path.name for path in paths)} in {folder.resolve()} ({took})")
    return 0


def _draw(job: Job, found, folder: Path) -> list[Path]:
    """Draw pages of cards; pages of an earlier run that there are no cards for any more are removed."""
    from pipeline.analysis.motion.sheets import place_name
    from pipeline.figures.drawing import own_style
    from pipeline.figures.motion import draw_motions, pages
    from pipeline.figures.output import write_figure
    from pipeline.plane.stored import read_stored

    options, name, paths = job.settings.config.figures, place_name(found, job.plan), []
    plane = read_stored(job.store_path, physical=options.units == "physical")
    with own_style():
        for number, cards in enumerate(pages(found), start=1):
            page = name if number == 1 else f"{name}-{number}"
            paths += write_figure(draw_motions(plane, found, cards), plane, folder, page, options.formats, options.dpi)
    number = len(pages(found)) + 1
    while stale := [path for kind in ("png", "pdf", "svg") if (path := folder / f"{name}-{number}.{kind}").exists()]:
        for path in stale:
            path.unlink()
        number += 1
    return paths


STAGE = Stage("motion", _run, _check)
