"""One block of rows: continue every row, write the block into the store, return a small receipt.

This is what runs on workers. A row that fails is recorded with its reason and the others go on.
"""

from dataclasses import dataclass
from time import perf_counter

from pipeline import store
from pipeline.config.places import Place
from pipeline.errors import DamagedError
from pipeline.plan.numerics import balance_of, continuation_of, row_of, seeds_of
from pipeline.plan.plan import Block, Plan
from pipeline.run.admission import worker_address
from pipeline.run.kernels import ready_for_rows
from pipeline.store.attempts import AttemptLog
from solver import Balance, Continuation, Row, RowError
from solver.rows.seeds import Seeds

__all__ = ["Outcome", "Receipt", "RowTrouble", "stored_row", "sweep_block", "sweep_blocks"]


@dataclass(frozen=True)
class Receipt:
    """What came of one block.

    Parameters
    ----------
    block : Block
    failures : tuple of (int, str)
        Its failed rows and their reasons.
    points : int
        Branch points computed.
    seconds : float
    lost : str
        What was wrong with its stored rows, so that none of them could be kept; else empty.
    """

    block: Block
    failures: tuple[tuple[int, str], ...]
    points: int
    seconds: float
    lost: str = ""

    @property
    def rows(self) -> int:
        """Number of rows done."""
        return self.block.stop - self.block.start


@dataclass(frozen=True)
class Outcome:
    """What came of a batch: a receipt per block that was stored, the worker, whether a row of the next block raised."""

    receipts: tuple[Receipt, ...]
    worker: str | None
    trouble: bool = False

    @property
    def sentence(self) -> str:
        """For the log."""
        rows = ", ".join(f"{receipt.block.start}-{receipt.block.stop - 1}" for receipt in self.receipts) or "none"
        points, failed = sum(r.points for r in self.receipts), sum(len(r.failures) for r in self.receipts)
        return (
            f"batch: {sum(receipt.rows for receipt in self.receipts)} rows ({rows}) in "
            f"{sum(receipt.seconds for receipt in self.receipts):.2f} s on {self.worker or 'this machine'}, "
            f"{points} points, {failed} failed{', the next one raised' if self.trouble else ''}"
        )


class RowTrouble(RuntimeError):
    """A row raised something unforeseen; it is worth another try elsewhere."""


def stored_row(plan: Plan, value: float, balance: Balance, continuation: Continuation, seeds: Seeds) -> Row:
    """One row as it is stored; raises RowError as well where it does not fit into the store."""
    row = row_of(plan, value, balance, continuation, seeds)
    for name, size, room in (
        ("max_solutions", row.mean.shape[1], plan.max_solutions),
        ("max_branches", len(row.curves), plan.max_branches),
        ("max_points", sum(len(curve.points) for curve in row.curves), plan.max_points),
    ):
        if size > room:
            raise RowError(f"it needs room for {size}, more than store.{name} = {room}")
    return row


def sweep_block(path: Place | str, plan: Plan, block: Block, limit: float | None = None) -> Receipt:
    """Compute one block of rows and write it; a row that fails for good is stored as failed, with the reason.

    Up-to-date rows are kept, if everything that is stored of the block can be verified.

    Parameters
    ----------
    path : Place or str
        The store, its template already written.
    plan : Plan
    block : Block
    limit : float, optional
        Seconds that a row may take; the process ends where one takes longer.

    Returns
    -------
    Receipt

    Raises
    ------
    RowTrouble
        If a row raises something unforeseen: nothing is written then, and the attempt is noted for the next one.
    """
    ready_for_rows(plan.solver["balance"], plan.kind)
    begin = perf_counter()
    balance, continuation = balance_of(plan.solver), continuation_of(plan.solver)
    seeds = seeds_of(plan.solver)
    rows: list[Row | str | None] = []
    try:
        kept, lost = store.kept_rows(path, plan, block), ""
    except DamagedError as error:
        kept, lost = {}, error.what
    with AttemptLog(path, block.start, limit) as attempts:
        for index in range(block.start, block.stop):
            if index in kept:
                rows.append(None)
                continue
            verdict = attempts.verdict(index)
            if verdict is not None:
                rows.append(verdict)
                continue
            try:
                with attempts.attempt(index):
                    rows.append(stored_row(*plan.row(index), balance, continuation, seeds))
            except RowError as error:
                # Foreseen, and the same on every worker.
                rows.append(str(error))
            except Exception as error:
                attempts.raised(index, f"{type(error).__name__}: {error}")
                verdict = attempts.verdict(index)
                if verdict is None:
                    raise RowTrouble(f"row {index}: {type(error).__name__}: {error}") from error
                rows.append(verdict)
        values = [kept[block.start + i] if row is None else store.row_values(plan, row) for i, row in enumerate(rows)]
        store.write_block(path, plan, block, values)
        attempts.forget()
    failures = tuple((block.start + i, row) for i, row in enumerate(rows) if isinstance(row, str))
    points = sum(len(curve.points) for row in rows if isinstance(row, Row) for curve in row.curves)
    return Receipt(block, failures, points, perf_counter() - begin, lost)


def sweep_blocks(path: Place, plan: Plan, blocks: tuple[Block, ...], limit: float | None) -> Outcome:
    """Several blocks one after the other, as far as their rows can be computed; see `sweep_block`."""
    receipts = []
    for block in blocks:
        try:
            receipts.append(sweep_block(path, plan, block, limit))
        except RowTrouble:
            return Outcome(tuple(receipts), worker_address(), trouble=True)
    return Outcome(tuple(receipts), worker_address())
