"""Workers that would give other numbers: found out before they compute, named, and left out."""

import platform
import re
import shutil
import signal
import subprocess
import sys
from importlib.metadata import version

import numpy as np
import pytest

from pipeline import store
from pipeline.run.environment import (
    ARITHMETIC,
    differences,
    differences_of_scheduler,
    digest_of,
    facts,
    packages_of_scheduler,
)
from tests.pipeline.faults.runs import INJECTED, KEPT, ROOT, finished, same, start, until
from tests.pipeline.schedulers import Scheduler, there, wait_until


@pytest.fixture(scope="module")
def edited(tmp_path_factory):
    """A copy of the sources with the same version, in which amplitudes are a thousandth larger."""
    copy = tmp_path_factory.mktemp("edited")
    for name in ("solver", "pipeline", "conf"):
        # With what Python has made of the sources, which takes longer than all else that a worker begins with.
        shutil.copytree(ROOT / name, copy / name)
    (row,) = (copy / "solver").rglob("row.py")
    honest = row.read_text()
    row.write_text(honest.replace("amplitude = np.linalg.norm(", "amplitude = 1.001 * np.linalg.norm("))
    assert row.read_text() != honest
    return copy


@pytest.fixture(scope="module")
def started(tmp_path_factory):
    with Scheduler(tmp_path_factory.mktemp("scheduler")) as process:
        yield process


@pytest.fixture
def scheduler(started):
    """The scheduler of the module, without workers; those of a test end with it."""
    yield started
    started.end_workers()
    there(started, 0)


def arguments(scheduler):
    return "cluster=scheduler", f"cluster.address={scheduler.address}"


def refused(run):
    """Workers that a run says it does not use, with the reasons."""
    return dict(re.findall(r"^note: worker (\S+) is not used, its results would not be equal: (.*)$", run.out, re.M))


def used(run):
    """Workers that stored something, as the log of a run has them."""
    (log,) = (run.path.parents[1] / "runs/plane").glob("*/run.log")
    return set(re.findall(r" on (tcp://\S+), \d+ points", log.read_text()))


@pytest.mark.costly
def test_a_worker_with_edited_sources_is_named_and_computes_nothing(tmp_path, scheduler, edited, undisturbed):
    scheduler.add_worker()
    (equal,) = there(scheduler, 1)
    scheduler.add_worker(edited)
    (other,) = there(scheduler, 2) - {equal}
    run = finished(tmp_path, *arguments(scheduler))
    assert (run.code, run.err) == (0, ""), run.err
    assert list(refused(run)) == [other] and "row.py differs" in refused(run)[other]
    assert used(run) == {equal}
    same(run.path, undisturbed)


@pytest.mark.costly
def test_one_that_joins_during_the_run_is_found_out_too(tmp_path, scheduler, edited, undisturbed):
    first = scheduler.add_worker()
    (equal,) = there(scheduler, 1)
    run = start(tmp_path, *arguments(scheduler))
    until(run, 3)
    first.send_signal(signal.SIGSTOP)
    scheduler.add_worker(edited)
    there(scheduler, 2)
    (log,) = (run.path.parents[1] / "runs/plane").glob("*/run.log")
    wait_until(lambda: "is not used" in log.read_text())
    assert np.any(store.statuses(run.path) == store.PENDING)
    first.send_signal(signal.SIGCONT)
    run.end()
    assert (run.code, run.err) == (0, ""), run.err
    assert len(refused(run)) == 1 and equal not in refused(run) and used(run) == {equal}
    same(run.path, undisturbed)


@pytest.mark.costly
def test_where_no_other_is_left_the_run_ends(tmp_path, scheduler, edited):
    run = start(tmp_path, *arguments(scheduler))
    said = [run.process.stdout.readline()]
    while "waiting for workers" not in said[-1]:
        said.append(run.process.stdout.readline())
        assert said[-1], said
    scheduler.add_worker(edited)
    run.end()
    assert run.code == 1 and run.err.startswith("error: no worker computes as this program does (tcp://"), run.err
    assert "row.py differs" in run.err and run.err.endswith(f"{KEPT}\n") and run.err.count("\n") == 1
    assert np.all(store.statuses(run.path) == store.PENDING)


def _of_edited(edited, _):
    return {"sources": edited}, "solver/.*row.py differs"


def _in_version_1(folder, name):
    """A folder that, first on the path, makes a package one of version 1.0, as far as Python knows."""
    library = folder / f"{name}-1.0.dist-info"
    library.mkdir(parents=True)
    (library / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    return {"PYTHONPATH": str(folder)}


def _of_another_numpy(_, folder):
    return _in_version_1(folder, "numpy"), r"numpy is 1\.0 there and \S+ here"


def _without_bevelmap(_, __):
    return {"PYTHONPATH": str(INJECTED), "BEVELMAP_TEST_FAULT": "absent"}, "bevelmap cannot be used there .*No module"


@pytest.mark.costly
@pytest.mark.parametrize(
    "kind", [pytest.param(_of_edited, marks=pytest.mark.slow), _of_another_numpy, _without_bevelmap]
)
def test_where_all_workers_differ_nothing_is_written(kind, tmp_path, scheduler, edited):
    how, reason = kind(edited, tmp_path / "library")
    scheduler.add_worker(**how)
    (other,) = there(scheduler, 1)
    run = finished(tmp_path, *arguments(scheduler))
    assert run.code == 2 and run.err.count("\n") == 1 and re.search(reason, run.err), run.err
    assert other in run.err and f"cluster.address = {scheduler.address!r} is not allowed" in run.err
    assert list(refused(run)) == [other] and not (tmp_path / "outputs").exists()


@pytest.mark.costly
@pytest.mark.parametrize("name", ["numpy", "bevelmap", "distributed"])
def test_a_scheduler_in_another_version_is_refused_before_anything_is_written(name, tmp_path):
    (tmp_path / "scheduler").mkdir()
    with Scheduler(tmp_path / "scheduler", **_in_version_1(tmp_path / "library", name)) as scheduler:
        scheduler.add_worker()
        run = finished(tmp_path, *arguments(scheduler))
    assert run.code == 2 and run.err.count("\n") == 1 and f"{name} is 1.0 there and " in run.err, run.err
    assert f"cluster.address = {scheduler.address!r} is not allowed" in run.err
    assert not (tmp_path / "outputs").exists()


def test_versions_of_a_scheduler_are_compared_and_those_it_need_not_have_only_where_it_does():
    own = {name: version(name) for name in packages_of_scheduler()}
    python = platform.python_version()
    assert differences_of_scheduler(own, python) == differences_of_scheduler({**own, "numpy": None}, python) == ""
    assert differences_of_scheduler({**own, "bevelmap": None}, f"{python}.final.0") == ""
    assert differences_of_scheduler({**own, "dask": "1.0"}, python).startswith("dask is 1.0 there and ")
    assert "python is 3.1 there" in differences_of_scheduler(own, "3.1.4.final.0")


def test_versions_of_bevelmap_are_named_where_its_sources_differ_and_nowhere_else():
    own = facts()
    assert digest_of({**own, "bevelmap": "0.1"}) == digest_of(own)
    said = differences({**own, "bevelmap": "0.1", "solver/rows/row.py": "other"}, own)
    assert said.startswith("bevelmap is 0.1 there and ") and said.endswith("solver/rows/row.py differs")


def _facts_of_a_process(folder=ROOT, code="", **environment):
    """The facts of another process, as this one would see them, after some code has run there."""
    script = f"from pipeline.run.environment import facts\n{code}\nprint(facts())"
    command = [sys.executable, "-c", script]
    environment = {"PATH": "", "PYTHONPATH": str(folder), **environment}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return eval(done.stdout)


def test_processes_are_equal_whatever_their_threads_are():
    assert _facts_of_a_process() == _facts_of_a_process(OPENBLAS_NUM_THREADS="1", PYTHONHASHSEED="7") == facts()


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="the variables are those of such processors")
def test_a_processor_that_rounds_otherwise_is_told_by_what_it_computes():
    other = _facts_of_a_process(OPENBLAS_CORETYPE="Nehalem", NPY_DISABLE_CPU_FEATURES="X86_V3 X86_V4")
    own = facts()
    assert other[ARITHMETIC] != own[ARITHMETIC] and {**other, ARITHMETIC: own[ARITHMETIC]} == own
    assert "rounds otherwise" in differences(other, own)


@pytest.mark.costly
def test_a_file_of_the_solver_that_changes_after_it_was_loaded_is_told(tmp_path, edited):
    copy = tmp_path / "copy"
    shutil.copytree(edited, copy)
    (row,) = (copy / "solver").rglob("row.py")
    name = row.relative_to(copy).as_posix()
    edit = f"file = __import__('pathlib').Path({str(row)!r})\nfile.write_text(file.read_text() + '# more')"
    before, after = _facts_of_a_process(copy), _facts_of_a_process(copy, edit)
    assert differences(after, before) == f"{name} has changed since it was loaded"
    assert differences(_facts_of_a_process(copy), before) == f"{name} differs"
    row.unlink()
    assert differences(_facts_of_a_process(copy), before) == f"{name} is missing there"
