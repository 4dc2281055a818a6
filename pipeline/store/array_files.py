"""What the files of an array hold: its metadata and its chunks."""

import numpy as np

from pipeline.store.array_layout import ArrayLayout
from pipeline.store.chunk_files import encoded
from pipeline.store.documents import content_of
from pipeline.store.names import METADATA

__all__ = ["array_files"]


def array_files(array: ArrayLayout, attributes: dict, values: np.ndarray | None = None) -> dict[str, bytes]:
    """Name -> content of the files of an array; of an array without values, which are written later, its metadata.

    Chunks with nothing but fill values are written too: nothing would tell one that was lost from one left out.

    Parameters
    ----------
    array : ArrayLayout
    attributes : dict
        What it says of itself, as JSON can have it.
    values : ndarray, optional
        Of the array's shape; objects where it holds texts.

    Examples
    --------
    >>> sorted(array_files(ArrayLayout("p", (3,), (2,), "float64", ("p",), 0.0), {}, np.zeros(3)))
    ['p/c/0', 'p/c/1', 'p/zarr.json']
    """
    contents = {f"{array.name}/{METADATA}": content_of(array.document(attributes))}
    for file, first in array.touched() if values is not None else ():
        within = tuple(slice(start, start + size) for start, size in zip(first, array.chunks, strict=True))
        # With an ellipsis it is an array also where there are no dimensions.
        here, chunk = values[(*within, ...)], np.full(array.chunks, array.fill_value, values.dtype)
        chunk[(*(slice(size) for size in here.shape), ...)] = here
        contents[file] = encoded(chunk.ravel(), array)
    return contents
