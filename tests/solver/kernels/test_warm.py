"""Compiling ahead: what is compiled, what is said of it, and processes that share the work."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
from filelock import lock_descriptor

from solver.continuation import correctors
from solver.enumeration.interval import add
from solver.kernels.store import KernelStore
from solver.kernels.warm import kernels_of, warm

ROOT = Path(__file__).parents[3]

#: Six kernels that take some tenths of a second each.
SHARED = "from solver.kernels import types\nfrom solver.kernels.compile import ARRAY, kernel\n" + "".join(
    f"""
@kernel(types.float64(ARRAY))
def sum_{i}(x):
    total = {float(i)}
    for j in range(x.shape[0]):
        for k in range(j):
            total += x[j] * x[k] + abs(x[j] - x[k]) ** 1.5
    return total
"""
    for i in range(6)
)
SCRIPT = f"""
import json, sys
sys.path[:0] = [sys.argv[1], {str(ROOT)!r}]
from solver.kernels import backend
from solver.kernels.warm import kernels_of, warm
compiled, original = [], backend._compiled
backend._compiled = lambda kernel, *others: compiled.append(kernel.__name__) or original(kernel, *others)
said = []
warm(kernels_of(["shared"]), lambda *report: said.append(report))
print(json.dumps([compiled, said]))
"""


@pytest.fixture
def start(tmp_path):
    """Start a process that compiles what is shared."""
    (tmp_path / "shared.py").write_text(SHARED)
    processes = []

    def start():
        environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
        command = [sys.executable, "-c", SCRIPT, str(tmp_path)]
        pipes = dict(stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        processes.append(subprocess.Popen(command, env=environment, **pipes))
        return processes[-1]

    yield start
    for process in processes:
        process.kill()
        process.communicate()


def _ended(process):
    out, err = process.communicate(timeout=300)
    assert process.returncode == 0 and err == "", err
    return json.loads(out)


@pytest.mark.costly
def test_several_processes_share_the_work(start, tmp_path):
    processes = [start() for _ in range(3)]
    results = [_ended(process) for process in processes]
    assert sorted(name for compiled, _ in results for name in compiled) == [f"sum_{i}" for i in range(6)]
    for _, said in results:
        assert said[-1] == ["", 6, 6] and [done for _, done, _ in said] == sorted(done for _, done, _ in said)
    # Nothing but entries is left.
    assert {path.suffix for path in (tmp_path / "cache/bevelmap").iterdir()} == {".kernel"}
    assert _ended(start())[0] == []


@pytest.mark.costly
def test_a_process_that_was_killed_holds_nothing_up(start, tmp_path):
    process = start()
    folder = tmp_path / "cache/bevelmap"
    while not list(folder.glob("*.lock")):
        assert process.poll() is None
        time.sleep(0.001)
    process.kill()
    process.wait()
    compiled, _ = _ended(start())
    assert 1 <= len(compiled) <= 6 and len(list(folder.glob("*.kernel"))) == 6


def test_waiting_for_another_process_has_an_end(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    store = KernelStore()
    with (store.folder / "x.kernel.lock").open("w") as other:
        lock_descriptor(other.fileno())
        for patience in (0.0, 0.1):
            with store.claimed("x.kernel", patience) as mine:
                assert not mine
        with store.claimed("y.kernel", 0.0) as mine:
            assert mine
    with store.claimed("x.kernel", 0.0) as mine:
        assert mine
    assert list(store.folder.iterdir()) == []


def test_kernels_by_name():
    whole = [correctors._newton, correctors._broyden, correctors.correct_all]
    assert kernels_of(["solver.continuation.correctors"]) == whole
    assert (
        kernels_of(["solver.continuation.correctors._broyden", "solver.continuation.correctors"])[0].__name__
        == "_broyden"
    )
    assert kernels_of(["solver.continuation.correctors"] * 2) == whole
    assert kernels_of(["solver.enumeration.interval", "solver.enumeration.interval.add"]) == [add]
    with pytest.raises(ModuleNotFoundError):
        kernels_of(["solver.continuation.no_such_module"])


def test_what_is_said():
    said = []
    warm([correctors._newton, correctors._broyden], lambda *report: said.append(report))
    module = "solver.continuation.correctors."
    assert said == [(f"{module}_newton", 0, 2), (f"{module}_broyden", 1, 2), ("", 2, 2)]
    warm([])
