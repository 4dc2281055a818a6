"""The stage with the real solver, on small planes: the same bytes everywhere, volumes, places, figures."""

import csv
import os
import shutil
import subprocess
import sys

import numpy as np
import pytest
import zarr

import pipeline
from pipeline import figures, store
from pipeline.__main__ import main
from pipeline.analysis.attractors.credibility import Credibility
from pipeline.errors import StoreError
from pipeline.store import groups
from solver.timedomain import AttractorKind as Kind
from tests.made_once import made_once
from tests.pipeline.planes import assert_same_contents, contents
from tests.pipeline.schedulers import ROOT, wait_until

SMALL = ["plane=omega_fe", "plane.sweep.num=14", "plane.parameter.num=4", "plane.sweep.min=0.5", "plane.sweep.max=1.4"]
PNG = ["figures.formats=[png]", "figures.dpi=30"]
SPUR = [
    "gear=consistent",
    "gear.translation_coupling=0",
    "gear.rotation_coupling=1",
    "gear.variation.rotation=1",
    "gear.xi_mesh=.05",
    "gear.alpha=.2",
    "gear.alpha_phase=3.141592653589793",
    "gear.alpha_harmonics=[[.1,3.141592653589793],[.05,3.141592653589793]]",
    "gear.f_e=.01",
    "gear.f_e_harmonics=[[.004,0.0],[.002,0.0]]",
    "plane.sweep.num=9",
    "plane.parameter.num=4",
    "plane.sweep.min=0.1",
    "plane.sweep.max=2.5",
    "plane.parameter.name=f_pm",
    "plane.parameter.min=0.02",
    "plane.parameter.max=0.5",
]


def run(root, *words):
    return main([*words, "store.name=plane", f"output.root={root}"])


@pytest.fixture(scope="module")
def made():
    """A plane with attractors, computed in this process; not to be changed."""

    def make(folder):
        assert run(folder, *SMALL, "cluster=none", "stages=[sweep,boundaries,attractors]") == 0

    return made_once("attractors-omega_fe", make)


@pytest.fixture
def copy(made, tmp_path):
    shutil.copytree(made / "store", tmp_path / "store")
    return tmp_path


def test_what_is_known_of_the_published_gear(made):
    """docs/physics.md, section 8.5: of several motions that order 1 has at both resonances, one is none."""
    plane = pipeline.open_plane(made / "store/plane.zarr")
    found = plane.tree["attractors"]
    assert found.kind.dims == ("f_e", "omega", "attractor") and found.attrs["starts"] == 4
    quiet = plane.attractors_at(omega=1.0, f_e=0.05)
    assert quiet.kind.values.tolist() == [1] and quiet.impact.values.tolist() == [0] and float(quiet.share[0]) == 1.0
    assert np.any((found.kind.values == Kind.PERIOD_2) & (found.impact.values == 1))
    judged = found.credibility.values
    assert np.sum(judged == Credibility.CONFIRMED) > judged.size / 2
    assert Credibility.NOT_A_PERIOD_1_MOTION in judged
    lone = found.n_attractors.values == 1
    np.testing.assert_array_equal(
        np.sum((found.kind.values > 0) & (found.kind.values <= Kind.CHAOTIC), axis=-1) == 1, lone
    )
    # What a motion of the map leads to is there.
    leads, stable = found.motion.values, plane.tree.stable.values == 1
    assert np.all(leads[~stable] == -1)
    told = found.label.attrs["labels"]
    assert told[int(found.label.sel(omega=1.0, f_e=0.05, method="nearest"))] == "1T/0"


def test_shares_and_hysteresis_of_an_opened_plane(made):
    plane = pipeline.open_plane(made / "store/plane.zarr")
    found, total = plane.tree["attractors"], 0
    for kind in (
        "1T",
        "2T",
        "3T",
        "4T",
        "5T",
        "6T",
        "7T",
        "8T",
        "nT",
        "quasi-periodic",
        "chaotic",
        "unbounded",
        "unsettled",
    ):
        total = total + plane.basin_share(kind).hits
    assert np.all(total == found.starts)
    assert plane.hysteresis().dims == ("f_e", "omega")
    with pytest.raises(StoreError, match="attractors"):
        pipeline.open_plane(_without_attractors(made)).hysteresis()


def _without_attractors(made):
    def make(folder):
        shutil.copytree(made / "store/plane.zarr", folder / "plane.zarr")
        groups.remove_added(folder / "plane.zarr")

    return made_once("attractors-none", make) / "plane.zarr"


@pytest.mark.costly
def test_workers_make_the_same_bytes(made, copy):
    path = copy / "store/plane.zarr"
    groups.remove_group(path, "attractors")
    assert run(copy, *SMALL, "cluster=local", "cluster.workers=2", "stages=[attractors]") == 0
    assert_same_contents(contents(path), contents(made / "store/plane.zarr"))
    for name in ("plane.csv", "plane.md", "plane-hysteresis.csv"):
        assert (copy / "attractors" / name).read_bytes() == (made / "attractors" / name).read_bytes()


@pytest.mark.costly
def test_a_run_that_is_killed_is_gone_on_with(made, copy):
    """A process of its own, ended by the system after its first block."""
    path = copy / "store/plane.zarr"
    groups.remove_group(path, "attractors")
    words = [*SMALL, "store.name=plane", f"output.root={copy}", "cluster=none", "stages=[attractors]"]
    process = subprocess.Popen(
        [sys.executable, "-m", "pipeline", *words],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        wait_until(
            lambda: any(groups.unfinished(path, "attractors").place.glob("packed/c/*")) or process.poll() is not None
        )
        assert process.poll() is None
    finally:
        process.kill()
        process.wait(30)
    assert not (path / "attractors").exists() and store.find_damage(path) == []
    assert run(copy, *SMALL, "cluster=none", "stages=[attractors]") == 0
    assert_same_contents(contents(path), contents(made / "store/plane.zarr"))


@pytest.mark.costly
def test_a_layer_of_a_volume_has_the_attractors_of_its_plane(tmp_path):
    sizes = ["plane=omega_b_fe", "plane.sweep.num=5", "plane.parameter.num=3", "plane.parameter2.num=2", "cluster=none"]
    words = [*sizes, "store.name=volume", f"output.root={tmp_path}", "attractors.starts=2"]
    assert main([*words, "stages=[sweep,attractors]"]) == 0
    volume = zarr.open_group(tmp_path / "store/volume.zarr", mode="r")
    value = float(volume["f_e"][1])
    assert main([*words, f"plane.layer={value}", "stages=[attractors]"]) == 0
    (layer,) = (tmp_path / "store").glob("volume-*.zarr")
    found = zarr.open_group(layer, mode="r")["attractors"]
    for name in ("kind", "impact", "mean", "hits", "state", "upwards", "seen", "credibility", "motion", "box"):
        assert volume["attractors"][name][1].tobytes() == found[name][...].tobytes(), name
    assert store.find_damage(tmp_path / "store/volume.zarr") == []


@pytest.mark.costly
def test_places_of_the_spur_pair(tmp_path):
    """The basin of the 2T motion beside 1T: about 46 % of states uniform in lambda 0.5 ... 2, speed -1 ... 1."""
    words = [*SPUR, "plane=omega_fe", "cluster=none", *PNG]
    assert run(tmp_path, *words, "stages=[sweep]") == 0
    words += ["attractors.points=[[1.8056604,0.1061538]]", "attractors.box=[[0.5,2],[-1,1]]", "attractors.slice=12"]
    assert run(tmp_path, *words, "stages=[attractors,figures]", "attractors.starts=300") == 0
    found = pipeline.open_plane(tmp_path / "store/plane.zarr").tree["places"]
    kinds = found.kind.values[0]
    (two,), (one,) = np.flatnonzero(kinds == Kind.PERIOD_2), np.flatnonzero(kinds == Kind.PERIOD_1)
    assert np.count_nonzero(kinds) == 2
    assert float(found.share_low[0, two]) < 0.46 < float(found.share_high[0, two])
    assert float(found.lowest[0, two]) == pytest.approx(0.9021, abs=1e-3)
    assert float(found.highest[0, two]) == pytest.approx(1.2978, abs=1e-3)
    assert set(np.unique(found["slice"].values)) == {one, two}
    # The slice is of the same box: it has about the same share.
    assert np.mean(found["slice"].values == two) == pytest.approx(0.46, abs=0.12)
    with (tmp_path / "attractors/plane-places.csv").open() as file:
        lines = list(csv.DictReader(file))
    assert [line["attractor"][:2] for line in lines] == [f"{kind}T" for kind in kinds[kinds > 0]]
    assert (tmp_path / "figures/plane/basins.png").stat().st_size > 4_000
    assert store.find_damage(tmp_path / "store/plane.zarr") == []


@pytest.mark.costly
def test_figures_are_drawn_and_the_same_again(made, tmp_path):
    names = ["attractors", "verification"]
    one, two = (
        figures.draw(made / "store/plane.zarr", tmp_path / folder, None, ["png"], 30, only=names)
        for folder in ("one", "two")
    )
    assert [path.stem for path in one] == names and [path.read_bytes() for path in one] == [
        path.read_bytes() for path in two
    ]
