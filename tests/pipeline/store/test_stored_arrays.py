"""Arrays read without zarr are what zarr reads."""

import shutil

import numpy as np
import pytest
import xarray as xr
import zarr
from hypothesis import given, settings
from hypothesis import strategies as st
from zarr.codecs import Crc32cCodec, ZstdCodec

from pipeline import store
from pipeline.errors import DamagedError, StoreError
from pipeline.store.stored_arrays import open_arrays, open_group
from tests.pipeline.planes import small_plan, small_store

_COMPRESSORS = (ZstdCodec(level=0), Crc32cCodec())
KINDS = ("int8", "uint16", "float64", "str")


@st.composite
def arrays(draw):
    """Shape, chunks, kind, and a place along the first axes."""
    shape = draw(st.lists(st.integers(1, 7), min_size=1, max_size=3))
    chunks = [draw(st.integers(1, size)) for size in shape]
    place = [_place(draw, size) for size in shape[: draw(st.integers(0, len(shape)))]]
    return tuple(shape), tuple(chunks), draw(st.sampled_from(KINDS)), tuple(place)


def _place(draw, size):
    if draw(st.booleans()):
        return draw(st.integers(0, size - 1))
    low = draw(st.none() | st.integers(0, size))
    return slice(low, draw(st.none() | st.integers(0, size + 2)))


@settings(max_examples=60, deadline=None)
@given(arrays(), st.booleans())
def test_any_part_of_any_array_is_what_zarr_reads(tmp_path_factory, array, half):
    shape, chunks, kind, place = array
    path = tmp_path_factory.mktemp("arrays") / "any.zarr"
    root = zarr.create_group(path, zarr_format=3)
    fill = {"str": "", "float64": float("nan")}.get(kind, 3)
    names = [f"axis_{number}" for number in range(len(shape))]
    made = root.create_array(
        "one", shape=shape, chunks=chunks, dtype=kind, fill_value=fill, compressors=_COMPRESSORS, dimension_names=names
    )
    values = np.arange(np.prod(shape)).reshape(shape)
    values = values.astype(str).astype(object) if kind == "str" else values.astype(kind)
    # Chunks that were never written are none on the disk.
    made[: (shape[0] + 1) // 2 if half else shape[0]] = values[: (shape[0] + 1) // 2 if half else shape[0]]
    with pytest.warns(UserWarning, match="Consolidated"):
        zarr.consolidate_metadata(path)
    found, wanted = open_arrays(path).read("one", *place), made[place or ...]
    assert np.shape(found) == np.shape(wanted)
    if kind == "str":
        assert np.asarray(found).tolist() == np.asarray(wanted).tolist()
    else:
        assert found.dtype == np.dtype(kind)
        np.testing.assert_array_equal(found, wanted)


@pytest.fixture(scope="module")
def plane(tmp_path_factory):
    return small_store(tmp_path_factory.mktemp("arrays") / "plane.zarr", small_plan(columns=21, rows=5))


@pytest.mark.parametrize("group", ["", "branches"])
def test_a_whole_store_is_what_xarray_reads(plane, group):
    arrays = open_group(plane, group) if group else open_arrays(plane)
    told = xr.open_zarr(plane, group=group or None, chunks=None, mask_and_scale=False, decode_coords=False).load()
    assert arrays.attributes == told.attrs
    for name, array in told.variables.items():
        np.testing.assert_array_equal(arrays.read(name).astype(array.dtype), array.values)
        assert arrays.attributes_of(name) == {**array.attrs}


def test_a_damaged_chunk_is_named(plane, tmp_path):
    plane_copy = shutil.copytree(plane, tmp_path / "copy.zarr")
    array = open_arrays(plane_copy).layout("mean")
    (file, *_) = array.files()
    content = bytearray((plane_copy / file).read_bytes())
    content[-1] ^= 1
    (plane_copy / file).write_bytes(content)
    with pytest.raises(DamagedError, match=f"{file}.*checksum"):
        open_arrays(plane_copy).read("mean")
    assert open_arrays(plane_copy).read("status").tolist() == [store.COMPLETE] * array.shape[0]


def test_what_is_no_array_of_this_program_is_refused(plane):
    with pytest.raises(DamagedError, match="nothing"):
        open_arrays(plane).read("nothing")
    assert open_group(plane, "attractors") is None and "mean" in open_arrays(plane)


def test_a_store_that_is_not_there_is_not_called_damaged(tmp_path):
    with pytest.raises(StoreError, match="no store at") as caught:
        open_arrays(tmp_path / "none.zarr")
    assert not isinstance(caught.value, DamagedError)
