"""Runs in jobs of a real SLURM: one command, jobs that end in the middle, and none that outlives its run."""

import contextlib
import re
import signal

import numpy as np
import pytest

from pipeline import store
from pipeline.config.compose import compose
from pipeline.run.slurm_cluster import slurm_cluster as jobs_of_a_run
from pipeline.run.slurm_jobs import give_back
from tests.pipeline.faults.runs import INJECTED, KEPT, ROWS, complete, finished, same, start, until
from tests.pipeline.schedulers import wait_until
from tests.slurm_cluster import MISSING, slurm_cluster

pytestmark = pytest.mark.skipif(bool(MISSING), reason=MISSING)

#: Jobs reach this machine where they are.
SLURM = ("cluster=slurm", "cluster.queue=main", "cluster.host=127.0.0.1")
ONE_CORE = (*SLURM, "cluster.cores=1")
#: Rows of 0.3 s.
SLOW = {"PYTHONPATH": str(INJECTED), "BEVELMAP_TEST_FAULT": "slow"}


@pytest.fixture(scope="module")
def slurm(tmp_path_factory):
    with slurm_cluster(tmp_path_factory.mktemp("slurm")) as started:
        yield started


@pytest.fixture
def environment(slurm):
    """What a run needs to find it; the jobs of a test end with the test."""
    yield slurm.environment
    slurm.ask("scancel", *slurm.jobs())


@contextlib.contextmanager
def jobs_of(folder, environment, monkeypatch, *wishes):
    """Jobs of this process, the first ones submitted, and what is said of them."""
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    said, settings = [], compose([*SLURM, f"output.root={folder}", *wishes]).config.cluster
    with jobs_of_a_run(settings, said.append) as jobs:
        jobs.begin()
        yield jobs, said


def given_back(slurm, folder):
    """Whether a run has left nothing behind: no job, no key, no folder."""
    wait_until(lambda: not slurm.jobs(), 30.0)
    return not (folder / "outputs/jobs").exists()


def test_one_command_computes_a_plane_in_jobs(tmp_path, slurm, environment, undisturbed):
    run = finished(tmp_path, *SLURM, "cluster.cores=2", "cluster.maximum_jobs=2", environment=environment)
    assert (run.code, run.err) == (0, ""), run.err
    assert "tasks run in SLURM jobs of queue main" in run.out
    same(run.path, undisturbed)
    (log,) = (run.path.parents[1] / "runs/plane").glob("*/run.log")
    # All of them speak TLS.
    assert " on tls://" in log.read_text() and "tcp://" not in log.read_text()
    assert given_back(slurm, tmp_path)


REFUSED = {
    "cluster.queue=nowhere": "cluster.queue = 'nowhere' is not allowed: sbatch says: .*partition",
    "cluster.memory=900GB": "cluster.memory = '900GB' is not allowed: sbatch says: .*emory",
    "cluster.directives=[--no-such-option]": "cluster = slurm is not allowed: sbatch says: .*no-such-option",
}


@pytest.mark.costly
@pytest.mark.parametrize("setting", REFUSED)
def test_what_sbatch_refuses_is_one_line_with_its_words(setting, tmp_path, environment):
    run = finished(tmp_path, *ONE_CORE, setting, environment=environment)
    assert run.code == 2 and run.err.count("\n") == 1, run.err
    assert re.search(REFUSED[setting], run.err), run.err
    assert not (tmp_path / "outputs").exists()


@pytest.mark.slow
@pytest.mark.parametrize("cores", [1, 2])
def test_a_job_that_ends_in_the_middle_is_replaced(cores, tmp_path, slurm, environment, undisturbed):
    words = (*SLURM, f"cluster.cores={cores}", "cluster.maximum_jobs=1")
    run = start(tmp_path, *words, environment={**environment, **SLOW})
    until(run, 3)
    (first,) = slurm.jobs()
    slurm.ask("scancel", first)
    run.end(240.0)
    assert (run.code, run.err) == (0, ""), run.err
    assert f"job {first} has ended" in run.out and run.out.count(" submitted") == 2
    same(run.path, undisturbed)
    assert given_back(slurm, tmp_path)


@pytest.mark.slow
def test_a_job_that_reaches_its_wall_time_is_replaced(tmp_path, slurm, environment):
    """Its workers leave before: nothing is computed twice but what they were at."""
    words = (*ONE_CORE, "cluster.maximum_jobs=1", "cluster.walltime=1", "plane.parameter.num=240")
    run = start(tmp_path, *words, environment={**environment, **SLOW})
    run.end(400.0)
    assert (run.code, run.err) == (0, ""), run.err
    assert "has ended" in run.out and "240 rows" in run.out and "computed again" not in run.out
    assert np.all(store.statuses(run.path) == store.COMPLETE) and store.find_damage(run.path) == []
    assert given_back(slurm, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_jobs_are_given_back_when_a_run_is_ended(number, tmp_path, slurm, environment):
    words = (*ONE_CORE, "cluster.minimum_jobs=6", "cluster.maximum_jobs=6")
    run = start(tmp_path, *words, environment={**environment, **SLOW})
    until(run, 3)
    # More than there is room for: some run, others wait.
    assert len(slurm.jobs()) == 6
    run.process.send_signal(number)
    run.end()
    name = "" if number == signal.SIGINT else f" by {number.name}"
    assert (run.code, run.err) == (128 + number, f"error: interrupted{name}{KEPT}\n")
    assert 0 < complete(run.path) < ROWS
    assert given_back(slurm, tmp_path)


@pytest.mark.slow
def test_a_queue_that_takes_no_jobs_for_a_while_is_waited_for(tmp_path, slurm, environment, undisturbed):
    run = start(tmp_path, *ONE_CORE, "cluster.maximum_jobs=1", environment={**environment, **SLOW})
    until(run, 3)
    try:
        slurm.ask("scontrol", "update", "PartitionName=main", "State=DRAIN")
        slurm.ask("scancel", *slurm.jobs())
        said = [run.process.stdout.readline()]
        while "0 jobs for now: sbatch says: " not in said[-1]:
            said.append(run.process.stdout.readline())
            assert said[-1], said
    finally:
        slurm.ask("scontrol", "update", "PartitionName=main", "State=UP")
    run.end(240.0)
    assert (run.code, run.err) == (0, ""), run.err
    same(run.path, undisturbed)


@pytest.mark.slow
def test_what_ends_a_process_in_a_moment_gives_its_jobs_back_first(tmp_path, slurm, environment, monkeypatch):
    """As where Python has no turn any more, and a thread hears of the signal."""
    with jobs_of(tmp_path, environment, monkeypatch, "cluster.minimum_jobs=5") as (jobs, said):
        assert len(slurm.jobs()) == 5 and "5 jobs" in said[0]
        give_back()
        wait_until(lambda: not slurm.jobs(), 30.0)
    assert not (tmp_path / "jobs").exists()


@pytest.mark.slow
def test_jobs_are_given_back_while_there_is_nothing_to_do(tmp_path, slurm, environment, monkeypatch):
    """As while figures are drawn; some are kept if that is asked for."""
    monkeypatch.setattr("pipeline.run.slurm_jobs._IDLE", 2.0)
    wishes = ("cluster.minimum_jobs=1", "cluster.maximum_jobs=4")
    with jobs_of(tmp_path, environment, monkeypatch, *wishes) as (jobs, said):
        jobs.fit(None)
        wait_until(lambda: len(slurm.jobs()) == 4, 30.0)
        jobs.rest()
        wait_until(lambda: len(slurm.jobs()) == 1, 30.0)
        jobs.fit(8)
        wait_until(lambda: len(slurm.jobs()) == 2, 30.0)
    assert any("3 jobs" in text and "given back" in text for text in said)
    assert given_back(slurm, tmp_path)


@pytest.mark.slow
def test_jobs_of_a_run_that_is_killed_end_by_themselves(tmp_path, slurm, environment):
    run = start(tmp_path, *ONE_CORE, "cluster.maximum_jobs=2", environment={**environment, **SLOW})
    until(run, 3)
    run.process.kill()
    run.end()
    wait_until(lambda: not slurm.jobs(), 120.0)


@pytest.mark.slow
def test_jobs_that_never_have_a_worker_end_the_run(tmp_path, slurm, environment):
    """As where nodes have no Python that works."""
    fault = {"SBATCH_EXPORT": "ALL,PYTHONHOME=/nowhere", **environment}
    run = start(tmp_path, *ONE_CORE, "cluster.minimum_jobs=3", "cluster.maximum_jobs=3", environment=fault)
    run.end(120.0)
    assert run.code == 1 and run.err.count("\n") == 1 and "before they have a worker" in run.err, run.err
    assert (
        "no Python frame" in run.err
        and "outputs/jobs" in run.err
        and not list((tmp_path / "outputs/jobs").rglob("*.pem"))
    )


@pytest.mark.slow
def test_jobs_that_have_nothing_to_do_are_given_back_during_the_run(tmp_path, slurm, environment):
    words = (*ONE_CORE, "cluster.minimum_jobs=0", "cluster.maximum_jobs=12")
    run = start(tmp_path, *words, environment={**environment, **SLOW})
    until(run, 24)
    # Twelve blocks, of which some are left; four cores.
    wait_until(lambda: len(slurm.jobs()) < 12 or run.process.poll() is not None)
    run.end(240.0)
    assert (run.code, run.err) == (0, ""), run.err
    assert "given back" in run.out
    assert given_back(slurm, tmp_path)
