"""A folder for what processes of a run keep while it lasts; those of runs that ended abruptly go with the next one.

Each folder has a file that its run holds locked. The system lets go of it however the run ends, so that a folder whose
file nobody holds belongs to nobody.
"""

import contextlib
import os
import shutil
import stat
import tempfile
from collections.abc import Iterator
from pathlib import Path

__all__ = ["scratch_folder"]

_PREFIX, _HELD = "bevelmap-run-", "held"


@contextlib.contextmanager
def scratch_folder() -> Iterator[Path]:
    """A new folder that nobody else can read, removed in the end."""
    _remove_left_behind(Path(tempfile.gettempdir()))
    folder = Path(tempfile.mkdtemp(prefix=_PREFIX))
    descriptor = _locked(folder / _HELD, os.O_CREAT)
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        if descriptor is not None:
            os.close(descriptor)


def _remove_left_behind(place: Path) -> None:
    """Remove folders of this user that no process holds."""
    for folder in place.glob(f"{_PREFIX}*"):
        with contextlib.suppress(OSError):
            found = folder.lstat()
            if not stat.S_ISDIR(found.st_mode) or (hasattr(os, "getuid") and found.st_uid != os.getuid()):
                continue
            # Without that file it is somebody else's, or has just been made.
            if (descriptor := _locked(folder / _HELD)) is not None:
                shutil.rmtree(folder, ignore_errors=True)
                os.close(descriptor)


def _locked(file: Path, flags: int = 0) -> int | None:
    """The open file, locked; None if another process holds it.

    Raises
    ------
    OSError
        If it cannot be opened.
    """
    from filelock import lock_descriptor

    descriptor = os.open(file, os.O_RDWR | flags | getattr(os, "O_NOFOLLOW", 0), 0o600)
    if lock_descriptor(descriptor, blocking=False):
        return descriptor
    os.close(descriptor)
    return None
