"""Thresholds and shares of a stored plane."""

import doctest

import pytest

import pipeline
import pipeline.plane.regions
from pipeline.errors import StoreError
from tests.pipeline.planes import small_plan, small_store


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    plan = small_plan("plane=omega_fe", columns=60, rows=16)
    return small_store(tmp_path_factory.mktemp("regions") / "plane.zarr", plan)


@pytest.mark.costly
def test_the_example_runs():
    assert doctest.testmod(pipeline.plane.regions).failed == 0


@pytest.mark.slow
def test_thresholds_do_not_depend_on_the_raster(stored):
    """docs/physics.md, section 7: 12 rows suffice for what the article reads off a fine map."""
    (found,) = pipeline.thresholds(stored, "1/1", window=(0.9, 2.0))
    assert found.appears == pytest.approx(0.13995830, abs=1e-6) and found.disappears == 0.5
    everything = pipeline.thresholds(str(stored))
    assert sum(found.share for found in everything) == pytest.approx(1.0, abs=1e-12)
    assert pipeline.thresholds(stored, "9/0") == ()


def test_what_is_not_allowed_is_said(stored, tmp_path):
    with pytest.raises(StoreError, match="there is no store"):
        pipeline.thresholds(tmp_path / "nothing.zarr")
    with pytest.raises(StoreError, match="x_window"):
        pipeline.thresholds(stored, window=(0.0, 1.0))
    plan = small_plan(columns=5, rows=2)
    with pytest.raises(StoreError, match="no complete row"):
        pipeline.thresholds(small_store(tmp_path / "empty.zarr", plan, blocks=[]))
