"""A study opened against its stores: every number is one that a store has, and what is missing is not made up."""

import numpy as np
import pytest
import xarray as xr

import pipeline
from pipeline.errors import StoreError
from pipeline.multirun.index import begun_index
from pipeline.plan.planning import plan
from tests.pipeline.multirun.test_study import settings_of
from tests.pipeline.planes import small_store

SIZES = ("plane.sweep.num=9", "plane.parameter.num=3")


def study_of(folder, *overrides, left_out=()):
    """A study whose stores are there but for some."""
    all_settings = settings_of(*SIZES, f"store.root={folder}", *overrides)
    for settings in all_settings:
        if settings.store_name not in left_out:
            small_store(settings.store_path, plan(settings))
    index, _ = begun_index(all_settings)
    index.write()
    return pipeline.open_study(folder)


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """Half backlash by damping, one combination missing."""
    folder = tmp_path_factory.mktemp("study")
    names = ("omega_fe-b=0.7-xi_mesh=0.02",)
    return study_of(folder, "gear.b=0.5,0.7,0.9", "gear.xi_mesh=0.05,0.02", left_out=names)


def same(found, wanted):
    assert found.dtype == wanted.dtype and found.shape == wanted.shape
    if found.dtype.kind in "OTU":
        assert found.tolist() == wanted.tolist()
    else:
        np.testing.assert_array_equal(found, wanted)


@pytest.mark.costly
def test_several_keys_are_several_dimensions(study):
    assert repr(study) == f"Study({str(study.root)!r}: 6 planes over gear.b 3, gear.xi_mesh 2; 5 complete, 1 pending)"
    assert study.varied == {"gear.b": (0.5, 0.7, 0.9), "gear.xi_mesh": (0.05, 0.02)}
    whole = study.to_xarray()
    assert whole.n_stable.dims == ("b", "xi_mesh", "f_e", "omega") and whole.n_stable.shape == (3, 2, 3, 9)
    assert whole.b.attrs == {"long_name": "gear.b", "units": "1"} and whole.sizes["b"] == 3
    whole = whole.load()
    for name, plane in study.planes.items():
        b, xi = study.listed.planes[name].values
        here = whole.sel(b=b, xi_mesh=xi)
        assert str(here.store.values) == name
        for key in plane.tree.data_vars:
            same(here[key].values, plane.tree[key].values)
            assert whole[key].attrs == plane.tree[key].attrs
    missing = whole.sel(b=0.7, xi_mesh=0.02)
    assert str(missing.store.values) == "" and np.all(missing.status == 0) and np.all(missing.domain == 0)
    assert np.all(missing.stable == -1) and np.all(np.isnan(missing.amplitude)) and set(missing.message.values) == {""}


def test_planes_open_by_name(study):
    assert len(study.planes) == 5 and "omega_fe-b=0.7-xi_mesh=0.02" not in study.planes
    plane = study.planes["omega_fe-b=0.5-xi_mesh=0.02"]
    assert plane.plan.gear["xi_mesh"] == 0.02 and plane is study.planes["omega_fe-b=0.5-xi_mesh=0.02"]
    with pytest.raises(KeyError):
        study.planes["omega_fe"]


def test_the_index_is_what_the_maps_tell(study):
    index = study.index
    assert (
        index.sizes == {"store": 6}
        and index["status"].values.tolist() == ["complete"] * 3 + ["pending"] + ["complete"] * 2
    )
    for name, plane in study.planes.items():
        here, domain = index.sel(store=name), plane.tree["domain"].values
        assert int(here.cells) == domain.size and int(here.domains) == np.unique(domain).size
        np.testing.assert_allclose(here.several_motions, np.mean(plane.tree["n_stable"].values > 1), atol=1e-6)
    assert int(index.cells.values[3]) == -1 and np.isnan(index.teeth_part.values[3])
    assert "omega_fe" in study._repr_html_()


@pytest.mark.costly
def test_a_tree_has_every_group_of_every_plane(tmp_path):
    tree = study_of(tmp_path, "gear=published,miter").to_datatree()
    assert set(tree.children) == {"omega_fe", "omega_fe-miter"} and set(tree["omega_fe"].children) == {"branches"}
    assert str(tree["omega_fe-miter"]["gear"].values) == "miter"
    stored = xr.open_zarr(tmp_path / "omega_fe.zarr", group="branches").load()
    for name in stored.data_vars:
        assert tree["omega_fe/branches"][name].variable.identical(stored[name].variable)


def test_names_are_a_coordinate_of_texts_and_units_are_kept(tmp_path):
    study = study_of(tmp_path, "gear=miter", "gear.physical.half_backlash='50 um','80 um'")
    whole = study.to_xarray()
    assert whole.half_backlash.values.tolist() == [50.0, 80.0] and whole.half_backlash.attrs["units"] == "um"


def test_gears_by_name(tmp_path):
    whole = study_of(tmp_path, "gear=published,miter").to_xarray()
    assert whole.gear.values.tolist() == ["published", "miter"] and whole.domain.dims == ("gear", "f_e", "omega")


def test_other_axes_are_not_concatenated(tmp_path):
    study = study_of(tmp_path, "plane.sweep.max=1.9,2")
    with pytest.raises(StoreError, match=r"different axes .*to_datatree"):
        study.to_xarray()
    assert len(study.to_datatree().children) == 2


def test_two_planes_for_one_value_are_not_concatenated(tmp_path):
    path = study_of(tmp_path, "gear.b=0.5,0.6").listed.path
    path.write_text(path.read_text().replace("omega_fe-b=0.6,0.6,", "omega_fe-b=0.6,0.5,"))
    study = pipeline.open_study(tmp_path)
    with pytest.raises(StoreError, match="two planes"):
        study.to_xarray()


def test_a_study_of_which_nothing_is_stored(tmp_path):
    study = study_of(tmp_path, "gear.b=0.5,0.6", left_out=("omega_fe-b=0.5", "omega_fe-b=0.6"))
    assert "2 pending" in repr(study) and len(study.planes) == 0
    with pytest.raises(StoreError, match="nothing of the study"):
        study.to_xarray()
    with pytest.raises(StoreError, match="no study at"):
        pipeline.open_study(tmp_path / "nowhere")
