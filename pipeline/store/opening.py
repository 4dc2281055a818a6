"""Looking a store over before zarr opens it: it may be damaged, and it may come from someone else.

Names and metadata only, no values but `status`. Metadata is compared with the plan, so that no array can claim a size,
a type or a codec that this program does not write; zarr would believe it, and reads formats that run code (pickles).
"""

import json
import math
import os
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import zarr

from pipeline.errors import DamagedError, StoreError
from pipeline.plan.plan import Plan
from pipeline.store.arrays import arrays_of
from pipeline.store.chunks import Chunks
from pipeline.store.states import PENDING
from pipeline.store.template import sizes_of

__all__ = ["METADATA", "claimed", "damaged", "document", "files_of", "listed_in", "look_over", "most_added"]

METADATA = "zarr.json"
_MOST_BYTES = 2**24
_PLACE = re.compile(r"[A-Za-z]\w*(/[A-Za-z]\w*)?", re.ASCII)
_CODECS = {"bytes", "vlen-utf8", "zstd", "crc32c"}
#: Bytes per entry of the types that this program writes; of texts, room for a long one.
_TYPES = {
    "bool": 1,
    "int8": 1,
    "uint8": 1,
    "int16": 2,
    "uint16": 2,
    "int32": 4,
    "uint32": 4,
    "int64": 8,
    "uint64": 8,
    "float32": 4,
    "float64": 8,
    "string": 200,
}
#: What all added groups may claim together, in bytes, however small the plane.
_ADDED_BYTES = 2**30
#: The first version of the schema whose chunks are all written.
_WHOLE = 3


def look_over(path: Path, plan: Plan, attributes: dict) -> None:
    """Raise unless a store is what its plan says, as far as names and metadata tell.

    Parameters
    ----------
    path : Path
    plan : Plan
        As the store itself describes it.
    attributes : dict
        What the root says, from whichever copy is sound.

    Raises
    ------
    DamagedError
        If metadata is missing or says something else, or a chunk of a stored row is missing.
    StoreError
        If there is anything but files and folders in it.
    """
    files, whole = files_of(path), attributes["bevelmap_schema"] >= _WHOLE
    _check_claims(path, plan)
    for file, fault in _disagreements(path):
        raise damaged(path, f"{file} {fault}")
    if (document(path / METADATA) or {}).get("attributes") != attributes:
        raise damaged(path, f"{METADATA} does not say what it should")
    listed = listed_in(path)
    dims = sizes_of(plan)
    expected = {axis.name: ((axis.num,), "float64") for axis in plan.axes}
    for name, spec in arrays_of(plan).items():
        expected[name] = tuple(dims[dim] for dim in spec["dims"]), {"str": "string"}.get(spec["dtype"], spec["dtype"])
    for name, (shape, kind) in expected.items():
        if name not in listed:
            if not whole:
                continue
            raise damaged(path, f"{name}/{METADATA} is not listed")
        told = tuple(listed[name]["shape"])
        if told != shape or listed[name]["data_type"] != kind:
            raise damaged(
                path, f"{name}/{METADATA} claims {listed[name]['data_type']} {told}, its plane has {kind} {shape}"
            )
    if whole:
        _check_files(path, plan, listed, files)


def damaged(path: Path, what: str) -> DamagedError:
    """The error for a store of which `what` is damaged."""
    return DamagedError(f"{path} is damaged: {what}; stages=[check] lists and check.repair=true mends it")


def files_of(path: Path) -> set[str]:
    """Names of all files of a store.

    Raises
    ------
    StoreError
        If there is anything but files and folders in it: what is behind a link is outside the store.
    """
    found, waiting = set(), [path]
    while waiting:
        with os.scandir(waiting.pop()) as entries:
            for entry in entries:
                if entry.is_dir(follow_symlinks=False):
                    waiting.append(Path(entry.path))
                elif entry.is_file(follow_symlinks=False):
                    found.add(os.path.relpath(entry.path, path))
                else:
                    kind = "a link" if entry.is_symlink() else "neither a file nor a folder"
                    name = os.path.relpath(entry.path, path)
                    raise StoreError(f"{path} is not allowed: {name!r} is {kind}; a store has files and folders only")
    return found


def document(file: Path) -> dict | None:
    """Metadata without what is gathered from other files; None if it cannot be read."""
    return _alone(_read(file))


def _alone(told):
    return {key: told[key] for key in told if key != "consolidated_metadata"} if isinstance(told, dict) else None


def _read(file: Path) -> dict | None:
    try:
        if file.stat().st_size > _MOST_BYTES:
            return None
        read = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None
    return read if isinstance(read, dict) else None


def listed_in(path: Path) -> dict[str, dict]:
    """The metadata that the root gathers, which is what zarr goes by; empty if it cannot be read."""
    gathered = (_read(path / METADATA) or {}).get("consolidated_metadata")
    known = isinstance(gathered, dict) and (gathered.get("kind"), gathered.get("must_understand")) == ("inline", False)
    listed = gathered.get("metadata") if known else None
    return {name: _alone(told) for name, told in listed.items()} if isinstance(listed, dict) else {}


def _disagreements(path: Path) -> Iterator[tuple[str, str]]:
    """Metadata files that cannot be read, or of which the root says something else: name and fault.

    An added group that is listed and gone altogether is none: so a run leaves it that was killed while it took it away.
    """
    if document(path / METADATA) is None:
        yield METADATA, "cannot be read" if (path / METADATA).exists() else "is missing"
        return
    listed = listed_in(path)
    if "branches" not in listed:
        yield METADATA, "does not list what is in the store"
    for name, told in listed.items():
        file = path / name / METADATA
        if not (path / name.partition("/")[0]).exists() and name != "branches":
            continue
        there = document(file)
        if there is None:
            yield f"{name}/{METADATA}", "cannot be read" if file.exists() else "is missing"
        elif told != there:
            yield METADATA, f"says something else than {name}/{METADATA}"


def _check_claims(path: Path, plan: Plan) -> None:
    """Raise unless all metadata that the root lists is of a kind and of sizes that this program writes.

    Raises
    ------
    DamagedError
    """
    added = 0
    own = set(arrays_of(plan))
    for name, told in listed_in(path).items():
        if not _PLACE.fullmatch(name):
            raise damaged(path, f"{METADATA} lists {name[:80]!r}, which is no name of this program")
        if told is None or told.get("zarr_format") != 3 or told.get("node_type") not in ("group", "array"):
            raise damaged(path, f"{METADATA} lists {name} in a format that this program does not write")
        if told["node_type"] == "array":
            size = claimed(told)
            if size is None:
                raise damaged(path, f"{METADATA} lists {name} as an array that this program does not write")
            added += size if name not in own else 0
    if added > (most := most_added(plan)):
        raise damaged(path, f"{METADATA} claims {added:.3g} bytes beside the plane, where {most:.3g} are allowed")


def most_added(plan: Plan) -> int:
    """Bytes that arrays beside the plane may claim together."""
    return max(_ADDED_BYTES, plan.bytes)


def claimed(told: dict) -> int | None:
    """Bytes of an array, from its metadata; None if no array of this program looks like that."""
    try:
        if told["node_type"] != "array" or told["zarr_format"] != 3:
            return None
        codecs = [codec["name"] for codec in told["codecs"]]
        counts = [*told["shape"], *told["chunk_grid"]["configuration"]["chunk_shape"]]
        fine = set(codecs) <= _CODECS and all(type(count) is int and count >= 0 for count in counts)
        fine = fine and len(counts) == 2 * len(told["shape"]) and not told.get("storage_transformers")
        # A chunk may be as wide as its array and no wider.
        fine = fine and all(
            chunk <= max(size, 1) for size, chunk in zip(counts, counts[len(told["shape"]) :], strict=False)
        )
        return math.prod(told["shape"]) * _TYPES[told["data_type"]] if fine else None
    except (KeyError, TypeError, ValueError):
        return None


def _check_files(path: Path, plan: Plan, listed: dict, files: set[str]) -> None:
    """Raise if a chunk of an axis or of a stored row is missing: zarr would take it for one that was never written."""
    arrays = {name: Chunks.of(Path(name), told) for name, told in listed.items() if told["node_type"] == "array"}
    rowwise = arrays_of(plan)
    try:
        status = zarr.open_array(path / "status", mode="r")[:]
    except (ValueError, OSError, RuntimeError, IndexError):
        status = None
    for name, chunks in arrays.items():
        if name in rowwise or not (path / name.partition("/")[0]).exists() or 0 in chunks.shape:
            continue
        for file in chunks.files():
            if str(file) not in files:
                raise damaged(path, f"{file} is missing")
    if status is None:
        raise damaged(path, "status cannot be read")
    for block in plan.blocks:
        place = plan.place(block)
        if np.all(status[place] == PENDING):
            continue
        for name in rowwise:
            for file in arrays[name].files(*place):
                if str(file) not in files:
                    raise damaged(path, f"{file} is missing (rows {block.start}-{block.stop - 1})")
