"""The stage sweep: rows of the plane that are not in the store yet."""

import math
from collections.abc import Sequence
from time import perf_counter

from pipeline import store
from pipeline.errors import ConfigurationError, counted
from pipeline.plan.axes import ROLES
from pipeline.plan.plan import Block
from pipeline.plan.planning import warnings
from pipeline.run.early import DRAWING, ROWS, is_small
from pipeline.run.job import Job, open_log
from pipeline.run.progress import Reporter, RowProgress
from pipeline.run.stage import Stage
from pipeline.run.warmup import warm_up_for
from pipeline.run.workforce import Workforce
from pipeline.store import groups
from pipeline.store.attempts import forget_attempts
from pipeline.store.files import files_at
from pipeline.store.listing import size_text
from pipeline.store.names import STORE_FILE
from pipeline.store.repair import remove_left_overs

__all__ = ["STAGE", "compute"]

#: Failed rows, and rows with notes, that are listed in full.
_LISTED = 10


def _check_store(job: Job) -> None:
    path, config = job.store_path, job.settings.config
    if config.store.overwrite:
        store.refuse_foreign(path)
    else:
        store.check(path, job.plan)
    # An object store has no room that one could ask for.
    free, place = files_at(path).room() or (math.inf, None)
    if job.plan.bytes > free:
        raise ConfigurationError(
            f"{' x '.join(f'plane.{role}.num' for role, _ in zip(ROLES, job.plan.axes, strict=False))} = "
            f"{' x '.join(str(axis.num) for axis in job.plan.axes)} is not allowed: "
            f"up to {size_text(job.plan.bytes)} do not fit into the {size_text(free)} free at {place}"
        )


def _run(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    settings, path = job.settings, job.store_path
    for text in warnings(job.plan, settings):
        reporter.line(f"note: {text}")
    begin = perf_counter()
    present = store.check(path, job.plan) if not settings.config.store.overwrite else False
    blocks = store.pending_blocks(path, job.plan) if present else job.plan.blocks
    if not blocks:
        reporter.line(f"sweep: all {job.plan.rows} rows are in {path} already, nothing to do")
        return 0
    everybody, workforce = workforce, _enough(job, blocks, workforce)
    warm_up_for(job, reporter, workforce)
    alone = workforce is not everybody
    if alone:
        _expect_figures(job, everybody)
    where = workforce.start()
    open_log(job, reporter)
    if present:
        # They belong to the rows as they were.
        groups.remove_added(path)
    else:
        files_at(path).clear(STORE_FILE)
        store.create(path, job.plan, settings.store_name, settings.yaml())
    rows = sum(block.stop - block.start for block in blocks)
    state = "continues: " if present else ""
    reporter.line(f"sweep: {state}{counted(rows, 'row')} of {job.plan.sweep.num} columns into {path}; {where}")
    status = compute(job, blocks, workforce, reporter, perf_counter() - begin)
    if not alone:
        _expect_figures(job, everybody)
    return status


def _expect_figures(job: Job, workforce: Workforce) -> None:
    """What draws is loaded while boundaries are traced, and of a small plane while its rows are computed."""
    if job.asks("figures") and job.plan.parameter2 is None:
        first_order = job.plan.solver["balance"] == "describing_function"
        workforce.expect([ROWS, DRAWING] if first_order else [DRAWING])


def _enough(job: Job, blocks: Sequence[Block], workforce: Workforce) -> Workforce:
    """This process and helpers where workers would take longer to start, unless a cluster is asked for."""
    cells = job.plan.sweep.num * sum(block.stop - block.start for block in blocks) * workforce.planes
    return workforce.alone() if is_small(job.settings, cells) else workforce


def compute(job: Job, blocks: Sequence[Block], workforce: Workforce, reporter: Reporter, waited: float = 0.0) -> int:
    """Compute blocks of a store and say what came of it; an exit status.

    Parameters
    ----------
    job : Job
    blocks : sequence of Block
        Of a store whose template is written.
    workforce : Workforce
    reporter : Reporter
    waited : float
        Seconds that getting ready took, for the report.
    """
    path, rows, ready = job.store_path, sum(block.stop - block.start for block in blocks), perf_counter()
    forget_attempts(path)
    lost, points = _run_blocks(job, blocks, workforce, reporter, RowProgress(reporter, rows))
    if not lost:
        lost += [
            f"rows {block.start}-{block.stop - 1} are stored no longer: the same command computes them again"
            for block in store.pending_blocks(path, job.plan, (store.COMPLETE, store.FAILED))
        ]
    seconds = perf_counter() - ready
    failed = store.failures(path)
    _list_rows(job, reporter, failed, " failed")
    _list_rows(job, reporter, store.notes(path), "")
    for text in lost:
        reporter.error(text)
    # Workers that were killed while they wrote leave drafts; all that were to be computed are.
    remove_left_overs(path)
    # A chunk that went missing while the others were computed would be read as fill values.
    store.read_layout(path)
    reporter.line(
        f"sweep: {counted(rows - len(failed), 'row')}, {points:,} branch points in {seconds:.2f} s "
        f"(after {waited:.2f} s to get ready)" + (f", {counted(len(failed), 'row')} failed" if failed else "")
    )
    proven = store.proven_cells(path)
    if proven is not None:
        count, cells = proven
        left = f", {cells - count:,} are not" if count < cells else ""
        reporter.line(f"sweep: {count:,} of {cells:,} cells proven{left}")
    forget_attempts(path)
    return 1 if failed or lost else 0


def _list_rows(job: Job, reporter: Reporter, rows: Sequence[tuple[int, str]], verb: str) -> None:
    """The first rows of a list with what is said of them."""
    for row, text in rows[:_LISTED]:
        reporter.line(f"  {job.plan.row_text(row)}{verb}: {text}")
    if len(rows) > _LISTED:
        reporter.line(f"  and {len(rows) - _LISTED} more; `message` in the store has every reason")


def _run_blocks(job: Job, blocks, workforce: Workforce, reporter: Reporter, progress: RowProgress):
    """Run the blocks, with a line per batch in the log; why blocks were lost, and the number of branch points."""
    from pipeline.run.dispatch import dispatch

    lost, points = [], 0
    with progress:
        for block, result in dispatch(job.store_path, job.plan, blocks, workforce, reporter.note):
            count = block.stop - block.start
            if isinstance(result, BaseException):
                lost.append(f"rows {block.start}-{block.stop - 1} were not stored: {type(result).__name__}: {result}")
                progress.advance(count, count)
            else:
                points += result.points
                if result.lost:
                    reporter.line(f"note: rows {block.start}-{block.stop - 1} were computed again: {result.lost}")
                progress.advance(count, len(result.failures))
    return lost, points


STAGE = Stage("sweep", _run, _check_store, on_workers=True, writes=True, of_volumes=True, tells_map=True)
