"""The command line for real: processes, a LocalCluster, files, signals."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from pipeline import store
from solver import domain_label, sweep_row
from tests.conftest import published
from tests.pipeline.faults.runs import complete
from tests.pipeline.planes import contents

PLANES = {"omega_b": "b", "omega_alpha": "alpha", "omega_fe": "f_e", "omega_fpm": "f_pm"}
SMALL = ["plane.sweep.num=80", "plane.parameter.num=18"]


def run(folder: Path, *arguments: str, **options) -> subprocess.CompletedProcess:
    command = [sys.executable, "-W", "error", "-m", "pipeline", *arguments]
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, env=environment, **options)


@pytest.fixture(scope="module")
def planes(tmp_path_factory):
    """All four planes by one command, tables included."""
    folder = tmp_path_factory.mktemp("planes")
    result = run(folder, "-m", f"plane={','.join(PLANES)}", "stages=[sweep,boundaries,figures,tables]", *SMALL)
    assert result.returncode == 0, result.stderr
    return folder, result


def test_all_four_planes(planes):
    folder, result = planes
    assert result.stderr == ""
    for name, parameter in PLANES.items():
        plane = xr.open_zarr(folder / f"outputs/store/{name}.zarr").load()
        assert plane.sizes[parameter] == 18 and plane.sizes["omega"] == 80
        assert np.all(plane.status == store.COMPLETE) and np.all(plane.n_stable >= 1)
        value = float(plane[parameter][11])
        row = sweep_row(published(**{parameter: value}), "omega", plane.omega.values)
        np.testing.assert_array_equal(plane.domain[11], row.domain)
        np.testing.assert_array_equal(plane["mean"][11, :, : row.mean.shape[1]], row.mean)
        assert "1/0" in {domain_label(int(code)) for code in np.unique(plane.domain)}
        for figure in ("map", "curves", "backbone"):
            for kind in ("png", "pdf"):
                assert (folder / f"outputs/figures/{name}/{figure}.{kind}").stat().st_size > 5000
        (log,) = folder.glob(f"outputs/runs/{name}/*/run.log")
        assert "18 rows" in log.read_text() and (log.parent / "config.yaml").is_file()
    for number in (1, 2, 3):
        for kind in ("csv", "md", "tex"):
            assert (folder / f"outputs/tables/table{number}.{kind}").stat().st_size > 100


def test_all_four_planes_share_one_cluster(planes):
    folder, _ = planes
    workers = [set(re.findall(r"info batch: .* on (tcp://\S+),", log.read_text())) for log in folder.glob("outputs/runs/*/*/run.log")]
    # Four clusters of two would have had eight addresses.
    assert len(workers) == 4 and all(workers) and len(set.union(*workers)) <= 2


def test_nothing_else_is_written(planes):
    folder, _ = planes
    assert [path.name for path in folder.iterdir()] == ["outputs"]
    assert sorted(path.name for path in (folder / "outputs").iterdir()) == ["boundaries", "figures", "runs", "store", "tables"]


def test_a_second_run_finds_the_work_done(planes):
    folder, _ = planes
    before = contents(folder / "outputs/store/omega_b.zarr")
    stamp = os.stat(folder / "outputs/store/omega_b.zarr/mean/c/0/0/0").st_mtime_ns
    result = run(folder, "plane=omega_b", *SMALL)
    assert result.returncode == 0 and "nothing to do" in result.stdout
    assert os.stat(folder / "outputs/store/omega_b.zarr/mean/c/0/0/0").st_mtime_ns == stamp
    assert before.keys() == contents(folder / "outputs/store/omega_b.zarr").keys()


def test_another_configuration_is_refused_and_overwrite_replaces(planes):
    folder, _ = planes
    result = run(folder, "plane=omega_fpm", "gear.b=0.5", "stages=[sweep]", "cluster=none", *SMALL)
    assert result.returncode == 2 and "gear.b: stored 1.0, asked 0.5" in result.stderr
    assert len(result.stderr.splitlines()) == 1
    result = run(folder, "plane=omega_fpm", "gear.b=0.5", "stages=[sweep]", "cluster=none", "store.overwrite=true",
                 *SMALL)  # fmt: skip
    assert result.returncode == 0, result.stderr
    plane = xr.open_zarr(folder / "outputs/store/omega_fpm.zarr")
    assert "b: 0.5" in plane.attrs["configuration"] and np.all(plane.status == store.COMPLETE)


def test_multirun_goes_on_after_a_plane_that_is_refused(tmp_path):
    (tmp_path / "outputs/store").mkdir(parents=True)
    (tmp_path / "outputs/store/omega_b.zarr").write_text("not a store")
    result = run(tmp_path, "-m", "plane=omega_b,omega_fe", "stages=[sweep]", "cluster=none", *SMALL)
    assert result.returncode == 2 and "omega_b.zarr is not allowed" in result.stderr
    assert np.all(store.statuses(tmp_path / "outputs/store/omega_fe.zarr") == store.COMPLETE)
    assert (tmp_path / "outputs/store/omega_b.zarr").read_text() == "not a store"


def test_failed_rows_give_status_1_and_a_summary(tmp_path):
    small = ["plane.sweep.num=80", "plane.parameter.num=8", "stages=[sweep]", "cluster=none", "store.max_solutions=2"]
    result = run(tmp_path, "plane=omega_fe", *small)
    assert result.returncode == 1 and "rows failed" in result.stdout
    assert "more than store.max_solutions = 2" in result.stdout
    status = store.statuses(tmp_path / "outputs/store/omega_fe.zarr")
    assert set(status) == {store.COMPLETE, store.FAILED}


def test_a_missing_plane_is_named_with_its_command(tmp_path):
    result = run(tmp_path, "stages=[tables]", "quality=draft")
    assert result.returncode == 2 and len(result.stderr.splitlines()) == 1
    for plane in ("omega_b", "omega_alpha", "omega_fpm"):
        assert f"python -m pipeline plane={plane} quality=draft" in result.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGKILL])
def test_an_interrupted_run_is_continued_to_the_same_bits(tmp_path, sent):
    arguments = ["plane=omega_alpha", "stages=[sweep]", "plane.sweep.num=200", "plane.parameter.num=240"]
    path = tmp_path / "outputs/store/omega_alpha.zarr"
    process = subprocess.Popen(
        [sys.executable, "-m", "pipeline", *arguments], cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True, start_new_session=True, env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])},
    )  # fmt: skip
    deadline = time.monotonic() + 120.0
    while complete(path) == 0 and process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.01)
    os.killpg(process.pid, sent)
    _, said = process.communicate(timeout=60)
    partly = store.statuses(path)
    assert 0 < np.sum(partly == store.COMPLETE) < 240
    if sent is signal.SIGINT:
        assert process.returncode == 130
        assert said.splitlines() == [
            "error: interrupted; what is stored is kept, and the same command goes on from there"
        ]
    result = run(tmp_path, *arguments)
    assert result.returncode == 0 and "continues" in result.stdout, result.stderr
    whole = tmp_path / "whole"
    whole.mkdir()
    assert run(whole, *arguments, "cluster=none").returncode == 0
    expected = contents(whole / "outputs/store/omega_alpha.zarr")
    for name, values in contents(path).items():
        same = values.tolist() == expected[name].tolist() if values.dtype.kind == "T" else (
            values.tobytes() == expected[name].tobytes()
        )  # fmt: skip
        assert same, name


def test_broyden_gives_the_same_plane(tmp_path):
    small = ["plane.sweep.num=60", "plane.parameter.num=9", "stages=[sweep]", "cluster=none"]
    for name in ("newton", "broyden"):
        result = run(tmp_path, "plane=omega_alpha", *small, f"solver.corrector={name}", f"store.name={name}")
        assert result.returncode == 0, result.stderr
    newton, broyden = (contents(tmp_path / f"outputs/store/{name}.zarr") for name in ("newton", "broyden"))
    for array in ("n_solutions", "n_stable", "domain", "stable", "impact", "open"):
        np.testing.assert_array_equal(newton[array], broyden[array])
    for array in ("mean", "amplitude"):
        np.testing.assert_allclose(newton[array], broyden[array], rtol=0, atol=1e-8)
