"""Who is given tasks: workers that have the kernels which those need, each compiled once on a machine."""

import os
import pickle
import signal
import subprocess
import sys
from collections import deque

import pytest

from pipeline.errors import WorkerLost
from pipeline.run.admission import Ready, Unequal, get_ready
from pipeline.run.environment import facts
from pipeline.run.workers import Task, Workers
from pipeline.run.workforce import Workforce
from tests.pipeline.faults.runs import finished, same, start
from tests.pipeline.planes import cluster
from tests.pipeline.schedulers import ROOT, Scheduler, there

#: Small ones: three quarters of a second each.
KERNELS = ("solver.continuation.correctors._newton", "solver.continuation.setup.no_contacts")


class Played:
    """A connection whose workers answer as they are told, and never out of turn.

    Parameters
    ----------
    **ready
        What each worker answers that is to get ready; None: nothing.
    """

    def __init__(self, **ready):
        self.ready, self.answers, self.given = ready, deque(), []

    def workers(self):
        return dict.fromkeys(self.ready, 1)

    def submit(self, finished, function, digest, payload, **places):
        function, arguments = pickle.loads(payload)
        future = object()
        if function is get_ready:
            (worker,) = places["workers"]
            assert not places["allow_other_workers"]
            if (answer := self.ready[worker]) is not None:
                self.answers.append((future, answer))
        else:
            self.given.append((arguments, places.get("workers")))
            self.answers.append((future, function(*arguments)))
        return future

    def next(self, finished, seconds):
        return self.answers.popleft() if self.answers else None

    def cancel(self, futures):
        """Nobody waits."""


def served(connection, kernels=KERNELS, count=6):
    """Results of some tasks, and what is said."""
    said, tasks = [], deque(Task((n, 2)) for n in range(count))
    workers = Workers(connection, said.append)
    workers.needs(kernels)
    results = [result for _, result in workers.serve(pow, lambda: tasks.popleft() if tasks else None)]
    assert sorted(results) == [n**2 for n in range(count)]
    return said


def test_a_cold_worker_gets_nothing_while_a_warm_one_is_there():
    connection = Played(warm=Ready("one", 0, 0.1), cold=None)
    assert served(connection) == []
    assert {place for _, places in connection.given for place in places} == {"warm"}


def test_a_machine_that_compiled_is_named_once():
    connection = Played(
        a=Ready("one", 3, 20.0), b=Ready("one", 2, 21.0), c=Ready("two", 1, 4.0), d=Ready("three", 0, 9)
    )
    said = served(connection)
    assert len(said) == 2 and "one in 20 s" in said[0] and "two in 4 s" in said[1]


def test_one_that_differs_or_cannot_is_refused_and_the_others_go_on():
    other = {**facts(), "numpy": "1.0"}
    connection = Played(
        a=Unequal("a", other), b=ModuleNotFoundError("No module named 'pipeline'"), c=Ready("one", 0, 1)
    )
    said = served(connection)
    assert len(said) == 2 and "numpy is 1.0 there" in said[0] and "cannot be used there" in said[1]
    assert all(places == ["c"] for _, places in connection.given)
    with pytest.raises(OSError, match=r"no worker computes as this program does .*numpy is 1\.0"):
        served(Played(a=Unequal("a", other)))


class Adapting(Played):
    """Workers that come when something waits for one."""

    def submit(self, finished, function, digest, payload, **places):
        if pickle.loads(payload)[0] is get_ready and not places:
            assert not self.ready
            future, self.ready = object(), {"first": Ready("one", 0, 0.1)}
            self.answers.append((future, self.ready["first"]))
            return future
        return super().submit(finished, function, digest, payload, **places)


def test_a_cluster_that_adapts_itself_is_asked_for_its_first_worker():
    connection = Adapting()
    assert served(connection) == [] and connection.ready and len(connection.given) == 6


def test_where_those_that_are_left_were_refused_before_the_run_ends():
    workers = Workers(Played(a=None), print)
    workers._admission.learn("a", {**facts(), "numpy": "1.0"})
    with pytest.raises(OSError, match=r"numpy is 1\.0"):
        next(workers.serve(pow, lambda: Task((3, 2))))


def test_workers_that_are_lost_again_and_again_before_they_are_ready_end_the_run(monkeypatch):
    monkeypatch.setattr("pipeline.run.workers._COUNT_EVERY", 0.0)
    with pytest.raises(OSError, match="lost before they had their kernels"):
        served(Played(a=WorkerLost("it ended")))


def test_without_kernels_those_that_are_known_are_ready():
    connection = Played(a=None)
    workers, tasks = Workers(connection, print), deque([Task((3, 2))])
    workers._admission.equal.add("a")
    assert [result for _, result in workers.serve(pow, lambda: tasks.popleft() if tasks else None)] == [9]


READY = """
import sys
from pipeline.run.admission import get_ready
print("here", flush=True)
sys.stdin.readline()
print(get_ready(tuple(sys.argv[1:])).compiled)
"""


@pytest.mark.costly
def test_processes_of_one_machine_compile_each_kernel_once(tmp_path):
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": str(ROOT)}
    tmp_path.chmod(0o700)
    pipes = dict(stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment)
    processes = [subprocess.Popen([sys.executable, "-c", READY, *KERNELS], **pipes) for _ in range(3)]
    for process in processes:
        assert process.stdout.readline() == "here\n"
    compiled = [int(process.communicate("go\n", timeout=300)[0]) for process in processes]
    # A kernel that two compile is counted twice, and kept once.
    assert sum(compiled) == len(list(tmp_path.rglob("*.kernel"))) >= 3


def _pid(number):
    return os.getpid()


@pytest.mark.costly
def test_cold_workers_compile_once_and_a_suspended_one_holds_nobody_up(tmp_path):
    said, cold = [], tmp_path / "cache"
    cold.mkdir(mode=0o700)
    with Scheduler(tmp_path) as scheduler:
        workers = [scheduler.add_worker(NUMBA_CACHE_DIR=str(cold)) for _ in range(2)]
        there(scheduler, 2)
        with Workforce(cluster("scheduler", address=scheduler.address, timeout=60.0), said.append) as workforce:
            workforce.needs(KERNELS)
            pids = {result for _, result in workforce.run(_pid, [(n,) for n in range(40)])}
            assert pids <= {worker.pid for worker in workers}
            assert len(said) == 1 and said[0].startswith("kernels: compiled on "), said
            third = scheduler.add_worker(NUMBA_CACHE_DIR=str(cold))
            there(scheduler, 3)
            third.send_signal(signal.SIGSTOP)
            # It is not ready, and cannot get ready: nothing is given to it.
            pids = {result for _, result in workforce.run(_pid, [(n,) for n in range(40)])}
            assert third.pid not in pids and len(said) == 1
            third.send_signal(signal.SIGCONT)


@pytest.mark.slow
def test_cold_workers_of_a_run_say_that_they_compiled_and_store_the_same(tmp_path):
    """All that rows need, from nothing."""
    cold = tmp_path / "cache"
    cold.mkdir(mode=0o700)
    with Scheduler(tmp_path) as scheduler:
        for _ in range(2):
            scheduler.add_worker(NUMBA_CACHE_DIR=str(cold))
        there(scheduler, 2)
        run = start(tmp_path / "cold", "cluster=scheduler", f"cluster.address={scheduler.address}").end(900.0)
    assert (run.code, run.err) == (0, ""), run.err
    assert run.out.count("kernels: compiled on ") == 1
    same(run.path, finished(tmp_path / "here", "cluster=none").path)
