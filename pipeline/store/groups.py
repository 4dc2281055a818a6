"""Groups that stages add to a store beside its rows.

A group is written beside the store and moved into it whole, and counts only once the store's metadata lists it, so that
a run killed at any moment leaves either the group or nothing. A sweep that computes rows takes all of them away first.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import zarr

from pipeline.store.array_layout import MOST_TEXT
from pipeline.store.codecs import COMPRESSORS, every_chunk
from pipeline.store.documents import listed_in
from pipeline.store.durable import move_whole
from pipeline.store.identity import read_layout
from pipeline.store.names import ADDED, GROUP_FILE, IN_BLOCKS
from pipeline.store.removal import refuse_unknown, remove_known
from pipeline.store.template import consolidate

if TYPE_CHECKING:
    # It takes a third of a second to load, which who only reads need not wait for.
    import xarray

__all__ = ["Arrays", "Variable", "open_group", "remove_added", "remove_group", "take_away", "unfinished", "write_group"]

#: Arrays of two and more dimensions are cut into chunks of at most this many entries along each.
_CHUNK = 1024


class Variable(NamedTuple):
    """An array with the names of its dimensions."""

    dims: tuple[str, ...]
    values: np.ndarray
    attrs: dict


@dataclass(frozen=True)
class Arrays:
    """What is written of an xarray.Dataset, for a stage that would load xarray for nothing else: it takes most of a
    second.

    Parameters
    ----------
    variables : mapping of str to Variable
    coords : collection of str
        Those of them that are coordinates.
    attrs : dict
        Of the group.
    """

    variables: Mapping[str, Variable]
    coords: Collection[str] = ()
    attrs: dict = field(default_factory=dict)

    @property
    def dims(self) -> set[str]:
        """Names of all dimensions."""
        return {dim for variable in self.variables.values() for dim in variable.dims}


def write_group(path: Path, name: str, dataset: "Arrays | xarray.Dataset") -> None:
    """Put a group into the store at `path`, in place of what was there.

    Parameters
    ----------
    path : Path
    name : str
    dataset : Arrays or xarray.Dataset
        Texts are objects. Its coordinates are named in the attribute `coordinates` of the group, as CF has it.

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
    places = [str(key) for key in dataset.coords if key not in dataset.dims]
    named = {"coordinates": " ".join(places)} if places else {}
    group = zarr.create_group(draft, zarr_format=3, attributes={**named, **dataset.attrs})
    for key, variable in dataset.variables.items():
        data = variable.values
        if data.dtype == object:
            data = np.array([str(one)[:MOST_TEXT] for one in data], dtype=object)
        most = max(data.size, 1) if data.ndim == 1 else _CHUNK
        with every_chunk():
            group.create_array(
                key,
                shape=data.shape,
                chunks=tuple(min(max(size, 1), most) for size in data.shape),
                dtype="str" if data.dtype == object else data.dtype,
                dimension_names=variable.dims,
                compressors=COMPRESSORS,
                attributes=variable.attrs,
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
    """Take away every group that stages have added, finished or not."""
    for name in ADDED:
        remove_group(path, name)
    for name in IN_BLOCKS:
        remove_known(unfinished(path, name), GROUP_FILE)


def open_group(path: Path, name: str) -> zarr.Group | None:
    """A group for reading; None if there is none."""
    # The consolidated metadata must list it and it must be there: otherwise a run was killed between the two.
    root = zarr.open_group(path, mode="r")
    return root[name] if name in root and (path / name).exists() else None


def unfinished(path: Path, name: str) -> Path:
    """Where a group is that is written block by block (`pipeline.store.row_groups`), until it is whole."""
    return _beside(path, name, "unfinished")


def _beside(path: Path, name: str, what: str) -> Path:
    return path.with_name(f".{path.name}.{name}.{what}")
