"""The stage boundaries: folds and grazings as curves, started from the stored rows."""

from time import perf_counter

import numpy as np

from pipeline import store
from pipeline.errors import WorkerLost, counted
from pipeline.plane.boundaries import read_boundaries
from pipeline.run.job import Job, note_unfinished
from pipeline.run.made import made_from, still_made, write_record
from pipeline.run.progress import Reporter
from pipeline.run.stage import Stage
from pipeline.run.warmup import warm_up_for
from pipeline.run.workforce import Workforce

__all__ = ["STAGE"]


def _run(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    path = job.store_path
    note_unfinished(job, reporter, "boundaries start from the others")
    if job.plan.parameter2 is not None:
        from pipeline.analysis.boundaries.layers import run_layers

        return run_layers(job, workforce, reporter)
    begin = perf_counter()
    try:
        summary = _traced(job, workforce, reporter)
    except (ArithmeticError, ValueError, np.linalg.LinAlgError, WorkerLost) as error:
        if store.damage_error(path) is not None:
            raise
        reporter.error(f"boundaries of {path} cannot be traced: {' '.join(str(error).split())}")
        return 1
    seconds = perf_counter() - begin
    counts = [f"{counted(n, f'{kind} curve')}" for kind, n in summary.curves.items()] or ["no boundaries"]
    special = ", ".join(f"{n} {kind.replace('_', '-')}" for kind, n in sorted(summary.special.items())) or "none"
    for text in summary.cut_short:
        reporter.error(text)
    if summary.found_done:
        reporter.line(f"boundaries: {', '.join(counts)} are in {path} already, nothing to do")
    else:
        reporter.line(
            f"boundaries: {', '.join(counts)} of {summary.points:,} points into {path}; special points: {special} "
            f"({seconds:.2f} s)"
        )
    return 1 if summary.cut_short else 0


def _traced(job: Job, workforce: Workforce, reporter: Reporter):
    """Trace here, or on a worker where other planes would wait for this process."""
    from pipeline.analysis import boundaries

    path, plan = job.store_path, job.plan
    if workforce.planes == 1:
        return boundaries.trace(path, plan, lambda: warm_up_for(job, reporter))
    if (summary := boundaries.stored_summary(path, plan)) is not None:
        return summary
    warm_up_for(job, reporter, workforce)
    ((_, result),) = workforce.run(boundaries.trace, [(path, plan)])
    if isinstance(result, Exception):
        raise result
    return result


def _write_sheets(job: Job, reporter: Reporter) -> None:
    from pipeline.analysis import boundaries

    if job.plan.parameter2 is not None:
        from pipeline.analysis.boundaries.layers import write_layer_sheets

        write_layer_sheets(job, reporter)
        return
    folder, name = job.settings.output_root / "boundaries", job.settings.store_name
    record, origin = folder / f".{name}.json", made_from(job.store_path)
    if (names := still_made(record, origin)) is None:
        stored = read_boundaries(job.store_path, job.plan)
        if stored is None:
            return
        names = boundaries.write_sheets(stored, job.plan, folder, name)
        write_record(record, origin, names)
    reporter.line(f"boundaries: {', '.join(file.name for file in names)} in {folder.resolve()}")


STAGE = Stage("boundaries", _run, on_workers=True, writes=True, of_volumes=True, finish=_write_sheets)
