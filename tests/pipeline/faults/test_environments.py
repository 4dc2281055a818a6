"""What is set around the program: variables and configuration files of libraries that stand in its way."""

import os
import subprocess
import sys

import dask
import distributed  # noqa: F401  (its defaults are there before they are changed)
import pytest

from pipeline.config.schema import Cluster
from pipeline.errors import ConfigurationError
from pipeline.run.cluster_settings import check_cluster
from pipeline.run.libraries import drawing_into_files, failed_import, with_own_dask
from pipeline.run.workforce import Workforce
from tests.pipeline.faults.runs import ROOT
from tests.pipeline.planes import cluster, small_plan, small_store


def _run(folder, *words, python=(), **variables) -> subprocess.CompletedProcess:
    environment = {**os.environ, "PYTHONPATH": str(ROOT), **variables}
    command = [sys.executable, *python, "-m", "pipeline", *words]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, env=environment, timeout=200)


def _one_line(result: subprocess.CompletedProcess) -> str:
    assert result.returncode == 2 and len(result.stderr.splitlines()) == 1, result.stderr
    return result.stderr


def test_python_without_assertions_is_refused(tmp_path):
    assert "python -O" in _one_line(_run(tmp_path, "stages=[sweep]", python=["-O"]))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.costly
@pytest.mark.parametrize("where", ["cluster=none", "cluster=local"])
def test_a_variable_that_ends_the_import_of_a_library_is_one_line(tmp_path, where):
    result = _run(
        tmp_path, "plane.sweep.num=9", "plane.parameter.num=2", "stages=[sweep]", where, NUMBA_NUM_THREADS="0"
    )
    assert "NUMBA_" in _one_line(result)


def test_only_an_error_of_an_import_is_one_of_a_library(tmp_path, monkeypatch):
    (tmp_path / "unloadable.py").write_text("int('x')")
    monkeypatch.syspath_prepend(tmp_path)
    found = []
    for code in ("import unloadable", "import json; json.loads('x')", "import no_such_library", "int('x')"):
        try:
            exec(code, {"__name__": "__main__"})
        except Exception as error:
            found.append(failed_import(error))
    assert "unloadable's own configuration" in str(found[0]) and found[1:] == [None, None, None]


@pytest.mark.costly
def test_a_display_that_is_not_there_is_no_matter(tmp_path, monkeypatch):
    (tmp_path / "outputs/store").mkdir(parents=True)
    small_store(tmp_path / "outputs/store/omega_fe.zarr", small_plan(columns=9, rows=3))
    words = ["stages=[figures]", "figures.formats=[png]", "figures.dpi=30", "figures.curves=[0.2]", "cluster=none"]
    result = _run(tmp_path, *words, MPLBACKEND="foo", SOURCE_DATE_EPOCH="yesterday")
    assert (result.returncode, result.stderr) == (0, "")
    assert (tmp_path / "outputs/figures/omega_fe/map.png").exists()
    # The variable is somebody else's: it is there again afterwards.
    monkeypatch.setenv("MPLBACKEND", "foo")
    with drawing_into_files():
        assert "MPLBACKEND" not in os.environ
    assert os.environ["MPLBACKEND"] == "foo"


@pytest.mark.costly
@pytest.mark.parametrize(
    "settings",
    [
        *(
            pytest.param({name: value}, marks=pytest.mark.slow)
            for name, value in (
                ("distributed.comm.timeouts.connect", "foo"),
                ("distributed.scheduler.worker-ttl", "foo"),
                ("distributed.nanny.pre-spawn-environ", 3),
            )
        ),
        {"distributed.worker.multiprocessing-method": "foo", "temporary-directory": "/nowhere/at/all"},
    ],
    ids=lambda settings: next(iter(settings)),
)
def test_workers_of_this_machine_are_started_with_dasks_own_defaults(settings):
    with dask.config.set(settings), Workforce(cluster("local", workers=1)) as workforce:
        assert [result for _, result in workforce.run(pow, [(2, 3)])] == [8]
        assert dask.config.get("distributed.comm.timeouts.connect") == "30s"
    with dask.config.set({"distributed.comm.timeouts.connect": "foo"}):
        with with_own_dask():
            assert dask.config.get("distributed.comm.timeouts.connect") == "30s"
        assert dask.config.get("distributed.comm.timeouts.connect") == "foo"


def test_a_scheduler_is_reached_as_dask_is_configured_or_that_is_said():
    config: Cluster = cluster("scheduler", address="tcp://127.0.0.1:9", timeout=1.0)
    check_cluster(config)
    with (
        dask.config.set({"distributed.client.heartbeat": "foo"}),
        Workforce(config) as workforce,
        pytest.raises(ConfigurationError) as caught,
    ):
        workforce.start()
    assert "dask" in str(caught.value) and "foo" in str(caught.value)


@pytest.mark.costly
def test_configuration_that_dask_cannot_read_is_said(tmp_path):
    (tmp_path / "bad").mkdir()
    (tmp_path / "bad/x.yaml").write_text("a: [1\n b: }")
    words = ["stages=[sweep]", "plane.sweep.num=9", "plane.parameter.num=3", "cluster.workers=2"]
    result = _run(tmp_path, *words, DASK_CONFIG=str(tmp_path / "bad"))
    assert "dask" in _one_line(result)
    assert [path.name for path in tmp_path.iterdir()] == ["bad"]
