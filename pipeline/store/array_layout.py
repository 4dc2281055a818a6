"""Which files an array is cut into, from its plan or from metadata that may come from someone else.

Metadata is what the specification of zarr says of its third version: https://zarr-specs.readthedocs.io
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np

__all__ = ["MOST_TEXT", "ArrayLayout"]

#: Longest text that is stored, in characters.
MOST_TEXT = 1000
#: Bytes per entry of the types that this program writes, as zarr names them; of texts, the most.
_TYPES = {
    "bool": 1,
    "int8": 1,
    "uint8": 1,
    "int16": 2,
    "uint16": 2,
    "int32": 4,
    "uint32": 4,
    "int64": 8,
    "uint64": 8,
    "float32": 4,
    "float64": 8,
    "string": 4 + 4 * MOST_TEXT,
}
_KEYS = {"name": "default", "configuration": {"separator": "/"}}
#: For every array of every store: the checksum is taken of the compressed bytes, as they are in the file.
_COMPRESSORS = ({"name": "zstd", "configuration": {"level": 0, "checksum": False}}, {"name": "crc32c"})


@dataclass(frozen=True)
class ArrayLayout:
    """One array: its chunks are the files `<name>/c/<i>/<j>/...`.

    Parameters
    ----------
    name : str
        In the store, such as "branches/mean".
    shape, chunks : tuple of int
        Sizes of the array and of its chunks.
    kind : str
        Type of the entries, as zarr names it.
    dims : tuple of str
        Names of the dimensions.
    fill : int, float or str
        What stands for entries that were never written, as in metadata: "NaN" for nan.
    """

    name: str
    shape: tuple[int, ...]
    chunks: tuple[int, ...]
    kind: str
    dims: tuple[str, ...]
    fill: int | float | str

    @classmethod
    def of_document(cls, name: str, told: dict | None) -> "ArrayLayout | None":
        """The layout that metadata tells; None if no array of this program has such metadata."""
        try:
            if (told["node_type"], told["zarr_format"], told["chunk_key_encoding"]) != ("array", 3, _KEYS):
                return None
            kind, (first, *others) = told["data_type"], told["codecs"]
            codecs = ["vlen-utf8" if kind == "string" else "bytes", *(codec["name"] for codec in _COMPRESSORS)]
            shape, chunks = told["shape"], told["chunk_grid"]["configuration"]["chunk_shape"]
            known = (
                kind in _TYPES
                and [first["name"], *(codec["name"] for codec in others)] == codecs
                and first.get("configuration", {}).get("endian", "little") == "little"
                and told["chunk_grid"]["name"] == "regular"
                and not told.get("storage_transformers")
                and all(type(size) is int and size >= 0 for size in shape)
                # A chunk may be as wide as its array and no wider.
                and all(
                    type(chunk) is int and 1 <= chunk <= max(size, 1) for size, chunk in zip(shape, chunks, strict=True)
                )
                and len(shape) == len(told["dimension_names"])
            )
            return (
                cls(name, *map(tuple, (shape, chunks)), kind, tuple(told["dimension_names"]), told["fill_value"])
                if known
                else None
            )
        except (AttributeError, KeyError, TypeError, ValueError):
            return None

    @classmethod
    def of_values(cls, name: str, dims: tuple[str, ...], values: np.ndarray, chunks: tuple[int, ...]) -> "ArrayLayout":
        """The layout of values at hand, of which texts are objects; they fill all of it."""
        kind = "string" if values.dtype == object else str(values.dtype)
        fill = "" if kind == "string" else values.dtype.type(0).item()
        return cls(name, values.shape, chunks, kind, dims, fill)

    @property
    def fill_value(self) -> int | float | str:
        """As numpy has it."""
        return math.nan if self.fill == "NaN" else self.fill

    def document(self, attributes: dict) -> dict:
        """The metadata of the array."""
        if self.kind == "string":
            first = {"name": "vlen-utf8", "configuration": {}}
        else:
            # Of single bytes there is no order.
            first = {"name": "bytes"} | ({"configuration": {"endian": "little"}} if _TYPES[self.kind] > 1 else {})
        return {
            "shape": list(self.shape),
            "data_type": self.kind,
            "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": list(self.chunks)}},
            "chunk_key_encoding": _KEYS,
            "fill_value": self.fill,
            "codecs": [first, *_COMPRESSORS],
            "attributes": attributes,
            "dimension_names": list(self.dims),
            "zarr_format": 3,
            "node_type": "array",
            "storage_transformers": [],
        }

    @property
    def bytes(self) -> int:
        """Bytes of the whole array, where it holds texts at most."""
        return math.prod(self.shape) * _TYPES[self.kind]

    @property
    def chunk_bytes(self) -> tuple[int, int]:
        """Fewest and most bytes of a chunk before it is compressed: the same unless it holds texts."""
        entries = math.prod(self.chunks)
        most = entries * _TYPES[self.kind]
        # Of texts, their number and the length of each come first.
        return (4 + 4 * entries, 4 + most) if self.kind == "string" else (most, most)

    @property
    def count(self) -> int:
        """Number of chunks."""
        return math.prod(-(-size // chunk) for size, chunk in zip(self.shape, self.chunks, strict=True))

    def files(self, *place: int | slice) -> Iterator[str]:
        """Names of the chunks that a place along the first axes touches; of all chunks unless told."""
        return (name for name, _ in self.touched(*place))

    def touched(self, *place: int | slice) -> Iterator[tuple[str, tuple[int, ...]]]:
        """The same chunks: name, and index of the first entry."""
        ends = [(at.start, at.stop) if isinstance(at, slice) else (at, at + 1) for at in place]
        ends += [(0, size) for size in self.shape[len(place) :]]
        along = (range(low // chunk, -(-high // chunk)) for (low, high), chunk in zip(ends, self.chunks, strict=True))
        for numbers in product(*along):
            first = tuple(number * chunk for number, chunk in zip(numbers, self.chunks, strict=True))
            yield "/".join((self.name, "c", *map(str, numbers))), first
