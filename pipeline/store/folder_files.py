"""The files of a store in a folder: whole under their names by `rename`, never behind a link."""

import contextlib
import os
import re
import shutil
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from pipeline.errors import StoreError
from pipeline.store.durable import settle, write_all
from pipeline.store.names import GROUP_FILE, STORE_FILE, refuse_unknown
from pipeline.store.zarr_library import load_zarr

__all__ = ["FolderFiles"]


@dataclass(frozen=True)
class FolderFiles:
    """Files below a folder; see `pipeline.store.files.Files`."""

    place: Path

    def exists(self) -> bool:
        return self.place.exists()

    def has(self, name: str) -> bool:
        return (self.place / name).exists()

    def read(self, name: str, most: int) -> bytes:
        with (self.place / name).open("rb", buffering=0) as stream:
            size = os.fstat(stream.fileno()).st_size
            return stream.read(min(size, most + 1))

    def head(self, name: str, count: int) -> tuple[bytes, int]:
        with (self.place / name).open("rb", buffering=0) as stream:
            return stream.read(count), os.fstat(stream.fileno()).st_size

    def at_hand(self, whole: Iterable[str] = (), heads: Iterable[str] = (), count: int = 0) -> "FolderFiles":
        return self

    def sizes(self) -> dict[str, int]:
        """Raises StoreError where there is a link: what is behind it is outside."""
        found = {}
        for name, entry in self._inside(missing_ok=False):
            if not entry.is_file(follow_symlinks=False):
                kind = "a link" if entry.is_symlink() else "neither a file nor a folder"
                raise StoreError(f"{self.place} is not allowed: {name!r} is {kind}; a store has files and folders only")
            # A run may rename a file that it has written, or take a group away, meanwhile.
            with contextlib.suppress(FileNotFoundError):
                found[name] = entry.stat(follow_symlinks=False).st_size
        return found

    def versions(self) -> dict[str, tuple]:
        found = {}
        for name, entry in self._inside(missing_ok=True):
            with contextlib.suppress(FileNotFoundError):
                status = entry.stat(follow_symlinks=False)
                found[name] = status.st_size, status.st_mtime_ns
        return found

    def _inside(self, missing_ok: bool) -> Iterator[tuple[str, os.DirEntry]]:
        """Everything but folders, with its name; no link is followed."""
        waiting = [("", self.place)]
        while waiting:
            prefix, folder = waiting.pop()
            for entry in _entries(folder, missing_ok or bool(prefix)):
                if entry.is_dir(follow_symlinks=False):
                    waiting.append((f"{prefix}{entry.name}/", entry.path))
                else:
                    yield prefix + entry.name, entry

    def folders(self) -> list[str]:
        return sorted(path.name for path in self.place.iterdir() if path.is_dir()) if self.place.is_dir() else []

    def write(self, contents: Mapping[str, bytes]) -> None:
        write_all({self.place / name: content for name, content in contents.items()})

    def appear(self, contents: Mapping[str, bytes], group: str = "") -> None:
        draft, folder = self.beside(f"{group}.draft" if group else "template"), self.place / group
        folder.parent.mkdir(parents=True, exist_ok=True)
        draft.clear(GROUP_FILE if group else STORE_FILE)
        for name, content in contents.items():
            (draft.place / name).parent.mkdir(parents=True, exist_ok=True)
            (draft.place / name).write_bytes(content)
        draft.move(FolderFiles(folder))

    def vanish(self, group: str) -> None:
        old, folder = self.beside(f"{group}.old"), self.within(group)
        old.clear(GROUP_FILE)
        if folder.exists():
            refuse_unknown(folder.place, folder.sizes(), GROUP_FILE)
            folder.place.rename(old.place)
            old.clear(GROUP_FILE)

    def move(self, target: "FolderFiles") -> None:
        settle([file for file in self.place.rglob("*") if file.is_file()])
        self.place.rename(target.place)

    def remove(self, name: str) -> None:
        file = self.place / name
        if file.is_dir() and not file.is_symlink():
            try:
                file.rmdir()
            except OSError:
                raise StoreError(
                    f"{file} cannot be removed: it should be a file, and is a folder; move it away"
                ) from None
        else:
            with contextlib.suppress(FileNotFoundError, NotADirectoryError):
                file.unlink()

    def clear(self, known: re.Pattern) -> None:
        """Of a link, the link alone is removed; folders are, when they are empty."""
        if self.place.is_symlink():
            self.place.unlink()
        if not self.place.exists():
            return
        refuse_unknown(self.place, self.sizes(), known)
        # By descriptors of folders, so that none of them can be exchanged for a link meanwhile.
        for place, folders, files, descriptor in os.fwalk(self.place, topdown=False):
            prefix = Path(place).relative_to(self.place)
            for name in files:
                if known.fullmatch(str(prefix / name)):
                    os.unlink(name, dir_fd=descriptor)
            for name in folders:
                with contextlib.suppress(OSError):
                    os.rmdir(name, dir_fd=descriptor)
        self.place.rmdir()

    def beside(self, what: str) -> "FolderFiles":
        return FolderFiles(self.place.with_name(f".{self.place.name}.{what}"))

    def within(self, group: str) -> "FolderFiles":
        return FolderFiles(self.place / group)

    def log(self, name: str) -> "_FileLog":
        return _FileLog(self.place / name)

    def zarr(self) -> Path:
        load_zarr()
        return self.place

    def room(self) -> tuple[int, Path]:
        folder = _existing(self.place)
        return shutil.disk_usage(folder).free, folder

    def refusal(self) -> str:
        folder = _existing(self.place)
        return "" if _is_writable(folder) else f"it must be a folder that can be written ({folder})"

    def is_shared(self) -> bool:
        return True

    def known_writable(self) -> bool:
        return _is_writable(_existing(self.place.parent))


class _FileLog:
    """Lines in a file, written without a buffer: a process may end at any moment."""

    def __init__(self, file: Path):
        self._file, self._stream = file, None

    def lines(self) -> list[str]:
        return self._file.read_text(errors="replace").splitlines() if self._file.exists() else []

    def open(self) -> None:
        self._file.parent.mkdir(exist_ok=True)
        self._stream = self._file.open("ab", buffering=0)

    def write(self, line: str) -> None:
        os.write(self._stream.fileno(), f"{line}\n".encode())

    def fileno(self) -> int:
        return self._stream.fileno()

    def close(self) -> None:
        self._stream.close()

    def remove(self) -> None:
        self._file.unlink(missing_ok=True)


def _entries(folder: Path | str, missing_ok: bool) -> list[os.DirEntry]:
    try:
        with os.scandir(folder) as entries:
            return list(entries)
    except FileNotFoundError:
        if missing_ok:
            return []
        raise


def _existing(folder: Path) -> Path:
    """The folder, or what is there of the folders that it is in."""
    place = folder.resolve()
    while not place.exists() and place != place.parent:
        place = place.parent
    return place


def _is_writable(folder: Path) -> bool:
    return folder.is_dir() and os.access(folder, os.W_OK | os.X_OK)
