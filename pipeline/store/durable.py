"""Files that are on the disk when a function returns: after a power loss they are whole under their names.

A disk that loses its power keeps what `fsync` was asked for; of any other file it may keep the name and not the bytes.
Names are not asked for: a journal keeps them in their order, and where one is lost all the same, a missing chunk of a
stored row is found when a run continues.
"""

import os
import uuid
from collections.abc import Collection, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

__all__ = ["settle", "write_all", "write_whole"]

#: Files that the disk is asked for at once: it writes them together, in about the time of a few.
_TOGETHER = 16


def settle(files: Collection[Path]) -> None:
    """Return when files are on the disk."""
    if len(files) == 1:
        # Threads would take longer to start.
        _settle(*files)
        return
    with ThreadPoolExecutor(max(1, min(_TOGETHER, len(files)))) as pool:
        list(pool.map(_settle, files))


def write_whole(file: Path, content: bytes) -> None:
    """Write a file, in place of what was there; its folder is made if need be."""
    write_all({file: content})


def write_all(contents: Mapping[Path, bytes]) -> None:
    """Write files, each in place of what was there, all of them on the disk before any has its name."""
    drafts = {}
    for file, content in contents.items():
        file.parent.mkdir(parents=True, exist_ok=True)
        # Named as zarr names what it has not finished, so that what a killed process leaves is known.
        drafts[file] = file.with_suffix(f".{uuid.uuid4().hex}.partial")
        drafts[file].write_bytes(content)
    settle(drafts.values())
    for file, draft in drafts.items():
        draft.replace(file)


def _settle(file: Path) -> None:
    descriptor = os.open(file, os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
