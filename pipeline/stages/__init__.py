"""The stages of a run, in their order: what each needs, checks and does. Checks come first and write nothing."""

import os
from dataclasses import replace
from pathlib import Path

from pipeline import store
from pipeline.cluster import Workforce, check_cluster
from pipeline.config import Settings
from pipeline.errors import ConfigurationError, StoreError
from pipeline.layers import extract_layer, layer_of, of_layer
from pipeline.plan import plan
from pipeline.progress import Reporter
from pipeline.stages import (
    basins,
    boundaries,
    check,
    debug,
    figures,
    jumps,
    listing,
    margins,
    report,
    sweep,
    tables,
    verify,
)
from pipeline.stages.job import Job, sweep_command
from pipeline.store.lock import holding

__all__ = ["PLANE_STAGES", "SHARED_STAGES", "Job", "prepare", "run_plane_stages", "run_shared_stages"]

#: What concerns one plane alone, and reads its plan from the store unless it is swept in the same run.
PLANE_STAGES = (
    sweep.STAGE,
    boundaries.STAGE,
    verify.STAGE,
    basins.STAGE,
    jumps.STAGE,
    margins.STAGE,
    figures.STAGE,
    check.STAGE,
    debug.STAGE,
)
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
    layered = config.plane.layer is not None
    if job.asks(sweep.STAGE.name):
        job = Job(settings, plan(settings))
    elif job.asks(debug.STAGE.name) and not job.store_path.exists():
        # A row can be looked at before there is a store.
        job = Job(settings, plan(settings))
    elif any((stage.needs_plan or layered) and stage in PLANE_STAGES for stage in asked):
        if not job.store_path.exists():
            raise StoreError(f"there is no store at {job.store_path}: {sweep_command(settings)} makes it")
        job = Job(settings, store.read_plan(job.store_path))
    if job.plan is not None:
        job = _of_layer(job) if layered else _of_volume(job, asked)
    for stage in asked:
        if job.asks(stage.name):
            stage.check(job)
    return job


def _of_layer(job: Job) -> Job:
    """The plane of one layer; what is stored under the names of the volume and of the plane must be these."""
    layer = layer_of(job.settings, job.plan)
    store.check(layer.volume, job.plan)
    found = Job(of_layer(job.settings, job.plan, layer), job.plan.layer(layer.index), layer)
    if not job.settings.config.store.overwrite:
        store.check(found.store_path, found.plan)
    return found


def _of_volume(job: Job, asked) -> Job:
    """Of a volume, only the stages that can have one; to ask for another is a mistake, unless nobody asked."""
    kept = [stage.name for stage in asked if stage.of_volumes or stage in SHARED_STAGES]
    if job.plan.parameter2 is None or len(kept) == len(asked):
        return job
    if job.settings.overridden("stages"):
        (refused, *_) = [stage.name for stage in asked if stage.name not in kept]
        raise ConfigurationError(
            f"stages = {refused!r} is not allowed for a volume: with plane.layer=VALUE, a value of "
            f"{job.plan.parameter2.name}, it is done in the plane of that layer"
        )
    return replace(job, settings=replace(job.settings, config=replace(job.settings.config, stages=kept)))


def _check_folder(key: str, folder: Path) -> None:
    """Raise unless the folder exists and can be written, or can be made."""
    place = folder.resolve()
    while not place.exists() and place != place.parent:
        place = place.parent
    if not place.is_dir() or not os.access(place, os.W_OK | os.X_OK):
        raise ConfigurationError(
            f"{key} = {str(folder)!r} is not allowed: it must be a folder that can be written ({place})"
        )


def run_plane_stages(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    """Run what concerns this plane alone, in the order of the stages; the worst exit status."""
    if job.layer is None and not any(stage.writes and job.asks(stage.name) for stage in PLANE_STAGES):
        return _run(PLANE_STAGES, job, workforce, reporter)
    with holding(job.store_path, job.settings.config.store.wait, reporter.line) as waited:
        store.remove_left_overs(job.store_path)
        # What was checked before a wait may have become another store.
        job = prepare(job.settings) if waited else job
        _extract_layer(job, reporter)
        return _run(PLANE_STAGES, job, workforce, reporter)


def _extract_layer(job: Job, reporter: Reporter) -> None:
    """Take the layer out of its volume, where there is one and that has not been done."""
    anew = job.settings.config.store.overwrite and job.asks(sweep.STAGE.name)
    if job.layer is None or job.store_path.exists() or not job.layer.volume.exists() or anew:
        return
    extract_layer(job.layer, job.store_path, job.plan, job.settings.store_name, job.settings.yaml())
    reporter.line(f"layer: {job.settings.store_name} taken out of {job.layer.volume} into {job.store_path}")


def run_shared_stages(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    """Run what needs several planes; with several jobs, once after all of them."""
    return _run(SHARED_STAGES, job, workforce, reporter)


def _run(stages, job: Job, workforce: Workforce, reporter: Reporter) -> int:
    reporter.log = None
    return max((stage.run(job, workforce, reporter) for stage in stages if job.asks(stage.name)), default=0)
