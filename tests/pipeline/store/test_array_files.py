"""What is written of an array is what zarr reads, chunks at its edges included."""

import numpy as np
import pytest
import zarr

from pipeline.store.array_files import array_files
from pipeline.store.array_layout import ArrayLayout


@pytest.mark.parametrize(("shape", "chunks"), [((5, 4), (2, 3)), ((3, 7, 2), (2, 3, 2)), ((4,), (4,)), ((), ())])
@pytest.mark.parametrize("kind", ["float64", "int8", "string"])
def test_zarr_reads_what_is_written(tmp_path, shape, chunks, kind):
    values = np.arange(np.prod(shape, dtype=int)).reshape(shape)
    values = (
        np.array([str(one) for one in values.flat], object).reshape(shape) if kind == "string" else values.astype(kind)
    )
    array = ArrayLayout.of_values("one", tuple(f"axis_{i}" for i in range(len(shape))), values, chunks)
    for name, content in array_files(array, {"units": "1"}, values).items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(content)
    told = zarr.open_array(tmp_path / "one", mode="r")
    assert (told.shape, told.chunks, dict(told.attrs)) == (shape, chunks, {"units": "1"})
    assert np.asarray(told[...]).tolist() == values.tolist()
