"""Where tasks run: the same results on every kind of cluster, real processes throughout."""

import os
import re
import subprocess
import sys
import time

import pytest

from pipeline.cluster import Workforce
from pipeline.plan import Block
from pipeline.sweep import sweep_block
from tests.pipeline.planes import cluster, contents, small_plan, small_store

LOCAL = cluster("local")
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


@pytest.fixture(scope="module")
def scheduler():
    """A real `dask scheduler` with one worker, as processes of their own on loopback."""
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    head = subprocess.Popen(
        [sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard"],
        stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True, env=environment,
    )  # fmt: skip
    address = None
    deadline = time.monotonic() + 60.0
    while address is None and time.monotonic() < deadline:
        found = re.search(r"tcp://127\.0\.0\.1:\d+", head.stderr.readline())
        address = found.group() if found else None
    worker = subprocess.Popen(
        [sys.executable, "-m", "distributed.cli.dask_worker", address, "--nthreads", "1", "--no-dashboard"],
        stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL, env=environment,
    )  # fmt: skip
    yield address
    for process in (worker, head):
        process.terminate()
        process.wait(30)
    head.stderr.close()


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


def test_stores_are_bitwise_equal_on_every_cluster(tmp_path, local, scheduler):
    plan = small_plan(columns=61, rows=36)
    expected = contents(small_store(tmp_path / "here.zarr", plan))
    with Workforce(cluster("scheduler", address=scheduler)) as remote:
        for name, workforce, blocks in (
            ("local", local, plan.blocks),
            ("remote", remote, list(reversed(plan.blocks))),
        ):
            path = small_store(tmp_path / f"{name}.zarr", plan, [])
            receipts = [r for _, r in workforce.run(sweep_block, [(str(path), plan, block) for block in blocks])]
            assert sorted(receipt.block.start for receipt in receipts) == [block.start for block in plan.blocks]
            for array, values in contents(path).items():
                assert values.dtype == expected[array].dtype
                if values.dtype.kind == "T":
                    assert values.tolist() == expected[array].tolist()
                else:
                    assert values.tobytes() == expected[array].tobytes(), array


def test_a_block_that_cannot_be_written_is_reported(tmp_path, local):
    plan = small_plan(columns=9, rows=3)
    ((_, result),) = local.run(sweep_block, [(str(tmp_path / "nowhere.zarr"), plan, Block(0, 1))])
    assert isinstance(result, Exception) and "nowhere" in str(result)
