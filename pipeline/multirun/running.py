"""Several planes by one command: all their tasks on one workforce, each plane as it would be alone."""

import functools
import traceback
from collections.abc import Sequence

from pipeline import store
from pipeline.config.compose import Settings
from pipeline.errors import ConfigurationError, counted
from pipeline.multirun.index import Index, begun_index
from pipeline.multirun.reporting import PlaneReporter, StudyProgress
from pipeline.multirun.turns import SharedWorkforce, run_side_by_side
from pipeline.run.attempt import attempt
from pipeline.run.job import Job
from pipeline.run.preparation import run_plane_stages
from pipeline.run.progress import Reporter
from pipeline.run.workforce import Workforce
from pipeline.stages import STAGES

__all__ = ["run_planes"]


def run_planes(all_settings: Sequence[Settings], jobs: Sequence[Job], workforce: Workforce, reporter: Reporter) -> int:
    """Run the stages of several planes; one that fails does not stop the others.

    Parameters
    ----------
    all_settings : sequence of Settings
        Of all planes of the command, those that were refused included.
    jobs : sequence of Job
        Of the others.
    workforce : Workforce
    reporter : Reporter

    Returns
    -------
    int
        1 if anything failed, else 0.
    """
    # Jobs that share a store, as figures in two formats, have it one after the other.
    by_store: dict[str, list[Job]] = {}
    for job in jobs:
        by_store.setdefault(job.settings.store_name, []).append(job)
    index = _index(all_settings, jobs, reporter)
    statuses: list[int] = []
    progress = StudyProgress(reporter, {name: sum(map(_due, here)) for name, here in by_store.items()})

    begun: set[str] = set()

    def body(name: str, shared: SharedWorkforce) -> None:
        begun.add(name)
        found = [_plane(job, shared, PlaneReporter(reporter, name, progress)) for job in by_store[name]]
        statuses.extend(found)
        progress.ends(name)
        begun.discard(name)
        if index is not None:
            index.learn(name, failed=any(found))

    try:
        with progress:
            run_side_by_side(workforce, [functools.partial(body, name) for name in by_store])
    finally:
        # Whatever ended them, part of their rows may be stored.
        for name in begun if index is not None else ():
            index.learn(name, failed=False)
    if index is not None:
        reporter.line(f"study: {counted(len(index.planes), 'plane')} in {index.path}")
    return min(max(statuses, default=0), 1)


def _index(all_settings: Sequence[Settings], jobs: Sequence[Job], reporter: Reporter) -> Index | None:
    """The index, written; None where no store is written, or not every plane has one of its own."""
    writes = {entry.name for entry in STAGES if not entry.several_planes and entry.load().writes}
    asked = {stage for job in jobs for stage in job.settings.config.stages}
    paths = {settings.store_path.resolve() for settings in all_settings}
    if len(paths) < len(all_settings) or len({path.parent for path in paths}) > 1 or not writes & asked:
        return None
    index, note = begun_index(all_settings)
    if note:
        reporter.line(note)
    index.write()
    return index


def _plane(job: Job, workforce: SharedWorkforce, reporter: PlaneReporter) -> int:
    try:
        return attempt(run_plane_stages, job, workforce, reporter)
    except Exception as error:  # a mistake of this program's, which the other planes need not suffer from
        reporter.error(f"{type(error).__name__}: {' '.join(str(error).split())}")
        reporter.note(traceback.format_exc())
        return 1


def _due(job: Job) -> int:
    """Rows that the sweep is going to compute."""
    if not job.asks("sweep"):
        return 0
    try:
        if not job.settings.config.store.overwrite and store.check(job.store_path, job.plan):
            return sum(block.stop - block.start for block in store.pending_blocks(job.store_path, job.plan))
    except ConfigurationError:
        pass  # the sweep says so when its turn comes
    return job.plan.rows
