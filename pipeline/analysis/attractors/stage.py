"""The stage attractors: what really happens in every cell, or thoroughly at single places."""

import hashlib
from time import perf_counter

import numpy as np

from pipeline import store
from pipeline.analysis.attractors.options import check_options, grid_of
from pipeline.run.job import Job, note_unfinished, open_log, say_failures
from pipeline.run.progress import Reporter, RowProgress
from pipeline.run.stage import Stage
from pipeline.run.warmup import warm_up_for
from pipeline.run.workforce import Workforce

__all__ = ["STAGE"]


def _run(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    if job.settings.config.attractors.points is not None:
        from pipeline.analysis.attractors.places import run_places

        return run_places(job, workforce, reporter)
    return _run_plane(job, workforce, reporter)


def _run_plane(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    from pipeline.analysis.attractors.dataset import read_attractors
    from pipeline.analysis.attractors.sheets import result_lines, write_sheets
    from pipeline.analysis.attractors.summary import summary_of
    from pipeline.analysis.attractors.tasks import Spec

    path, options, begin = job.store_path, job.settings.config.attractors, perf_counter()
    note_unfinished(job, reporter, "there, no motion of the map is started from")
    grid = grid_of(job.plan, options)
    limit = None if workforce.config.kind == "none" else workforce.config.row_seconds
    spec = Spec(path, grid, options, _map_digest(job), limit)
    group = spec.group
    if not (done := group.is_finished):
        warm_up_for(job, reporter, workforce)
        where = workforce.start()
        open_log(job, reporter)
        group.begin()
        cells = grid.blocks.rows * len(grid.columns)
        reporter.line(f"attractors: {cells:,} cells with {options.starts} random starts each; {where}")
        lost = _compute(spec, workforce, reporter)
        if lost:
            say_failures([f"attractors: {text}: the same command goes on with them" for text in lost], reporter)
            return 1
        group.finish(summary_of(path, group, grid, options))
    found = read_attractors(path)
    folder, name = job.settings.output_root / "attractors", job.settings.store_name
    sheets = write_sheets(path, job.plan, found, folder, name)
    failures = [
        f"{grid.row_text(row)} failed: {text}" for row, text in enumerate(found.message.values.ravel().tolist()) if text
    ]
    say_failures(failures, reporter)
    for text in result_lines(path, job.plan, found):
        reporter.line(f"attractors: {text}")
    end = f"are in {path} already, nothing to do" if done else f"into {path} ({perf_counter() - begin:.2f} s)"
    reporter.line(f"attractors: {int(found.n_attractors.sum()):,} in {found.n_attractors.size:,} cells {end}")
    reporter.line(f"attractors: {', '.join(sheet.name for sheet in sheets)} in {folder.resolve()}")
    lost = 0
    if options.branches:
        from pipeline.analysis.attractors.isolated import run_isolated

        lost = run_isolated(job, workforce, reporter, found)
    return 1 if failures or lost else 0


def _compute(spec, workforce: Workforce, reporter: Reporter) -> list[str]:
    """Run all rounds with a bar for each; why blocks were lost."""
    from pipeline.analysis.attractors.rounds import Progress, run_rounds

    bars: list[RowProgress] = []

    def close() -> None:
        if bars:
            bars.pop().__exit__()

    def begins(round: int, rows: int) -> None:
        close()
        if rows:
            bars.append(RowProgress(reporter, rows, what="attractors").__enter__())
            if round:
                # Plain lines say so, too: counting begins anew.
                bars[-1].retell(f"attractors, round {round}", rows)

    try:
        return run_rounds(spec, workforce, Progress(begins, lambda *done: bars[-1].advance(*done), reporter.note))
    finally:
        close()


def _map_digest(job: Job) -> bytes:
    """Digest of what attractors depend on of the map, block by block, every chunk verified."""
    from pipeline.analysis.attractors.tasks import MAP

    digest = hashlib.sha256()
    for block in job.plan.blocks:
        stored = store.read_rows(job.store_path, job.plan, block, MAP + ("motion",) * (job.plan.motion_size > 0))
        complete = stored["status"] == store.COMPLETE
        digest.update(complete.tobytes())
        for name in stored:
            digest.update(np.ascontiguousarray(stored[name][complete]).tobytes())
    return digest.digest()


STAGE = Stage(
    "attractors",
    _run,
    lambda job: check_options(job.settings.config.attractors, job.plan),
    on_workers=True,
    writes=True,
    of_volumes=True,
)
