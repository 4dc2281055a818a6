"""Groups that are too long in the making to be lost: written block of rows by block of rows beside the store.

Such a group is whole like any other once it is in the store. Until then it is in a folder beside it, which another run
goes on with. There each block is one file that has the chunks of all arrays, so that it is as it was or as it shall
be, whatever interrupts; when all blocks are done, they become the chunks of the arrays. Where a chunk of a finished
group is damaged, the group goes back there (`set_aside`), and what is sound of it is kept.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.config.places import Place
from pipeline.errors import DamagedError, Unreachable
from pipeline.plan.row_blocks import Block, RowBlocks
from pipeline.store.array_files import array_files
from pipeline.store.array_layout import MOST_TEXT, ArrayLayout
from pipeline.store.chunk_files import ChunkError, decoded, encoded, read_chunk
from pipeline.store.damage import damaged
from pipeline.store.documents import content_of, document, group_document, listed_in
from pipeline.store.files import Files, files_at
from pipeline.store.groups import remove_group, unfinished, unlist
from pipeline.store.identity import read_layout
from pipeline.store.names import GROUP_FILE, METADATA
from pipeline.store.template import consolidate

__all__ = ["RowArray", "RowGroup", "set_aside"]

#: The folder of blocks.
_PACKED = "packed"
#: What such a file may hold, and more than any does.
_MOST_PACKED = 2**40


@dataclass(frozen=True)
class RowArray:
    """An array along the rows of a group.

    Parameters
    ----------
    dims : tuple of str
        Its dimensions behind those of the rows.
    sizes : tuple of int
        Of these.
    dtype : str
        "str" for texts.
    fill : int, float or str
        Of entries that are not computed.
    attributes : dict
    """

    dims: tuple[str, ...]
    sizes: tuple[int, ...]
    dtype: str
    fill: int | float | str
    attributes: dict

    @property
    def numpy_type(self):
        """As numpy has it."""
        return object if self.dtype == "str" else self.dtype

    def empty(self, rows: int) -> np.ndarray:
        """Fill values of so many rows."""
        return np.full((rows, *self.sizes), self.fill, self.numpy_type)


@dataclass(frozen=True, eq=False)
class RowGroup:
    """One group in the making.

    Parameters
    ----------
    store : Place
        The store that it belongs to.
    name : str
        One of `pipeline.store.names.ADDED`.
    rows : RowBlocks
        Rows of its own, in blocks of its own.
    dims : tuple of str
        Names of the dimensions of these rows, the layers first.
    arrays : dict
        Name -> RowArray: what is written of a block.
    places : dict
        Coordinates: name -> (dims, values, attributes).
    attributes : dict
        Of the group; they say what it is made from.
    """

    store: Place
    name: str
    rows: RowBlocks
    dims: tuple[str, ...]
    arrays: dict[str, RowArray]
    places: dict[str, tuple]
    attributes: dict

    @property
    def folder(self) -> Files:
        """Where it is until it is whole."""
        return unfinished(self.store, self.name)

    @cached_property
    def layouts(self) -> dict[str, ArrayLayout]:
        """Name -> where its chunks are."""
        return {name: self._layout(name, array) for name, array in self.arrays.items()}

    def _layout(self, name: str, array: RowArray) -> ArrayLayout:
        shape = (*self.rows.shape, *array.sizes)
        chunks = (*(1,) * (len(self.rows.shape) - 1), self.rows.size, *(max(size, 1) for size in array.sizes))
        fill = array.fill if array.fill == array.fill else "NaN"
        kind = "string" if array.dtype == "str" else array.dtype
        return ArrayLayout(name, shape, chunks, kind, (*self.dims, *array.dims), fill)

    @property
    def is_finished(self) -> bool:
        """Whether it is in the store, made from the same, and the store lists it."""
        return self.name in listed_in(files_at(self.store)) and self._is_this(self._final)

    @property
    def _final(self) -> Files:
        """Where it is when it is whole."""
        return files_at(self.store).within(self.name)

    def _is_this(self, folder: Files) -> bool:
        """Whether a folder holds this group, its coordinates sound; its blocks are looked at when they are read."""
        arrays = {name: f"{name}/{METADATA}" for name in (*self.layouts, *self.places)}
        coordinates = (f"{name}/c/{'/'.join('0' * np.ndim(place[1]))}" for name, place in self.places.items())
        folder = folder.at_hand((METADATA, *arrays.values(), *coordinates))
        told = document(folder, METADATA)
        if told is None or told.get("attributes") != self._told():
            return False
        documents = {name: document(folder, arrays[name]) for name in self.layouts}
        if any(ArrayLayout.of_document(name, documents[name]) != array for name, array in self.layouts.items()):
            return False
        return all(self._is_place(folder, name) for name in self.places)

    def _is_place(self, folder: Files, name: str) -> bool:
        """Whether a folder holds a coordinate."""
        layout = ArrayLayout.of_document(name, document(folder, f"{name}/{METADATA}"))
        values = np.asarray(self.places[name][1])
        if layout is None or layout.chunks != values.shape or layout.kind != str(values.dtype):
            return False
        try:
            (file,) = layout.files()
            return read_chunk(folder, file, layout).tobytes() == values.tobytes()
        except DamagedError:
            return False

    @cached_property
    def _fingerprint(self) -> str:
        """What it is made from, in short."""
        return hashlib.sha256(json.dumps(self._told(), sort_keys=True).encode()).hexdigest()[:32]

    def _told(self) -> dict:
        named = [name for name, (dims, *_) in self.places.items() if dims != (name,)]
        return {**({"coordinates": " ".join(named)} if named else {}), **self.attributes}

    def begin(self) -> None:
        """Make the folder, unless there is one to go on with: left by another run, or a group that counts no longer."""
        if self._is_this(self.folder):
            return
        self.folder.clear(GROUP_FILE)
        if self._is_this(self._final):
            self._final.move(self.folder)
            return
        contents = {METADATA: content_of(group_document(self._told()))}
        for name, (dims, values, attributes) in self.places.items():
            values = np.asarray(values)
            layout = ArrayLayout.of_values(name, tuple(dims), values, values.shape)
            contents |= array_files(layout, attributes, values)
        for name, array in self.arrays.items():
            contents |= array_files(self.layouts[name], array.attributes)
        self.folder.appear(contents)

    def read(self, block: Block) -> dict[str, np.ndarray] | None:
        """What is stored of a block; None unless all of it is there and sound.

        Returns
        -------
        dict or None
            Name -> (rows, ...) array; texts as objects.
        """
        try:
            chunks = self._packed(block) if self.folder.has(self._pack(block)) else self._unpacked(block)
            found = {name: decoded(chunks[name], layout) for name, layout in self.layouts.items()}
        except Unreachable:
            raise
        except (OSError, ValueError, KeyError, TypeError, ChunkError):
            return None
        rows = block.stop - block.start
        return {name: values.reshape(self.rows.size, *self.arrays[name].sizes)[:rows] for name, values in found.items()}

    def write(self, block: Block, values: Mapping[str, np.ndarray]) -> None:
        """Write all arrays of a block; it is on the disk when this returns.

        Parameters
        ----------
        block : Block
        values : mapping
            Name -> (rows, ...) array.
        """
        chunks = {name: self._encoded(name, values[name]) for name in self.arrays}
        # Whose block it is: a task may outlive its run, and write into the group of another.
        head = json.dumps({"of": self._fingerprint, "sizes": {name: len(one) for name, one in chunks.items()}}).encode()
        self.folder.write({self._pack(block): b"".join([head, b"\n", *chunks.values()])})

    def _pack(self, block: Block) -> str:
        return "/".join([_PACKED, "c", *map(str, self.rows.chunk_of(block))])

    def _packed(self, block: Block) -> dict[str, bytes]:
        """The chunks that the file of a block has.

        Raises
        ------
        ChunkError
            If it is of a group that was made from something else.
        """
        head, _, content = self.folder.read(self._pack(block), _MOST_PACKED).partition(b"\n")
        told, chunks, start = json.loads(head), {}, 0
        if told["of"] != self._fingerprint:
            raise ChunkError("is of another group")
        for name, size in told["sizes"].items():
            chunks[name] = content[start : start + size]
            start += size
        return chunks

    def _unpacked(self, block: Block) -> dict[str, bytes]:
        """The chunks of a block in a group that was finished once."""
        files = {name: self._file(block, name) for name in self.arrays}
        folder = self.folder.at_hand(files.values())
        return {name: folder.read(file, _MOST_PACKED) for name, file in files.items()}

    def _file(self, block: Block, name: str) -> str:
        (file,) = self.layouts[name].files(*self.rows.place(block))
        return file

    def _encoded(self, name: str, values: np.ndarray) -> bytes:
        values = np.asarray(values, self.arrays[name].numpy_type)
        if values.dtype == object:
            values = np.array([str(one)[:MOST_TEXT] for one in values.ravel()], dtype=object)
        return encoded(values.ravel(), self.layouts[name])

    def finish(self, summary: Mapping[str, tuple[RowArray, np.ndarray]]) -> None:
        """Make chunks of all blocks, add arrays that only the whole group tells, and put it into the store, in place
        of what was there.

        Parameters
        ----------
        summary : mapping
            Name -> the array, and its values along all rows, (*rows.shape, ...).

        Raises
        ------
        DamagedError
            If rows of the plane went missing meanwhile.
        """
        read_layout(self.store)
        for block in self.rows.all:
            if self.folder.has(self._pack(block)):
                try:
                    chunks = self._packed(block)
                except ChunkError as error:
                    raise damaged(self.store, f"{self._pack(block)} of {self.name} {error}") from None
                self.folder.write({self._file(block, name): chunk for name, chunk in chunks.items()})
        contents = {}
        for name, (array, values) in summary.items():
            self.folder.within(name).clear(GROUP_FILE)
            values = np.asarray(values, array.numpy_type)
            contents |= array_files(self._layout(name, array), array.attributes, values)
        self.folder.write(contents)
        # Not before: what is half made is made from them again.
        self.folder.within(_PACKED).clear(GROUP_FILE)
        remove_group(self.store, self.name)
        self.folder.move(self._final)
        consolidate(self.store)


def set_aside(path: Place, name: str) -> None:
    """Take a damaged group out of the store, to be gone on with: what is not sound of it is computed again."""
    files = files_at(path)
    unlist(files, [name])
    unfinished(path, name).clear(GROUP_FILE)
    files.within(name).move(unfinished(path, name))
