"""Global continuation over a plane: rounds in which every row goes on from what its neighbours have gained.

In round 0 attractors are sought in every row by itself. In round r a row is given exactly what its two neighbours
gained in round r - 1; what is new is followed along the row. The rounds end when no row gains anything. Rows only ever
add to what they know, so that what a row had gained in a round can be read from one that has gone further: a run that
was interrupted, in the middle of a round too, comes to the same in the end as one that was not, bit by bit.
"""

import itertools
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np

from pipeline.analysis.attractors.tasks import Gains, Receipt, Spec, continue_block, gains_of_row, search_block
from pipeline.errors import StoreError, WorkerLost
from pipeline.plan.row_blocks import Block
from pipeline.run.workforce import Task, Workforce
from pipeline.store.attempts import MOST_ATTEMPTS, forget_attempts
from pipeline.store.lock import check_held
from pipeline.store.row_groups import RowGroup

__all__ = ["Progress", "run_rounds"]


@dataclass
class _Rows:
    """What this process knows of the rows of one layer.

    Parameters
    ----------
    done : dict
        Row -> last round that it has been through; -1 where it failed.
    gains : dict
        Row -> round -> what it gained.
    """

    done: dict[int, int] = field(default_factory=dict)
    gains: dict[int, dict[int, Gains]] = field(default_factory=dict)

    def learn(self, receipt: Receipt, rows) -> None:
        failed = {row for row, _ in receipt.failures}
        for row in rows:
            self.done[row] = -1 if row in failed and receipt.round == 0 else max(self.done.get(row, 0), receipt.round)
        for row, gained in receipt.gains.items():
            self.gains.setdefault(row, {})[receipt.round] = gained


@dataclass(frozen=True)
class Progress:
    """What is told of a run while it goes on.

    Parameters
    ----------
    begins : callable
        begins(round, rows): so many rows are due in this round.
    advance : callable
        advance(rows, failed): so many more are done.
    note : callable
        Takes a line for the log.
    """

    begins: Callable[[int, int], None] = lambda round, rows: None
    advance: Callable[[int, int], None] = lambda rows, failed: None
    note: Callable[[str], None] = lambda text: None


def run_rounds(spec: Spec, workforce: Workforce, progress: Progress) -> list[str]:
    """Compute what is not stored yet of all rows, layer by layer.

    Parameters
    ----------
    spec : Spec
        Its group must have been begun.
    workforce : Workforce
    progress : Progress

    Returns
    -------
    list of str
        Why blocks were lost, which the same command tries again; empty where all rows are through.

    Raises
    ------
    OSError, StoreError
        If the scheduler goes away, or a block cannot be read or written: the next one could not either.
    """
    group, lost = spec.group, []
    forget_attempts(group.folder.place)
    layer = group.rows.of_layer
    for first in range(0, group.rows.rows, layer):
        blocks = group.rows.holding(Block(first, first + layer))
        lost += _run_layer(spec, group, blocks, workforce, progress)
        if lost:
            break
    if not lost:
        forget_attempts(group.folder.place)
    return lost


def _run_layer(spec: Spec, group: RowGroup, blocks: list[Block], workforce: Workforce, progress: Progress) -> list[str]:
    rows = _Rows()
    fresh = [block for block in blocks if not _recalled(group, block, rows)]
    progress.begins(0, sum(block.stop - block.start for block in fresh))
    tasks = {block: (spec, block) for block in fresh}
    lost, rounds = _through(search_block, tasks, rows, workforce, progress), itertools.count(1)
    while not lost and (due := _due(spec, rows, round := next(rounds))) is not None:
        tasks = {}
        for block in blocks:
            brought = {row: due[row] for row in range(block.start, block.stop) if row in due}
            if brought:
                tasks[block] = (spec, block, round, brought)
        progress.begins(round, len(due))
        lost = _through(continue_block, tasks, rows, workforce, progress)
    return lost


def _recalled(group: RowGroup, block: Block, rows: _Rows) -> bool:
    """Take over what is stored of a block; whether all of it is there and sound."""
    stored = group.read(block)
    if stored is None:
        return False
    for i, row in enumerate(range(block.start, block.stop)):
        rows.done[row] = int(stored["rounds"][i])
        rows.gains[row] = gains_of_row({name: values[i, ...] for name, values in stored.items()})
    return True


def _due(spec: Spec, rows: _Rows, round: int) -> dict[int, Gains] | None:
    """Row -> what is brought to it in a round, for the rows that have not been through it; None where rounds end."""
    if not any(round - 1 in gained for gained in rows.gains.values()):
        return None
    due = {}
    for row, done in rows.done.items():
        if done < 0 or done >= round:
            continue
        beside = (rows.gains.get(other, {}).get(round - 1) for other in spec.grid.neighbours(row))
        parts = [gained for gained in beside if gained is not None]
        if parts:
            due[row] = tuple(np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    return due


def _through(function: Callable, tasks: dict[Block, tuple], rows: _Rows, workforce, progress: Progress) -> list[str]:
    """Run one task a block; why blocks were lost."""
    lost = []
    for block, result in _run(function, tasks, workforce):
        concerned = tasks[block][-1] if function is continue_block else range(block.start, block.stop)
        if isinstance(result, Receipt):
            rows.learn(result, concerned)
            progress.note(
                f"round {result.round}: rows {block.start}-{block.stop - 1} in {result.seconds:.2f} s, "
                f"{len(result.failures)} failed"
            )
            progress.advance(result.rows, len(result.failures))
        else:
            lost.append(f"rows {block.start}-{block.stop - 1} were not stored: {type(result).__name__}: {result}")
            progress.advance(len(concerned), len(concerned))
    return lost


def _run(function: Callable, tasks: dict[Block, tuple], workforce: Workforce) -> Iterator[tuple[Block, object]]:
    """The receipt of every block, or the exception that it was given up for.

    A task whose worker was lost is done again: every row may use up its tries once, then it is not the rows.
    """
    waiting, losses = deque(tasks), dict.fromkeys(tasks, 0)

    def take() -> Task | None:
        return Task(tasks[waiting.popleft()], left=len(waiting)) if waiting else None

    for task, result in workforce.serve(function, take):
        block = task.arguments[1]
        check_held(task.arguments[0].group.store)
        if isinstance(result, WorkerLost) and losses[block] < MOST_ATTEMPTS * (block.stop - block.start):
            losses[block] += 1
            waiting.append(block)
        elif isinstance(result, OSError | StoreError):
            raise result
        else:
            yield block, result
