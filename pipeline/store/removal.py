"""Removing files by names that this program gives, and folders only when they are empty."""

import contextlib
import os
import re
from pathlib import Path

from pipeline.errors import StoreError
from pipeline.store.names import files_of

__all__ = ["refuse_unknown", "remove_file", "remove_known"]


def remove_file(file: Path) -> None:
    """Remove a file, or an empty folder that is in its place, if there is one.

    Raises
    ------
    StoreError
        If there is a folder with something in it.
    """
    if file.is_dir() and not file.is_symlink():
        try:
            file.rmdir()
        except OSError:
            raise StoreError(f"{file} cannot be removed: it should be a file, and is a folder; move it away") from None
    else:
        with contextlib.suppress(FileNotFoundError, NotADirectoryError):
            file.unlink()


def remove_known(folder: Path, known: re.Pattern) -> None:
    """Remove a folder of which every file has a name that `known` matches; of a link, the link alone.

    Raises
    ------
    StoreError
        If anything else is in it; then nothing is removed.
    """
    if folder.is_symlink():
        folder.unlink()
    if not folder.exists():
        return
    refuse_unknown(folder, known)
    # By descriptors of folders, so that none of them can be exchanged for a link meanwhile.
    for place, folders, files, descriptor in os.fwalk(folder, topdown=False):
        prefix = Path(place).relative_to(folder)
        for name in files:
            if known.fullmatch(str(prefix / name)):
                os.unlink(name, dir_fd=descriptor)
        for name in folders:
            with contextlib.suppress(OSError):
                os.rmdir(name, dir_fd=descriptor)
    folder.rmdir()


def refuse_unknown(folder: Path, known: re.Pattern) -> None:
    """Raise unless every file in a folder has a name that `known` matches.

    Raises
    ------
    StoreError
        Naming a file that has not.
    """
    for name in sorted(files_of(folder)):
        if not known.fullmatch(name):
            raise StoreError(
                f"{folder} cannot be removed: {name[:200]!r} in it is no file of this program; move it away first"
            )
