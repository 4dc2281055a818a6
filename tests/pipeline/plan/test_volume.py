"""Volumes: every layer is the plane of that layer, in one store with one more dimension."""

import json
import shutil

import numpy as np
import pytest
import xarray as xr
import zarr

from pipeline import store
from pipeline.__main__ import main
from pipeline.config.compose import compose
from pipeline.errors import StoreError
from pipeline.plan.plan import plan_of
from pipeline.plan.planning import plan
from pipeline.plane.regions import thresholds
from pipeline.plane.stored import read_stored
from pipeline.store.arrays import arrays_of
from tests.pipeline.planes import assert_same_contents, assert_same_values, contents, small_plan, small_store

ARGUMENTS = [
    "plane=omega_b_fe",
    "plane.sweep.num=30",
    "plane.parameter.num=8",
    "plane.parameter2.num=3",
    "cluster=none",
]


def run(folder, *arguments):
    return main([*ARGUMENTS, f"output.root={folder}", *arguments])


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """The outputs of one run of the stages sweep and figures."""
    folder = tmp_path_factory.mktemp("volume") / "outputs"
    assert run(folder, "stages=[sweep,figures]", "figures.formats=[png]", "figures.dpi=30") == 0
    return folder


@pytest.fixture(scope="module")
def volume(swept):
    return swept / "store/omega_b_fe.zarr"


def test_blocks_number_rows_through_and_stay_within_layers():
    planned = plan(compose(ARGUMENTS))
    assert [axis.name for axis in planned.axes] == ["omega", "b", "f_e"] and planned.rows == 24
    numbers = [number for block in planned.blocks for number in range(block.start, block.stop)]
    assert numbers == list(range(24))
    assert all(block.start // 8 == (block.stop - 1) // 8 for block in planned.blocks)
    seen = np.zeros((3, 8), int)
    for block in planned.blocks:
        seen[planned.place(block)] += 1
    assert np.all(seen == 1)
    row = planned.row(13)
    assert row == (planned.layer(1), planned.parameter.values[5])
    assert planned.row_text(13) == "row 13 (f_e = 0.25, b = 1.07714)"


def test_a_layer_is_the_plane_that_one_would_ask_for():
    planned = plan(compose(ARGUMENTS))
    plane = plan(compose(["plane=omega_b", "gear.f_e=0.25", "plane.sweep.num=30", "plane.parameter.num=8"]))
    assert planned.layer(1) == plane and planned.layer(1).fingerprint == plane.fingerprint
    assert plan_of(json.loads(json.dumps(planned.inputs))) == planned
    over = plan(
        compose(
            [
                "plane=b_fe",
                "plane.omega=null",
                "plane.parameter2={name:omega,min:0.5,max:0.7,num:3}",
                "plane.sweep.num=9",
                "plane.parameter.num=4",
            ]
        )
    )
    alone = plan(compose(["plane=b_fe", "plane.omega=0.6", "plane.sweep.num=9", "plane.parameter.num=4"]))
    assert over.layer(1) == alone


def test_schema_with_xarray_alone(volume):
    planned = store.read_plan(volume)
    here = xr.open_zarr(volume)
    assert here.domain.dims == ("f_e", "b", "omega") and here.amplitude.dims == ("f_e", "b", "omega", "solution")
    assert here.status.dims == here.message.dims == ("f_e", "b") and np.all(here.status == store.COMPLETE)
    for axis in planned.axes:
        np.testing.assert_array_equal(here[axis.name], axis.values)
    branches = xr.open_zarr(volume, group="branches")
    assert branches.amplitude.dims == branches.omega.dims == ("f_e", "b", "point")
    place = dict(f_e=0.25, b=0.7)
    points = branches.sel(place, method="nearest").load()
    top = float(np.nanmax(points.amplitude))
    assert top >= float(np.nanmax(here.sel(place, method="nearest").amplitude)) > 0.0
    tree = xr.open_datatree(volume, engine="zarr")
    assert tree["branches"]["mean"].dims == ("f_e", "b", "point")
    chunks = zarr.open_group(volume, mode="r")["mean"].chunks
    assert chunks == (1, planned.rows_per_block, 30, planned.max_solutions)


@pytest.mark.costly
def test_every_layer_is_bitwise_its_plane(volume, tmp_path):
    found, planned = contents(volume), store.read_plan(volume)
    for index, value in enumerate(planned.parameter2.values.tolist()):
        plane = ["plane=omega_b", f"gear.f_e={value!r}", *ARGUMENTS[1:3], "cluster=none", "stages=[sweep]"]
        assert main([*plane, f"output.root={tmp_path}", f"store.name=layer{index}"]) == 0
        expected = contents(tmp_path / f"store/layer{index}.zarr")
        for name in arrays_of(planned):
            assert_same_values(found[name][index], expected[name], name)


def test_an_interrupted_volume_continues(volume, tmp_path):
    planned = plan(compose(ARGUMENTS))
    path = small_store(tmp_path / "store/omega_b_fe.zarr", planned, planned.blocks[::2])
    assert store.pending_blocks(path, planned) == planned.blocks[1::2]
    assert run(tmp_path, "stages=[sweep]") == 0
    assert_same_contents(contents(path), contents(volume))


@pytest.mark.costly
def test_check_mends_a_chunk_of_one_layer(volume, tmp_path, capsys):
    path = tmp_path / "store/omega_b_fe.zarr"
    shutil.copytree(volume, path)
    assert run(tmp_path, "stages=[check]") == 0
    step = store.read_plan(path).rows_per_block
    (path / "mean/c/1/0/0/0").write_bytes(b"nothing")
    (path / "status/c/2/1").unlink()
    assert run(tmp_path, "stages=[check]") == 1
    said = capsys.readouterr()
    assert f"mean/c/1/0/0/0 does not agree with its checksum (rows 8-{7 + step})" in said.err
    assert f"status/c/2/1 is missing (rows {16 + step}-{15 + 2 * step})" in said.err
    assert f"2 damaged files, {2 * step} rows in 2 blocks" in said.out
    assert run(tmp_path, "stages=[check]", "check.repair=true") == 0
    assert_same_contents(contents(path), contents(volume))


def test_failures_name_both_values(tmp_path, capsys):
    assert run(tmp_path, "stages=[sweep]", "store.max_points=20") == 1
    said = capsys.readouterr().out
    assert "and 14 more; `message` in the store has every reason" in said
    assert "row 0 (f_e = 0, b = 0.02) failed: it needs room for" in said
    failed = store.failures(tmp_path / "store/omega_b_fe.zarr")
    assert [row for row, _ in failed] == list(range(24)) and all("max_points" in reason for _, reason in failed)


@pytest.mark.costly
def test_layers_are_drawn(swept, volume):
    from pipeline.figures.volume import coexistence, draw_volume, shown_layers

    assert [path.name for path in (swept / "figures/omega_b_fe").glob("[!.]*")] == ["layers.png"]
    stored = read_stored(volume)
    layers = shown_layers(stored)
    assert list(layers) == [0.0, 0.25, 0.5]
    for index, plane in enumerate(layers.values()):
        np.testing.assert_array_equal(plane.domain, contents(volume)["domain"][index])
    figure = draw_volume(stored)
    titles = [axes.get_title() for axes in figure.axes if axes.get_title()]
    assert titles == ["$f_e$ = 0", "$f_e$ = 0.25", "$f_e$ = 0.5", "layers in which $n$ is at least 2, of 3"]
    # In one row, and below it in how many layers several motions coexist.
    assert len({round(axes.get_position().y0, 6) for axes in figure.axes[:3]}) == 1
    several = np.sum(contents(volume)["n_stable"] >= 2, axis=0)
    np.testing.assert_array_equal(coexistence(stored), several)
    assert several.max() > 1
    shown = {text.get_text() for axes in figure.axes for text in axes.texts}
    present = {layers[0.0].labels[code] for code in np.unique(contents(volume)["domain"]).tolist()}
    assert present <= shown and len(present) > 3


@pytest.mark.costly
def test_a_layer_is_taken_out_as_a_plane(volume, tmp_path, capsys):
    shutil.copytree(volume, tmp_path / "store/omega_b_fe.zarr")
    # The layer nearest to 0.2; what is stored is not computed again.
    assert run(tmp_path, "plane.layer=0.2", "stages=[sweep,boundaries]") == 0
    said = capsys.readouterr().out
    assert "omega_b_fe-f_e=0.25 taken out of" in said and "all 8 rows are in" in said and "fold curve" in said
    path = tmp_path / "store/omega_b_fe-f_e=0.25.zarr"
    assert (tmp_path / "boundaries/omega_b_fe-f_e=0.25.csv").exists()
    found, whole = contents(path), contents(volume)
    for name in arrays_of(store.read_plan(path)):
        assert_same_values(found[name], whole[name][1], name)
    assert store.find_damage(path) == [] and len(thresholds(path, "1/0")) >= 1
    with pytest.raises(StoreError, match="is a volume"):
        thresholds(volume, "1/0")


@pytest.mark.costly
def test_a_layer_that_is_not_computed_yet_is_computed_alone(volume, tmp_path):
    assert run(tmp_path, "plane.layer=0.5", "stages=[sweep]") == 0
    found, whole = contents(tmp_path / "store/omega_b_fe-f_e=0.5.zarr"), contents(volume)
    assert_same_values(found["domain"], whole["domain"][2], "domain")
    assert not (tmp_path / "store/omega_b_fe.zarr").exists()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (
            ["plane.parameter2.name=b"],
            "plane.parameter2.name = 'b' is not allowed: the parameter axis has that name already",
        ),
        (["plane.parameter2.name=x"], "plane.parameter2.name = 'x' is not allowed: it must be one of"),
        (["plane.parameter2.name=temperature"], "plane.parameter2.name = 'temperature' is not allowed"),
        (["plane.parameter2.num=1"], "plane.parameter2.num = 1 is not allowed"),
        (["plane.parameter2.min=1"], "plane.parameter2.max = 0.5 is not allowed"),
        (["gear.f_e=0.2"], "gear.f_e is not allowed here: f_e is an axis of this plane"),
        (["plane.parameter2={name:kappa,min:-1,max:1,num:3}"], "plane.parameter2.min = -1.0 is not allowed"),
        (
            ["plane.max_cells=700"],
            "plane.sweep.num x plane.parameter.num x plane.parameter2.num = 720 is not allowed: it must be at most",
        ),
        (
            ["store.max_points=10000000", "plane.parameter.num=5000"],
            "plane.parameter2.num = 30 x 5000 x 3 is not allowed: up to",
        ),
        (["plane=omega_fe"], "plane.parameter2.num is not allowed here: this plane has no third axis"),
        (["stages=[margins]"], "stages = 'margins' is not allowed for a volume: with plane.layer=VALUE"),
        (["figures.window=[0.5,0.7,0.1,0.3]"], "figures.window = [0.5, 0.7, 0.1, 0.3] is not allowed for a volume"),
        (["figures.curves=[0.5]"], "figures.curves = [0.5] is not allowed for a volume"),
        (["plane.layer=0.7"], "plane.layer = 0.7 is not allowed: it must lie within f_e = 0 ... 0.5"),
        (["plane.layer=much"], "plane.layer: Value 'much'"),
        (["plane.parameter2=null", "plane.layer=0.3"], "has no value|no third axis"),
    ],
)
def test_mistakes_are_one_line(volume, tmp_path, capsys, arguments, said):
    if arguments[0].startswith("stages"):
        shutil.copytree(volume, tmp_path / "store/omega_b_fe.zarr")
    before = sorted(tmp_path.rglob("*"))
    flat = arguments[0] == "plane.parameter2=null"
    given = [argument for argument in ARGUMENTS if "parameter2" not in argument or not flat]
    assert main([*given, f"output.root={tmp_path}", *arguments]) == 2
    line = capsys.readouterr().err
    assert line.count("\n") == 1 and any(part in line for part in said.split("|"))
    assert sorted(tmp_path.rglob("*")) == before


def test_a_plane_keeps_its_digest():
    """A volume must not change what planes are known by; the digest is that of a plane of schema 4."""
    assert plan(compose(["solver.certify=columns"])).fingerprint == "1d1f200ff1501e68"
    assert "parameter2" not in small_plan().inputs
