"""Blocks of rows given out to workers: in batches of about a second, a few at a time, again where an attempt failed.

What can fail is a row: it raises, hangs, or takes its process with it. Each attempt is noted
(`pipeline.store.attempts`), so that the third one of the same row gives up on that row alone and the rest of its block
is stored.
"""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from pipeline.config.places import Place
from pipeline.errors import StoreError, WorkerLost
from pipeline.plan.plan import Block, Plan
from pipeline.run.rows import Outcome, Receipt, sweep_blocks
from pipeline.run.workforce import Task, Workforce
from pipeline.store.attempts import MOST_ATTEMPTS
from pipeline.store.lock import check_held

__all__ = ["Batches", "Pace", "dispatch"]


@dataclass
class Pace:
    """How long rows of a kind have taken."""

    seconds: float = 0.0
    rows: int = 0

    def learn(self, receipt: Receipt) -> None:
        """How long a block took."""
        self.seconds += receipt.seconds
        self.rows += receipt.rows

    def of(self, block: Block) -> float | None:
        """Seconds that a block takes; None where nothing is known."""
        return self.seconds / self.rows * (block.stop - block.start) if self.rows else None


def dispatch(
    path: Place,
    plan: Plan,
    blocks: Sequence[Block],
    workforce: Workforce,
    note: Callable[[str], None] = lambda text: None,
) -> Iterator[tuple[Block, Receipt | Exception]]:
    """Compute blocks of a store on workers.

    Parameters
    ----------
    path : Place
        A store whose template is written.
    plan : Plan
    blocks : sequence of Block
    workforce : Workforce
    note : callable, optional
        Is given a sentence about every batch.

    Yields
    ------
    (Block, Receipt or Exception)
        In any order; the exception says why a block could not be stored.

    Raises
    ------
    OSError
        If the scheduler goes away, or a block cannot be written: the next one could not either.
    LeaseLost
        If another run has taken the store over.
    """
    kind = (plan.kind, plan.sweep.num, *(plan.solver[name] for name in ("balance", "order", "period")))
    batches = Batches(blocks, workforce, workforce.paces.setdefault(kind, Pace()))
    limit = None if workforce.config.kind == "none" else workforce.config.row_seconds

    def take() -> Task | None:
        chosen, avoid = batches.take()
        if not chosen:
            return None
        return Task((path, plan, tuple(chosen), limit), avoid, left=batches.left)

    for task, result in workforce.serve(sweep_blocks, take):
        check_held(path)
        given = list(task.arguments[2])
        if isinstance(result, Outcome):
            note(result.sentence)
            for receipt in result.receipts:
                batches.pace.learn(receipt)
                yield receipt.block, receipt
            left = given[len(result.receipts) :]
            batches.again(left, result.worker)
        elif isinstance(result, WorkerLost):
            for block in batches.again(given, None):
                yield block, result
        elif isinstance(result, OSError | StoreError):
            raise result
        else:
            for block in given:
                yield block, result


class Batches:
    """What is still to be given out, and how much of it at a time."""

    def __init__(self, blocks: Sequence[Block], workforce: Workforce, pace: Pace):
        self._fresh, self._retry = deque(blocks), deque()
        self._workforce, self.pace = workforce, pace
        self._losses: dict[Block, int] = {}

    def take(self) -> tuple[list[Block], str | None]:
        """The next batch and the worker that should not get it; retries go alone."""
        if self._retry:
            block, avoid = self._retry.popleft()
            return [block], avoid
        seconds = self._workforce.task_seconds
        per_block = self.pace.of(self._fresh[0]) if self._fresh else None
        # Towards the end, less at a time, so that all workers end together.
        most = -(-len(self._fresh) // max(2 * self._workforce.size, 1))
        size = 1 if per_block is None else max(1, min(int(seconds / max(per_block, 1e-6)), most))
        return [self._fresh.popleft() for _ in range(min(size, len(self._fresh)))], None

    @property
    def left(self) -> int:
        """Blocks that have not been given out."""
        return len(self._fresh) + len(self._retry)

    def again(self, blocks: Sequence[Block], avoid: str | None) -> list[Block]:
        """Put blocks back; those that have had more than their tries already are returned instead.

        Every row may use up its tries once: after so many losses it is not the rows.
        """
        given_up = []
        for block in blocks:
            losses = self._losses[block] = self._losses.get(block, 0) + 1
            if losses > MOST_ATTEMPTS * (block.stop - block.start):
                given_up.append(block)
            else:
                self._retry.append((block, avoid))
        return given_up
