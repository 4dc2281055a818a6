"""Groups that stages add to a store beside its rows.

A group is written beside the store and moved into it whole, and counts only once the store's metadata lists it, so that
a run killed at any moment leaves either the group or nothing. A sweep that computes rows takes all of them away first.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import zarr

from pipeline import store
from pipeline.store.codecs import COMPRESSORS, every_chunk
from pipeline.store.removal import remove

__all__ = ["Variable", "open_group", "remove_added", "remove_group", "write_group"]

#: The group that the rows themselves fill.
_ROWS = "branches"
#: Arrays of two and more dimensions are cut into chunks of at most this many entries along each.
_CHUNK = 1024


@dataclass(frozen=True)
class Variable:
    """One array of a group: dimension or dimensions, type ("str" for text), attributes and values."""

    dims: str | tuple[str, ...]
    dtype: str
    data: object
    attributes: dict = field(default_factory=dict)


def write_group(path: Path, name: str, attributes: dict, variables: Mapping[str, Variable]) -> None:
    """Put a group into the store at `path`, in place of what was there."""
    draft = _beside(path, name, "draft")
    remove(draft)
    group = zarr.create_group(draft, zarr_format=3, attributes=attributes)
    for key, variable in variables.items():
        text = variable.dtype == "str"
        data = np.array(variable.data, dtype=object if text else variable.dtype, order="C")
        most = max(data.size, 1) if data.ndim == 1 else _CHUNK
        with every_chunk():
            group.create_array(
                key,
                shape=data.shape,
                chunks=tuple(min(max(size, 1), most) for size in data.shape),
                dtype=variable.dtype,
                dimension_names=[variable.dims] if isinstance(variable.dims, str) else list(variable.dims),
                compressors=COMPRESSORS,
                attributes=variable.attributes,
            )[...] = data
    remove_group(path, name)
    draft.rename(path / name)
    store.consolidate(path)


def remove_group(path: Path, name: str) -> None:
    """Take a group away, if there is one or the metadata still lists one that a killed run has taken away."""
    old = _beside(path, name, "old")
    remove(old)
    if (path / name).exists():
        (path / name).rename(old)
        store.consolidate(path)
        remove(old)
    elif name in zarr.open_group(path, mode="r"):
        store.consolidate(path)


def remove_added(path: Path) -> None:
    """Take away every group that stages have added."""
    listed = {name for name, _ in zarr.open_group(path, mode="r").groups()}
    there = {folder.name for folder in path.iterdir() if _is_group(folder)}
    for name in sorted((listed | there) - {_ROWS}):
        remove_group(path, name)


def open_group(path: Path, name: str) -> zarr.Group | None:
    """A group for reading; None if there is none."""
    # The consolidated metadata must list it and it must be there: otherwise a run was killed between the two.
    root = zarr.open_group(path, mode="r")
    return root[name] if name in root and (path / name).exists() else None


def _is_group(folder: Path) -> bool:
    metadata = folder / "zarr.json"
    return metadata.is_file() and json.loads(metadata.read_text(encoding="utf-8"))["node_type"] == "group"


def _beside(path: Path, name: str, what: str) -> Path:
    return path.with_name(f".{path.name}.{name}.{what}")
