"""The stage diagram: a row followed up and down, as a figure and as tables."""

from time import perf_counter

from pipeline.analysis.diagram.options import way_of
from pipeline.figures import stage as figures_stage
from pipeline.run.job import Job
from pipeline.run.progress import Reporter
from pipeline.run.sheets import write_files
from pipeline.run.stage import Stage
from pipeline.run.warmup import warm_up_for
from pipeline.run.workforce import Workforce

__all__ = ["STAGE"]


def _check(job: Job) -> None:
    way_of("diagram", job.settings.config.diagram, job.plan)
    # Its figure is drawn as the others are.
    figures_stage.STAGE.check(job)


def _run(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    from pipeline import figures
    from pipeline.analysis.diagram.following import follow
    from pipeline.analysis.diagram.sheets import diagram_lines, diagram_sheets, row_name
    from pipeline.figures.diagram import draw_diagram
    from pipeline.plane.row_curves import curves_at
    from pipeline.plane.stored import read_stored

    settings, begin = job.settings, perf_counter()
    options = settings.config.figures
    way = way_of("diagram", settings.config.diagram, job.plan)
    warm_up_for(job, reporter)
    followed, curves = follow(job.plan, way), curves_at(read_stored(job.store_path), way.value)
    for text in diagram_lines(followed):
        reporter.line(f"diagram: {text}")
    folder, name = settings.output_root / "diagram" / settings.store_name, row_name(job.plan, way)
    paths = write_files(folder, diagram_sheets(followed, curves, name))
    paths += figures.draw_one(
        job.store_path, folder, name, lambda plane: draw_diagram(plane, followed, curves), options
    )
    took = f"{perf_counter() - begin:.2f} s"
    reporter.line(f"diagram: {', '.join(path.name for path in paths)} in {folder.resolve()} ({took})")
    return 0


STAGE = Stage("diagram", _run, _check)
