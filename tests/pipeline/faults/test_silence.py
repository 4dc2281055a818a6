"""A scheduler that is suspended says nothing and closes nothing: every wait for it ends within `cluster.timeout`."""

import os
import re
import signal
import subprocess
import sys

import pytest
import zarr

from pipeline import open_plane
from pipeline.errors import ConfigurationError
from tests.pipeline.faults.runs import KEPT, ROOT, ROWS, complete, continued, finished, same, start, until
from tests.pipeline.schedulers import Scheduler, there

#: Seconds in which a run ends that waits for two at a time; without a bound it would never.
_END = 60.0


@pytest.fixture(scope="module")
def started(tmp_path_factory):
    with Scheduler(tmp_path_factory.mktemp("scheduler")) as process:
        yield process


@pytest.fixture
def scheduler(started):
    """The scheduler of the module, without workers; it runs on, and those of a test end with it."""
    yield started
    started.process.send_signal(signal.SIGCONT)
    started.end_workers()
    there(started, 0)


def arguments(scheduler):
    return "cluster=scheduler", f"cluster.address={scheduler.address}", "cluster.timeout=2"


@pytest.mark.costly
def test_a_scheduler_that_is_suspended_before_the_run_is_refused(tmp_path, scheduler):
    scheduler.process.send_signal(signal.SIGSTOP)
    run = start(tmp_path, *arguments(scheduler)).end(_END)
    assert run.code == 2 and run.err.count("\n") == 1, run.err
    assert f"cluster.address = {scheduler.address!r} is not allowed" in run.err and "within 2 s" in run.err
    assert not (tmp_path / "outputs").exists()


@pytest.mark.costly
@pytest.mark.parametrize("workers", [pytest.param(0, marks=pytest.mark.slow), 1])
def test_one_that_is_suspended_during_the_run_ends_it(workers, tmp_path, scheduler, undisturbed, capsys):
    """While tasks are computed and gathered, and while the run waits for a worker."""
    for _ in range(workers):
        scheduler.add_worker()
    run = start(tmp_path, *arguments(scheduler))
    if workers:
        until(run, 3)
    else:
        while "waiting for workers" not in run.process.stdout.readline():
            assert run.process.poll() is None
    scheduler.process.send_signal(signal.SIGSTOP)
    run.end(_END)
    assert run.code == 1, run.err
    assert run.err == f"error: the scheduler at {scheduler.address} does not answer within 2 s{KEPT}\n"
    assert (complete(run.path) > 0) == bool(workers)
    continued(tmp_path, capsys)
    same(run.path, undisturbed)


@pytest.mark.costly
def test_one_that_is_suspended_when_all_is_done_does_not_hold_the_run(tmp_path, scheduler, undisturbed):
    scheduler.add_worker()
    run = start(tmp_path, *arguments(scheduler))
    while not re.match(r"sweep: \d+ rows, ", run.process.stdout.readline()):
        assert run.process.poll() is None
    scheduler.process.send_signal(signal.SIGSTOP)
    run.end(_END)
    assert (run.code, run.err) == (0, "")
    same(run.path, undisturbed)


@pytest.mark.costly
def test_a_run_that_is_stopped_itself_goes_on(tmp_path, scheduler, undisturbed):
    """Its own questions to the scheduler are too old then, which is not the scheduler's fault."""
    scheduler.add_worker()
    run = start(tmp_path, "cluster=scheduler", f"cluster.address={scheduler.address}", "cluster.timeout=1")
    until(run, 3)
    run.process.send_signal(signal.SIGSTOP)
    signal.sigtimedwait([], 2.5)
    run.process.send_signal(signal.SIGCONT)
    run.end()
    assert (run.code, run.err) == (0, ""), run.err
    same(run.path, undisturbed)


@pytest.mark.costly
@pytest.mark.parametrize("words", ["cluster=none", pytest.param("cluster.workers=1", marks=pytest.mark.slow)])
def test_settings_of_zarr_in_the_environment_change_nothing(words, tmp_path, undisturbed):
    """With the first one a run would wait for ever, as would its workers."""
    settings = {"ZARR_ASYNC__CONCURRENCY": "0", "ZARR_ASYNC__TIMEOUT": "-1", "ZARR_THREADING__MAX_WORKERS": "x"}
    run = finished(tmp_path, words, environment=settings)
    assert (run.code, run.err) == (0, ""), run.err
    same(run.path, undisturbed)


@pytest.mark.parametrize("concurrency", [0, -1, "'x'"])
def test_a_plane_is_not_opened_where_zarr_would_wait_for_ever(concurrency, undisturbed):
    """In a process of the user's own, whose settings stay as they are."""
    with zarr.config.set({"async.concurrency": concurrency}), pytest.raises(ConfigurationError, match="concurrency"):
        open_plane(undisturbed)
    with zarr.config.set({"async.concurrency": 1}):
        assert open_plane(undisturbed).tree["n_solutions"].shape[0] == ROWS


@pytest.mark.slow
def test_a_malformed_configuration_file_of_dask_is_one_line(tmp_path):
    file = tmp_path / "malformed.yaml"
    file.write_text("a: [1")
    run = finished(tmp_path, "cluster.workers=2", environment={"DASK_CONFIG": str(file)})
    assert run.code == 2 and run.err.count("\n") == 1 and "dask" in run.err and file.name in run.err, run.err
    assert not (tmp_path / "outputs").exists()


def test_a_malformed_configuration_file_of_zarr_matters_only_to_who_opens_stores_with_it(tmp_path):
    file = tmp_path / "malformed.yaml"
    file.write_text("a: [1")
    program = "from pipeline.__main__ import main; from pipeline.store.files import files_at; "
    program += "assert main(['stages=[list]']) == 0; files_at('any').zarr()"
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "ZARR_CONFIG": str(file)}
    run = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, env=environment, timeout=200
    )
    line = run.stderr.splitlines()[-1]
    assert run.returncode == 1 and "ConfigurationError" in line and "zarr" in line and str(file) in line, run.stderr
