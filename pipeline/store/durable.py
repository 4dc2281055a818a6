"""Files that are on the disk when a function returns: after a power loss they are whole under their names.

A disk that loses its power keeps what `fsync` was asked for; of any other file it may keep the name and not the bytes.
Names are not asked for: a journal keeps them in their order, and where one is lost all the same, a missing chunk of a
stored row is found when a run continues.
"""

import os
import uuid
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

__all__ = ["move_whole", "settle", "write_whole"]

#: Files that the disk is asked for at once: it writes them together, in about the time of a few.
_TOGETHER = 16


def settle(files: Iterable[Path]) -> None:
    """Return when files are on the disk."""
    with ThreadPoolExecutor(_TOGETHER) as pool:
        list(pool.map(_settle, files))


def move_whole(draft: Path, folder: Path) -> None:
    """Give a folder its name when everything in it is on the disk."""
    settle(file for file in draft.rglob("*") if file.is_file())
    draft.rename(folder)


def write_whole(file: Path, content: bytes) -> None:
    """Write a file, in place of what was there; its folder is made if need be."""
    file.parent.mkdir(parents=True, exist_ok=True)
    # Named as zarr names what it has not finished, so that what a killed process leaves is known.
    draft = file.with_suffix(f".{uuid.uuid4().hex}.partial")
    draft.write_bytes(content)
    _settle(draft)
    draft.replace(file)


def _settle(file: Path) -> None:
    descriptor = os.open(file, os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
