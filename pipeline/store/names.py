"""Names of the files of a store. Nothing in a store is opened, written or removed under any other name."""

import contextlib
import os
import re
from pathlib import Path

from pipeline.errors import StoreError

__all__ = ["ADDED", "GROUP_FILE", "IN_BLOCKS", "LEFT_OVER", "METADATA", "ROWS", "STORE_FILE", "files_of", "is_name"]

METADATA = "zarr.json"
#: The group that the rows themselves fill.
ROWS = "branches"
#: Groups that stages add, arrays in them and no further groups.
ADDED = ("attractors", "boundaries", "isolated", "places")
#: Those of them that are written block by block; see `pipeline.store.row_groups`.
IN_BLOCKS = ("attractors",)

_NAME = r"[A-Za-z]\w{0,79}"
_PARTIAL = r"\.[0-9a-f]{32}\.partial"
_ARRAY = rf"zarr(\.json|{_PARTIAL})|c(/\d{{1,9}})+({_PARTIAL})?"
#: Metadata and chunks as zarr names them, those that are half written included: relative to a store, or to a group.
STORE_FILE = re.compile(rf"zarr{_PARTIAL}|({_NAME}/){{0,2}}({_ARRAY})", re.ASCII)
GROUP_FILE = re.compile(rf"({_NAME}/)?({_ARRAY})", re.ASCII)
#: What zarr leaves behind where a process is ended while it writes; never read.
LEFT_OVER = re.compile(rf".*{_PARTIAL}", re.ASCII)


def is_name(text: str) -> bool:
    """Whether an array of this program may be called so.

    Examples
    --------
    >>> is_name("domain_low"), is_name(".."), is_name("a/b"), is_name("")
    (True, False, False, False)
    """
    return re.fullmatch(_NAME, text, re.ASCII) is not None


def files_of(folder: Path) -> dict[str, int]:
    """All files below a folder, in it by name, and their sizes in bytes.

    Raises
    ------
    StoreError
        If there is anything but files and folders: what is behind a link is outside.
    """
    found, waiting = {}, [("", folder)]
    while waiting:
        prefix, place = waiting.pop()
        for entry in _entries(place, missing_ok=bool(prefix)):
            name = prefix + entry.name
            if entry.is_dir(follow_symlinks=False):
                waiting.append((f"{name}/", entry.path))
            elif entry.is_file(follow_symlinks=False):
                # A run may rename a file that it has written, or take a group away, meanwhile.
                with contextlib.suppress(FileNotFoundError):
                    found[name] = entry.stat(follow_symlinks=False).st_size
            else:
                kind = "a link" if entry.is_symlink() else "neither a file nor a folder"
                raise StoreError(f"{folder} is not allowed: {name!r} is {kind}; a store has files and folders only")
    return found


def _entries(place, missing_ok: bool) -> list[os.DirEntry]:
    try:
        with os.scandir(place) as entries:
            return list(entries)
    except FileNotFoundError:
        if missing_ok:
            return []
        raise
