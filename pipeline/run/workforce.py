"""Where tasks run: in this process, on worker processes of this machine, in jobs, or on a running dask scheduler.

Tasks are independent and write their own results; only small receipts come back, in any order.
"""

import contextlib
import logging
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator, Sequence, Sized
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import replace
from queue import SimpleQueue

from pipeline.config.schema import Cluster
from pipeline.errors import ConfigurationError, WorkerLost, unusable
from pipeline.run.cluster_settings import address_of, check_start, security_of, setting_of, unreached
from pipeline.run.environment import differences_of_scheduler, packages_of_scheduler
from pipeline.run.workers import Task, Workers

__all__ = ["Task", "Workforce"]

#: A task is done again after this many losses of its worker.
_MOST_LOST = 2
#: Seconds of a task, at least, and tasks that are given out in a second, at most: one takes one to two milliseconds of
#: this process, and as much of the scheduler (`python -m benchmarks.cluster_limits`).
_TASK_SECONDS, _TASKS_A_SECOND = 1.0, 250
#: Seconds in which the workers of this machine load the solver, unless it is compiled; they are used in any case.
_START_WITHIN = 60.0


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
        self._connection = self._workers = self._jobs = None
        self._kernels: tuple[str, ...] = ()
        #: How long rows take, by what they are of (`pipeline.run.dispatch.Pace`): one plane learns from another.
        self.paces: dict = {}
        self._open = contextlib.ExitStack()

    #: Planes that share it: what one of them does alone, others wait for.
    planes = 1

    def aside(self) -> contextlib.AbstractContextManager:
        """To wait within for something else than tasks, which keeps no other plane waiting."""
        return contextlib.nullcontext()

    def __enter__(self):
        return self

    def __exit__(self, *error):
        # An interrupt ends workers at once.
        self._connection = self._helpers = self._jobs = self._workers = None
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
            self._connection = start[self.config.kind]()
            self._open.callback(self._connection.close)
            self._workers = Workers(self._connection, self._say, self._jobs)
            self._workers.meet(_START_WITHIN if local else self.config.timeout, local)
            if nobody := self._workers.nobody():
                raise ConfigurationError(f"{setting_of(self.config)} is not allowed: {nobody}")
        self._workers.needs(self._kernels)
        address = self._connection.dashboard() if self.config.dashboard else None
        dashboard = f", dashboard {address}" if address else ""
        if local:
            return f"tasks run on {self.config.workers} worker processes{dashboard}"
        if self._jobs is not None:
            return f"{self._jobs.sentence}{dashboard}"
        if not self._workers.present(now=True):
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
            connection = Connection(address, security, self.config.timeout)
        except (KeyError, TypeError, AttributeError) as error:
            # Times and transports that dask was told of, and cannot read.
            raise unusable("dask", error) from None
        except (OSError, ValueError) as error:
            raise unreached(self.config, address, security, error) from None
        if differs := differences_of_scheduler(*connection.versions(packages_of_scheduler())):
            connection.close()
            raise ConfigurationError(f"{setting_of(self.config)} is not allowed: of that scheduler, {differs}")
        return connection

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
        yield from self._workers.serve(function, take)

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

    def needs(self, kernels: Iterable[str]) -> None:
        """Which kernels the next tasks need: workers elsewhere are given none before they have them."""
        self._kernels = tuple(dict.fromkeys([*self._kernels, *kernels]))
        if self._workers is not None:
            # Tasks of another plane may be under way.
            self._workers.needs(self._kernels)

    def expect(self, modules: Sequence[str]) -> None:
        """Have processes of this machine load modules that `run_beside` will need, while this one goes on.

        Workers do, where there are some already; otherwise helpers, which start sooner.
        """
        if self.config.kind != "local" or self._helpers is not None:
            return
        from pipeline.run.helpers import helpers, load

        if self._connection is not None:
            submit, answers = self._connection.submit, SimpleQueue()
            places = [{"workers": [worker], "allow_other_workers": False} for worker in self._workers.present(now=True)]
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
        """Number of threads that run tasks, 0 before workers start; those of a foreign scheduler may come and go."""
        if self.config.kind == "none":
            return 1 if self._helpers is None else 1 + self._helpers.count
        return 0 if self._workers is None else self._workers.size

    @property
    def task_seconds(self) -> float:
        """Seconds of work that a task should hold: more, and workers end at different times; less, and giving it out
        costs. The more workers, the longer: this process and the scheduler can serve so many tasks a second."""
        return max(_TASK_SECONDS, self.size / _TASKS_A_SECOND)

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
