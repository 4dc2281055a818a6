"""What is damaged in a store, file by file.

Metadata is compared with the template that the store's own plan makes; every chunk of every stored row and of every
added group must be there and agree with its checksum.
"""

import functools
import json
from collections.abc import Iterator

from pipeline.config.places import Place
from pipeline.errors import DamagedError, StoreError
from pipeline.plan.plan import Plan, plan_of
from pipeline.store.array_layout import ArrayLayout
from pipeline.store.arrays import axes_in_store, layouts_of, row_layouts
from pipeline.store.block_states import is_stored
from pipeline.store.chunk_files import fault_of, read_chunk
from pipeline.store.damage import Damage, damaged
from pipeline.store.documents import document, document_of
from pipeline.store.files import Files, files_at
from pipeline.store.identity import plan_from, root_attributes
from pipeline.store.layout import Layout, group_faults, listing_faults
from pipeline.store.names import METADATA, ROWS
from pipeline.store.template import template_files

__all__ = ["damage_error", "find_damage", "template_of"]


#: Chunks of a group that are looked at with one delay.
_TOGETHER = 64


def find_damage(path: Place) -> list[Damage]:
    """Everything that is damaged in a store, one entry per file; nothing is written.

    Raises
    ------
    StoreError
        If there is no store, neither of the two places that say what it holds can be read, or there are links or
        foreign arrays in it.
    """
    files = files_at(path)
    plan, template = template_of(files)
    layout = Layout.of(files, plan)
    found = [*listing_faults(layout), *_metadata(layout, template), *_axes(layout), *_rows(layout)]
    for group in layout.groups:
        found += _group(layout, group)
    return list({damage.file: damage for damage in reversed(found)}.values())[::-1]


def template_of(files: Files) -> tuple[Plan, dict[str, bytes]]:
    """The plan of a store, and what its files would hold if it had no row."""
    attributes = root_attributes(files)
    return plan_from(attributes, files.place), _template(json.dumps(attributes))


@functools.lru_cache(maxsize=4)
def _template(attributes: str) -> dict[str, bytes]:
    """It is asked for before and after a repair."""
    told = json.loads(attributes)
    return template_files(plan_of(json.loads(told["numbers"])), told)


def _metadata(layout: Layout, template: dict[str, bytes]) -> Iterator[Damage]:
    """Metadata of the plane that is missing or says something else, the root's list of it included."""
    root = document(layout.store, METADATA)
    for name in ("", ROWS, *layouts_of(layout.plan)):
        file = f"{name}/{METADATA}".lstrip("/")
        there, wanted = document(layout.store, file), document_of(template[file])
        if there is None:
            yield Damage(file, "cannot be read" if file in layout.files else "is missing")
        elif there != wanted:
            yield Damage(file, "does not say what it should")
        if name and root is not None and layout.listed.get(name) != wanted:
            yield Damage(METADATA, f"does not say what it should of {name}")


def _axes(layout: Layout) -> Iterator[Damage]:
    """Chunks of axes, with the values that the plan gives them."""
    arrays = layouts_of(layout.plan)
    for name, axis in axes_in_store(layout.plan).items():
        (file,) = arrays[name].files()
        if (fault := fault_of(layout.store, file, arrays[name])) is not None:
            yield Damage(file, fault)
        elif read_chunk(layout.store, file, arrays[name]).tobytes() != axis.values.tobytes():
            yield Damage(file, "does not hold the values that it should")


def _rows(layout: Layout) -> Iterator[Damage]:
    """Chunks of rows: of a block that is stored all must be there; those that are there must be sound."""
    plan, arrays = layout.plan, row_layouts(layout.plan)
    for block in layout.touched_blocks:
        files = {array.name: next(array.files(*plan.place(block))) for array in arrays.values()}
        store = layout.store.at_hand(files.values())
        # It is written first and last: where it is damaged, or gone and others are there, the block may be stored.
        try:
            pending = store.has(files["status"]) and not is_stored(store, plan, block)
        except DamagedError:
            pending = False
        for name, file in files.items():
            fault = fault_of(store, file, arrays[name])
            if fault is not None and not (pending and fault == "is missing"):
                yield Damage(file, fault, block)


def _group(layout: Layout, group: str) -> Iterator[Damage]:
    """What is wrong with an added group; only if its metadata and sizes are sound are its chunks read."""
    if found := list(group_faults(layout, group)):
        yield from found
        return
    for name in sorted({file.partition("/c/")[0] for file in layout.files if file.startswith(f"{group}/")}):
        array = ArrayLayout.of_document(name, document(layout.store, f"{name}/{METADATA}"))
        chunks = list(array.files()) if array is not None else []
        for start in range(0, len(chunks), _TOGETHER):
            store = layout.store.at_hand(chunks[start : start + _TOGETHER])
            for file in chunks[start : start + _TOGETHER]:
                if (fault := fault_of(store, file, array)) is not None:
                    yield Damage(file, fault, group=group)


def damage_error(path: Place) -> StoreError | None:
    """What to say of an error that came up over a store: the first damaged file and the way on; None if all is well."""
    try:
        found = find_damage(path)
    except StoreError as refused:
        return refused
    return damaged(path, found[0].sentence) if found else None
