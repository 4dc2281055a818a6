"""Compiled kernels on disk: one file each, in a folder that nobody else can change, believed with its checksum only.

What is read is unpickled and its machine code runs, so whoever can write an entry can run code as this user. The folder
must therefore belong to this user with mode 0700, and nobody else may be able to exchange it or one of its parents. An
entry that is empty, cut short or damaged is removed. Where nothing can be kept, one line says so.
"""

import atexit
import contextlib
import functools
import hashlib
import logging
import os
import shutil
import stat
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

__all__ = ["KernelStore", "kernel_store", "why_distrusted"]

#: Entries of one kernel: of several versions, processors and sets of numba's settings.
_MOST_KEPT = 16
_LOG = logging.getLogger(__name__)


def _trusted_owners() -> set[int]:
    """This user and root, and what root outside a user namespace (a container without privileges) shows as inside."""
    owners = {0, os.geteuid()}
    with contextlib.suppress(OSError, ValueError):
        unmapped = int(Path("/proc/sys/fs/overflowuid").read_text())
        ranges = [[int(word) for word in line.split()] for line in Path("/proc/self/uid_map").read_text().splitlines()]
        if not any(first <= unmapped < first + count for first, _, count in ranges):
            owners.add(unmapped)
    return owners


def why_distrusted(folder: Path) -> str | None:
    """Why another user could have put something into a folder, None where nobody could; links are not followed."""
    others_write, owners = stat.S_IWGRP | stat.S_IWOTH, _trusted_owners()
    for part in (folder, *folder.parents):
        state = part.lstat()
        mode = stat.S_IMODE(state.st_mode)
        if not stat.S_ISDIR(state.st_mode):
            return f"{part} is not a folder"
        if state.st_uid != os.geteuid() and (part == folder or state.st_uid not in owners):
            return f"{part} belongs to another user"
        # Where the sticky bit is set, as in /tmp, others can neither move nor remove what is not theirs.
        if mode & others_write and (part == folder or not mode & stat.S_ISVTX):
            return f"{part} can be written by other users (mode {mode:04o})"
    return None


def _own_folder(home: Path) -> Path:
    """The folder for kernels in `home`, made if need be; raises OSError where it cannot be trusted or written."""
    home.mkdir(mode=0o700, parents=True, exist_ok=True)
    folder = home.resolve() / "bevelmap"
    folder.mkdir(mode=0o700, exist_ok=True)
    reason = why_distrusted(folder)
    if reason is None and not os.access(folder, os.W_OK | os.X_OK):
        reason = f"{folder} cannot be written"
    if reason is not None:
        raise PermissionError(reason)
    folder.chmod(0o700)
    return folder


class KernelStore:
    """Compiled kernels by name: in the user's cache folder, else in a private one for this run, else nowhere.

    The folder is `bevelmap` in NUMBA_CACHE_DIR, else XDG_CACHE_HOME, else ~/.cache. A private one is removed when this
    process ends; processes that it starts find it in NUMBA_CACHE_DIR.
    """

    _HEAD = b"bevelmap kernel 1\n"

    def __init__(self):
        self._keeps, self._is_private = True, False
        #: Entries that this process made.
        self.made = 0
        self._folders: list[Path] = []
        try:
            home = os.environ.get("NUMBA_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME")
            self._folders.append(_own_folder(Path(home) if home else Path.home() / ".cache"))
        except (OSError, RuntimeError) as error:  # RuntimeError: there is no home directory
            self._retreat(error)

    @property
    def folder(self) -> Path | None:
        """Where new entries are kept; None if nowhere."""
        return self._folders[-1] if self._keeps else None

    def _retreat(self, error: Exception) -> None:
        """Keep new entries in a private folder, or nowhere where that has failed as well."""
        kept = "not kept"
        self._keeps, self._is_private = not self._is_private, True
        if self._keeps:
            try:
                home = tempfile.mkdtemp(prefix="bevelmap-")
                atexit.register(shutil.rmtree, home, ignore_errors=True)
                self._folders.append(_own_folder(Path(home)))
                os.environ["NUMBA_CACHE_DIR"] = home
                kept = "kept for this run only"
            except OSError:
                self._keeps = False
        _LOG.warning("note: compiled kernels are %s: %s", kept, error)

    def has(self, name: str) -> bool:
        """Whether there is an entry, sound or not."""
        return any((folder / name).exists() for folder in self._folders)

    def read(self, name: str) -> bytes | None:
        """The content of an entry, None if there is none; one that is damaged or another user's is removed."""
        for folder in self._folders:
            try:
                content = self._read(folder / name)
            except FileNotFoundError:
                continue
            except (OSError, ValueError):
                self._remove(folder / name)
                continue
            return content
        return None

    def _read(self, path: Path) -> bytes:
        with os.fdopen(os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK), "rb") as file:
            state = os.fstat(file.fileno())
            if not stat.S_ISREG(state.st_mode) or state.st_uid != os.geteuid():
                raise PermissionError(f"{path} is not this user's")
            data = file.read()
            # The time says when it was last of use.
            with contextlib.suppress(OSError):
                os.utime(file.fileno())
        head, content = data[: len(self._HEAD) + 32], data[len(self._HEAD) + 32 :]
        if head != self._head(path.name, content):
            raise ValueError(f"{path} is damaged")
        return content

    def _head(self, name: str, content: bytes) -> bytes:
        """What an entry starts with: its checksum holds under its own name only."""
        return self._HEAD + hashlib.sha256(name.encode() + b"\n" + content).digest()

    def write(self, name: str, content: bytes) -> None:
        """Keep an entry, which appears whole or not at all."""
        self.made += 1
        while self._keeps:
            try:
                handle, partial = tempfile.mkstemp(dir=self._folders[-1], suffix=".partial")
                try:
                    with os.fdopen(handle, "wb") as file:
                        file.write(self._head(name, content) + content)
                    Path(partial).replace(self._folders[-1] / name)
                except BaseException:
                    self._remove(Path(partial))
                    raise
            except OSError as error:
                self._retreat(error)
            else:
                self._forget_old(name)
                return

    def _forget_old(self, name: str) -> None:
        """Keep the last few entries of a kernel: every edit makes another, and branches are gone back to."""
        kernel, _, _ = name.rpartition("-")
        with contextlib.suppress(OSError):
            entries = sorted(self._folders[-1].glob(f"{kernel}-*.kernel"), key=lambda entry: entry.stat().st_mtime_ns)
            for entry in entries[:-_MOST_KEPT]:
                self._remove(entry)

    @contextlib.contextmanager
    def claimed(self, name: str, patience: float) -> Iterator[bool]:
        """Only one process at a time makes an entry.

        Yields
        ------
        bool
            False if another one is at it and has not ended within `patience` seconds.
        """
        if not self._keeps:
            yield True
            return
        from filelock import lock_descriptor  # takes a while to import, and few processes compile anything

        path, until = self._folders[-1] / f"{name}.lock", time.monotonic() + patience
        with contextlib.ExitStack() as opened:
            while True:
                try:
                    file = opened.enter_context(path.open("w"))
                    mine = lock_descriptor(file.fileno(), blocking=False)
                except OSError:  # no such locks on this file system, or the disk is full: every process for itself
                    break
                if mine:
                    opened.callback(self._remove, path)
                    break
                opened.close()
                if time.monotonic() >= until:
                    yield False
                    return
                time.sleep(0.02)
            yield True

    def drop(self, name: str) -> None:
        """Remove an entry."""
        for folder in self._folders:
            self._remove(folder / name)

    @staticmethod
    def _remove(path: Path) -> None:
        with contextlib.suppress(OSError):
            path.unlink()


@functools.cache
def kernel_store() -> KernelStore:
    """The store of this process."""
    return KernelStore()
