"""Runs side by side: who has the turn, whose task is next, and how all of them end."""

import _thread
import contextlib
import operator
import threading
import time
from collections import deque

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.multirun.turns import run_side_by_side
from pipeline.run.workforce import Task, Workforce
from tests.pipeline.planes import cluster


class Slots:
    """A workforce that has so many tasks under way, and ends the one that `choose` picks."""

    config = cluster("local")

    def __init__(self, count, choose=lambda count: 0):
        self.count, self.choose, self.idle, self.order = count, choose, [], []

    size = 2

    def serve(self, function, take):
        running = deque()
        while True:
            while len(running) < self.count and (task := take()) is not None:
                running.append(task)
                self.order.append(task.arguments[1])
            if not running:
                return
            self.idle.append(self.count - len(running))
            running.rotate(-self.choose(len(running)))
            task = running.popleft()
            yield task, function(*task.arguments)


def tasks_of(name, *counts):
    """A body with some stages of so many tasks each, and what it will have got."""
    got = []

    def body(workforce):
        for stage, count in enumerate(counts):
            tasks = [((name, stage), (number,)) for number in range(count)]
            got.extend(result for _, result in workforce.run(operator.add, tasks))

    return body, got, [(name, stage, number) for stage, count in enumerate(counts) for number in range(count)]


def test_a_later_run_begins_where_those_before_have_no_task():
    """No slot is idle until the last run has no task left."""
    bodies = [tasks_of(name, 5, 3) for name in "abc"]
    workforce = Slots(4)
    run_side_by_side(workforce, [body for body, _, _ in bodies])
    assert all(sorted(got) == wanted for _, got, wanted in bodies)
    given = [stage for stage, _ in workforce.order]
    assert given[:5] == [("a", 0)] * 5 and given[5] == ("b", 0)
    # As soon as the first run goes on, it is first again.
    assert given.index(("a", 1)) < given.index(("c", 0))
    assert set(workforce.idle[: -sum((5, 3, 4))]) == {0}


@given(
    counts=st.lists(st.lists(st.integers(0, 4), max_size=3), min_size=1, max_size=5),
    slots=st.integers(1, 6),
    chances=st.randoms(use_true_random=False),
)
@settings(max_examples=60, deadline=None)
def test_every_run_gets_its_own_results_whatever_ends_first(counts, slots, chances):
    bodies = [tasks_of(name, *some) for name, some in enumerate(counts)]
    run_side_by_side(Slots(slots, chances.randrange), [body for body, _, _ in bodies])
    assert all(sorted(got) == wanted for _, got, wanted in bodies)


def test_a_workforce_that_has_nothing_to_do_is_not_asked():
    class Never(Slots):
        def serve(self, function, take):
            raise AssertionError

    bodies = [tasks_of("a"), tasks_of("b", 0, 0)]
    run_side_by_side(Never(1), [body for body, _, _ in bodies])


def test_what_this_process_does_alone_is_done_in_the_same_way():
    class Never(Slots):
        def serve(self, function, take):
            raise AssertionError

    got = []

    def body(workforce):
        alone = workforce.alone()
        assert alone.config.kind == "none" and alone.size == 1 and alone.planes == 2
        got.extend(alone.run(operator.floordiv, [(6, 2), (1, 0)]))

    run_side_by_side(Never(1), [body, body])
    assert got[0] == ((6, 2), 3) == got[2]
    assert all(isinstance(got[i][1], ZeroDivisionError) for i in (1, 3))


def test_a_run_may_wait_for_something_else_than_a_task():
    opened, said = threading.Event(), []

    def first(workforce):
        with workforce.aside():
            assert opened.wait(60.0)
        said.append("first")

    def second(workforce):
        said.append(dict(workforce.run(operator.neg, [(1,)])))
        opened.set()

    run_side_by_side(Slots(1), [first, second])
    assert said == [{(1,): -1}, "first"]


def test_what_take_raises_is_raised_in_its_run():
    caught = []

    def take():
        raise LookupError("none")

    def body(workforce):
        try:
            list(workforce.serve(operator.neg, take))
        except LookupError as error:
            caught.append(error)
        caught.append(list(workforce.run(operator.neg, [(1,)])))

    run_side_by_side(Slots(1), [body])
    assert str(caught[0]) == "none" and caught[1] == [((1,), -1)]


def test_results_of_what_a_run_has_left_are_dropped():
    """As where a block cannot be written, and the loop over results is left with tasks under way."""
    got = []

    def body(workforce):
        for _, result in workforce.run(operator.neg, [(1,), (2,), (3,)]):
            got.append(result)
            break
        got.extend(result for _, result in workforce.run(operator.pos, [(7,)]))

    run_side_by_side(Slots(3), [body])
    assert got == [-1, 7]


@pytest.mark.parametrize("fails", ["where results are used", "where tasks are taken"])
def test_a_run_that_fails_has_no_task_under_way_when_its_lock_is_gone(fails):
    """They would write into a store that is another run's by then; what has not begun is not begun."""
    events, numbers = [], iter(range(1, 6))

    def take():
        if (number := next(numbers)) == 4 and fails == "where tasks are taken":
            raise LookupError
        return Task((number,))

    def body(workforce):
        with contextlib.suppress(LookupError), contextlib.ExitStack() as lock:
            lock.callback(events.append, "lock gone")
            for _ in workforce.serve(events.append, take):
                if fails == "where results are used":
                    raise LookupError

    other, got, wanted = tasks_of("other", 3)
    run_side_by_side(Slots(3), [body, other])
    assert events == [1, 2, 3, "lock gone"] and sorted(got) == wanted


def test_a_run_that_raises_ends_the_others():
    ended = []

    def waits(workforce):
        with contextlib.ExitStack() as stack:
            stack.callback(ended.append, "waits")
            list(workforce.run(operator.neg, [(1,), (2,)]))

    def raises(workforce):
        raise ArithmeticError("no")

    with pytest.raises(ArithmeticError, match="no"):
        run_side_by_side(Slots(3), [waits, raises])
    assert ended == ["waits"]


def test_an_interrupt_ends_the_run_that_is_at_work_and_those_that_wait():
    """The interrupt comes to the main thread, while a run is busy in another."""
    ended = []

    def waits(workforce):
        try:
            list(workforce.run(operator.neg, [(1,)]))
        finally:
            ended.append("waits")

    def busy(workforce):
        try:
            _thread.interrupt_main()
            while True:
                time.sleep(0.001)
        finally:
            ended.append("busy")

    with pytest.raises(KeyboardInterrupt):
        run_side_by_side(Slots(4), [waits, busy])
    assert sorted(ended) == ["busy", "waits"]
    assert not [thread for thread in threading.enumerate() if "_work" in thread.name]


def test_a_worker_that_must_be_avoided_is_avoided():
    avoided = []

    class Watched(Slots):
        def serve(self, function, take):
            def watched():
                task = take()
                if task is not None:
                    avoided.append(task.avoid)
                return task

            return super().serve(function, watched)

    tasks = deque([Task((1,), "tcp://there:1"), Task((2,))])

    def body(workforce):
        list(workforce.serve(operator.neg, lambda: tasks.popleft() if tasks else None))

    run_side_by_side(Watched(1), [body])
    assert avoided == ["tcp://there:1", None]


def test_in_this_process():
    bodies = [tasks_of(name, 3, 1) for name in "ab"]
    with Workforce(cluster("none")) as workforce:
        run_side_by_side(workforce, [body for body, _, _ in bodies])
    assert all(sorted(got) == wanted for _, got, wanted in bodies)
