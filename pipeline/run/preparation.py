"""Preparing and running the stages that were asked for. Checks come first and write nothing.

What not every stage needs is imported where it is: zarr and most of the solver take longer than the shortest stages.
"""

import contextlib
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from pipeline import store
from pipeline.config.compose import Settings
from pipeline.config.places import Place
from pipeline.errors import ConfigurationError, StoreError, Unreachable
from pipeline.plan.differences import by_key, differences, of_typed
from pipeline.plan.layers import layer_of, of_layer
from pipeline.plan.plan import Plan
from pipeline.plan.planning import plan
from pipeline.run.cluster_settings import check_cluster
from pipeline.run.job import Job, command, other_numbers
from pipeline.run.progress import Reporter
from pipeline.run.stage import Stage
from pipeline.run.workforce import Workforce
from pipeline.stages import STAGES
from pipeline.store.files import files_at
from pipeline.store.lock import exclusive_lock

__all__ = ["prepare", "run_plane_stages", "run_shared_stages", "stored_plan"]


def _asked(job: Job, several_planes: bool) -> list[Stage]:
    """The stages that the user wants, of those for one plane or of those for several, in the order of a run."""
    return [entry.load() for entry in STAGES if entry.several_planes == several_planes and job.asks(entry.name)]


def prepare(settings: Settings) -> Job:
    """Check everything that can be checked without writing or starting anything.

    Raises
    ------
    ConfigurationError
        One line.
    """
    try:
        return _prepared(settings)
    except Unreachable as error:
        # Nothing is begun yet.
        raise StoreError(str(error)) from None


def _prepared(settings: Settings) -> Job:
    config = settings.config
    known = [entry.name for entry in STAGES]
    for name in config.stages:
        if name not in known:
            raise ConfigurationError(f"stages = {name!r} is not allowed: it must be a list of {', '.join(known)}")
    if not config.stages:
        raise ConfigurationError(f"stages = [] is not allowed: it must be a list of {', '.join(known)}")
    job = Job(settings, None)
    plane_stages = _asked(job, several_planes=False)
    asked = [*plane_stages, *_asked(job, several_planes=True)]
    if not all(stage.only_reads(job) for stage in asked):
        _check_folder("output.root", Path(config.output.root))
    if _write_into_store(asked, job):
        _check_folder("store.root", settings.store_root)
    if any(stage.on_workers for stage in asked):
        check_cluster(config.cluster)
    if config.cluster.kind != "none" and not files_at(settings.store_root).is_shared():
        raise ConfigurationError(
            f"store.root = {str(settings.store_root)!r} is not allowed with cluster.kind = {config.cluster.kind!r}: "
            "no other process sees it; cluster=none computes in this one"
        )
    layered = config.plane.layer is not None
    reads = any(stage.needs_plan or layered for stage in plane_stages)
    if job.asks("sweep") or (job.asks("debug") and not store.exists(job.store_path)):
        # A row can be looked at before there is a store.
        job = Job(settings, plan(settings))
        if job.asks("sweep") and not layered and not config.store.overwrite:
            _refuse_other(settings, job.store_path, job.plan)
    elif reads:
        job = Job(settings, stored_plan(settings))
    elif plane_stages and store.exists(job.store_path):
        # What is damaged is for the stage to say.
        found = None
        with contextlib.suppress(StoreError):
            found = store.read_plan(job.store_path)
        if found is not None:
            _check_typed(settings, job.store_path, found)
    if job.plan is not None:
        job = _of_layer(job) if layered else _of_volume(job, plane_stages)
    for stage in asked:
        if job.asks(stage.name):
            stage.check(job)
    return job


def stored_plan(settings: Settings) -> Plan:
    """The plan of the store of some settings, for which everything holds that the user typed.

    Raises
    ------
    ConfigurationError
        If there is no such store, or it was made with other numbers; the message has the ways on.
    """
    path = settings.store_path.resolve()
    if not store.exists(path):
        raise StoreError(f"there is no store at {path}: {command(settings)} makes it")
    found = store.read_plan(path)
    _check_typed(settings, path, found)
    return found


def _check_typed(settings: Settings, path: Place, found: Plan) -> None:
    if changes := of_typed(settings, found):
        raise other_numbers(settings, path, changes)


def _refuse_other(settings: Settings, path: Place, wanted: Plan) -> None:
    """Raise unless there is no store, or the one of exactly this plan."""
    try:
        store.check(path, wanted)
    except StoreError:
        # What is there may be no store at all, which is then what there is to say.
        changes = differences(by_key(store.read_layout(path, going_on=True).plan.inputs), by_key(wanted.inputs))
        raise other_numbers(settings, path, changes) from None


def _of_layer(job: Job) -> Job:
    """The plane of one layer; what is stored under the names of the volume and of the plane must be these."""
    layer = layer_of(job.settings, job.plan)
    _refuse_other(job.settings, layer.volume, job.plan)
    found = Job(of_layer(job.settings, job.plan, layer), job.plan.layer(layer.index), layer)
    if not job.settings.config.store.overwrite:
        _refuse_other(found.settings, found.store_path, found.plan)
    return found


def _of_volume(job: Job, plane_stages: Iterable[Stage]) -> Job:
    """Of a volume, only the stages that can have one; to ask for another is a mistake, unless nobody asked."""
    refused = [stage.name for stage in plane_stages if not stage.of_volumes]
    if job.plan.parameter2 is None or not refused:
        return job
    if job.settings.overridden("stages"):
        raise ConfigurationError(
            f"stages = {refused[0]!r} is not allowed for a volume: with plane.layer=VALUE, a value of "
            f"{job.plan.parameter2.name}, it is done in the plane of that layer"
        )
    kept = [name for name in job.settings.config.stages if name not in refused]
    return replace(job, settings=replace(job.settings, config=replace(job.settings.config, stages=kept)))


def _write_into_store(stages: Iterable[Stage], job: Job) -> bool:
    return any(stage.writes and not stage.only_reads(job) for stage in stages)


def _check_folder(key: str, folder: Place) -> None:
    """Raise unless the folder exists and can be written, or can be made."""
    if allowed := files_at(folder).refusal():
        raise ConfigurationError(f"{key} = {str(folder)!r} is not allowed: {allowed}")


def run_plane_stages(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    """Run what concerns this plane alone, in the order of the stages; the worst exit status."""
    stages = _asked(job, several_planes=False)
    makes = _write_into_store(stages, job) or (job.layer is not None and not store.exists(job.store_path))
    # Nobody writes where nobody can.
    alone = any(stage.writes for stage in stages) and files_at(job.store_path).known_writable()
    if not (makes or alone):
        return _run_with_result(stages, job, workforce, reporter)
    from pipeline.store.repair import remove_left_overs

    wait = job.settings.config.store.wait
    with contextlib.ExitStack() as held:
        try:
            with workforce.aside() if wait else contextlib.nullcontext():
                waited = held.enter_context(exclusive_lock(job.store_path, wait, reporter.line))
        except Unreachable as error:
            raise StoreError(str(error)) from None
        remove_left_overs(job.store_path)
        # What was checked before a wait may have become another store.
        job = prepare(job.settings) if waited else job
        _take_out_layer(job, reporter)
        return _run_with_result(stages, job, workforce, reporter)


def _run_with_result(stages: Iterable[Stage], job: Job, workforce: Workforce, reporter: Reporter) -> int:
    """Run stages, and where they were about the map say at the end what it tells."""
    status = _run(stages, job, workforce, reporter)
    if any(stage.tells_map for stage in stages):
        from pipeline.plane.result import result_line
        from pipeline.plane.stored import StoredPlane

        if text := result_line(StoredPlane(job.store_path, job.plan)):
            reporter.line(f"{job.settings.store_name}: {text}")
    return status


def _take_out_layer(job: Job, reporter: Reporter) -> None:
    """Take the layer out of its volume, where there is one and that has not been done."""
    anew = job.settings.config.store.overwrite and job.asks("sweep")
    if job.layer is None or anew or store.exists(job.store_path) or not store.exists(job.layer.volume):
        return
    from pipeline.store.extraction import extract_layer

    extract_layer(job.layer, job.store_path, job.plan, job.settings.store_name, job.settings.yaml())
    reporter.line(f"layer: {job.settings.store_name} taken out of {job.layer.volume} into {job.store_path}")


def run_shared_stages(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    """Run what needs several planes; with several jobs, once after all of them."""
    return _run(_asked(job, several_planes=True), job, workforce, reporter)


def _run(stages: Iterable[Stage], job: Job, workforce: Workforce, reporter: Reporter) -> int:
    reporter.log, stages, status = None, list(stages), 0
    for number, stage in enumerate(stages, start=1):
        status = max(status, stage.run(job, workforce, reporter))
        for later in stages[number:]:
            later.begin(job, workforce)
            if later.writes:
                break
        stage.finish(job, reporter)
    return status
