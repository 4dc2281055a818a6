"""Helpers: processes that load and wait, of which nothing depends on."""

import multiprocessing
import os
import subprocess
import sys

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
    yield made, _children() - before
    made.close()
    # The executor waits for processes that were killed, too, and whoever comes second sees them a moment longer.
    wait_until(lambda: not _children() - before)


_EXPECTED = {(2, 3): 8, (3, 2): 9, (0, -1): ZeroDivisionError, (5, 5): 3125}


def test_tasks_and_their_errors_come_back(helpers):
    made, processes = helpers
    assert len(processes) == COUNT
    assert _answers(made.run(pow, _TASKS)) == _EXPECTED
    ((_, where),) = made.run(os.getpid, [()])
    assert where in {process.pid for process in processes}


def test_what_a_helper_was_killed_over_is_done_here(helpers):
    made, processes = helpers
    for process in processes:
        process.kill()
    assert _answers(made.run(pow, _TASKS)) == _EXPECTED
    ((_, where),) = made.run(os.getpid, [()])
    assert where == os.getpid()


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
