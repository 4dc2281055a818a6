"""Boundaries and attractors of a volume: of every layer what the plane of that layer would have."""

import dataclasses
import shutil

import numpy as np
import pytest
import xarray as xr

import pipeline
from pipeline import store
from pipeline.__main__ import main
from pipeline.analysis.attractors.dataset import NUMBERS
from pipeline.analysis.boundaries.group import write_boundaries
from pipeline.errors import StoreError
from pipeline.plane.boundaries import read_boundaries
from solver import ParameterError

pytestmark = pytest.mark.costly
SMALL = ["plane=omega_b_fe", "plane.sweep.num=21", "plane.parameter.num=4", "plane.parameter2.num=2", "cluster=none"]
FEW = ["attractors.columns=3", "attractors.rows=2", "attractors.starts=1"]
TRACED = [*SMALL, *FEW, "stages=[sweep,boundaries,attractors,figures]", "figures.formats=[png]", "figures.dpi=30"]


@pytest.fixture(scope="module")
def outputs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("layers")
    assert main([*TRACED, f"output.root={folder}"]) == 0
    return folder


@pytest.fixture(scope="module")
def volume(outputs):
    return pipeline.open_plane(outputs / "store/omega_b_fe.zarr")


@pytest.fixture(scope="module")
def plane(outputs, tmp_path_factory):
    """The plane of the last layer as `plane.layer` takes it out, traced and integrated by itself."""
    folder = tmp_path_factory.mktemp("plane")
    shutil.copytree(outputs / "store/omega_b_fe.zarr", folder / "store/omega_b_fe.zarr")
    stages = "stages=[sweep,boundaries,attractors]"
    assert main([*SMALL, *FEW, stages, "plane.layer=0.5", f"output.root={folder}"]) == 0
    return pipeline.open_plane(folder / "store/omega_b_fe-f_e=0.5.zarr")


def test_a_layer_has_the_boundaries_of_its_plane_bit_by_bit(volume, plane, outputs):
    assert repr(volume) == "OpenVolume('omega_b_fe': omega 21 x b 4 x f_e 2; attractors, boundaries, branches)"
    layer = volume.layer(0.4)
    assert repr(layer) == repr(plane) and layer.plan == plane.plan and len(plane.stored.boundaries.curves) > 3
    found, wanted = layer.stored.boundaries, plane.stored.boundaries
    assert found.digest == wanted.digest and len(found.curves) == len(wanted.curves)
    for one, other in zip(found.curves, wanted.curves, strict=True):
        for field in dataclasses.fields(one):
            np.testing.assert_array_equal(getattr(one, field.name), getattr(other, field.name))
    sheet = "boundaries/omega_b_fe-f_e=0.5.csv"
    assert (outputs / sheet).read_bytes() == (plane.path.parents[1] / sheet).read_bytes()
    # Curves of the other layer are others.
    assert volume.layer(0.0).stored.boundaries.digest != found.digest


def test_a_layer_has_the_attractors_of_its_plane_bit_by_bit(volume, plane):
    found, wanted = (one.tree["attractors"].to_dataset().load() for one in (volume.layer(0.5), plane))
    for name in (*NUMBERS, "kind", "impact", "share", "n_attractors", "credibility", "starts"):
        np.testing.assert_array_equal(found[name].values, wanted[name].values)
    place = dict(omega=0.6, b=1.0)
    assert (
        volume.layer(0.5).attractors_at(**place).force.values.tolist()
        == plane.attractors_at(**place).force.values.tolist()
    )


def test_a_layer_answers_as_its_plane_does(volume, plane):
    layer, place = volume.layer(0.5), dict(omega=0.6, b=1.0)
    assert layer.label_near(**place) == plane.label_near(**place) != ""
    assert layer.nearest_boundaries(**place) == plane.nearest_boundaries(**place)
    assert (
        layer.thresholds() == plane.thresholds() and layer.mask("jump").values.sum() == plane.mask("jump").values.sum()
    )
    xr.testing.assert_equal(layer.curve_near(b=1.0), plane.curve_near(b=1.0))
    xr.testing.assert_equal(layer.motions_near(**place), plane.motions_near(**place))
    assert layer.tree["boundaries"].sizes == plane.tree["boundaries"].sizes
    assert len(layer.plot.map().axes) == len(plane.plot.map().axes)
    with pytest.raises(StoreError, match=r"plane\.layer"):
        layer.explore()
    with pytest.raises(ParameterError, match="f_e"):
        volume.layer(0.7)


def test_layers_are_drawn_with_their_attractors(outputs):
    names = sorted(path.name for path in (outputs / "figures/omega_b_fe").glob("*.png"))
    assert names == ["attractors-f_e=0.5.png", "attractors-f_e=0.png", "layers.png"]


def test_what_is_stored_is_not_traced_again_and_what_is_missing_is(outputs, tmp_path, capsys, monkeypatch):
    shutil.copytree(outputs / "store", tmp_path / "store")
    path = tmp_path / "store/omega_b_fe.zarr"
    plan = store.read_plan(path)
    layers = [read_boundaries(path, plan, layer) for layer in range(2)]
    command = [*SMALL, "stages=[boundaries]", f"output.root={tmp_path}"]
    assert main(command) == 0 and "nothing to do" in capsys.readouterr().out
    # As an interrupt leaves it: the first layer is done.
    write_boundaries(path, plan, [layers[0], None])
    assert read_boundaries(path, plan, 1) is None and read_boundaries(path, plan, 0).digest == layers[0].digest
    traced = []

    def instead(path, plan, layer):
        traced.append(layer)
        raise ArithmeticError("injected")

    with monkeypatch.context() as patch:
        patch.setattr("pipeline.analysis.boundaries.layers.layer_boundaries", instead)
        assert main(command) == 1
    said = capsys.readouterr()
    assert traced == [1] and "f_e = 0.5 cannot be traced: injected" in said.err and "in 1 of 2 layers" in said.out
    # What was there of the other layer is kept.
    assert read_boundaries(path, plan, 0).digest == layers[0].digest
    assert store.find_damage(path) == []
