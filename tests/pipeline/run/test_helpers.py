"""Helpers: processes that load and wait, of which nothing depends on."""

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from multiprocessing import forkserver

import psutil
import pytest

from pipeline.run.helpers import COUNT, Helpers
from pipeline.run.workforce import Workforce
from tests.pipeline.planes import cluster
from tests.pipeline.schedulers import ROOT, wait_until

_TASKS = [(2, 3), (3, 2), (0, -1), (5, 5)]


def _answers(results) -> dict:
    return {task: type(result) if isinstance(result, Exception) else result for task, result in results}


def _children() -> set:
    return set(multiprocessing.active_children())


@pytest.fixture
def helpers():
    before = _children()
    made = Helpers(["json"])
    yield made, lambda: _children() - before
    made.close()
    # The executor waits for processes that were killed, too, and whoever comes second sees them a moment longer.
    wait_until(lambda: not _children() - before)


_EXPECTED = {(2, 3): 8, (3, 2): 9, (0, -1): ZeroDivisionError, (5, 5): 3125}


def test_tasks_and_their_errors_come_back(helpers):
    made, processes = helpers
    assert _answers(made.run(pow, _TASKS)) == _EXPECTED
    assert len(processes()) == COUNT
    ((_, where),) = made.run(os.getpid, [()])
    assert where in {process.pid for process in processes()}


def test_what_was_begun_is_not_done_twice(helpers, tmp_path):
    made, _ = helpers
    notes = [(os.open, (tmp_path / name, os.O_CREAT | os.O_EXCL)) for name in "ab"]
    for function, task in notes:
        made.begin(function, [task])
        made.begin(function, [task])
    tasks = [task for _, task in notes]
    # Whoever opened one of them again would be refused.
    results = dict(made.run(os.open, [*tasks, (tmp_path / "c", os.O_CREAT)]))
    assert len(results) == 3 and not any(isinstance(result, Exception) for result in results.values())


def test_what_a_helper_was_killed_over_is_done_here(helpers):
    made, processes = helpers
    list(made.run(pow, _TASKS))
    made.begin(time.sleep, [(60.0,)])
    for process in processes():
        process.kill()
    assert _answers(made.run(pow, _TASKS)) == _EXPECTED
    ((_, where),) = made.run(os.getpid, [()])
    assert where == os.getpid()


@pytest.mark.skipif("forkserver" not in multiprocessing.get_all_start_methods(), reason="nothing forks here")
def test_helpers_are_forked_again_or_done_without_where_what_forks_them_was_killed(helpers):
    made, _ = helpers
    os.kill(forkserver._forkserver._forkserver_pid, signal.SIGKILL)
    assert _answers(made.run(pow, _TASKS)) == _EXPECTED


@pytest.mark.costly
@pytest.mark.skipif("forkserver" not in multiprocessing.get_all_start_methods(), reason="nothing forks here")
def test_what_forks_helpers_is_ended_with_them_even_while_it_loads():
    made = Helpers(["pipeline.figures.ready"])
    made.begin(pow, _TASKS)
    server = psutil.Process(forkserver._forkserver._forkserver_pid)
    made.close()
    assert not server.is_running()


@pytest.mark.skipif("forkserver" not in multiprocessing.get_all_start_methods(), reason="nothing forks here")
def test_what_forks_helpers_is_not_started_again_between_its_end_and_theirs(monkeypatch):
    """Helpers that such a one forked would keep it alive, and whoever waits for its end, for good."""
    made, kill = Helpers(["json"]), os.kill

    def kill_and_begin(*arguments):
        monkeypatch.undo()
        kill(*arguments)
        made.begin(pow, _TASKS)
        time.sleep(0.5)

    monkeypatch.setattr(os, "kill", kill_and_begin)
    made.close()
    assert forkserver._forkserver._forkserver_pid is None


def test_helpers_that_cannot_load_leave_everything_to_this_process():
    made = Helpers(["tests.there_is_no_such_module"])
    assert _answers(made.run(pow, _TASKS)) == _EXPECTED
    ((_, where),) = made.run(os.getpid, [()])
    assert where == os.getpid()
    made.close()


@pytest.mark.costly
def test_helpers_end_with_the_process_that_was_killed():
    code = (
        "import multiprocessing, os, signal\nfrom pipeline.run.helpers import Helpers\nhelpers = Helpers(['json'])\n"
        "list(helpers.run(os.getpid, [()] * 4))\n"
        "print(*(child.pid for child in multiprocessing.active_children()), flush=True)\n"
        "os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, stdout=subprocess.PIPE, text=True, timeout=120)
    started = [int(pid) for pid in done.stdout.split()]
    assert len(started) == COUNT
    wait_until(lambda: not any(map(psutil.pid_exists, started)), 30.0)


def test_a_workforce_has_helpers_where_it_may_start_processes(monkeypatch):
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    before = _children()
    with Workforce(cluster("local")) as workforce:
        assert not workforce.has_local_workers
        workforce.expect(["json"])
        assert workforce.has_local_workers
        assert _answers(workforce.run_beside(pow, _TASKS)) == _EXPECTED
    assert not workforce.has_local_workers
    wait_until(lambda: not _children() - before)
    for alone in (cluster("none"), cluster("scheduler", address="tcp://127.0.0.1:9")):
        with Workforce(alone) as workforce:
            workforce.expect(["json"])
            assert not workforce.has_local_workers
    monkeypatch.setattr(os, "cpu_count", lambda: 1)
    with Workforce(cluster("local")) as workforce:
        workforce.expect(["json"])
        assert not workforce.has_local_workers
