"""The stages of a run: what each needs, checks and does. Checks come first and write nothing."""

import os
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from time import perf_counter

import numpy as np

from pipeline import groups, store
from pipeline.cluster import Workforce, check_cluster
from pipeline.config import Settings
from pipeline.errors import ConfigurationError, StoreError
from pipeline.integration_options import check_basins, check_jumps, check_verify
from pipeline.plan import Plan, plan, warnings
from pipeline.progress import Reporter, RowProgress

__all__ = ["PLANE_STAGES", "SHARED_STAGES", "Job", "prepare", "run_plane_stages", "run_shared_stages"]

TABLE_PLANES = ("omega_b", "omega_alpha", "omega_fpm")


@dataclass(frozen=True)
class Job:
    """A checked configuration with the plan of its plane (None where no stage needs one)."""

    settings: Settings
    plan: Plan | None

    @property
    def store_path(self) -> Path:
        """Where the plane's store is, or will be."""
        return self.settings.store_path.resolve()

    def asks(self, stage: str) -> bool:
        """Whether the user wants this stage."""
        return stage in self.settings.config.stages


def prepare(settings: Settings) -> Job:
    """Check everything that can be checked without writing or starting anything.

    Raises
    ------
    ConfigurationError
        One line.
    """
    config = settings.config
    known = [*PLANE_STAGES, *SHARED_STAGES]
    for stage in config.stages:
        if stage not in known:
            raise ConfigurationError(f"stages = {stage!r} is not allowed: it must be a list of {', '.join(known)}")
    if not config.stages:
        raise ConfigurationError(f"stages = [] is not allowed: it must be a list of {', '.join(known)}")
    for key, folder in (("output.root", config.output.root), ("store.root", config.store.root)):
        _check_folder(key, Path(folder))
    job = Job(settings, None)
    if job.asks("sweep"):
        check_cluster(config.cluster)
        job = Job(settings, plan(settings))
        _check_store(job)
    elif any(job.asks(stage) for stage in PLANE_STAGES):
        if not job.store_path.exists():
            raise StoreError(f"there is no store at {job.store_path}: {sweep_command(settings)} makes it")
        job = Job(settings, store.read_plan(job.store_path))
    _check_integration(job)
    if job.asks("figures"):
        from pipeline import figures

        options = config.figures
        figures.check_options(job.plan, **_figure_options(options))
    return job


def _check_integration(job: Job) -> None:
    config = job.settings.config
    if any(job.asks(stage) for stage in ("verify", "basins", "jumps")):
        check_cluster(config.cluster)
    if job.asks("verify"):
        check_verify(config.verify)
    if job.asks("basins"):
        check_basins(config.basins, job.plan)
    if job.asks("jumps"):
        check_jumps(config.jumps, job.plan)


def sweep_command(settings: Settings, plane: str | None = None) -> str:
    """The command that computes a plane with these choices of gear, quality and store."""
    choices, root = settings.choices, settings.config.store.root
    words = ["python -m pipeline", f"plane={plane or choices['plane']}"]
    words += [f"{group}={choices[group]}" for group, usual in (("gear", "published"), ("quality", "paper"))
              if choices[group] != usual]  # fmt: skip
    kept = ("output.root=", "store.root=", "solver=", "solver.order=", "solver.period=")
    words += [override for override in settings.overrides if override.startswith(kept)]
    if plane is None and settings.config.store.name is not None:
        words.append(f"store.name={settings.config.store.name}")
    return " ".join(words) if root else words[0]


def _check_folder(key: str, folder: Path) -> None:
    """Raise unless the folder exists and can be written, or can be made."""
    place = folder.resolve()
    while not place.exists() and place != place.parent:
        place = place.parent
    if not place.is_dir() or not os.access(place, os.W_OK | os.X_OK):
        raise ConfigurationError(f"{key} = {str(folder)!r} is not allowed: it must be a folder that can be written ({place})")


def _check_store(job: Job) -> None:
    path, config = job.store_path, job.settings.config
    if config.store.overwrite:
        store.refuse_foreign(path)
    else:
        store.check(path, job.plan)
    place = path
    while not place.exists():
        place = place.parent
    free = shutil.disk_usage(place).free
    if job.plan.bytes > free:
        raise ConfigurationError(
            f"plane.sweep.num x plane.parameter.num = {job.plan.sweep.num} x {job.plan.parameter.num} is not allowed: "
            f"up to {job.plan.bytes / 1e9:.3g} GB do not fit into the {free / 1e9:.3g} GB free at {place}"
        )


def _sweep(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    settings, path = job.settings, job.store_path
    for text in warnings(job.plan):
        reporter.line(f"note: {text}")
    begin = perf_counter()
    present = store.check(path, job.plan) if not settings.config.store.overwrite else False
    blocks = store.pending_blocks(path, job.plan) if present else job.plan.blocks
    if not blocks and not _neighbours(job).size:
        reporter.line(f"sweep: all {job.plan.parameter.num} rows are in {path} already, nothing to do")
        return 0
    where = workforce.start()
    _open_log(job, reporter)
    if present:
        # They belong to the rows as they were.
        groups.remove_added(path)
    else:
        shutil.rmtree(path, ignore_errors=True)
        store.create(path, job.plan, settings.store_name, settings.yaml())
    rows = sum(block.stop - block.start for block in blocks)
    columns = job.plan.sweep.num
    state = "continues: " if present else ""
    reporter.line(f"sweep: {state}{rows} rows of {columns} columns into {path}; {where}")
    ready = perf_counter()
    lost, points = _run_blocks(job, blocks, {}, workforce, reporter)
    if not lost:
        lost += _certify_neighbours(job, workforce, reporter)
    seconds = perf_counter() - ready
    failed = store.failures(path)
    for row, reason in failed[:10]:
        reporter.line(f"  row {row} ({job.plan.parameter.name} = {job.plan.parameter.values[row]:.6g}) failed: {reason}")
    if len(failed) > 10:
        reporter.line(f"  and {len(failed) - 10} more; `message` in the store has every reason")
    for text in lost:
        reporter.error(text)
    reporter.line(
        f"sweep: {rows - len(failed)} rows, {points} branch points in {seconds:.2f} s "
        f"(after {ready - begin:.2f} s to get ready), {len(failed)} rows failed"
    )
    return 1 if failed or lost else 0


def _neighbours(job: Job):
    """Rows that a second look is due to; none where enumeration is off or looks everywhere anyway."""
    return store.rows_to_certify(job.store_path) if job.plan.solver["certify"] == "columns" else np.empty(0, int)


def _certify_neighbours(job: Job, workforce: Workforce, reporter: Reporter) -> list[str]:
    """Look everywhere in rows beside which folds come or go, until no more such rows turn up; why blocks were lost."""
    lost, before = [], store.certified_rows(job.store_path).size
    while not lost and (due := _neighbours(job)).size:
        rows = np.union1d(due, store.certified_rows(job.store_path))
        chosen = {block: frozenset(rows[(rows >= block.start) & (rows < block.stop)].tolist()) for block in job.plan.blocks}
        blocks = [block for block in job.plan.blocks if np.any((due >= block.start) & (due < block.stop))]
        lost, _ = _run_blocks(job, blocks, chosen, workforce, None)
    count = store.certified_rows(job.store_path).size - before
    reporter.line(f"sweep: {count} rows next to births and deaths of folds enumerated at every column")
    return lost


def _run_blocks(job: Job, blocks, every_column: dict, workforce: Workforce, reporter: Reporter | None):
    """Run the blocks, with a bar if a reporter is given; why blocks were lost, and the number of branch points."""
    from pipeline.sweep import sweep_block

    lost, points = [], 0
    tasks = [(str(job.store_path), job.plan, block, every_column.get(block, frozenset())) for block in blocks]
    rows = sum(block.stop - block.start for block in blocks)
    with RowProgress(reporter, rows) as progress:
        for (_, _, block, _), result in workforce.run(sweep_block, tasks):
            count = block.stop - block.start
            if isinstance(result, BaseException):
                lost.append(f"rows {block.start}-{block.stop - 1} were not stored: {type(result).__name__}: {result}")
                progress.advance(count, count)
            else:
                points += result.points
                progress.advance(count, len(result.failures))
    return lost, points


def _trace(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    from pipeline import boundaries

    path, plan = job.store_path, job.plan
    _note_unfinished(job, reporter, "boundaries start from the others")
    begin = perf_counter()
    try:
        summary = boundaries.trace(path, plan)
    except (ArithmeticError, ValueError, np.linalg.LinAlgError) as error:
        reporter.error(f"boundaries of {path} cannot be traced: {' '.join(str(error).split())}")
        return 1
    folder = job.settings.output_root / "boundaries"
    names = boundaries.write_sheets(boundaries.read_boundaries(path, plan), plan, folder, job.settings.store_name)
    seconds = perf_counter() - begin
    counts = [f"{n} {kind} curve{'s' * (n != 1)}" for kind, n in summary.curves.items()] or ["no boundaries"]
    special = ", ".join(f"{n} {kind.replace('_', '-')}" for kind, n in sorted(summary.special.items())) or "none"
    for text in summary.cut_short:
        reporter.error(text)
    if summary.found_done:
        reporter.line(f"boundaries: {', '.join(counts)} are in {path} already, nothing to do")
    else:
        reporter.line(
            f"boundaries: {', '.join(counts)} of {summary.points} points into {path}; special points: {special} "
            f"({seconds:.2f} s)"
        )
    reporter.line(f"boundaries: {', '.join(name.name for name in names)} in {folder.resolve()}")
    return 1 if summary.cut_short else 0


def _note_unfinished(job: Job, reporter: Reporter, consequence: str) -> None:
    unfinished = int(np.sum(store.statuses(job.store_path) != store.COMPLETE))
    if unfinished:
        reporter.line(f"note: {unfinished} rows of {job.store_path} are not complete, {consequence}")


def _verify(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    from pipeline import verification

    path, options = job.store_path, job.settings.config.verify
    _note_unfinished(job, reporter, "they are not verified")
    begin = perf_counter()
    total = verification.tasks_of(path, job.plan, options)
    with RowProgress(reporter, total, what="verify", unit="motions and rows") as bar:
        summary = verification.verify(path, job.plan, options, workforce.run, bar.advance)
    folder = job.settings.output_root / "verification"
    (domain, _), stored = verification.read_labels(path), verification.read_verification(path)
    names = verification.write_sheets(domain, stored, job.plan, options, folder, job.settings.store_name)
    _say_failures(summary.failures, reporter)
    whole = verification.region_lines(domain, stored)[-1]
    reporter.line(f"verify: {', '.join(f'{n} {kind.name.lower()}' for kind, n in summary.verdicts.items() if n)}")
    right = f"{whole.share:.1%} ({whole.low:.1%} to {whole.high:.1%}) right by integration; " if whole.samples else ""
    shares = ", ".join(f"{share:.1%} {kind.words}" for kind, share in summary.shares.items() if share)
    seconds = perf_counter() - begin
    done = f"are in {path} already, nothing to do" if summary.found_done else f"into {path} ({seconds:.2f} s)"
    reporter.line(f"verify: of the cells {right}{shares}; {done}")
    reporter.line(f"verify: {', '.join(name.name for name in names)} in {folder.resolve()}")
    return 1 if summary.failures else 0


def _basins(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    from pipeline import basins

    path, options = job.store_path, job.settings.config.basins
    begin = perf_counter()
    total = len(options.points) if options.points is not None else options.cells
    with RowProgress(reporter, total, what="basins", unit="places") as bar:
        found, done = basins.measure(path, job.plan, options, workforce.run, bar.advance)
    sheet = basins.write_sheet(found, job.plan, job.settings.output_root / "basins", job.settings.store_name)
    failures = [f"basins at {job.plan.sweep.name} = {x:.6g}, {job.plan.parameter.name} = {p:.6g} failed: {text}"
                for x, p, text in zip(found.places["x"], found.places["p"], found.messages, strict=True)
                if text]  # fmt: skip
    _say_failures(failures, reporter)
    attractors = int(found.places["n_attractors"].sum())
    end = f"are in {path} already, nothing to do" if done else f"into {path} ({perf_counter() - begin:.2f} s)"
    places = f"{len(found.messages)} places" if len(found.messages) else "no place with coexisting motions"
    reporter.line(f"basins: {attractors} attractors at {places} from {options.starts} starts each, {end}")
    reporter.line(f"basins: {sheet.name} in {sheet.parent.resolve()}")
    return 1 if failures else 0


def _jumps(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    from pipeline import jumps

    path, options = job.store_path, job.settings.config.jumps
    begin = perf_counter()
    with RowProgress(reporter, jumps.rows_of(job.plan, options).size, what="jumps") as bar:
        found, done = jumps.follow(path, job.plan, options, workforce.run, bar.advance)
    sheets = jumps.write_sheets(found, job.plan, job.settings.output_root / "jumps", job.settings.store_name)
    values = job.plan.parameter.values[found.rows]
    failures = [f"row {row} ({job.plan.parameter.name} = {value:.6g}) could not be followed: {text}"
                for row, value, text in zip(found.rows, values, found.messages, strict=True) if text]  # fmt: skip
    _say_failures(failures, reporter)
    widest = int(np.argmax(found.widths))
    end = f"are in {path} already, nothing to do" if done else f"into {path} ({perf_counter() - begin:.2f} s)"
    reporter.line(
        f"jumps: {found.rows.size} rows, {int(np.sum(found.widths > 0.0))} with hysteresis, at most "
        f"{found.widths[widest]:.4g} wide at {job.plan.parameter.name} = {values[widest]:.6g}, {end}"
    )
    reporter.line(f"jumps: {', '.join(sheet.name for sheet in sheets)} in {sheets[0].parent.resolve()}")
    return 1 if failures else 0


def _say_failures(failures, reporter: Reporter) -> None:
    for text in failures[:10]:
        reporter.error(text)
    if len(failures) > 10:
        reporter.line(f"  and {len(failures) - 10} more; the store has every reason")


def _figure_options(options) -> dict:
    """The settings of figures as `pipeline.figures.draw` takes them."""
    return {name: getattr(options, name) for name in ("curves", "formats", "dpi", "window", "stability", "units")}


def _draw(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    from pipeline import figures

    options = job.settings.config.figures
    _note_unfinished(job, reporter, "the figures leave them blank")
    begin = perf_counter()
    folder = job.settings.output_root / "figures" / job.settings.store_name
    paths = figures.draw(job.store_path, folder, **_figure_options(options))
    names = ", ".join(path.name for path in paths)
    reporter.line(f"figures: {names} in {folder.resolve()} ({perf_counter() - begin:.2f} s)")
    return 0


def _tabulate(job: Job, reporter: Reporter) -> int:
    from pipeline import tables

    settings = job.settings
    root = Path(settings.config.store.root).resolve()
    stores = {
        plane: (root / f"{settings.name_of(plane)}.zarr", sweep_command(settings, plane)) for plane in TABLE_PLANES
    }
    folder = settings.output_root / "tables"
    paths = tables.write(stores, folder)
    reporter.line(f"tables: {', '.join(path.name for path in paths)} in {folder.resolve()}")
    return 0


def _open_log(job: Job, reporter: Reporter) -> None:
    """Make the folder of this run with the configuration as resolved and as typed; the reporter logs into it."""
    stamp = datetime.now(UTC).strftime("%Y-%m-%dT%H-%M-%S.%fZ")
    folder = job.settings.output_root / "runs" / job.settings.store_name / stamp
    folder.mkdir(parents=True)
    (folder / "config.yaml").write_text(job.settings.yaml(), encoding="utf-8")
    (folder / "overrides.txt").write_text("".join(f"{line}\n" for line in job.settings.overrides), encoding="utf-8")
    reporter.log = folder / "run.log"
    reporter.line(f"run: configuration and log in {folder.resolve()}")


PLANE_STAGES: dict[str, Callable[[Job, Workforce, Reporter], int]] = {
    "sweep": _sweep,
    "boundaries": _trace,
    "verify": _verify,
    "basins": _basins,
    "jumps": _jumps,
    "figures": _draw,
}
SHARED_STAGES: dict[str, Callable[[Job, Reporter], int]] = {"tables": _tabulate}


def run_plane_stages(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    """Run what concerns this plane alone, in the order of the stages; the worst exit status."""
    reporter.log = None
    status = 0
    for stage, run in PLANE_STAGES.items():
        if job.asks(stage):
            status = max(status, run(job, workforce, reporter))
    return status


def run_shared_stages(job: Job, reporter: Reporter) -> int:
    """Run what needs several planes; with several jobs, once after all of them."""
    reporter.log = None
    return max((run(job, reporter) for stage, run in SHARED_STAGES.items() if job.asks(stage)), default=0)
