"""Files that are on the disk when a function returns: after a power loss they are whole under their names.

A disk that loses its power keeps what `fsync` was asked for; of all else it may keep the name and not the bytes.
"""

import errno
import os
import uuid
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

__all__ = ["move_whole", "settle", "write_whole"]

#: Files that are handed to the disk at once: it writes them together, in about the time of one.
_TOGETHER = 16


def settle(folder: Path, files: Iterable[str]) -> None:
    """Return when files are on the disk, and their names in all folders up to `folder`.

    Parameters
    ----------
    folder : Path
    files : iterable of str
        Names in it.
    """
    names = [Path(file) for file in files]
    parents = {parent for name in names for parent in name.parents}
    with ThreadPoolExecutor(_TOGETHER) as pool:
        list(pool.map(_settle_file, [folder / name for name in names]))
        list(pool.map(_settle_names, [folder / parent for parent in parents]))


def move_whole(draft: Path, folder: Path) -> None:
    """Give a folder its name when everything in it is on the disk."""
    settle(draft, [str(file.relative_to(draft)) for file in draft.rglob("*") if file.is_file()])
    draft.rename(folder)
    _settle_names(folder.parent)


def write_whole(file: Path, content: bytes) -> None:
    """Write a file, in place of what was there; its folder is made if need be."""
    file.parent.mkdir(parents=True, exist_ok=True)
    # Named as zarr names what it has not finished, so that what a killed process leaves is known.
    draft = file.with_suffix(f".{uuid.uuid4().hex}.partial")
    draft.write_bytes(content)
    _settle_file(draft)
    draft.replace(file)
    _settle_names(file.parent)


def _settle_file(file: Path) -> None:
    descriptor = os.open(file, os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _settle_names(folder: Path) -> None:
    """The names of what was made or moved in a folder; some systems cannot be asked, and keep their order anyway."""
    if os.name != "posix":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno != errno.EINVAL:
            raise
    finally:
        os.close(descriptor)
