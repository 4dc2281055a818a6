"""Groups that stages add to a store beside its rows.

A group is written beside the store and moved into it whole, and counts only once the store's metadata lists it, so that
a run killed at any moment leaves either the group or nothing. A sweep that computes rows takes all of them away first.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pipeline.config.places import Place
from pipeline.store.array_files import array_files
from pipeline.store.array_layout import MOST_TEXT, ArrayLayout
from pipeline.store.documents import content_of, group_document, listed_in
from pipeline.store.files import Files, files_at
from pipeline.store.identity import read_layout
from pipeline.store.names import ADDED, GROUP_FILE, IN_BLOCKS, METADATA, refuse_unknown
from pipeline.store.template import consolidate

if TYPE_CHECKING:
    # It takes a third of a second to load, which who only reads need not wait for.
    import xarray

__all__ = ["Arrays", "Variable", "remove_added", "remove_group", "unfinished", "unlist", "write_group"]

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


def write_group(path: Place, name: str, dataset: "Arrays | xarray.Dataset") -> None:
    """Put a group into the store at `path`, in place of what was there.

    Parameters
    ----------
    path : Place
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
    contents = _contents(dataset)
    remove_group(path, name)
    files_at(path).appear(contents, name)
    consolidate(path)


def _contents(dataset: "Arrays | xarray.Dataset") -> dict[str, bytes]:
    """What the files of a group hold: name in it -> content."""
    places = [str(key) for key in dataset.coords if key not in dataset.dims]
    named = {"coordinates": " ".join(places)} if places else {}
    contents = {METADATA: content_of(group_document({**named, **dataset.attrs}))}
    for key, variable in dataset.variables.items():
        data = variable.values
        if data.dtype == object:
            data = np.array([str(one)[:MOST_TEXT] for one in data], dtype=object)
        most = max(data.size, 1) if data.ndim == 1 else _CHUNK
        layout = ArrayLayout.of_values(key, variable.dims, data, tuple(min(max(n, 1), most) for n in data.shape))
        contents |= array_files(layout, variable.attrs, data)
    return contents


def remove_group(path: Place, name: str) -> None:
    """Take a group away, if there is one or the metadata still lists one that is gone.

    The store does not list it any more before anything of it is removed.

    Raises
    ------
    StoreError
        If it holds anything that is no file of a group; then nothing is removed.
    """
    files = files_at(path)
    unlist(files, [name])
    files.vanish(name)


def unlist(files: Files, names: Collection[str]) -> None:
    """Have the store list these groups no longer, which are removed next; raises as `remove_group`."""
    for name in names:
        inside = (file.removeprefix(f"{name}/") for file in files.sizes() if file.startswith(f"{name}/"))
        refuse_unknown(f"{files.place}/{name}", inside, GROUP_FILE)
    if {*names} & listed_in(files).keys():
        consolidate(files.place, names)


def remove_added(path: Place) -> None:
    """Take away every group that stages have added, finished or not."""
    for name in ADDED:
        remove_group(path, name)
    for name in IN_BLOCKS:
        unfinished(path, name).clear(GROUP_FILE)


def unfinished(path: Place, name: str) -> Files:
    """Where a group is that is written block by block (`pipeline.store.row_groups`), until it is whole."""
    return files_at(path).beside(f"{name}.unfinished")
