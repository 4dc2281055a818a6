"""Helpers: processes that load and wait, of which nothing depends on."""

import contextlib
import multiprocessing
import os
import signal
import subprocess
import sys
import time
from multiprocessing import forkserver

import psutil
import pytest

from pipeline.config.compose import compose
from pipeline.errors import WorkerLost
from pipeline.run.early import early_helpers
from pipeline.run.helpers import COUNT, Helpers
from pipeline.run.workforce import Task, Workforce
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


def _where(_) -> int:
    return os.getpid()


def _killed_elsewhere(here: int) -> int:
    if os.getpid() != here:
        os.kill(os.getpid(), signal.SIGKILL)
    return here


def _shared(made, function, tasks) -> list:
    """What comes of tasks that are shared with helpers."""
    with Workforce(cluster("local"), helpers=made) as everybody:
        waiting = list(tasks)
        take = lambda: Task(waiting.pop()) if waiting else None  # noqa: E731
        return [result for _, result in everybody.alone().serve(function, take)]


def test_tasks_are_done_here_until_helpers_have_loaded_and_then_on_both_sides(helpers):
    made, processes = helpers
    wait_until(lambda: made.is_ready)
    found = _shared(made, _where, [(i,) for i in range(50)])
    assert len(found) == 50 and os.getpid() in found
    assert set(found) - {os.getpid()} and set(found) <= {os.getpid(), *(process.pid for process in processes())}


def test_tasks_do_not_wait_for_helpers_that_never_load():
    made = Helpers(["tests.there_is_no_such_module"])
    assert _shared(made, _where, [(i,) for i in range(3)]) == [os.getpid()] * 3
    made.close()


def test_a_task_that_ends_its_helper_is_lost_and_the_others_are_done_here(helpers):
    made, _ = helpers
    wait_until(lambda: made.is_ready)
    found = _shared(made, _killed_elsewhere, [(os.getpid(),)] * 5)
    lost = [result for result in found if isinstance(result, WorkerLost)]
    assert 1 <= len(lost) <= COUNT and len(found) == 5
    assert all(result == os.getpid() for result in found if result not in lost)


def test_whoever_stops_taking_results_leaves_nothing_running(helpers):
    made, processes = helpers
    wait_until(lambda: made.is_ready)
    with Workforce(cluster("local"), helpers=made) as everybody:
        tasks = [Task((0.0,)), Task((60.0,))]
        results = everybody.alone().serve(time.sleep, lambda: tasks.pop() if tasks else None)
        next(results)
        results.close()
    wait_until(lambda: not processes())


@pytest.mark.parametrize(
    ("overrides", "expected"),
    [
        ([], True),
        (["plane.sweep.num=20", "plane.parameter.num=4"], True),
        (["plane.sweep.num=4000", "plane.parameter.num=2000"], False),
        (["stages=[sweep]"], False),
        (["stages=[figures]"], False),
        (["solver=hb"], False),
        (["cluster.workers=2"], False),
        (["cluster=none"], False),
        (["plane=omega_b_fe"], False),
    ],
)
def test_helpers_are_started_early_for_a_new_small_plane_that_is_drawn(tmp_path, monkeypatch, overrides, expected):
    monkeypatch.setattr("pipeline.run.helpers.Helpers", lambda modules: contextlib.nullcontext(modules))
    monkeypatch.setattr("contextlib.closing", lambda made: made)
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    settings = compose([*overrides, f"store.root={tmp_path}"])

    def started(*all_settings) -> bool:
        with early_helpers(all_settings) as found:
            return found is not None

    assert started(settings) == expected
    assert not started(settings, settings)
    settings.store_path.mkdir()
    assert not started(settings)


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
