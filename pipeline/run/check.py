"""The stage check: every file of a store against its checksum and the template, and rows against their computation."""

from time import perf_counter

from pipeline import store
from pipeline.errors import StoreError, counted
from pipeline.plan.plan import Plan
from pipeline.run.job import Job
from pipeline.run.kernels import kernels_for
from pipeline.run.progress import Reporter
from pipeline.run.stage import Stage
from pipeline.run.sweep import compute
from pipeline.run.warmup import warm_up_where
from pipeline.run.workforce import Workforce
from pipeline.stages import STAGES
from pipeline.store.repair import repair

__all__ = ["STAGE"]

_SHOWN = 20


def _run(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    path, config = job.store_path, job.settings.config
    begin = perf_counter()
    damage = store.find_damage(path)
    for item in damage[:_SHOWN]:
        reporter.error(f"check: {item.sentence}")
    if len(damage) > _SHOWN:
        reporter.line(f"  and {len(damage) - _SHOWN} more files")
    seconds = perf_counter() - begin
    if not damage:
        reporter.line(f"check: every file of {path} is sound ({seconds:.2f} s)")
        return _recompute(job, workforce, reporter) if config.check.recompute else 0
    blocks = {item.block for item in damage if item.block is not None}
    rows = sum(block.stop - block.start for block in blocks)
    groups = sorted({item.group for item in damage if item.group is not None})
    what = f"{counted(len(damage), 'damaged file')}, {counted(rows, 'row')} in {counted(len(blocks), 'block')}"
    what += f", groups {', '.join(groups)}" if groups else ""
    if not config.check.repair:
        reporter.line(f"check: {what}; the same command with check.repair=true mends them")
        return 1
    repair(path, damage)
    status = _again(job, workforce, reporter) if blocks else 0
    left = store.find_damage(path)
    for name in groups:
        # Places and isolated branches are made with attractors.
        stage = name if any(entry.name == name for entry in STAGES) else "attractors"
        reporter.line(f"check: the damaged group {name} was taken away: stages=[{stage}] makes it again")
    mended = f"check: {what} mended ({perf_counter() - begin:.2f} s)"
    reporter.line(mended if not left else f"check: {len(left)} still damaged")
    if status or left:
        return 1
    return _recompute(job, workforce, reporter) if config.check.recompute else 0


def _recompute(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    """Compute some rows again and say which differ from what is stored, and in what."""
    from pipeline.run.recompute import compare_row, drawn_rows

    path, options, begin = job.store_path, job.settings.config.check, perf_counter()
    plan = store.read_layout(path).plan
    rows = drawn_rows(path, plan, options.recompute, options.seed)
    if rows:
        _start(plan, workforce, reporter)
    different = 0
    for (_, _, row), result in workforce.run(compare_row, [(path, plan, row) for row in rows]):
        if isinstance(result, OSError | StoreError):
            raise result
        failed = isinstance(result, BaseException)
        if failed or result:
            different += 1
            what = f"it fails: {' '.join(str(result).split())}" if failed else ", ".join(one.sentence for one in result)
            reporter.error(f"check: {plan.row_text(row)} is stored otherwise than it is computed here: {what}")
    said = f"{different} of {len(rows)} rows differ from" if different else f"{len(rows)} rows are bit by bit"
    reporter.line(f"check: {said} what is computed here ({perf_counter() - begin:.2f} s)")
    return 1 if different else 0


def _start(plan: Plan, workforce: Workforce, reporter: Reporter) -> None:
    """Start what rows are computed on, which is there for no other stage of this run."""
    warm_up_where(workforce, kernels_for(["sweep"], plan.solver["balance"], plan.kind), reporter)
    workforce.start()


def _again(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    """Compute what has been marked as pending."""
    plan = store.read_layout(job.store_path).plan
    _start(plan, workforce, reporter)
    return compute(Job(job.settings, plan), store.pending_blocks(job.store_path, plan), workforce, reporter)


STAGE = Stage(
    "check",
    _run,
    on_workers=True,
    writes=True,
    only_reads=lambda job: not job.settings.config.check.repair,
    needs_plan=False,
    of_volumes=True,
)
