"""What is damaged in a store, file by file, and how to mend it.

Metadata is compared with the template that the store's own plan makes; every chunk of every stored row and of every
added group must be there and agree with its checksum. Damaged rows are marked as pending, so that a sweep computes
exactly their blocks again; damaged groups are taken away, so that their stages make them again.
"""

import contextlib
import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import google_crc32c
import numpy as np
import zarr

from pipeline.errors import DamagedError, StoreError
from pipeline.plan.plan import SCHEMA_VERSION, Block, Plan
from pipeline.store.arrays import arrays_of
from pipeline.store.chunks import Chunks
from pipeline.store.identity import plan_from, root_attributes
from pipeline.store.opening import METADATA, claimed, damaged, document, files_of, listed_in, most_added
from pipeline.store.removal import remove
from pipeline.store.states import PENDING
from pipeline.store.template import consolidate, create_again

__all__ = ["Damage", "damage_error", "find_damage", "mend", "remove_left_overs"]

#: What zarr leaves behind where a process is ended while it writes; never read.
_LEFT_OVER = "*.partial"
_CHECKSUM = 4


@dataclass(frozen=True)
class Damage:
    """One damaged file.

    Parameters
    ----------
    file : str
        Within the store.
    fault : str
        What is wrong with it.
    block : Block or None
        The rows that it belongs to; None for metadata and axes, and for groups.
    group : str or None
        The added group that it belongs to.
    """

    file: str
    fault: str
    block: Block | None = None
    group: str | None = None

    @property
    def sentence(self) -> str:
        """For the terminal."""
        whose = f" (rows {self.block.start}-{self.block.stop - 1})" if self.block else ""
        return f"{self.file} {self.fault}{whose}"


def find_damage(path: Path) -> list[Damage]:
    """Everything that is damaged in a store; nothing is written.

    Raises
    ------
    StoreError
        If there is no store, or neither of the two places that say what it holds can be read.
    """
    if path.exists():
        files_of(path)
    with _template(path) as (plan, template):
        found = [*_metadata(path, template), *_rows(path, template, plan)]
    for name in _added(path):
        found += _group(path, name, most_added(plan))
    return found


def mend(path: Path, damage: list[Damage]) -> None:
    """Put metadata and axes back, mark damaged rows as pending, take damaged groups away.

    Parameters
    ----------
    path : Path
    damage : list of Damage
        As `find_damage` gave it.
    """
    with _template(path) as (plan, template):
        own = [item for item in damage if item.group is None]
        for item in own:
            source = template / item.file
            if item.block is None and source.exists():
                (path / item.file).parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(source, path / item.file)
        # A damaged chunk that is only partly written again would have to be read first.
        for item in own:
            if item.block is not None:
                remove(path / item.file)
        for name in {item.group for item in damage if item.group is not None}:
            remove(path / name)
        consolidate(path)
        status = zarr.open_group(path, mode="r+")["status"]
        for block in {item.block for item in own if item.block is not None}:
            status[plan.place(block)] = PENDING


@contextlib.contextmanager
def _template(path: Path) -> Iterator[tuple[Plan, Path]]:
    """The plan of a store, and what the store would be with no row, made elsewhere for as long as it is needed."""
    attributes = root_attributes(path)
    plan = plan_from(attributes, path)
    with tempfile.TemporaryDirectory(prefix="bevelmap-") as folder:
        template = Path(folder) / path.name
        create_again(template, plan, attributes)
        yield plan, template


def _metadata(path: Path, template: Path) -> Iterator[Damage]:
    """Metadata files of the template that are missing or say something else, the root's list of all others included."""
    listed = listed_in(path)
    for expected in sorted(template.rglob(METADATA)):
        file = str(expected.relative_to(template))
        there, wanted, name = path / file, document(expected), str(expected.parent.relative_to(template))
        if not there.exists():
            yield Damage(file, "is missing")
        elif document(there) != wanted:
            yield Damage(file, "cannot be read" if document(there) is None else "does not say what it should")
        if document(path / METADATA) is not None and file != METADATA and listed.get(name) != wanted:
            yield Damage(METADATA, f"does not say what it should of {name}")


def _fault(file: Path) -> str | None:
    """What is wrong with a chunk file, by its checksum; None if nothing is."""
    try:
        content = file.read_bytes()
    except FileNotFoundError:
        return "is missing"
    except IsADirectoryError:
        return "is a folder"
    if not content:
        return "is empty"
    # As zarr's codec crc32c writes it: the last four bytes, little-endian.
    if google_crc32c.value(content[:-_CHECKSUM]) != int.from_bytes(content[-_CHECKSUM:], "little"):
        return "does not agree with its checksum"
    return None


def _rows(path: Path, template: Path, plan: Plan) -> Iterator[Damage]:
    """Chunks of axes and rows: of a block that is stored all must be there; those that are there must be sound."""
    arrays = {}
    for metadata in template.rglob(METADATA):
        told, name = document(metadata), str(metadata.parent.relative_to(template))
        if told["node_type"] == "array":
            arrays[name] = Chunks.of(path / name, told)
    rowwise = set(arrays_of(plan))
    for name in sorted(arrays.keys() - rowwise):
        for file in arrays[name].files():
            if (fault := _fault(file)) is not None:
                yield Damage(str(file.relative_to(path)), fault)
    for block in plan.blocks:
        place = plan.place(block)
        files = [file for name in sorted(rowwise) for file in arrays[name].files(*place)]
        (status,) = arrays["status"].files(*place)
        # It is written first and last: where it is damaged, or gone and others are there, the block may be stored.
        pending = not any(file.exists() for file in files) or (
            _fault(status) is None and _all_pending(status, path, template, place)
        )
        for file in files:
            fault = _fault(file)
            if fault is not None and not (pending and fault == "is missing"):
                yield Damage(str(file.relative_to(path)), fault, block)


def _all_pending(status: Path, path: Path, template: Path, place: tuple) -> bool:
    """Whether a sound chunk of `status` says that none of its rows is stored; read with the template's metadata."""
    copy = template / status.relative_to(path)
    copy.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(status, copy)
    return bool(np.all(zarr.open_array(template / "status", mode="r")[place] == PENDING))


def _added(path: Path) -> list[str]:
    """Folders of groups that stages have added: groups by their own metadata, or by the root's."""
    listed = {name.partition("/")[0] for name in listed_in(path) if "/" in name} - {"branches"}
    groups = {
        folder.name for folder in path.iterdir() if (document(folder / METADATA) or {}).get("node_type") == "group"
    }
    return sorted({name for name in listed | groups if (path / name).is_dir()} - {"branches"})


def _group(path: Path, name: str, most: int) -> Iterator[Damage]:
    """Damage in a group that a stage has added; without a second copy of its metadata, what is in doubt is damaged."""
    listed, size = listed_in(path), 0
    children = {f"{name}/{child.name}" for child in (path / name).iterdir() if child.is_dir()}
    for place in (name, *sorted(children | {other for other in listed if other.startswith(f"{name}/")})):
        file = f"{place}/{METADATA}"
        told = document(path / file)
        if told is None:
            yield Damage(file, "cannot be read" if (path / file).exists() else "is missing", None, name)
            continue
        if place in listed and listed[place] != told:
            yield Damage(file, f"says something else than {METADATA}", None, name)
        if told.get("node_type") == "group" and place == name and told.get("zarr_format") == 3:
            continue
        bytes_ = claimed(told)
        size += bytes_ or 0
        if bytes_ is None or size > most:
            yield Damage(file, "claims what this program does not write", None, name)
            continue
        for chunk in Chunks.of(path / place, told).files():
            if (fault := _fault(chunk)) is not None:
                yield Damage(str(chunk.relative_to(path)), fault, None, name)


def remove_left_overs(path: Path) -> None:
    """Remove what killed processes left half written; the store must be held."""
    for file in path.rglob(_LEFT_OVER):
        file.unlink(missing_ok=True)


def damage_error(path: Path, error: Exception) -> StoreError | None:
    """What to say where `error` came up over a store: the first damaged file and the way on; None if all is well."""
    try:
        if (version := root_attributes(path)["bevelmap_schema"]) < SCHEMA_VERSION:
            said = " ".join(str(error).split())
            return DamagedError(
                f"{path} cannot be read ({said}); being of schema {version}, it has no checksums to mend it by"
            )
        found = find_damage(path)
    except StoreError as refused:
        return refused
    return damaged(path, found[0].sentence) if found else None
