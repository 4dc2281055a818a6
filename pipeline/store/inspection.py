"""What is damaged in a store, file by file.

Metadata is compared with the template that the store's own plan makes; every chunk of every stored row and of every
added group must be there and agree with its checksum.
"""

import contextlib
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

import google_crc32c
import numpy as np
import zarr

from pipeline.errors import StoreError
from pipeline.plan.plan import Plan
from pipeline.store.array_layout import ArrayLayout
from pipeline.store.arrays import axes_in_store, layouts_of, row_layouts
from pipeline.store.damage import Damage, damaged
from pipeline.store.documents import document
from pipeline.store.identity import plan_from, root_attributes
from pipeline.store.layout import Layout, group_faults, listing_faults
from pipeline.store.names import METADATA, ROWS
from pipeline.store.states import PENDING
from pipeline.store.template import create_again

__all__ = ["damage_error", "find_damage", "template_of"]

_CHECKSUM = 4


def find_damage(path: Path) -> list[Damage]:
    """Everything that is damaged in a store, one entry per file; nothing is written.

    Raises
    ------
    StoreError
        If there is no store, neither of the two places that say what it holds can be read, or there are links or
        foreign arrays in it.
    """
    with template_of(path) as (plan, template):
        layout = Layout.of(path, plan)
        found = [*listing_faults(layout), *_metadata(layout, template), *_axes(layout), *_rows(layout, template)]
        for group in layout.groups:
            found += [*group_faults(layout, group), *_group(layout, group)]
    return list({damage.file: damage for damage in reversed(found)}.values())[::-1]


@contextlib.contextmanager
def template_of(path: Path) -> Iterator[tuple[Plan, Path]]:
    """The plan of a store, and what the store would be with no row, made elsewhere for as long as it is needed."""
    attributes = root_attributes(path)
    plan = plan_from(attributes, path)
    with tempfile.TemporaryDirectory(prefix="bevelmap-") as folder:
        template = Path(folder) / path.name
        create_again(template, plan, attributes)
        yield plan, template


def _metadata(layout: Layout, template: Path) -> Iterator[Damage]:
    """Metadata of the plane that is missing or says something else, the root's list of it included."""
    root = document(layout.path / METADATA)
    for name in ("", ROWS, *layouts_of(layout.plan)):
        file = f"{name}/{METADATA}".lstrip("/")
        there, wanted = document(layout.path / file), document(template / file)
        if there is None:
            yield Damage(file, "cannot be read" if file in layout.files else "is missing")
        elif there != wanted:
            yield Damage(file, "does not say what it should")
        if name and root is not None and layout.listed.get(name) != wanted:
            yield Damage(METADATA, f"does not say what it should of {name}")


def _fault(file: Path) -> str | None:
    """What is wrong with a chunk file, by its checksum; None if nothing is."""
    try:
        content = file.read_bytes()
    except (FileNotFoundError, NotADirectoryError):
        return "is missing"
    except IsADirectoryError:
        return "is a folder"
    if not content:
        return "is empty"
    # As zarr's codec crc32c writes it: the last four bytes, little-endian.
    if google_crc32c.value(content[:-_CHECKSUM]) != int.from_bytes(content[-_CHECKSUM:], "little"):
        return "does not agree with its checksum"
    return None


def _axes(layout: Layout) -> Iterator[Damage]:
    arrays = layouts_of(layout.plan)
    for file in (file for name in axes_in_store(layout.plan) for file in arrays[name].files()):
        if (fault := _fault(layout.path / file)) is not None:
            yield Damage(file, fault)


def _rows(layout: Layout, template: Path) -> Iterator[Damage]:
    """Chunks of rows: of a block that is stored all must be there; those that are there must be sound."""
    path, plan, arrays = layout.path, layout.plan, row_layouts(layout.plan)
    for block in plan.blocks:
        place = plan.place(block)
        files = [file for array in arrays.values() for file in array.files(*place)]
        (status,) = arrays["status"].files(*place)
        # It is written first and last: where it is damaged, or gone and others are there, the block may be stored.
        pending = not any(file in layout.files for file in files) or (
            _fault(path / status) is None and _all_pending(path / status, template, status, place)
        )
        for file in files:
            fault = _fault(path / file)
            if fault is not None and not (pending and fault == "is missing"):
                yield Damage(file, fault, block)


def _all_pending(status: Path, template: Path, name: str, place: tuple) -> bool:
    """Whether a sound chunk of `status` says that none of its rows is stored; read with the template's metadata."""
    copy = template / name
    copy.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(status, copy)
    return bool(np.all(zarr.open_array(template / "status", mode="r")[place] == PENDING))


def _group(layout: Layout, group: str) -> Iterator[Damage]:
    """Chunks of an added group, of those arrays whose metadata is sound."""
    for name in sorted(name.rpartition("/")[0] for name in layout.files if name.startswith(f"{group}/")):
        array = ArrayLayout.of_document(name, document(layout.path / name / METADATA))
        for file in array.files() if array is not None and array.count <= len(layout.files) else ():
            if (fault := _fault(layout.path / file)) is not None:
                yield Damage(file, fault, group=group)


def damage_error(path: Path) -> StoreError | None:
    """What to say of an error that came up over a store: the first damaged file and the way on; None if all is well."""
    try:
        found = find_damage(path)
    except StoreError as refused:
        return refused
    return damaged(path, found[0].sentence) if found else None
