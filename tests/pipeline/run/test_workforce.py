"""Where tasks run: the same results on every kind of cluster, real processes throughout."""

import json
import os
import signal
import subprocess
import sys

import numpy as np
import pytest
from distributed import Client

from pipeline import store
from pipeline.__main__ import main
from pipeline.plan.plan import Block
from pipeline.run.rows import sweep_block
from pipeline.run.workforce import Workforce
from tests.pipeline.planes import assert_same_contents, cluster, contents, small_plan, small_store
from tests.pipeline.schedulers import Scheduler, wait_until

LOCAL = cluster("local", workers=1)
NONE = cluster("none")


def _fails_on_three(number):
    if number == 3:
        raise ValueError("three")
    return number * number, os.getpid(), {key: os.environ.get(key) for key in ("OMP_NUM_THREADS", "NUMBA_NUM_THREADS")}


@pytest.fixture(scope="module")
def local():
    with Workforce(LOCAL) as workforce:
        workforce.start()
        yield workforce


@pytest.fixture
def scheduler(tmp_path):
    with Scheduler(tmp_path) as started:
        yield started


def test_exceptions_come_back_beside_results_on_workers_with_one_thread(local):
    results = {task[0]: result for task, result in local.run(_fails_on_three, [(n,) for n in range(6)])}
    assert isinstance(results.pop(3), ValueError)
    assert {n: value for n, (value, _, _) in results.items()} == {n: n * n for n in (0, 1, 2, 4, 5)}
    assert os.getpid() not in {pid for _, pid, _ in results.values()}
    assert all(set(threads.values()) == {"1"} for _, _, threads in results.values())


def test_in_process_keeps_exceptions_too():
    with Workforce(NONE) as workforce:
        results = {task[0]: result for task, result in workforce.run(_fails_on_three, [(2,), (3,)])}
    assert results[2][:2] == (4, os.getpid()) and isinstance(results[3], ValueError)


@pytest.mark.slow
def test_stores_are_bitwise_equal_on_every_cluster(tmp_path, local, scheduler):
    plan = small_plan(columns=61, rows=36)
    expected = contents(small_store(tmp_path / "here.zarr", plan))
    scheduler.add_worker()
    with Workforce(cluster("scheduler", address=scheduler.address)) as remote:
        for name, workforce, blocks in (("local", local, plan.blocks), ("remote", remote, list(reversed(plan.blocks)))):
            path = small_store(tmp_path / f"{name}.zarr", plan, [])
            receipts = [r for _, r in workforce.run(sweep_block, [(str(path), plan, block) for block in blocks])]
            assert sorted(receipt.block.start for receipt in receipts) == [block.start for block in plan.blocks]
            assert_same_contents(contents(path), expected)


@pytest.mark.slow
def test_workers_may_come_and_go(tmp_path, scheduler):
    """A run that begins without a worker waits for one; it is stopped within a row, another joins, it is killed."""
    plane = ["plane=omega_fe", "plane.sweep.num=61", "plane.parameter.num=30", "stages=[sweep]"]
    path = tmp_path / "outputs/store/omega_fe.zarr"
    command = [sys.executable, "-m", "pipeline", *plane, f"output.root={tmp_path / 'outputs'}"]
    run = subprocess.Popen(
        [*command, "cluster=scheduler", f"cluster.scheduler_file={scheduler.file}"], stdout=subprocess.PIPE, text=True
    )
    try:
        said = []
        while not said or "waiting for workers" not in said[-1]:
            said.append(run.stdout.readline())
            assert said[-1], said
        first = scheduler.add_worker()
        wait_until(lambda: np.any(store.statuses(path) == store.COMPLETE))
        first.send_signal(signal.SIGSTOP)
        assert np.any(store.statuses(path) == store.PENDING)
        scheduler.add_worker()
        with Client(scheduler.address, set_as_default=False) as onlooker:
            wait_until(lambda: len(onlooker.nthreads()) == 2)
        first.kill()
        rest = run.communicate(timeout=200)[0]
        assert run.returncode == 0, rest
        assert "30 rows" in rest and "failed" not in rest
    finally:
        run.kill()
        run.wait()
    assert main([*plane, "cluster=none", f"output.root={tmp_path / 'alone'}"]) == 0
    assert_same_contents(contents(path), contents(tmp_path / "alone/store/omega_fe.zarr"))


def test_a_scheduler_that_does_not_answer_is_one_line(tmp_path, capsys):
    file = tmp_path / "scheduler.json"
    file.write_text(json.dumps({"address": "tcp://127.0.0.1:9"}))
    small = ["plane.sweep.num=9", "plane.parameter.num=3", f"output.root={tmp_path / 'outputs'}"]
    where = ["cluster=scheduler", "cluster.timeout=1", f"cluster.scheduler_file={file}"]
    assert main([*small, *where]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and f"cluster.scheduler_file = '{file}' is not allowed" in said
    assert not (tmp_path / "outputs").exists()


def test_a_block_that_cannot_be_written_is_reported(tmp_path, local):
    plan = small_plan(columns=9, rows=3)
    ((_, result),) = local.run(sweep_block, [(str(tmp_path / "nowhere.zarr"), plan, Block(0, 1))])
    assert isinstance(result, Exception) and "nowhere" in str(result)
