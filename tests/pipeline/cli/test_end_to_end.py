"""The command line for real: processes, a LocalCluster, files, signals."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from pipeline import store
from pipeline.__main__ import main
from solver import domain_label, sweep_row
from tests.conftest import published
from tests.pipeline.planes import assert_same_contents, contents

PLANES = {"omega_b": "b", "omega_alpha": "alpha", "omega_fe": "f_e", "omega_fpm": "f_pm"}
SMALL = ["plane.sweep.num=40", "plane.parameter.num=5", "figures.formats=[png]", "figures.dpi=30"]


def run(folder: Path, *arguments: str, **options) -> subprocess.CompletedProcess:
    command = [sys.executable, "-W", "error", "-m", "pipeline", *arguments]
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[3])}
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, env=environment, **options)


def here(folder: Path, *arguments: str) -> int:
    """Exit status of a run in this process."""
    return main([*arguments, "cluster=none", f"output.root={folder / 'outputs'}"])


@pytest.fixture(scope="module")
def planes(tmp_path_factory):
    """All four planes by one command, tables included."""
    folder = tmp_path_factory.mktemp("planes")
    result = run(folder, "-m", f"plane={','.join(PLANES)}", "stages=[sweep,tables]", "cluster.workers=1", *SMALL)
    assert result.returncode == 0, result.stderr
    return folder, result


def test_all_four_planes(planes):
    folder, result = planes
    assert result.stderr == ""
    for name, parameter in PLANES.items():
        plane = xr.open_zarr(folder / f"outputs/store/{name}.zarr").load()
        assert plane.sizes[parameter] == 5 and plane.sizes["omega"] == 40
        assert np.all(plane.status == store.COMPLETE) and np.all(plane.n_stable >= 1)
        value = float(plane[parameter][3])
        row = sweep_row(published(**{parameter: value}), "omega", plane.omega.values)
        np.testing.assert_array_equal(plane.domain[3], row.domain)
        np.testing.assert_array_equal(plane["mean"][3, :, : row.mean.shape[1]], row.mean)
        assert "1/0" in {domain_label(int(code)) for code in np.unique(plane.domain)}
        (log,) = folder.glob(f"outputs/runs/{name}/*/run.log")
        assert "5 rows" in log.read_text() and (log.parent / "config.yaml").is_file()
    for number in (1, 2, 3):
        for kind in ("csv", "md", "tex"):
            assert (folder / f"outputs/tables/table{number}.{kind}").stat().st_size > 100


def test_all_four_planes_share_one_cluster(planes):
    folder, _ = planes
    logs = [log.read_text() for log in folder.glob("outputs/runs/*/*/run.log")]
    workers = [set(re.findall(r"info batch: .* on (tls://\S+),", log)) for log in logs]
    # Four clusters would have had four addresses.
    assert len(workers) == 4 and all(workers) and len(set.union(*workers)) == 1


def test_nothing_else_is_written(planes):
    folder, _ = planes
    assert [path.name for path in folder.iterdir()] == ["outputs"]
    made = sorted(path.name for path in (folder / "outputs").iterdir())
    assert made == ["runs", "store", "tables"]


@pytest.mark.costly
def test_a_second_run_finds_the_work_done_and_draws(planes, capsys):
    folder, _ = planes
    before = contents(folder / "outputs/store/omega_b.zarr")
    stamp = (folder / "outputs/store/omega_b.zarr/mean/c/0/0/0").stat().st_mtime_ns
    assert here(folder, "plane=omega_b", *SMALL) == 0
    assert capsys.readouterr().out.count("nothing to do") == 1
    assert (folder / "outputs/store/omega_b.zarr/mean/c/0/0/0").stat().st_mtime_ns == stamp
    after = contents(folder / "outputs/store/omega_b.zarr")
    assert_same_contents({name: after[name] for name in before}, before)
    for figure in ("map", "curves", "backbone"):
        assert (folder / f"outputs/figures/omega_b/{figure}.png").stat().st_size > 2000


def test_another_configuration_is_refused_and_overwrite_replaces(planes, capsys):
    folder, _ = planes
    other = ["plane=omega_fpm", "gear.b=0.5", "stages=[sweep]", "store.name=omega_fpm", *SMALL]
    assert here(folder, *other) == 2
    said = capsys.readouterr().err
    assert "gear.b: stored 1.0, asked 0.5" in said and len(said.splitlines()) == 1
    assert "store.overwrite=true" in said and "gear.b=0.5" in said
    assert here(folder, *other, "store.overwrite=true") == 0
    plane = xr.open_zarr(folder / "outputs/store/omega_fpm.zarr")
    assert "b: 0.5" in plane.attrs["configuration"] and np.all(plane.status == store.COMPLETE)


def test_multirun_goes_on_after_a_plane_that_is_refused(tmp_path, capsys):
    (tmp_path / "outputs/store").mkdir(parents=True)
    (tmp_path / "outputs/store/omega_b.zarr").write_text("not a store")
    assert here(tmp_path, "-m", "plane=omega_b,omega_fe", "stages=[sweep]", *SMALL) == 2
    assert "omega_b.zarr is not allowed" in capsys.readouterr().err
    assert np.all(store.statuses(tmp_path / "outputs/store/omega_fe.zarr") == store.COMPLETE)
    assert (tmp_path / "outputs/store/omega_b.zarr").read_text() == "not a store"


def test_failed_rows_give_status_1_and_a_summary(tmp_path, capsys):
    small = ["plane.sweep.num=80", "plane.parameter.num=8", "stages=[sweep]", "store.max_solutions=2"]
    assert here(tmp_path, "plane=omega_fe", *small) == 1
    said = capsys.readouterr().out
    assert "rows failed" in said and "more than store.max_solutions = 2" in said
    status = store.statuses(tmp_path / "outputs/store/omega_fe.zarr")
    assert set(status) == {store.COMPLETE, store.FAILED}


@pytest.mark.costly
def test_a_missing_plane_is_named_with_its_command(tmp_path):
    result = run(tmp_path, "stages=[tables]", "quality=draft")
    assert result.returncode == 2 and len(result.stderr.splitlines()) == 1
    for plane in ("omega_b", "omega_alpha", "omega_fpm"):
        assert f"python -m pipeline plane={plane} quality=draft" in result.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.costly
def test_broyden_gives_the_same_plane(tmp_path):
    small = ["plane.sweep.num=60", "plane.parameter.num=6", "stages=[sweep]"]
    for name in ("newton", "broyden"):
        assert here(tmp_path, "plane=omega_alpha", *small, f"solver.corrector={name}", f"store.name={name}") == 0
    newton, broyden = (contents(tmp_path / f"outputs/store/{name}.zarr") for name in ("newton", "broyden"))
    for array in ("n_solutions", "n_stable", "domain", "stable", "impact", "open"):
        np.testing.assert_array_equal(newton[array], broyden[array])
    for array in ("mean", "amplitude"):
        np.testing.assert_allclose(newton[array], broyden[array], rtol=0, atol=1e-8)
