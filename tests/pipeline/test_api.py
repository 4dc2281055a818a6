"""A stored plane opened for questions: stored answers against computed ones."""

import numpy as np
import pytest
import xarray as xr

import pipeline
from pipeline import store
from pipeline.config.quantities import QUANTITIES
from pipeline.errors import StoreError
from pipeline.plane.labels import jumping
from solver import ParameterError
from tests.pipeline.planes import COARSE, small_plan, small_store, traced_store


@pytest.fixture(scope="module")
def plane(tmp_path_factory):
    path = tmp_path_factory.mktemp("opened") / "omega_fe.zarr"
    return pipeline.open_plane(traced_store(path, small_plan(*COARSE)))


def grid(plane):
    x, p = plane.plan.sweep.values, plane.plan.parameter.values
    return [(float(x[i]), float(p[j])) for i in range(0, 41, 6) for j in (1, 4)]


def test_by_name_and_by_path(plane, monkeypatch):
    assert pipeline.open_plane("omega_fe", root=plane.path.parent).plan == plane.plan
    assert pipeline.open_plane(str(plane.path)).attributes["configuration_hash"] == plane.plan.fingerprint
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
        for name in (*QUANTITIES, "phase", "multiplier"):
            np.testing.assert_allclose(at[name], near[name], rtol=0, atol=1e-7)
            assert at[name].attrs == near[name].attrs == plane.tree[name].attrs
        for name in ("stable", "impact", "instability"):
            np.testing.assert_array_equal(at[name], near[name])


@pytest.mark.costly
def test_motions_of_higher_order_are_those_of_their_row(tmp_path):
    planned = small_plan("plane=omega_fe", "solver=hb", "solver.order=3", columns=41, rows=5)
    plane = pipeline.open_plane(small_store(tmp_path / "third.zarr", planned))
    x, p = float(planned.sweep.values[11]), float(planned.parameter.values[2])
    near, at = plane.motions_near(omega=x, f_e=p), plane.motions_at(omega=x, f_e=p)
    assert near.identical(at) and at.sizes["solution"] == 3
    # Off the grid: the same motion on the branches of the same value.
    x, p = 0.611, 0.21
    at, curve = plane.motions_at(omega=x, f_e=p), plane.curve_at(f_e=p)
    assert float(at.omega) == x and at.sizes["solution"] == 3
    for i in range(3):
        near_it = np.abs(curve.omega.values - x) + np.abs(curve.rms.values - at.rms.values[i]) < 0.05
        assert np.any(near_it) and np.min(np.abs(curve.highest.values[near_it] - at.highest.values[i])) < 0.05


def test_physical_values_are_the_dimensionless_ones_in_units(tmp_path):
    planned = small_plan("plane=omega_fe", "gear=miter", columns=21, rows=3)
    plane = pipeline.open_plane(small_store(tmp_path / "miter.zarr", planned))
    scales, units = pipeline.scales_of(planned), set()
    here = dict(omega=0.9, f_e=0.1)
    asked = (
        (plane.motions_at, here),
        (plane.motions_near, here),
        (plane.curve_at, {"f_e": 0.1}),
        (plane.curve_near, {"f_e": 0.1}),
    )
    for ask, where in asked:
        plain, shown = ask(**where), ask(**where, physical=True)
        for name, one in QUANTITIES.items():
            size, unit = (1.0, "1") if one.scale is None else (scales[one.scale].shown, scales[one.scale].unit)
            np.testing.assert_allclose(shown[name], size * plain[name], rtol=1e-15)
            assert shown[name].attrs == {"long_name": one.title, "units": unit} and plain[name].attrs["units"] == "1"
            units.add(unit)
        np.testing.assert_allclose(shown.omega, scales["omega"].shown * plain.omega, rtol=1e-15)
        assert shown.omega.attrs == {"long_name": "pinion speed", "units": "rpm"}
        np.testing.assert_array_equal(shown.stable, plain.stable)
    assert units == {"1", "µm", "m/s", "N"}


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
    for name in ("cos", "sin", "stable", "impact", "branch", "event", "omega"):
        np.testing.assert_array_equal(near[name], at[name])
    for name in QUANTITIES:
        np.testing.assert_allclose(near[name], at[name], rtol=0, atol=1e-12)
    motion = plane.motions_at(omega=float(at.omega[20]), f_e=value)
    stable = np.flatnonzero(motion.stable.values == at.stable.values[20])
    for name in QUANTITIES:
        assert np.min(np.abs(motion[name].values[stable] - at[name].values[20])) < 1e-7, name


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
