"""Where tasks run: in this process, on worker processes of this machine, in jobs, or on a running dask scheduler.

Tasks are independent and write their own results; only small receipts come back, in any order.
"""

import contextlib
import logging
import pickle
import time
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator, Sequence, Sized
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, field, replace
from queue import SimpleQueue

from pipeline.config.schema import Cluster
from pipeline.errors import ConfigurationError, WorkerLost
from pipeline.run.admission import Admission, Unequal, call_if_equal, introduce
from pipeline.run.cluster_settings import address_of, check_start, security_of, setting_of
from pipeline.run.libraries import unusable

__all__ = ["Task", "Workforce"]

#: Tasks under way per thread: one is computed, one waits.
_AHEAD = 2
#: A task is done again after this many losses of its worker.
_MOST_LOST = 2
#: Seconds between two counts of the workers.
_COUNT_EVERY = 1.0
#: Seconds before a worker that gives tasks back gets another one.
_PAUSE = 0.1
#: Seconds in which the workers of this machine load the solver, unless it is compiled; they are used in any case.
_START_WITHIN = 60.0


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


class Workforce:
    """Runs tasks; workers start when first needed and serve all planes of a run.

    Parameters
    ----------
    config : Cluster
        Checked by `pipeline.run.cluster_settings.check_cluster`.
    say : callable, optional
        Takes a line about workers that must not compute (`pipeline.run.admission`).
    helpers : pipeline.run.helpers.Helpers, optional
        Those that have been started; whoever started them ends them.

    Examples
    --------
    >>> from pipeline.config.compose import compose
    >>> with Workforce(compose(["cluster=none"]).config.cluster) as workforce:
    ...     list(workforce.run(pow, [(2, 3), (3, 2)]))
    [((2, 3), 8), ((3, 2), 9)]
    """

    def __init__(self, config: Cluster, say: Callable[[str], None] = lambda text: None, helpers=None):
        self.config = config
        self._say, self._helpers = say, helpers
        self._connection = self._admission = self._jobs = None
        self._open = contextlib.ExitStack()
        self._seen: tuple[float, dict[str, int]] = -_COUNT_EVERY, {}

    #: Planes that share it: what one of them does alone, others wait for.
    planes = 1

    def aside(self) -> contextlib.AbstractContextManager:
        """To wait within for something else than tasks, which keeps no other plane waiting."""
        return contextlib.nullcontext()

    def __enter__(self):
        return self

    def __exit__(self, *error):
        # An interrupt ends workers at once.
        self._connection = self._helpers = self._jobs = None
        return self._open.__exit__(*error)

    def start(self) -> str:
        """Start or reach the workers, once; a sentence that says where tasks run.

        Raises
        ------
        ConfigurationError
            If a scheduler does not answer in time, none of its workers computes as this process does, or no job is
            taken.
        """
        if self.config.kind == "none":
            return "tasks run in this process" + (" and beside it" if self._helpers is not None else "")
        local = self.config.kind == "local"
        if self._connection is None:
            check_start(self.config)
            _silence()
            start = {"local": self._start_local, "slurm": self._submit_jobs, "scheduler": self._reach_scheduler}
            self._admission = Admission(self._say)
            self._connection = start[self.config.kind]()
            self._open.callback(self._connection.close)
            self._ask(_START_WITHIN if local else self.config.timeout, local)
            if self._nobody():
                raise ConfigurationError(f"{setting_of(self.config)} is not allowed: {self._admission.nobody()}")
        address = self._connection.dashboard() if self.config.dashboard else None
        dashboard = f", dashboard {address}" if address else ""
        if local:
            return f"tasks run on {self.config.workers} worker processes{dashboard}"
        if self._jobs is not None:
            return f"{self._jobs.sentence}{dashboard}"
        if not self._workers(now=True):
            return f"waiting for workers: the scheduler at {self._connection.address} has none yet{dashboard}"
        return f"tasks run on the scheduler at {self._connection.address}, {self.size} threads at present{dashboard}"

    def _start_local(self):
        from pipeline.run.connection import Connection
        from pipeline.run.local_cluster import local_cluster

        started = local_cluster(self.config.workers, self.config.memory, self.config.dashboard)
        cluster = self._open.enter_context(started)
        return Connection(cluster, cluster.security, self.config.timeout)

    def _submit_jobs(self):
        from pipeline.run.connection import Connection
        from pipeline.run.slurm_cluster import slurm_cluster

        with contextlib.ExitStack() as started:
            jobs = started.enter_context(slurm_cluster(self.config, self._say))
            jobs.begin()
            connection = Connection(jobs.cluster, jobs.cluster.security, self.config.timeout)
            self._open.push(started.pop_all())
        self._jobs = jobs
        return connection

    def _reach_scheduler(self):
        from pipeline.run.connection import Connection

        address = address_of(self.config)
        security = security_of(self.config, address)
        try:
            return Connection(address, security, self.config.timeout)
        except (KeyError, TypeError, AttributeError) as error:
            # Times and transports that dask was told of, and cannot read.
            raise unusable("dask", error) from None
        except (OSError, ValueError) as error:
            reason = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise ConfigurationError(
                f"{setting_of(self.config)} is not allowed: it must be that of a dask scheduler, "
                f"and none answered there within {self.config.timeout:g} s ({reason})"
            ) from None

    def run(self, function: Callable, tasks: Iterable[tuple]) -> Iterator[tuple[tuple, object]]:
        """Call `function(*task)` for every task; yields (task, result), or (task, exception) where it raised.

        A task whose worker was lost is done again, up to three times in all.

        Parameters
        ----------
        function : callable
            Importable on the workers.
        tasks : iterable of tuple
            Small, picklable arguments; taken as workers become free.
        """
        source, again, lost = iter(tasks), deque(), Counter()
        left = len(tasks) if isinstance(tasks, Sized) else None

        def take() -> Task | None:
            nonlocal left
            fresh = not again
            arguments = next(source, None) if fresh else again.popleft()
            if fresh and left:
                left -= 1
            return None if arguments is None else Task(arguments, left=left)

        for task, result in self.serve(function, take):
            if isinstance(result, WorkerLost) and lost[id(task.arguments)] < _MOST_LOST:
                lost[id(task.arguments)] += 1
                again.append(task.arguments)
            else:
                yield task.arguments, result

    def serve(self, function: Callable, take: Callable[[], Task | None]) -> Iterator[tuple[Task, object]]:
        """Call `function(*task.arguments)` for whatever `take` gives, until it gives None and nothing is under way.

        Only a few tasks per worker are under way at a time, so that the memory of this process does not depend on their
        number, and what becomes of one can decide what `take` gives next.

        Yields
        ------
        (Task, object)
            With the result, or the exception that was raised, which is `WorkerLost` where the worker's process ended.

        Raises
        ------
        OSError
            If the scheduler goes away or falls silent, or no worker is left that may compute.
        """
        if self.config.kind == "none":
            yield from self._serve_here(function, take)
            return
        self.start()
        connection, running, finished, again = self._connection, {}, SimpleQueue(), deque()
        left: int | None = None

        def next_task() -> Task | None:
            nonlocal left
            if again:
                return again.popleft()
            task = take()
            left = 0 if task is None else task.left
            return task

        try:
            while True:
                # A few at a time: until workers have enough to do.
                while len(running) < _AHEAD * max(self.size, 1) and (task := next_task()) is not None:
                    payload = pickle.dumps((function, task.arguments))
                    digest, places = self._admission.digest, self._places(task)
                    running[connection.submit(finished, call_if_equal, digest, payload, **places)] = task
                if not running:
                    return
                if self._jobs is not None:
                    self._jobs.fit(None if left is None else left + len(running) + len(again))
                # However long tasks take, the scheduler must answer, and a worker that joins gets its own.
                if (done := connection.next(finished, _COUNT_EVERY)) is None:
                    continue
                task, result = running.pop(done[0]), done[1]
                if self._is_refusal(result):
                    again.append(task)
                else:
                    yield task, result
        finally:
            connection.cancel(running)

    def _serve_here(self, function: Callable, take: Callable[[], Task | None]) -> Iterator[tuple[Task, object]]:
        """`serve` in this process, and on helpers where there are any and they have loaded."""
        beside: dict[Future, Task] = {}
        try:
            while True:
                for future in [future for future in beside if future.done()]:
                    yield beside.pop(future), self._helpers.outcome(future)
                if (task := take()) is not None:
                    if (future := self._beside(function, task, len(beside))) is not None:
                        beside[future] = task
                    else:
                        yield task, _attempt(function, task.arguments)
                elif beside:
                    wait(beside, return_when=FIRST_COMPLETED)
                else:
                    return
        finally:
            if beside:
                # Whoever stops here wants no more of what they are at.
                self._helpers.kill()

    def _beside(self, function: Callable, task: Task, running: int) -> Future | None:
        """A task on a helper that has nothing to do; None where there is none."""
        if self._helpers is None or running >= self._helpers.count:
            return None
        return self._helpers.submit(function, task.arguments)

    def _places(self, task: Task) -> dict:
        """Where a task may run, as `Client.submit` takes it: anywhere, unless there are workers to be avoided."""
        if task.avoid is None and not self._admission.refused:
            return {}
        others = [worker for worker in self._admission.allowed(self._workers()) if worker != task.avoid]
        # If those have all gone when the task's turn comes, any worker may have it: a refused one gives it back.
        return {"workers": others, "allow_other_workers": True} if others else {}

    def _is_refusal(self, result) -> bool:
        """Whether a worker that must not compute has given a task back.

        Raises
        ------
        OSError
            If there is no other worker.
        """
        admission = self._admission
        if isinstance(result, Unequal):
            if result.worker in admission.refused:
                # It gets tasks because the others are away: not too many of them.
                time.sleep(_PAUSE)
            admission.learn(result.worker, result.facts)
        elif isinstance(result, WorkerLost) or not isinstance(result, Exception) or not self._ask(self.config.timeout):
            return False
        if self._nobody():
            raise OSError(admission.nobody())
        return True

    def _ask(self, seconds: float, load: bool = False) -> bool:
        """Ask the workers that have not been asked yet for their facts; whether any of them is refused.

        Parameters
        ----------
        seconds : float
            To wait for their answers: one that is busy gives its own with its first task.
        load : bool
            Whether they should load the solver before they answer.
        """
        connection, admission, answers = self._connection, self._admission, SimpleQueue()
        asked = {
            connection.submit(answers, introduce, load, workers=[worker], allow_other_workers=False): worker
            for worker in admission.unknown(self._workers(now=True))
        }
        before, deadline = len(admission.refused), time.monotonic() + seconds
        while asked and (left := deadline - time.monotonic()) > 0.0:
            self._workers()  # the scheduler must answer
            if (done := connection.next(answers, min(left, _COUNT_EVERY))) is not None:
                worker, answer = asked.pop(done[0]), done[1]
                if not isinstance(answer, WorkerLost):
                    admission.learn(worker, answer)
        connection.cancel(asked)
        return len(admission.refused) > before

    def _nobody(self) -> bool:
        """Whether there are workers, and none of them may compute."""
        workers = self._workers(now=True)
        return bool(workers) and not self._admission.allowed(workers)

    def expect(self, modules: Sequence[str]) -> None:
        """Have processes of this machine load modules that `run_beside` will need, while this one goes on.

        Workers do, where there are some already; otherwise helpers, which start sooner.
        """
        if self.config.kind != "local" or self._helpers is not None:
            return
        from pipeline.run.helpers import helpers, load

        if self._connection is not None:
            submit, answers = self._connection.submit, SimpleQueue()
            places = [{"workers": [worker], "allow_other_workers": False} for worker in self._workers(now=True)]
            # Kept, since dask drops what nobody waits for.
            self._loading = [submit(answers, load, tuple(modules), **place) for place in places]
            return
        self._helpers = self._open.enter_context(helpers(self.config, modules))

    def alone(self) -> "Workforce":
        """This process, and helpers if there are any, for what takes less time than workers take to start."""
        return Workforce(replace(self.config, kind="none"), self._say, self._helpers)

    def begin_beside(self, function: Callable, tasks: Iterable[tuple]) -> None:
        """Have helpers, where there are any, begin with tasks that `run_beside` will be asked for."""
        if self._helpers is not None:
            self._helpers.begin(function, tasks)

    def run_beside(self, function: Callable, tasks: Iterable[tuple]) -> Iterator[tuple[tuple, object]]:
        """`run` on processes of this machine that have been started for something else, if `has_local_workers`."""
        beside = self if self._connection is not None else self._helpers
        return beside.run(function, tasks)

    @property
    def has_local_workers(self) -> bool:
        """Whether processes of this machine, which share its files, run already."""
        return self.config.kind == "local" and (self._connection is not None or self._helpers is not None)

    @property
    def size(self) -> int:
        """Number of threads that run tasks; workers of a foreign scheduler may come and go."""
        if self.config.kind == "none":
            return 1 if self._helpers is None else 1 + self._helpers.count
        workers = self._workers()
        return sum(workers[worker] for worker in self._admission.allowed(workers))

    def _workers(self, now: bool = False) -> dict[str, int]:
        """Threads of the workers by address, as they are now or were a moment ago."""
        if now or time.monotonic() - self._seen[0] > _COUNT_EVERY:
            self._seen = time.monotonic(), self._connection.workers()
        return self._seen[1]

    def close(self) -> None:
        """Stop the workers that this object started, and give its jobs back; a foreign scheduler goes on."""
        self.__exit__(None, None, None)


def _silence() -> None:
    """Keep dask's log off the terminal: what the user needs to know of lost workers and schedulers is said here."""
    import distributed  # noqa: F401  (it gives its loggers their levels when it is imported)

    for name in ["distributed", *logging.root.manager.loggerDict]:
        if name.split(".")[0] == "distributed":
            logging.getLogger(name).setLevel(logging.CRITICAL)


def _attempt(function: Callable, task: tuple):
    """The result, or the exception that a worker would have sent back."""
    try:
        return function(*task)
    except Exception as error:  # the reason is kept: it is reported exactly as one that comes from a worker
        return error
