"""Batches of blocks: their sizes follow what blocks took, all blocks come once, and what failed comes again, alone."""

from types import SimpleNamespace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.errors import WorkerLost
from pipeline.plan.plan import Block
from pipeline.run.dispatch import Batches, Pace, dispatch
from pipeline.run.rows import Outcome, Receipt
from pipeline.run.workforce import Task, Workforce
from pipeline.store.attempts import MOST_ATTEMPTS
from tests.pipeline.planes import cluster, small_plan

WORKERS = 2


def blocks_of(count, rows=2):
    return [Block(rows * i, rows * (i + 1)) for i in range(count)]


def batches(count, seconds=None):
    made = Batches(blocks_of(count), SimpleNamespace(size=WORKERS, task_seconds=1.0), Pace())
    if seconds is not None:
        made.pace.learn(Receipt(Block(0, 2), (), 0, seconds))
    return made


def sizes(made):
    taken = []
    while chosen := made.take()[0]:
        taken.append(len(chosen))
    return taken


@pytest.mark.parametrize(("seconds", "size"), [(0.01, 100), (0.1, 10), (0.3, 3), (0.7, 1), (5.0, 1)])
def test_a_batch_holds_half_a_second_to_two_of_work(seconds, size):
    taken = sizes(batches(4000, seconds))
    assert taken[0] == size and (0.5 <= taken[0] * seconds <= 2.0 or size == 1)
    assert sum(taken) == 4000


def test_before_anything_is_known_batches_are_single_blocks():
    assert len(batches(100).take()[0]) == 1


@given(count=st.integers(1, 300), seconds=st.floats(1e-4, 3.0), workers=st.integers(1, 8))
@settings(max_examples=50, deadline=None)
def test_workers_end_together(count, seconds, workers):
    """Whichever worker takes the next batch when free, none waits longer at the end than a batch, or a block, lasts."""
    made = Batches(blocks_of(count), SimpleNamespace(size=workers, task_seconds=1.0), Pace())
    made.pace.learn(Receipt(Block(0, 2), (), 0, seconds))
    free, last = [0.0] * workers, 0
    while chosen := made.take()[0]:
        free.sort()
        free[0] += len(chosen) * seconds
        last = len(chosen)
    busy = [moment for moment in free if moment > 0.0]
    assert last == 1
    assert max(free) <= count * seconds / workers + max(1.0, seconds) * 1.0001
    assert max(busy) - min(busy) <= max(1.0, seconds) * 1.0001


def test_sizes_follow_the_mean_of_the_receipts():
    made = batches(4000, 0.02)
    assert len(made.take()[0]) == 50
    made.pace.learn(Receipt(Block(2, 4), (), 0, 0.18))
    assert len(made.take()[0]) == 10


def test_a_plane_learns_from_another_of_its_kind(tmp_path):
    """Whose first batches hold a second of work, where nothing was known those of the first plane are single blocks."""
    plan = small_plan(columns=9, rows=64)

    def answer(blocks):
        return Outcome(tuple(Receipt(block, (), 1, 0.01) for block in blocks), None)

    workforce = Scripted(answer)
    workforce.size = 1
    first = [list(dispatch(tmp_path, plan, plan.blocks, workforce)), len(workforce.tasks[0].arguments[2])]
    count = len(workforce.tasks)
    list(dispatch(tmp_path, plan, plan.blocks, workforce))
    assert first[1] == 1 and len(workforce.tasks[count].arguments[2]) == len(plan.blocks) // 2


@pytest.mark.parametrize(("threads", "seconds"), [(1, 1.0), (250, 1.0), (1000, 4.0)])
def test_more_workers_are_given_longer_tasks(threads, seconds):
    workforce = Workforce(cluster("scheduler"))
    workforce._workers = SimpleNamespace(size=threads)
    assert workforce.task_seconds == seconds


def test_blocks_that_failed_come_again_alone_and_elsewhere_until_their_tries_are_used_up():
    made = batches(4000, 0.02)
    chosen, _ = made.take()
    assert made.again(chosen[:2], "tcp://there:1") == []
    assert [made.take() for _ in range(2)] == [([block], "tcp://there:1") for block in chosen[:2]]
    assert len(made.take()[0]) == 50
    given_up = [made.again(chosen[:1], None) for _ in range(2 * MOST_ATTEMPTS)]
    assert given_up[-1] == chosen[:1] and not any(given_up[:-1])


class Scripted:
    """A workforce that answers as told: one answer per task, by the task's blocks."""

    size, task_seconds = WORKERS, 1.0
    config = SimpleNamespace(kind="local", row_seconds=60.0)

    def __init__(self, answer):
        self.answer, self.tasks, self.paces = answer, [], {}

    def serve(self, function, take):
        while (task := take()) is not None:
            self.tasks.append(task)
            yield task, self.answer(list(task.arguments[2]))


def test_everything_is_stored_although_batches_break_off(tmp_path):
    """Of every batch of several blocks only the first is stored; the others come again, one at a time."""
    plan = small_plan(columns=9, rows=64)

    def first_only(blocks):
        return Outcome((Receipt(blocks[0], (), 1, 0.01),), "tcp://there:1" if len(blocks) > 1 else None)

    workforce = Scripted(first_only)
    results = list(dispatch(tmp_path, plan, plan.blocks, workforce))
    assert sorted(block.start for block, _ in results) == [block.start for block in plan.blocks]
    assert all(isinstance(result, Receipt) for _, result in results)
    avoided = [task for task in workforce.tasks if task.avoid]
    assert avoided and all(len(task.arguments[2]) == 1 and task.avoid == "tcp://there:1" for task in avoided)
    assert all(isinstance(task, Task) and task.arguments[3] == 60.0 for task in workforce.tasks)


def test_a_block_whose_workers_are_always_lost_is_given_up(tmp_path):
    plan = small_plan(columns=9, rows=32)

    def loses(blocks):
        if plan.blocks[5] in blocks:
            return WorkerLost("lost")
        return Outcome(tuple(Receipt(block, (), 1, 0.01) for block in blocks), None)

    workforce = Scripted(loses)
    results = dict(dispatch(tmp_path, plan, plan.blocks, workforce))
    assert results.keys() == set(plan.blocks) and isinstance(results.pop(plan.blocks[5]), WorkerLost)
    assert all(isinstance(result, Receipt) for result in results.values())
    tries = sum(plan.blocks[5] in task.arguments[2] for task in workforce.tasks)
    assert tries == MOST_ATTEMPTS * (plan.blocks[5].stop - plan.blocks[5].start) + 1
