"""What ends a run from outside, and who does not read what it says: one line at most, the lock let go, nothing lost."""

import itertools
import os
import signal
import subprocess
import sys

import pytest

from pipeline import store
from pipeline.__main__ import main
from tests.conftest import slow_but
from tests.pipeline.faults.runs import COMMAND, INJECTED, KEPT, ROOT, ROWS, complete, continued, same, start, until

#: One worker is enough to be told.
_CLUSTERS = {"local": ("cluster=local", "cluster.workers=1"), "none": ("cluster=none",)}
_ENDED = list(itertools.product([signal.SIGTERM, signal.SIGHUP], ["local", "none"]))


@pytest.mark.costly
@pytest.mark.parametrize(("number", "cluster"), slow_but([_ENDED[0], _ENDED[3]], _ENDED))
def test_a_signal_that_ends_a_run_is_one_line(number, cluster, tmp_path, undisturbed, capsys):
    # Slow enough that it is not done before it is told.
    environment = {"PYTHONPATH": str(INJECTED), "BEVELMAP_TEST_FAULT": "slow"}
    run = start(tmp_path, *_CLUSTERS[cluster], environment=environment)
    until(run, 3)
    # A terminal that is closed, or a scheduler of jobs, tells all processes; `kill` tells one.
    os.killpg(run.process.pid, number) if number == signal.SIGHUP else run.process.send_signal(number)
    run.end()
    assert (run.code, run.err) == (128 + number, f"error: interrupted by {number.name}{KEPT}\n")
    assert 0 < complete(run.path) < ROWS and not list(run.path.parent.glob(".*.lock"))
    assert "sweep: continues: " in continued(tmp_path, capsys)
    same(run.path, undisturbed)


_SPUN = [(signal.SIGINT, "local"), (signal.SIGTERM, "none"), (signal.SIGINT, "none")]


@pytest.mark.costly
@pytest.mark.parametrize(("number", "cluster"), slow_but(_SPUN[:2], _SPUN))
def test_a_compiled_loop_without_end_is_interrupted(number, cluster, tmp_path, undisturbed, capsys):
    """Python itself does not see a signal until the loop is over."""
    environment = {"PYTHONPATH": str(INJECTED), "BEVELMAP_TEST_FAULT": "spin"}
    run = start(tmp_path, *_CLUSTERS[cluster], environment=environment)
    until(run, ROWS // 2)
    os.killpg(run.process.pid, number)
    run.end(60.0)
    name = "" if number == signal.SIGINT else f" by {number.name}"
    assert (run.code, run.err) == (128 + number, f"error: interrupted{name}{KEPT}\n")
    assert not list(run.path.parent.glob(".*.lock"))
    assert "sweep: continues: " in continued(tmp_path, capsys)
    same(run.path, undisturbed)


def test_a_hangup_that_is_ignored_stays_ignored(tmp_path):
    """As below nohup."""
    code = (
        "import os, signal\nfrom pipeline.cli.process import ended_by_signals\n"
        "signal.signal(signal.SIGHUP, signal.SIG_IGN)\n"
        "with ended_by_signals(print):\n    os.kill(os.getpid(), signal.SIGHUP)\nprint('on')"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (0, "on\n", "")


def test_a_run_that_ends_by_itself_after_another_handler_heard_is_not_ended_once_more():
    """A library may take a signal over, and end what it does in its own way."""
    code = (
        "import os, signal\nfrom pipeline.cli.process import ended_by_signals\n"
        "with ended_by_signals(print):\n    signal.signal(signal.SIGINT, lambda *_: None)\n"
        "    os.kill(os.getpid(), signal.SIGINT)\nprint('ended')"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (0, "ended\n", "")


_CLOSED = [("| head -1",), ("| true",), (">&-",), ("2>&-",), (">&- 2>&-",)]


@pytest.mark.costly
@pytest.mark.parametrize(("closed",), slow_but([_CLOSED[0], _CLOSED[-1]], _CLOSED))
def test_a_run_that_nobody_reads_completes(closed, tmp_path, undisturbed):
    # A worker inherits what the run writes to.
    workers = "cluster.workers=1" if closed == _CLOSED[-1][0] else "cluster=none"
    words = " ".join([sys.executable, "-W", "error", "-m", "pipeline", *COMMAND, workers])
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    shell = ["bash", "-c", f"{words} {closed}; exit ${{PIPESTATUS[0]}}"]
    done = subprocess.run(shell, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stderr) == (0, "")
    path = tmp_path / "outputs/store/plane.zarr"
    assert store.find_damage(path) == []
    same(path, undisturbed)


@pytest.mark.parametrize("option", ["--help", "--cfg", "--shell-completion=bash"])
@pytest.mark.parametrize("closed", ["| true", ">&-"])
def test_a_text_that_nobody_reads_is_no_error(option, closed, tmp_path):
    shell = ["bash", "-c", f"{sys.executable} -W error -m pipeline {option} {closed}; exit ${{PIPESTATUS[0]}}"]
    done = subprocess.run(shell, cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, "")


def test_several_planes_of_which_one_is_refused_say_which_were_run(tmp_path, capsys):
    """Exit status 2 alone would say that nothing was written."""
    size = ["plane.sweep.num=9", "plane.parameter.num=3", "stages=[sweep]", "cluster=none"]
    code = main([*size, f"output.root={tmp_path}", "-m", "plane=omega_fe,omega_b", "gear.b=0.5"])
    said = capsys.readouterr()
    assert code == 2 and "gear.b" in said.err and said.err.count("\n") == 1
    assert said.out.splitlines()[-1].startswith("note: 1 of 2 planes were run: omega_fe-b=0.5")
    assert sorted(path.name for path in (tmp_path / "store").iterdir()) == ["omega_fe-b=0.5.zarr", "study.csv"]
