"""The stage basins: shares of random initial states that reach each of several coexisting motions."""

from time import perf_counter

from pipeline.analysis.integration_options import check_basins
from pipeline.run.job import Job, say_failures
from pipeline.run.progress import Reporter, RowProgress
from pipeline.run.stage import Stage
from pipeline.run.workforce import Workforce

__all__ = ["STAGE"]


def _run(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    from pipeline.analysis.basins import running as basins

    path, options = job.store_path, job.settings.config.basins
    begin = perf_counter()
    total = len(options.points) if options.points is not None else options.cells
    with RowProgress(reporter, total, what="basins", unit="places") as bar:
        found, done = basins.measure(path, job.plan, options, workforce.run, bar.advance)
    sheet = basins.write_sheet(found, job.plan, job.settings.output_root / "basins", job.settings.store_name)
    failures = [
        f"basins at {job.plan.sweep.name} = {x:.6g}, {job.plan.parameter.name} = {p:.6g} failed: {text}"
        for x, p, text in zip(found.places["x"], found.places["p"], found.messages, strict=True)
        if text
    ]
    say_failures(failures, reporter)
    attractors = int(found.places["n_attractors"].sum())
    end = f"are in {path} already, nothing to do" if done else f"into {path} ({perf_counter() - begin:.2f} s)"
    places = f"{len(found.messages)} places" if len(found.messages) else "no place with coexisting motions"
    reporter.line(f"basins: {attractors} attractors at {places} from {options.starts} starts each, {end}")
    reporter.line(f"basins: {sheet.name} in {sheet.parent.resolve()}")
    return 1 if failures else 0


STAGE = Stage(
    "basins", _run, lambda job: check_basins(job.settings.config.basins, job.plan), on_workers=True, writes=True
)
