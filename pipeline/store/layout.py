"""Looking a store over before zarr opens it: it may be damaged, and it may come from someone else.

Every reader goes through `validate_layout`. Names, metadata and sizes of files are compared with the plan, so that no
array can be anywhere else, or claim a size, a type or a codec that this program does not write; zarr would believe it.
"""

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.config.places import Place
from pipeline.errors import DamagedError, StoreError
from pipeline.plan.plan import Block, Plan
from pipeline.store.array_layout import ArrayLayout
from pipeline.store.arrays import layouts_of, row_layouts
from pipeline.store.block_states import read_states
from pipeline.store.chunk_files import HEADER, ChunkError, claim_of
from pipeline.store.damage import Damage, damaged
from pipeline.store.documents import document, listed_in
from pipeline.store.files import Files
from pipeline.store.names import ADDED, METADATA, ROWS, is_name
from pipeline.store.states import PENDING

__all__ = ["Layout", "group_faults", "listing_faults", "validate_layout"]

#: Bytes that may be claimed whatever is there, and how many may stand behind one that is.
_UNSEEN, _MOST_COMPRESSED = 2**26, 2**12


@dataclass(frozen=True)
class Layout:
    """What is in a store, as far as names and metadata tell.

    Parameters
    ----------
    store : Files
        What is read next of it is at hand.
    plan : Plan
    files : dict
        Name -> size in bytes.
    listed : dict
        What the root gathers: name -> metadata, None where that is none.
    """

    store: Files
    plan: Plan
    files: dict[str, int]
    listed: dict[str, dict | None]

    @classmethod
    def of(cls, store: Files, plan: Plan) -> "Layout":
        """Look into a store.

        Raises
        ------
        StoreError
            If there are links in it, or metadata of arrays or groups that no stage of this program adds.
        """
        files = store.sizes()
        own = {ROWS, *layouts_of(plan)}
        for name in sorted(files):
            place, _, file = name.rpartition("/")
            if file.startswith(".z") or (file == METADATA and place and place not in own and not _is_added(place)):
                raise StoreError(
                    f"{store.place} is not allowed: {name[:200]!r} is no part of a store of this program; move it away"
                )
        store = store.at_hand(name for name in files if name.rpartition("/")[2] == METADATA)
        return cls(store, plan, files, listed_in(store))

    @property
    def path(self) -> Place:
        """Where the store is."""
        return self.store.place

    @property
    def groups(self) -> list[str]:
        """The added groups that are there; what has no metadata of its own and is not listed is half made or half taken
        away, and counts for nothing."""
        there = {name.partition("/")[0] for name in self.files}
        return [name for name in ADDED if name in there and (name in self.listed or f"{name}/{METADATA}" in self.files)]

    @cached_property
    def touched_blocks(self) -> list[Block]:
        """Blocks of which any chunk is there."""
        rows, along = row_layouts(self.plan), len(self.plan.row_axes)
        parts = (file.partition("/c/") for file in self.files)
        there = {tuple(index.split("/")[:along]) for name, _, index in parts if name in rows}
        blocks = self.plan.blocks if there else ()
        return [block for block in blocks if tuple(map(str, self.plan.chunk_of(block))) in there]

    @property
    def states(self) -> np.ndarray:
        """State of every row, (rows,); raises DamagedError where it cannot be read."""
        states = np.full(self.plan.rows, PENDING, np.uint8)
        status, place = row_layouts(self.plan)["status"], self.plan.place
        store = self.store.at_hand(next(status.files(*place(block))) for block in self.touched_blocks)
        for block in self.touched_blocks:
            states[block.start : block.stop] = read_states(store, self.plan, block)
        return states

    def refuse_hollow(self) -> None:
        """Raise if the plane is large and there is next to nothing in it: readers of rows make room for all of them.

        Raises
        ------
        StoreError
        """
        rows = row_layouts(self.plan)
        stored = sum(size for file, size in self.files.items() if file.partition("/c/")[0] in rows)
        if _is_hollow(self.plan.bytes, stored):
            raise StoreError(
                f"{self.path} has room for {self.plan.bytes:.3g} bytes and holds {stored}: "
                "next to nothing of it is computed, stages=[sweep] goes on with it"
            )


def validate_layout(store: Files, plan: Plan, attributes: dict, going_on: bool = False) -> Layout:
    """Look a store over; nothing in it is opened under a name that this program has not given.

    Parameters
    ----------
    store : Files
    plan : Plan
        As the store itself describes it.
    attributes : dict
        What the root says, from whichever copy is sound.
    going_on : bool
        Whether blocks that are not stored are written next, whatever a power loss has left of their chunks.

    Raises
    ------
    DamagedError
        If metadata is missing or says something else than its plan, or a chunk of a stored row is missing.
    StoreError
        If there are links or foreign arrays in it.
    """
    layout = Layout.of(store, plan)
    for damage in _faults(layout, attributes, going_on):
        raise damaged(store.place, damage.sentence)
    return layout


def _faults(layout: Layout, attributes: dict, going_on: bool) -> Iterator[Damage]:
    yield from _root(layout, attributes)
    yield from listing_faults(layout)
    yield from _plane(layout)
    for name in layout.groups:
        yield from group_faults(layout, name)
    yield from _chunks(layout, going_on)


def _is_added(place: str) -> bool:
    """Whether a stage may add a group or an array of this name."""
    group, slash, array = place.partition("/")
    return group in ADDED and (not slash or is_name(array))


def _root(layout: Layout, attributes: dict) -> Iterator[Damage]:
    """What the root says of the store."""
    told = document(layout.store, METADATA)
    if told is None:
        yield Damage(METADATA, "cannot be read" if METADATA in layout.files else "is missing")
    elif told.get("attributes") != attributes or not _is_group(told):
        yield Damage(METADATA, "does not say what it should")
    for name in {ROWS, *layouts_of(layout.plan)} - set(layout.listed):
        yield Damage(METADATA, f"does not list {name}")


def _is_group(told: dict) -> bool:
    return (told.get("node_type"), told.get("zarr_format")) == ("group", 3)


def listing_faults(layout: Layout) -> Iterator[Damage]:
    """Names that the root lists and nothing of this program has: zarr would open what is there, outside as well."""
    for name in sorted(set(layout.listed) - {ROWS, *layouts_of(layout.plan)}):
        if not _is_added(name):
            yield Damage(METADATA, f"lists {name[:80]!r}, which is no name of this program")


def _plane(layout: Layout) -> Iterator[Damage]:
    """Metadata of the plane's own arrays."""
    for name, expected in {ROWS: None, **layouts_of(layout.plan)}.items():
        file = f"{name}/{METADATA}"
        told = document(layout.store, file)
        if told is None:
            yield Damage(file, "cannot be read" if file in layout.files else "is missing")
        elif not _is_group(told) if expected is None else ArrayLayout.of_document(name, told) != expected:
            yield Damage(file, "does not say what it should")
        elif layout.listed.get(name) != told:
            yield Damage(METADATA, f"says something else than {file}")


def group_faults(layout: Layout, group: str) -> Iterator[Damage]:
    """Metadata and chunks of an added group; without a second copy of its metadata, what is in doubt is damaged."""
    there = {name.rpartition("/")[0] for name in layout.files if name.endswith(f"/{METADATA}")}
    inside = {name for name in there | set(layout.listed) if name.startswith(f"{group}/") and _is_added(name)}
    claimed = stored = 0
    store = _chunks_at_hand(layout, lambda name: name.startswith(f"{group}/"))
    for name in (group, *sorted(inside)):
        file = f"{name}/{METADATA}"
        told = document(layout.store, file)
        array = ArrayLayout.of_document(name, told)
        if told is None:
            yield Damage(file, "cannot be read" if file in layout.files else "is missing", group=group)
        elif layout.listed.get(name, told) != told:
            yield Damage(file, f"says something else than {METADATA}", group=group)
        elif name == group and _is_group(told):
            continue
        # Every chunk is a file, so that there are no more chunks than files.
        elif array is None or array.count > len(layout.files):
            yield Damage(file, "claims what this program does not write", group=group)
        else:
            for chunk in array.files():
                try:
                    claimed += claim_of(store, chunk, array)
                    stored += layout.files.get(chunk, 0)
                except ChunkError as error:
                    yield Damage(chunk, str(error), group=group)
            if _is_hollow(claimed, stored):
                yield Damage(file, f"claims {claimed} bytes, of which {stored} are there", group=group)


def _is_hollow(claimed: int, stored: int) -> bool:
    """Whether so many bytes cannot be what was compressed into so few, or are too few to matter."""
    return claimed > max(_UNSEEN, _MOST_COMPRESSED * stored)


def _chunks(layout: Layout, going_on: bool) -> Iterator[Damage]:
    """Chunks of axes and of rows: a missing one zarr would take for one that was never written, and of the others it
    would believe how many bytes they stand for."""
    rows, layouts = row_layouts(layout.plan), layouts_of(layout.plan)
    store = _chunks_at_hand(layout, layouts.__contains__)
    for name, array in layouts.items():
        for file in array.files() if name not in rows else ():
            if (fault := _claim_fault(store, file, array)) is not None:
                yield Damage(file, fault)
    for block in layout.touched_blocks:
        place = layout.plan.place(block)
        try:
            stored = bool(np.any(read_states(store, layout.plan, block) != PENDING))
        except DamagedError as error:
            yield Damage(error.what.split(" ", 1)[0], error.what.split(" ", 1)[1], block)
            continue
        for array in rows.values() if stored or not going_on else ():
            (file,) = array.files(*place)
            fault = _claim_fault(store, file, array)
            if fault is not None and (stored or fault != "is missing"):
                yield Damage(file, fault, block)


def _chunks_at_hand(layout: Layout, wanted: Callable[[str], bool]) -> Files:
    """The store with the chunks of some arrays at hand: of states and texts all of them, of others how they begin."""
    whole = {name for name, array in row_layouts(layout.plan).items() if name == "status" or array.kind == "string"}
    parts = ((file, *file.partition("/c/")[:2]) for file in layout.files)
    chunks = ((file, name in whole) for file, name, slash in parts if slash and wanted(name))
    first, second = itertools.tee(chunks)
    return layout.store.at_hand((file for file, all in first if all), (file for file, all in second if not all), HEADER)


def _claim_fault(store: Files, file: str, array: ArrayLayout) -> str | None:
    try:
        claim_of(store, file, array)
    except ChunkError as error:
        return str(error)
    return None
