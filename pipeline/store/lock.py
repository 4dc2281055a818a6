"""One writer per store: a lock beside it.

Beside a folder it is a file with the operating system's own lock on it (`flock`, on Windows `LockFileEx`), which goes
with the process however that ends; a file that is left behind locks nothing, and what it says is only for people. A
network file system must pass `flock` on (Linux's NFS does). In an object store it is a lease: `pipeline.store.lease`.
"""

import contextlib
import json
import os
import socket
import time
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from pathlib import Path

from pipeline.config.places import ObjectPlace, Place
from pipeline.errors import StoreError

__all__ = ["check_held", "exclusive_lock", "let_go", "lock_path"]

_EVERY = 0.2
#: Lock files that this process holds.
_HELD: set[Path] = set()


def lock_path(path: Path) -> Path:
    """The lock file of the store at `path`."""
    return path.with_name(f".{path.name}.lock")


def exclusive_lock(path: Place, wait: bool, say: Callable[[str], None]) -> contextlib.AbstractContextManager[bool]:
    """Hold the store at `path` for writing, while in the block.

    Parameters
    ----------
    path : Place
    wait : bool
        Whether to wait for another run to end.
    say : callable
        Takes a line about a wait, or about a run that ended without tidying up.

    Yields
    ------
    bool
        Whether it had to wait: then the store is not what it was.

    Raises
    ------
    StoreError
        If another process holds it and `wait` is false: host, process and since when.
    """
    return _holding_file(path, wait, say) if isinstance(path, Path) else _leasing(path, wait, say)


@contextlib.contextmanager
def _leasing(place: ObjectPlace, wait: bool, say: Callable[[str], None]) -> Iterator[bool]:
    # What they stand on takes a while to load.
    from pipeline.store.lease import leased
    from pipeline.store.objects import explained, of_bucket

    with contextlib.ExitStack() as stack:
        with explained(place):
            name = place.with_name(f".{place.name}.lease").key
            waited = stack.enter_context(leased(of_bucket(place), name, str(place), wait, say))
        yield waited


@contextlib.contextmanager
def _holding_file(path: Path, wait: bool, say: Callable[[str], None]) -> Iterator[bool]:
    place = lock_path(path)
    made = [folder for folder in (place.parent, *place.parent.parents) if not folder.exists()]
    place.parent.mkdir(parents=True, exist_ok=True)
    told = False
    while (descriptor := _attempt(place)) is None:
        holder = _holder(place)
        if not wait:
            raise StoreError(f"{path} is in use by {holder}: wait for it, or say store.wait=true")
        if not told:
            say(f"store: {path} is in use by {holder}, waiting")
            told = True
        time.sleep(_EVERY)
    _HELD.add(place)
    try:
        if os.fstat(descriptor).st_size:
            say(f"store: {_holder(place)} ended without letting go of {path}, going on")
        _sign(descriptor)
        yield told
    finally:
        # First the name, then the lock: who waits finds that the name has gone, and tries again. A folder that can no
        # longer be written, or has gone, must not hide why the run ended.
        with contextlib.suppress(OSError):
            place.unlink()
        _HELD.discard(place)
        os.close(descriptor)
        # Where nothing was written, nothing is left.
        with contextlib.suppress(OSError):
            for folder in made:
                folder.rmdir()


def check_held(place: Place) -> None:
    """Raise if this process held a store and another run has taken it over, as it may where the lock is a lease.

    Raises
    ------
    LeaseLost
    Unreachable
        If that cannot be known.
    """
    if isinstance(place, Path):
        return
    from pipeline.store import lease
    from pipeline.store.objects import explained

    with explained(place):
        lease.check_held(str(place))


def let_go() -> None:
    """Remove the lock files that this process holds, which is about to end; the locks go with it."""
    for place in list(_HELD):
        with contextlib.suppress(OSError):
            place.unlink()


def _attempt(place: Path) -> int | None:
    """An open, locked file under that name, or None if another process has it."""
    from filelock import lock_descriptor  # takes a while to import, and most stages need no lock

    # A link in its place would have the file that it leads to overwritten.
    descriptor = os.open(place, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o644)
    with contextlib.suppress(FileNotFoundError):
        if lock_descriptor(descriptor, blocking=False) and place.stat().st_ino == os.fstat(descriptor).st_ino:
            return descriptor
    os.close(descriptor)
    return None


def _sign(descriptor: int) -> None:
    """Write who holds it, where there is room on the disk: the lock holds without."""
    since = datetime.now(UTC).isoformat(timespec="seconds")
    text = json.dumps({"host": socket.gethostname(), "pid": os.getpid(), "since": since})
    with contextlib.suppress(OSError):
        os.ftruncate(descriptor, 0)
        os.lseek(descriptor, 0, os.SEEK_SET)
        os.write(descriptor, text.encode())


def _holder(place: Path) -> str:
    """Who signed it, in words."""
    try:
        signed = json.loads(place.read_text(encoding="utf-8"))
        return f"process {int(signed['pid'])} on {str(signed['host'])[:80]} since {str(signed['since'])[:40]}"
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return "another process"
