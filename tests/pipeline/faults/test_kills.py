"""kill -9 at seeded moments all over the sweep: the store that comes of it is the undisturbed one, bit by bit."""

import os
import random
import signal

import pytest

from pipeline import store
from tests.conftest import slow_but
from tests.pipeline.faults.runs import INJECTED, KEPT, ROWS, complete, continued, same, start, until, workers_of
from tests.pipeline.schedulers import Scheduler

_FEW = [("client", 1), ("worker", 2), ("workers", 3), ("client", 4), ("scheduler", 5), ("client", 6), ("the worker", 7)]
#: Every process once: the only worker, the scheduler, the client.
_ONCE = [_FEW[6], _FEW[4], _FEW[5]]
_VICTIMS = ["client", "worker", "workers", "client", "scheduler"]
_MANY = [(_VICTIMS[seed % len(_VICTIMS)], seed) for seed in range(100, 150)]


def _moment(seed: int, of: int) -> int:
    """Rows after which to kill: the sweep is cut into six parts, and seeds take one after the other."""
    part, rest = seed % 6, random.Random(seed).random()
    return min(1 + int(of * (part + rest) / 6), of - 12)


def _kill_client(folder, seed):
    run = start(folder, "cluster.workers=1")
    seen = until(run, _moment(seed, ROWS))
    run.process.kill()
    run.end()
    return seen


def _kill_workers(folder, seed, count, of=2):
    """The run itself must get over it."""
    run = start(folder, f"cluster.workers={of}")
    seen = until(run, _moment(seed, ROWS))
    workers = workers_of(run)
    assert len(workers) == of
    for process in workers[:count]:
        process.kill()
    run.end()
    assert (run.code, run.err) == (0, ""), run.err
    return seen


def _kill_scheduler(folder, seed):
    with Scheduler(folder) as scheduler:
        scheduler.add_worker()
        run = start(folder, "cluster=scheduler", f"cluster.address={scheduler.address}")
        seen = until(run, _moment(seed, ROWS))
        scheduler.process.kill()
        run.end()
    assert run.err == f"error: the scheduler at {scheduler.address} is gone{KEPT}\n" and run.code == 1
    return seen


def _harm(victim, folder, seed, undisturbed, capsys):
    if victim == "client":
        seen = _kill_client(folder, seed)
    elif victim == "scheduler":
        seen = _kill_scheduler(folder, seed)
    else:
        seen = _kill_workers(folder, seed, *{"worker": (1,), "workers": (2,), "the worker": (1, 1)}[victim])
    assert 0 < seen < ROWS
    path = folder / "outputs/store/plane.zarr"
    if victim in ("client", "scheduler"):
        assert 0 < complete(path) < ROWS
        assert "sweep: continues: " in continued(folder, capsys)
    same(path, undisturbed)
    assert store.find_damage(path) == [] and not list(path.rglob("*.partial"))
    assert not [left for left in path.parent.iterdir() if left != path]


@pytest.mark.costly
@pytest.mark.parametrize(("victim", "seed"), slow_but(_ONCE, _FEW))
def test_killed_and_continued(victim, seed, tmp_path, undisturbed, capsys):
    _harm(victim, tmp_path, seed, undisturbed, capsys)


@pytest.mark.slow
@pytest.mark.parametrize(("victim", "seed"), _MANY)
def test_killed_and_continued_fifty_times(victim, seed, tmp_path, undisturbed, capsys):
    _harm(victim, tmp_path, seed, undisturbed, capsys)


@pytest.mark.slow
def test_an_interrupted_run_says_so_and_is_continued(tmp_path, undisturbed, capsys):
    environment = {"PYTHONPATH": str(INJECTED), "BEVELMAP_TEST_FAULT": "slow"}
    run = start(tmp_path, "cluster.workers=1", environment=environment)
    until(run, 3)
    os.killpg(run.process.pid, signal.SIGINT)
    run.end()
    assert (run.code, run.err) == (130, f"error: interrupted{KEPT}\n")
    assert 0 < complete(run.path) < ROWS and "sweep: continues: " in continued(tmp_path, capsys)
    same(run.path, undisturbed)
