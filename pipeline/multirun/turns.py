"""Runs side by side in one process: each in a thread of its own, of which one at a time has the turn.

A run is written as if it were alone. Where it waits for tasks, another has the turn, so that tasks of several runs are
under way on one workforce. No two threads ever work at once: what is not made for threads needs no lock here.

Earlier runs come first: a later one is given tasks where those before it have none to give.
"""

import contextlib
import ctypes
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from queue import Empty, SimpleQueue

from pipeline.run.workforce import Task, Workforce

__all__ = ["SharedWorkforce", "run_side_by_side"]

#: Seconds that runs may take to tidy up after an interrupt.
_TIDY = 5.0
#: Seconds after which the main thread looks whether a signal has come: not every one wakes it.
_HEAR_EVERY = 0.2


class _Ended(BaseException):
    """Raised in a run whose turn does not come any more."""


@dataclass
class _Source:
    """What a run waits for: tasks that `take` gives, until it gives None and none is under way."""

    function: Callable
    take: Callable[[], Task | None]
    #: Whether this process does them.
    here: bool
    under_way: int = 0
    #: Whether `take` had nothing, which only a result can change.
    dry: bool = False


@dataclass(frozen=True)
class _Given(Task):
    """A task of one of the runs, as the workforce is given it."""

    run: "_Run | None" = None
    source: _Source | None = None
    task: Task | None = None


def call(function: Callable, arguments: tuple):
    """What a worker does: tasks of several runs have functions of their own."""
    return function(*arguments)


class SharedWorkforce:
    """A workforce as one run sees it: everything is that of all runs, but tasks are served in turns.

    Parameters
    ----------
    shared : Workforce
    run : _Run
    here : bool
        Whether tasks are done by this process.
    """

    def __init__(self, shared: Workforce, run: "_Run", here: bool = False):
        self._shared, self._run, self._here = shared, run, here
        self.config = replace(shared.config, kind="none") if here else shared.config
        self.planes = run.number_of_runs

    def __getattr__(self, name: str):
        return getattr(self._shared, name)

    #: Built on `serve`.
    run = Workforce.run

    def serve(self, function: Callable, take: Callable[[], Task | None]) -> Iterator[tuple[Task, object]]:
        """As `Workforce.serve`; other runs have their turns while this one waits."""
        return self._run.serve(function, take, self._here)

    def start(self) -> str:
        """As `Workforce.start`."""
        return "tasks run in this process" if self._here else self._shared.start()

    @property
    def size(self) -> int:
        """Threads for which this run should have tasks until its end; 0 where there are more runs than threads, and
        others have tasks for them."""
        return 1 if self._here else self._shared.size // max(self._run.runs_left, 1)

    def alone(self) -> "SharedWorkforce":
        """This process alone."""
        return SharedWorkforce(self._shared, self._run, here=True)

    def aside(self) -> contextlib.AbstractContextManager:
        """Others have their turns meanwhile."""
        return self._run.aside()

    @property
    def has_local_workers(self) -> bool:
        """Whether tasks are done by processes that share the files of this machine."""
        return self.config.kind == "local"

    def expect(self, modules: Sequence[str]) -> None:
        """Nothing: workers have other tasks meanwhile."""

    def begin_beside(self, function: Callable, tasks: Iterable[tuple]) -> None:
        """Nothing: their turn comes."""

    def run_beside(self, function: Callable, tasks: Iterable[tuple]) -> Iterator[tuple[tuple, object]]:
        """As any other tasks."""
        return self.run(function, tasks)


class _Run:
    """One run: its thread, what it waits for, and what it is told when its turn comes."""

    def __init__(self, turns: "_Turns", body: Callable[[SharedWorkforce], None], number_of_runs: int):
        self._turns, self._body, self.number_of_runs = turns, body, number_of_runs
        self._told: SimpleQueue = SimpleQueue()
        self.source: _Source | None = None
        self.is_over, self.error = False, None
        self.thread = threading.Thread(target=self._work, daemon=True)

    @property
    def runs_left(self) -> int:
        """Number of runs that are not over."""
        return self._turns.runs_left

    def tell(self, what: object) -> None:
        """Give it the turn, with what it waited for; an exception is raised in it."""
        self._told.put(what)

    def _work(self) -> None:
        try:
            self._wait()
            self._body(SharedWorkforce(self._turns.workforce, self))
        except _Ended:
            pass
        except BaseException as error:
            self.error = error
        finally:
            self.is_over, self.source = True, None
            self._turns.given_back.put(self)

    def _wait(self):
        """What it is told, when its turn has come."""
        told = self._told.get()
        if isinstance(told, BaseException):
            raise told
        return told

    def _pass(self):
        """Give the turn back, and wait for the next one."""
        self._turns.given_back.put(self)
        return self._wait()

    def serve(self, function: Callable, take: Callable, here: bool) -> Iterator[tuple[Task, object]]:
        """Results of tasks, one with every turn.

        Whoever leaves early waits for the tasks that are under way: they may write what the run's lock keeps for it.
        """
        source = _Source(function, take, here)
        try:
            while (found := self._served(source)) is not None:
                yield found
        except _Ended:
            # All runs end, and their workers with them.
            source.under_way = 0
            raise
        finally:
            source.take = _nothing
            while source.under_way:
                self._served(source)

    def _served(self, source: _Source) -> tuple[Task, object] | None:
        """A task of a source that is done, with its result; None where there is none any more."""
        self.source = source
        try:
            return self._pass()
        finally:
            self.source = None

    @contextlib.contextmanager
    def aside(self) -> Iterator[None]:
        """No turn is needed within."""
        self._turns.given_back.put(self)
        try:
            yield
        finally:
            self._turns.returned.put(self)
            self._wait()


class _Turns:
    """All runs of a command.

    Parameters
    ----------
    workforce : Workforce
    bodies : sequence of callable
        Each takes a `SharedWorkforce`.
    """

    def __init__(self, workforce: Workforce, bodies: Sequence[Callable[[SharedWorkforce], None]]):
        self.workforce = workforce
        #: Runs that have just passed their turn, and those that were aside and want one.
        self.given_back: SimpleQueue = SimpleQueue()
        self.returned: SimpleQueue = SimpleQueue()
        self._waiting = deque(_Run(self, body, len(bodies)) for body in bodies)
        self._active: list[_Run] = []

    @property
    def runs_left(self) -> int:
        """Number of runs that are not over."""
        return len(self._waiting) + len(self._active)

    def run(self) -> None:
        """Until all are over.

        Raises
        ------
        BaseException
            The first that a run ended with.
        """
        try:
            while self._waiting or self._active:
                # A workforce that is asked to serve starts its workers: not before there is something to do.
                if (first := self._next_task()) is not None:
                    self._serve(first)
                elif self._active:
                    # All of them are aside.
                    self._turn_of(_next_of(self.returned), None)
        finally:
            self._end()

    def _serve(self, first: _Given) -> None:
        begun = [first]
        for given, result in self.workforce.serve(call, lambda: begun.pop() if begun else self._next_task()):
            given.source.under_way -= 1
            given.source.dry = False
            if given.run.source is given.source:
                self._turn_of(given.run, (given.task, result))

    def _next_task(self) -> _Given | None:
        """A task of the first run that has one; the next run begins where none has."""
        while True:
            self._let_return()
            for run in self._active:
                if (given := self._task_of(run)) is not None:
                    return given
            if not self._waiting:
                return None
            run = self._waiting.popleft()
            self._active.append(run)
            run.thread.start()
            self._turn_of(run, None)

    def _task_of(self, run: _Run) -> _Given | None:
        """A task of a run for the workforce; where it has none at all it goes on, until it has or is over."""
        while (source := run.source) is not None and not source.dry:
            try:
                task = source.take()
            except Exception as error:  # the run's own
                self._turn_of(run, error)
                continue
            if task is None:
                source.dry = True
                if not source.under_way:
                    self._turn_of(run, None)
            elif source.here:
                self._turn_of(run, (task, _done_here(source.function, task.arguments)))
            else:
                source.under_way += 1
                # Of those that have not begun nobody knows how many tasks they have.
                left = task.left if self.runs_left == 1 else None
                return _Given((source.function, task.arguments), task.avoid, run, source, task, left=left)
        return None

    def _let_return(self) -> None:
        """Give those a turn that have been aside."""
        with contextlib.suppress(Empty):
            while True:
                self._turn_of(self.returned.get_nowait(), None)

    def _turn_of(self, run: _Run, told: object) -> None:
        """Let a run go on until it waits again, or is over."""
        run.tell(told)
        _next_of(self.given_back)
        if run.is_over:
            self._active = [other for other in self._active if other is not run]
            if run.error is not None:
                raise run.error

    def _end(self) -> None:
        """End runs that are not over: an interrupt, which only the main thread hears of, is raised in all of them."""
        for run in self._active:
            run.tell(_Ended())
            # Of the one that has the turn, or is aside, wherever it is.
            if run.source is None and not run.is_over:
                ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(run.thread.ident), ctypes.py_object(_Ended))
        deadline = time.monotonic() + _TIDY
        for run in self._active:
            run.thread.join(max(deadline - time.monotonic(), 0.0))


def _nothing() -> None:
    """What a source takes that is given up."""


def _next_of(queue: SimpleQueue) -> _Run:
    """What is put into a queue; signals are heard of meanwhile."""
    while True:
        with contextlib.suppress(Empty):
            return queue.get(timeout=_HEAR_EVERY)


def _done_here(function: Callable, arguments: tuple):
    """The result, or the exception that a worker would have sent back."""
    try:
        return function(*arguments)
    except Exception as error:  # the reason is kept: it is reported exactly as one that comes from a worker
        return error


def run_side_by_side(workforce: Workforce, bodies: Sequence[Callable[[SharedWorkforce], None]]) -> None:
    """Run several bodies, each as if it were alone, their tasks in one list.

    Parameters
    ----------
    workforce : Workforce
        Does the tasks of all.
    bodies : sequence of callable
        Each is called with a `SharedWorkforce`, in the order in which they come first.

    Raises
    ------
    BaseException
        The first that a body raised; the others are ended.
    """
    _Turns(workforce, bodies).run()
