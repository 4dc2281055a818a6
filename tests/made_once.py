"""What several tests only read is made once in a session, by whichever of its processes needs it first."""

import shutil
from collections.abc import Callable
from pathlib import Path

from filelock import FileLock

__all__ = ["made_once", "share"]

_SHARED: list[Path] = []


def share(folder: Path) -> None:
    """Tell this process the folder that all processes of the session have in common."""
    _SHARED[:] = [folder]


def made_once(name: str, make: Callable[[Path], None]) -> Path:
    """The folder of a name, filled by the first who asks for it; not to be changed.

    Parameters
    ----------
    name : str
        Tells apart whatever differs: two callers with one name get one folder.
    make : callable
        Fills a new folder.

    Returns
    -------
    Path
    """
    (shared,) = _SHARED
    folder = shared / name
    with FileLock(shared / f"{name}.lock"):
        if not folder.exists():
            draft = shared / f"{name}.draft"
            # One whose making failed.
            shutil.rmtree(draft, ignore_errors=True)
            draft.mkdir()
            make(draft)
            draft.rename(folder)
    return folder
