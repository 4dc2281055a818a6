"""Groups that stages add to a store beside its rows.

A group is written beside the store and moved into it whole, and counts only once the store's metadata lists it, so that
a run killed at any moment leaves either the group or nothing. A sweep that computes rows takes all of them away first.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import zarr

from pipeline.store.array_layout import MOST_TEXT
from pipeline.store.codecs import COMPRESSORS, every_chunk
from pipeline.store.documents import listed_in
from pipeline.store.durable import move_whole
from pipeline.store.identity import read_layout
from pipeline.store.names import ADDED, GROUP_FILE
from pipeline.store.removal import refuse_unknown, remove_known
from pipeline.store.template import consolidate

__all__ = ["Variable", "open_group", "remove_added", "remove_group", "take_away", "write_group"]

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
    """Put a group into the store at `path`, in place of what was there.

    Raises
    ------
    DamagedError
        If rows went missing meanwhile: what the group was computed from may have been read as fill values.
    """
    if name not in ADDED:
        raise ValueError(f"{name!r} is no group that stages add: one of {', '.join(ADDED)}")
    read_layout(path)
    draft = _beside(path, name, "draft")
    remove_known(draft, GROUP_FILE)
    group = zarr.create_group(draft, zarr_format=3, attributes=attributes)
    for key, variable in variables.items():
        text = variable.dtype == "str"
        values = [str(one)[:MOST_TEXT] for one in variable.data] if text else variable.data
        data = np.array(values, dtype=object if text else variable.dtype, order="C")
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
    move_whole(draft, path / name)
    consolidate(path)


def remove_group(path: Path, name: str) -> None:
    """Take a group away, if there is one or the metadata still lists one that a killed run has taken away."""
    if take_away(path, name) or name in listed_in(path):
        consolidate(path)


def take_away(path: Path, name: str) -> bool:
    """Take the files of a group away, all at once, and leave it listed, which counts as none; whether it was there.

    Raises
    ------
    StoreError
        If it holds anything that is no file of a group; then nothing is removed.
    """
    old = _beside(path, name, "old")
    remove_known(old, GROUP_FILE)
    if not (path / name).exists():
        return False
    refuse_unknown(path / name, GROUP_FILE)
    (path / name).rename(old)
    remove_known(old, GROUP_FILE)
    return True


def remove_added(path: Path) -> None:
    """Take away every group that stages have added."""
    for name in ADDED:
        remove_group(path, name)


def open_group(path: Path, name: str) -> zarr.Group | None:
    """A group for reading; None if there is none."""
    # The consolidated metadata must list it and it must be there: otherwise a run was killed between the two.
    root = zarr.open_group(path, mode="r")
    return root[name] if name in root and (path / name).exists() else None


def _beside(path: Path, name: str, what: str) -> Path:
    return path.with_name(f".{path.name}.{name}.{what}")
