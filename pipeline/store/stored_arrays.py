"""What is stored in arrays, read without zarr: chunk by chunk, each looked over before it is believed."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pipeline.config.places import Place
from pipeline.errors import StoreError
from pipeline.store.array_layout import ArrayLayout
from pipeline.store.chunk_files import read_chunk
from pipeline.store.damage import damaged
from pipeline.store.documents import gathered
from pipeline.store.files import Files, files_at
from pipeline.store.names import METADATA

__all__ = ["StoredArrays", "open_arrays", "open_group"]


@dataclass(frozen=True, eq=False)
class StoredArrays:
    """The arrays of a store, or of a group in one.

    Parameters
    ----------
    files : Files
        Of the store.
    attributes : dict
        What the store or the group says of itself.
    documents : mapping of str to dict
        Metadata of what is in it; name within it -> as in the file.
    group : str
        Its name and a slash; empty of a whole store.

    Examples
    --------
    >>> arrays = open_arrays("outputs/store/omega_fe.zarr")  # doctest: +SKIP
    >>> arrays.read("branches/mean", slice(0, 3), slice(100)).shape  # doctest: +SKIP
    (3, 100)
    """

    files: Files
    attributes: dict
    documents: Mapping[str, dict]
    group: str = ""

    def __contains__(self, name: str) -> bool:
        return name in self.documents

    def attributes_of(self, name: str) -> dict:
        """What an array says of itself."""
        return self.documents[name].get("attributes", {})

    def layout(self, name: str) -> ArrayLayout:
        """How an array is cut into chunks.

        Raises
        ------
        DamagedError
            If there is no such array, or none that this program writes.
        """
        layout = ArrayLayout.of_document(self.group + name, self.documents.get(name))
        if layout is None:
            raise damaged(self.files.place, f"{self.group}{name} is no array of this program")
        return layout

    def read(self, name: str, *place: int | slice) -> np.ndarray:
        """An array, or what a place along its first axes has of it, as numpy cuts it; steps are 1.

        What was never written holds the fill value. Whether a chunk that should be there is missing was looked at when
        the store was opened (`pipeline.store.read_layout`).

        Parameters
        ----------
        name : str
        *place : int or slice

        Returns
        -------
        ndarray
            Of objects where the array holds texts.

        Raises
        ------
        DamagedError
            If a chunk is damaged, or there is no such array.
        """
        layout = self.layout(name)
        ends = [_ends(at, size) for at, size in zip(place, layout.shape, strict=False)]
        ends += [(0, size) for size in layout.shape[len(ends) :]]
        kind = object if layout.kind == "string" else np.dtype(layout.kind)
        values = np.empty([high - low for low, high in ends], kind)
        touched = dict(layout.touched(*(slice(*pair) for pair in ends)))
        files = self.files.at_hand(touched)
        for file, corner in touched.items():
            at, within = [], []
            for (low, high), first, chunk in zip(ends, corner, layout.chunks, strict=True):
                start, stop = max(low, first), min(high, first + chunk)
                at.append(slice(start - low, stop - low))
                within.append(slice(start - first, stop - first))
            values[*at] = read_chunk(files, file, layout)[*within] if files.has(file) else layout.fill_value
        single = tuple(0 if isinstance(at, int) else slice(None) for at in place)
        return values[single]


def _ends(at: int | slice, size: int) -> tuple[int, int]:
    if isinstance(at, int):
        return at, at + 1
    low, high, _ = at.indices(size)
    return low, max(low, high)


def open_arrays(path: "Place | str") -> StoredArrays:
    """All arrays of a store that its root lists.

    Raises
    ------
    StoreError
        If there is none, or its root cannot be read.
    """
    files = files_at(path)
    root, listed = gathered(files)
    if root is None:
        if not files.exists():
            raise StoreError(f"there is no store at {files.place}")
        raise damaged(files.place, f"{METADATA} cannot be read")
    return StoredArrays(files, root.get("attributes", {}), {name: told for name, told in listed.items() if told})


def open_group(path: "Place | str", name: str) -> StoredArrays | None:
    """A group that a stage has added; None if there is none."""
    # The root must list it and it must be there: otherwise a run was killed between the two.
    whole = open_arrays(path)
    if name not in whole or not whole.files.has(f"{name}/{METADATA}"):
        return None
    inside = f"{name}/"
    documents = {key.removeprefix(inside): told for key, told in whole.documents.items() if key.startswith(inside)}
    return StoredArrays(whole.files, whole.attributes_of(name), documents, inside)
