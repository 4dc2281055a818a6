"""The one reader of stored planes, against what xarray reads of the same store."""

import shutil

import numpy as np
import pytest
import xarray as xr
import zarr

from pipeline import store
from pipeline.plan.plan import Plan
from pipeline.plane.stored import StoredPlane, read_stored
from pipeline.store import groups
from pipeline.store.stored_arrays import open_group
from tests.pipeline.planes import small_plan, small_store

_CELLS = ("domain", "n_stable", "open")
_MOTIONS = ("mean", "amplitude", "phase", "stable", "impact", "instability")
_POINTS = ("mean", "amplitude", "stable", "impact", "branch", "event")


@pytest.fixture(scope="module")
def plane(tmp_path_factory):
    return small_store(tmp_path_factory.mktemp("stored") / "plane.zarr", small_plan(columns=21, rows=5))


@pytest.fixture(scope="module")
def volume(tmp_path_factory):
    plan = small_plan("plane=omega_b_fe", "plane.parameter2.num=3", columns=11, rows=3)
    return small_store(tmp_path_factory.mktemp("stored") / "volume.zarr", plan)


def assert_as_xarray_reads(stored: StoredPlane, root: xr.Dataset, branches: xr.Dataset) -> None:
    for name in (*_CELLS, *_MOTIONS, "status"):
        np.testing.assert_array_equal(getattr(stored, name), root[name], err_msg=name)
    used = int(stored.n_points.max())
    for name in _POINTS:
        np.testing.assert_array_equal(stored.points[name], branches[name][:, :used], err_msg=name)
    np.testing.assert_array_equal(stored.points["position"], branches[stored.plan.sweep.name][:, :used])
    np.testing.assert_array_equal(stored.end_reason, branches.end_reason)


def test_a_plane(plane):
    root = xr.open_zarr(plane)
    stored = read_stored(plane)
    assert_as_xarray_reads(stored, root, xr.open_zarr(plane, group="branches"))
    assert stored.about == root.attrs and stored.attributes["omega"] == root.omega.attrs
    assert stored.labels == dict(zip(root.domain.flag_values, root.domain.labels, strict=True))


@pytest.mark.parametrize("layer", [0, 2])
def test_a_layer_of_a_volume(volume, layer):
    root, branches = (xr.open_zarr(volume, group=group).isel(f_e=layer) for group in (None, "branches"))
    stored = read_stored(volume).layer_at(layer)
    assert_as_xarray_reads(stored, root, branches)
    assert stored.plan == store.read_plan(volume).layer(layer) and stored.boundaries is None


def test_a_whole_volume(volume):
    np.testing.assert_array_equal(read_stored(volume).domain, xr.open_zarr(volume).domain)


@pytest.mark.parametrize("layer", [None, 1])
def test_parts_make_up_the_whole(plane, volume, layer, monkeypatch):
    # Several chunks, and not all of them.
    monkeypatch.setattr(Plan, "_rows_at_once", 2)
    whole = read_stored(plane, True) if layer is None else read_stored(volume, True).layer_at(layer)
    parts = list(whole.parts)
    assert len(parts) > 1 and all(part.dynamic and part.layer == layer for part in parts)
    for name in (*_CELLS, *_MOTIONS, "status", "rows", "unstable", "contradictory", "end_reason"):
        joined = np.concatenate([getattr(part, name) for part in parts])
        np.testing.assert_array_equal(joined, getattr(whole, name), err_msg=name)
    assert [segments for part in parts for segments in part.segments] == whole.segments


def test_an_array_is_read_when_it_is_asked_for_and_once(plane, tmp_path):
    copy = shutil.copytree(plane, tmp_path / "copy.zarr")
    stored = read_stored(copy)
    shutil.rmtree(copy / "phase")
    amplitude = stored.amplitude
    shutil.rmtree(copy / "amplitude")
    assert stored.amplitude is amplitude and np.isfinite(amplitude).any()


def test_labels_of_rows_that_are_not_complete_are_not_believed(plane, tmp_path):
    """A run that was killed while it computed rows again leaves their old labels behind the new state."""
    copy = shutil.copytree(plane, tmp_path / "copy.zarr")
    zarr.open_group(copy, mode="r+")["status"][1] = store.PENDING
    stored, before = StoredPlane(copy, store.read_plan(plane)), read_stored(plane)
    assert before.domain[1].all() and not stored.domain[1].any()
    np.testing.assert_array_equal(np.delete(stored.domain, 1, axis=0), np.delete(before.domain, 1, axis=0))


def test_a_group_is_the_dataset_it_was_written_from(plane, tmp_path):
    copy = shutil.copytree(plane, tmp_path / "copy.zarr")
    written = xr.Dataset(
        {
            "kind": ("cell", np.array([1, 2, 3], "int8"), {"long_name": "a kind"}),
            "message": ("cell", np.array(["", "ä", "b"], dtype=object), {}),
            "wide": (("cell", "end"), np.arange(6.0).reshape(3, 2), {"units": "1"}),
            "none": ("nothing", np.empty(0), {}),
        },
        {"cell_omega": ("cell", [0.1, 0.2, 0.3], {"units": "1"}), "end": ("end", [0, 1], {})},
        {"made_from": "this"},
    )
    groups.write_group(copy, "places", written)
    xr.testing.assert_identical(xr.open_zarr(copy, group="places").load().astype(written.dtypes), written)
    group = open_group(copy, "places")
    assert group.attributes["coordinates"] == "cell_omega" and group.read("kind").dtype == np.int8
    assert store.find_damage(copy) == []
