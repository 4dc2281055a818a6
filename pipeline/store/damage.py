"""What is damaged in a store, file by file, and how to mend it.

Metadata is compared with the template that the store's own plan makes; every chunk of every stored row and of every added
group must be there and agree with its checksum. Damaged rows are marked as pending, so that a sweep computes exactly their
blocks again; damaged groups are taken away, so that their stages make them again.
"""

import contextlib
import json
import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import google_crc32c
import numpy as np
import zarr

from pipeline.errors import StoreError
from pipeline.plan import Block, Plan
from pipeline.store.arrays import arrays_of
from pipeline.store.identity import plan_from, root_attributes
from pipeline.store.states import PENDING
from pipeline.store.template import consolidate, create_again

__all__ = ["Damage", "damage_error", "find_damage", "mend", "remove_left_overs"]

_METADATA = "zarr.json"
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
    with _template(path) as (plan, template):
        found = [*_metadata(path, template), *_rows(path, template, plan)]
    for name in _added(path):
        found += _group(path, name)
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
                (path / item.file).unlink(missing_ok=True)
        for name in {item.group for item in damage if item.group is not None}:
            shutil.rmtree(path / name)
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
    """Metadata files of the template that are missing or say something else."""
    for expected in sorted(template.rglob(_METADATA)):
        file = str(expected.relative_to(template))
        there = path / file
        if not there.exists():
            yield Damage(file, "is missing")
        elif _document(there) != _document(expected):
            yield Damage(file, "cannot be read" if _document(there) is None else "does not say what it should")


def _document(file: Path) -> dict | None:
    """Metadata without what is gathered from other files; None if it cannot be read."""
    try:
        document = json.loads(file.read_text(encoding="utf-8"))
        document.pop("consolidated_metadata", None)
        return document
    except (OSError, ValueError, AttributeError):
        return None


@dataclass(frozen=True)
class _Chunks:
    """The chunk files of one array: its folder, and its shape and that of its chunks."""

    folder: Path
    shape: tuple[int, ...]
    chunks: tuple[int, ...]

    @classmethod
    def of(cls, folder: Path, document: dict) -> "_Chunks":
        """The chunks of an array whose metadata is `document`."""
        return cls(folder, tuple(document["shape"]), tuple(document["chunk_grid"]["configuration"]["chunk_shape"]))

    def files(self, *place: int | slice) -> list[Path]:
        """Files of the chunks that a place along the first axes touches; of all chunks unless told."""
        ends = [(at.start, at.stop) if isinstance(at, slice) else (at, at + 1) for at in place]
        ends += [(0, size) for size in self.shape[len(place) :]]
        along = (range(low // chunk, -(-high // chunk)) for (low, high), chunk in zip(ends, self.chunks, strict=True))
        return [self.folder.joinpath("c", *map(str, numbers)) for numbers in product(*along)]


def _fault(file: Path) -> str | None:
    """What is wrong with a chunk file, by its checksum; None if nothing is."""
    try:
        content = file.read_bytes()
    except FileNotFoundError:
        return "is missing"
    if not content:
        return "is empty"
    # As zarr's codec crc32c writes it: the last four bytes, little-endian.
    if google_crc32c.value(content[:-_CHECKSUM]) != int.from_bytes(content[-_CHECKSUM:], "little"):
        return "does not agree with its checksum"
    return None


def _rows(path: Path, template: Path, plan: Plan) -> Iterator[Damage]:
    """Chunks of axes and rows: of a block that is stored all must be there; those that are there must be sound."""
    arrays = {}
    for metadata in template.rglob(_METADATA):
        document, name = _document(metadata), str(metadata.parent.relative_to(template))
        if document["node_type"] == "array":
            arrays[name] = _Chunks.of(path / name, document)
    rowwise = set(arrays_of(plan))
    for name in sorted(arrays.keys() - rowwise):
        for file in arrays[name].files():
            if (fault := _fault(file)) is not None:
                yield Damage(str(file.relative_to(path)), fault)
    for block in plan.blocks:
        place = plan.place(block)
        files = [file for name in sorted(rowwise) for file in arrays[name].files(*place)]
        (status,) = arrays["status"].files(*place)
        # Where the status itself is damaged, the block may have been stored.
        pending = not status.exists() and not any(file.exists() for file in files) or (
            _fault(status) is None and _all_pending(status, path, template, place)
        )  # fmt: skip
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
    """Folders of groups that stages have added."""
    return sorted(folder.name for folder in path.iterdir()
                  if folder.is_dir() and folder.name != "branches" and not (folder / "c").is_dir()
                  and any(child.is_dir() and child.name != "c" for child in folder.iterdir()))  # fmt: skip


def _group(path: Path, name: str) -> Iterator[Damage]:
    """Damage in a group that a stage has added; its metadata has no second copy, so that it must be readable."""
    folder = path / name
    for child in (folder, *sorted(child for child in folder.iterdir() if child.is_dir())):
        file = child / _METADATA
        document = _document(file)
        if document is None:
            yield Damage(str(file.relative_to(path)), "cannot be read" if file.exists() else "is missing", None, name)
            continue
        if document.get("node_type") != "array" or 0 in document["shape"]:
            continue
        for chunk in _Chunks.of(child, document).files():
            if (fault := _fault(chunk)) is not None:
                yield Damage(str(chunk.relative_to(path)), fault, None, name)


def remove_left_overs(path: Path) -> None:
    """Remove what killed processes left half written; the store must be held."""
    for file in path.rglob(_LEFT_OVER):
        file.unlink(missing_ok=True)


def damage_error(path: Path) -> StoreError | None:
    """An error that names the first damaged file and the way on; None if nothing is damaged."""
    try:
        found = find_damage(path)
    except StoreError as error:
        return error
    return StoreError(f"{path} is damaged: {found[0].sentence}; stages=[check] lists and mends it") if found else None
