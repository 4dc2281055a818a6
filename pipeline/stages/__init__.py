"""The stages of a run, in their order: what each needs, checks and does. Checks come first and write nothing."""

import os
from pathlib import Path

from pipeline import store
from pipeline.cluster import Workforce, check_cluster
from pipeline.config import Settings
from pipeline.errors import ConfigurationError, StoreError
from pipeline.plan import plan
from pipeline.progress import Reporter
from pipeline.stages import (
    basins, boundaries, check, debug, figures, jumps, listing, margins, report, sweep, tables, verify,
)  # fmt: skip
from pipeline.stages.job import Job, sweep_command
from pipeline.store.lock import holding

__all__ = ["PLANE_STAGES", "SHARED_STAGES", "Job", "prepare", "run_plane_stages", "run_shared_stages"]

#: What concerns one plane alone, and reads its plan from the store unless it is swept in the same run.
PLANE_STAGES = (
    sweep.STAGE, boundaries.STAGE, verify.STAGE, basins.STAGE, jumps.STAGE, margins.STAGE, figures.STAGE, check.STAGE,
    debug.STAGE,
)  # fmt: skip
#: What needs several planes.
SHARED_STAGES = (tables.STAGE, report.STAGE, listing.STAGE)


def prepare(settings: Settings) -> Job:
    """Check everything that can be checked without writing or starting anything.

    Raises
    ------
    ConfigurationError
        One line.
    """
    config = settings.config
    known = [stage.name for stage in (*PLANE_STAGES, *SHARED_STAGES)]
    for name in config.stages:
        if name not in known:
            raise ConfigurationError(f"stages = {name!r} is not allowed: it must be a list of {', '.join(known)}")
    if not config.stages:
        raise ConfigurationError(f"stages = [] is not allowed: it must be a list of {', '.join(known)}")
    for key, folder in (("output.root", config.output.root), ("store.root", config.store.root)):
        _check_folder(key, Path(folder))
    job = Job(settings, None)
    asked = [stage for stage in (*PLANE_STAGES, *SHARED_STAGES) if job.asks(stage.name)]
    if any(stage.on_workers for stage in asked):
        check_cluster(config.cluster)
    if job.asks(sweep.STAGE.name):
        job = Job(settings, plan(settings))
    elif job.asks(debug.STAGE.name) and not job.store_path.exists():
        # A row can be looked at before there is a store.
        job = Job(settings, plan(settings))
    elif any(stage.needs_plan and stage in PLANE_STAGES for stage in asked):
        if not job.store_path.exists():
            raise StoreError(f"there is no store at {job.store_path}: {sweep_command(settings)} makes it")
        job = Job(settings, store.read_plan(job.store_path))
    for stage in asked:
        stage.check(job)
    return job


def _check_folder(key: str, folder: Path) -> None:
    """Raise unless the folder exists and can be written, or can be made."""
    place = folder.resolve()
    while not place.exists() and place != place.parent:
        place = place.parent
    if not place.is_dir() or not os.access(place, os.W_OK | os.X_OK):
        raise ConfigurationError(f"{key} = {str(folder)!r} is not allowed: it must be a folder that can be written ({place})")


def run_plane_stages(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    """Run what concerns this plane alone, in the order of the stages; the worst exit status."""
    if not any(stage.writes and job.asks(stage.name) for stage in PLANE_STAGES):
        return _run(PLANE_STAGES, job, workforce, reporter)
    with holding(job.store_path, job.settings.config.store.wait, reporter.line) as waited:
        store.remove_left_overs(job.store_path)
        # What was checked before a wait may have become another store.
        return _run(PLANE_STAGES, prepare(job.settings) if waited else job, workforce, reporter)


def run_shared_stages(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    """Run what needs several planes; with several jobs, once after all of them."""
    return _run(SHARED_STAGES, job, workforce, reporter)


def _run(stages, job: Job, workforce: Workforce, reporter: Reporter) -> int:
    reporter.log = None
    return max((stage.run(job, workforce, reporter) for stage in stages if job.asks(stage.name)), default=0)
