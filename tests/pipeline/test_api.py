"""A stored plane opened for questions: stored answers against computed ones."""

import numpy as np
import pytest
import xarray as xr

import pipeline
from pipeline import store
from pipeline.errors import StoreError
from pipeline.plane.labels import jumping
from solver import ParameterError
from tests.pipeline.planes import small_plan, small_store, traced_store


@pytest.fixture(scope="module")
def plane(tmp_path_factory):
    path = tmp_path_factory.mktemp("opened") / "omega_fe.zarr"
    planned = small_plan("plane=omega_fe", columns=40, rows=5)
    return pipeline.open_plane(traced_store(path, planned))


def grid(plane):
    x, p = plane.plan.sweep.values, plane.plan.parameter.values
    return [(float(x[i]), float(p[j])) for i in range(0, 40, 6) for j in (1, 3)]


def test_by_name_and_by_path(plane, monkeypatch):
    assert pipeline.open_plane("omega_fe", root=plane.path.parent).plan == plane.plan
    assert pipeline.open_plane(str(plane.path)).attributes["configuration_hash"] == plane.plan.digest
    assert isinstance(plane.tree, xr.DataTree) and set(plane.tree.children) == {"branches", "boundaries"}
    monkeypatch.chdir(plane.path.parent)
    with pytest.raises(StoreError, match="there is no store at"):
        pipeline.open_plane("omega_b")


def test_labels_and_motions_at_stored_places_are_those_stored(plane):
    for omega, f_e in grid(plane):
        here = dict(omega=omega, f_e=f_e)
        assert plane.label_at(**here) == plane.label_near(**here) != ""
        near, at = plane.motions_near(**here), plane.motions_at(**here)
        assert near.sizes == at.sizes
        for name in ("mean", "amplitude", "phase"):
            np.testing.assert_allclose(at[name], near[name], rtol=0, atol=1e-8)
        np.testing.assert_array_equal(at.stable, near.stable)
        np.testing.assert_array_equal(at.impact, near.impact)


def test_masks_are_of_labels_and_traits(plane):
    for label in ("1/0", "2/0-1", "2/0-2"):
        mask = plane.mask(label)
        assert mask.dtype == bool and mask.dims == ("f_e", "omega")
        for omega, f_e in grid(plane):
            assert bool(mask.sel(omega=omega, f_e=f_e)) == (plane.label_near(omega=omega, f_e=f_e) == label)
    np.testing.assert_array_equal(plane.mask("jump"), plane.tree["n_stable"] > 1)
    shown = [plane.labels[int(code)] for code in np.unique(plane.tree["domain"])]
    union = sum(plane.mask(label).astype(int) for label in shown if jumping(label))
    np.testing.assert_array_equal(union == 1, plane.mask("jump"))


def test_a_curve_anew_is_the_stored_one(plane):
    value = float(plane.plan.parameter.values[2])
    near, at = plane.curve_near(f_e=value + 1e-3), plane.curve_at(f_e=value)
    assert float(near.f_e) == float(at.f_e) == value
    for name in ("mean", "cos", "sin", "amplitude", "stable", "impact", "branch", "event", "omega"):
        np.testing.assert_array_equal(near[name], at[name])


def test_nearest_boundaries_part_the_labels_they_say(plane):
    here = dict(omega=0.6, f_e=0.2)
    found = plane.nearest_boundaries(**here)
    sides = {(one.name, one.upward) for one in found}
    assert sides == {("omega", True), ("omega", False), ("f_e", True), ("f_e", False)}
    widths = {"omega": 1.95, "f_e": plane.plan.parameter.high - plane.plan.parameter.low}
    shares = [one.distance / widths[one.name] for one in found]
    assert shares == sorted(shares)
    for one in found:
        sign = 1.0 if one.upward else -1.0
        before, beyond = (plane.label_at(**{**here, one.name: one.place + side * sign * 1e-6}) for side in (-1.0, 1.0))
        assert before == plane.label_at(**here) and beyond == plane.label_of(one.beyond) != before
    assert plane.label_of(0) == ""


def test_thresholds_are_those_of_the_store(plane):
    assert plane.thresholds("2/0-2") == pipeline.thresholds(plane.path, "2/0-2")


@pytest.mark.parametrize(
    ("ask", "what"),
    [
        (lambda plane: plane.label_at(omega=0.6), "f_e and omega"),
        (lambda plane: plane.label_near(omega=0.6, b=1.0), "f_e and omega"),
        (lambda plane: plane.label_at(omega=2.5, f_e=0.2), "omega = 2.5"),
        (lambda plane: plane.motions_near(omega=float("nan"), f_e=0.2), "omega = nan"),
        (lambda plane: plane.curve_at(omega=0.6), "f_e"),
        (lambda plane: plane.mask("2/7"), "a label n/I such as"),
    ],
)
def test_wrong_questions_are_one_line(plane, ask, what):
    with pytest.raises(ParameterError, match="is not allowed: it must be") as raised:
        ask(plane)
    assert what in str(raised.value) and "\n" not in str(raised.value)


def test_what_cannot_be_answered_is_said(tmp_path):
    planned = small_plan("plane=omega_fe", "solver=hb", "solver.order=2", "solver.certify_columns=5", columns=9, rows=3)
    path = small_store(tmp_path / "second.zarr", planned, blocks=planned.blocks[:1])
    plane = pipeline.open_plane(path)
    low, far = planned.parameter.low, planned.parameter.high
    with pytest.raises(StoreError, match="of order 2, of which solutions cannot be enumerated"):
        plane.label_at(omega=0.6, f_e=low)
    with pytest.raises(StoreError, match="no boundaries"):
        plane.nearest_boundaries(omega=0.6, f_e=low)
    with pytest.raises(StoreError, match="is not complete"):
        plane.curve_near(f_e=far)
    assert plane.label_near(omega=0.6, f_e=far) == "" and not plane.mask("1/0").sel(f_e=far).any()
    assert store.statuses(path)[0] == store.COMPLETE and plane.curve_near(f_e=low).sizes["point"] > 2
