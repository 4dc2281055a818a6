"""Removing what may be a file, a folder or a link; through a link nothing is removed."""

import contextlib
import shutil
from pathlib import Path

__all__ = ["remove"]


def remove(path: Path) -> None:
    """Remove whatever is at `path`, if anything."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        with contextlib.suppress(FileNotFoundError, NotADirectoryError):
            path.unlink()
