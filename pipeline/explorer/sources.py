"""Data of figures on one page: what several of them show is sent once."""

import hashlib

import numpy as np
from bokeh.models import ColumnDataSource

__all__ = ["Sources"]


class Sources:
    """The data sources of a page; equal data have one source."""

    def __init__(self):
        self._known: dict[str, ColumnDataSource] = {}

    def of(self, data: dict) -> ColumnDataSource:
        """The source of some columns: lists, arrays and lists of arrays."""
        digest = hashlib.blake2b(digest_size=16)
        _add(digest, data)
        return self._known.setdefault(digest.hexdigest(), ColumnDataSource(data))


def _add(digest, part) -> None:
    if isinstance(part, np.ndarray):
        digest.update(f"{part.dtype}{part.shape}".encode())
        digest.update(np.ascontiguousarray(part).tobytes())
    elif isinstance(part, dict | list | tuple):
        digest.update(f"{type(part).__name__}{len(part)}".encode())
        for one in part.items() if isinstance(part, dict) else part:
            _add(digest, one)
    else:
        digest.update(f"{part!r},".encode())
