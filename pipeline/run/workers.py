"""Workers of a scheduler: who is ready for tasks, and tasks a few at a time for those who are.

A worker that joins is asked first. It answers when it computes as this process does, and has the kernels that tasks
need; until then others have the rows. So none waits for the compiler of another machine, and on one machine all that
are not ready yet share what is to be compiled.
"""

import pickle
import time
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from queue import SimpleQueue

from pipeline.errors import WorkerLost
from pipeline.run.admission import Admission, Ready, Unequal, call_if_equal, get_ready, introduce

__all__ = ["Task", "Workers"]

#: Tasks under way per thread: one is computed, one waits.
_AHEAD = 2
#: Seconds between two counts of the workers.
_COUNT_EVERY = 1.0
#: Seconds before a worker that gives tasks back gets another one.
_PAUSE = 0.1
#: A run ends when so many workers were lost while they got ready, and none has been.
_MOST_UNREADY = 5


@dataclass(frozen=True)
class Task:
    """Arguments of one call, and the address of a worker that should not get it.

    Parameters
    ----------
    arguments : tuple
    avoid : str, optional
    left : int, optional
        How many tasks may come after this one, as far as that is known: there need not be more jobs.
    """

    arguments: tuple
    avoid: str | None = None
    left: int | None = field(default=None, kw_only=True)


class Workers:
    """Workers of a scheduler, and what is known of each.

    Parameters
    ----------
    connection : pipeline.run.connection.Connection
    say : callable
        Takes a line about workers.
    jobs : pipeline.run.slurm_jobs.Jobs, optional
        In which they are, and of which there can be more.
    """

    def __init__(self, connection, say: Callable[[str], None], jobs=None):
        self._connection, self._say, self._jobs = connection, say, jobs
        self._admission = Admission(say)
        self._seen: tuple[float, dict[str, int]] = -_COUNT_EVERY, {}
        self._kernels: tuple[str, ...] = ()
        #: Workers that have the kernels, machines that were spoken of, and workers lost before they were ready.
        self._ready: set[str] = set()
        self._hosts: set[str] = set()
        self._lost = 0
        #: Threads of those that are ready, and the count that this and what was asked is of.
        self._threads, self._counted = 0, None

    def present(self, now: bool = False) -> dict[str, int]:
        """Threads of the workers by address, as they are now or were a moment ago."""
        if now or time.monotonic() - self._seen[0] > _COUNT_EVERY:
            self._seen = time.monotonic(), self._connection.workers()
        return self._seen[1]

    @property
    def size(self) -> int:
        """Number of threads of those that may compute."""
        workers = self.present()
        return sum(workers[worker] for worker in self._admission.allowed(workers))

    def nobody(self) -> str:
        """Why none computes, where there are workers and none may; else empty."""
        workers = self.present(now=True)
        return self._admission.nobody() if workers and not self._admission.allowed(workers) else ""

    def needs(self, kernels: tuple[str, ...]) -> None:
        """Which kernels the next tasks need."""
        if kernels != self._kernels:
            self._kernels = kernels
            self._ready.clear()
            self._counted = None

    def meet(self, seconds: float, load: bool) -> None:
        """Ask those that are there for their facts.

        Parameters
        ----------
        seconds : float
            To wait for their answers: one that is busy is asked again before it is given anything.
        load : bool
            Whether they should load the solver before they answer.
        """
        connection, answers = self._connection, SimpleQueue()
        asked = {
            connection.submit(answers, introduce, load, workers=[worker], allow_other_workers=False): worker
            for worker in self._admission.unknown(self.present(now=True))
        }
        deadline = time.monotonic() + seconds
        while asked and (left := deadline - time.monotonic()) > 0.0:
            self.present()  # the scheduler must answer
            if (done := connection.next(answers, min(left, _COUNT_EVERY))) is not None:
                worker, answer = asked.pop(done[0]), done[1]
                if not isinstance(answer, WorkerLost):
                    self._admission.learn(worker, answer)
        connection.cancel(asked)

    def serve(self, function: Callable, take: Callable[[], Task | None]) -> Iterator[tuple[Task, object]]:
        """As `pipeline.run.workforce.Workforce.serve`."""
        connection, finished, again = self._connection, SimpleQueue(), deque()
        running: dict[object, Task] = {}
        asked: dict[object, str | None] = {}
        left: int | None = None

        def next_task() -> Task | None:
            nonlocal left
            if again:
                return again.popleft()
            task = take()
            left = 0 if task is None else task.left
            return task

        # What was asked before came to another queue.
        self._counted = None
        try:
            while True:
                self._ask(finished, asked)
                # A few at a time: until workers have enough to do.
                while len(running) < _AHEAD * self._threads and (task := next_task()) is not None:
                    running[self._given(finished, function, task)] = task
                if not running:
                    # Whoever is not ready yet need not be, if there is nothing left.
                    if (task := next_task()) is None:
                        return
                    again.append(task)
                if self._jobs is not None:
                    self._jobs.fit(None if left is None else left + len(running) + len(again))
                # However long tasks take, the scheduler must answer, and a worker that joins gets its own.
                if (done := connection.next(finished, _COUNT_EVERY)) is None:
                    continue
                future, result = done
                if future in asked:
                    self._learn(asked.pop(future), result)
                elif self._is_given_back(result):
                    again.append(running.pop(future))
                else:
                    yield running.pop(future), result
        finally:
            connection.cancel([*running, *asked])
            if self._jobs is not None:
                self._jobs.rest()

    def _ask(self, finished: SimpleQueue, asked: dict) -> None:
        """Have workers get ready that are not, after each count; those that are known, and need no kernels, are.

        Raises
        ------
        OSError
            If those that are there must not compute. Where they are in jobs, others come in place of those that ended.
        """
        workers = self.present()
        if self._counted is workers:
            return
        allowed, waiting = self._admission.allowed(workers), set(asked.values())
        if workers and not allowed and self._jobs is None:
            raise OSError(self._admission.nobody())
        for worker in allowed:
            if worker in self._ready or worker in waiting:
                continue
            if not self._kernels and worker in self._admission.equal:
                self._ready.add(worker)
                continue
            asked[self._get_ready(finished, workers=[worker], allow_other_workers=False)] = worker
        if not workers and self._jobs is None and None not in waiting:
            # A cluster that adapts itself starts no worker before something waits for one.
            asked[self._get_ready(finished)] = None
        self._counted = workers
        self._threads = sum(threads for worker, threads in workers.items() if worker in self._ready)

    def _get_ready(self, finished: SimpleQueue, **places):
        """The future of what makes a worker ready."""
        payload = pickle.dumps((get_ready, (self._kernels,)))
        return self._connection.submit(finished, call_if_equal, self._admission.digest, payload, **places)

    def _learn(self, worker: str | None, answer) -> None:
        """Note what a worker answers that was to get ready; None is whichever came first, which is asked again itself.

        Raises
        ------
        OSError
            If there is no other worker, or they are lost time and again.
        """
        self._counted = None
        if worker is None:
            self.present(now=True)
        if isinstance(answer, Ready):
            if worker is not None:
                self._admission.equal.add(worker)
                self._ready.add(worker)
            if answer.compiled and answer.host not in self._hosts:
                self._hosts.add(answer.host)
                self._say(f"kernels: compiled on {answer.host} in {answer.seconds:.0f} s, once for all its workers")
        elif isinstance(answer, WorkerLost):
            self._lost += 1
            if self._lost >= _MOST_UNREADY and not self._ready:
                raise OSError(f"{self._lost} workers were lost before they had their kernels: {answer}")
        elif isinstance(answer, Unequal):
            self._refuse(answer.worker, answer.facts)
        elif worker is not None:
            self._refuse(worker, answer)

    def _refuse(self, worker: str, answer) -> None:
        self._ready.discard(worker)
        self._counted = None
        self._admission.learn(worker, answer)
        if nobody := self.nobody():
            raise OSError(nobody)

    def _given(self, finished: SimpleQueue, function: Callable, task: Task):
        """The future of a task, which is given to those that are ready."""
        payload = pickle.dumps((function, task.arguments))
        return self._connection.submit(finished, call_if_equal, self._admission.digest, payload, **self._places(task))

    def _places(self, task: Task) -> dict:
        """Where a task may run, as `Client.submit` takes it: anywhere, unless there are workers to be avoided."""
        workers = self.present()
        places = [worker for worker in workers if worker in self._ready and worker != task.avoid]
        # If those have all gone when the task's turn comes, any worker may have it: a refused one gives it back.
        return {} if len(places) in (0, len(workers)) else {"workers": places, "allow_other_workers": True}

    def _is_given_back(self, result) -> bool:
        """Whether a task has come to a worker that must not compute, or cannot.

        Raises
        ------
        OSError
            If there is no other worker.
        """
        if isinstance(result, Unequal):
            if result.worker in self._admission.refused:
                # It gets tasks because the others are away: not too many of them.
                time.sleep(_PAUSE)
            self._refuse(result.worker, result.facts)
            return True
        if isinstance(result, ModuleNotFoundError) and (result.name or "").split(".")[0] in ("pipeline", "solver"):
            time.sleep(_PAUSE)
            return True
        return False
