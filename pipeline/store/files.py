"""The files of a store, wherever they are: one protocol, and the one place that asks where a store is.

Names are relative to the store, with `/` between their parts. What a function writes is there for good when it
returns, and whole under its name.
"""

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Protocol

from pipeline.config.places import ObjectPlace, Place, as_place
from pipeline.errors import ConfigurationError
from pipeline.store.folder_files import FolderFiles

__all__ = ["Files", "Log", "files_at"]


class Log(Protocol):
    """Lines that outlive the process that writes them."""

    def lines(self) -> list[str]:
        """What was written, by whichever process; empty where there is none."""

    def open(self) -> None:
        """Begin writing."""

    def write(self, line: str) -> None:
        """Add a line."""

    def fileno(self) -> int:
        """Of a file into which lines may be written from outside Python; whether they outlive the process, it tells
        with `lines`."""

    def close(self) -> None:
        """End writing."""

    def remove(self) -> None:
        """Take all lines away."""


class Files(Protocol):
    """Files below one place, which need not exist."""

    @property
    def place(self) -> Place:
        """Where they are, as messages name it."""

    def exists(self) -> bool:
        """Whether there is anything."""

    def has(self, name: str) -> bool:
        """Whether there is a file of this name."""

    def read(self, name: str, most: int) -> bytes:
        """A file; of one that is longer than `most` bytes, its first `most` + 1.

        Raises
        ------
        FileNotFoundError, NotADirectoryError, IsADirectoryError
            If there is no such file.
        """

    def head(self, name: str, count: int) -> tuple[bytes, int]:
        """The first bytes of a file, and its size; raises as `read`."""

    def at_hand(self, whole: Iterable[str] = (), heads: Iterable[str] = (), count: int = 0) -> "Files":
        """The same files, of which these are read next, the first `count` bytes of `heads` and of the others all:
        where each takes its time to come, they are fetched together."""

    def sizes(self) -> dict[str, int]:
        """All files and their sizes in bytes.

        Raises
        ------
        StoreError
            If there is anything but files and folders.
        FileNotFoundError
            If there is nothing.
        """

    def versions(self) -> dict[str, tuple]:
        """All files, each with its size in bytes and what changes when it is written; links are files here."""

    def folders(self) -> list[str]:
        """Names of the folders directly in it, in order; none where there is nothing."""

    def write(self, contents: Mapping[str, bytes]) -> None:
        """Write files, each in place of what was there."""

    def appear(self, contents: Mapping[str, bytes], group: str = "") -> None:
        """Write a store, or a group in one, where there is none: it is there as a whole or not at all.

        Of a group in a store, it is there for whoever opens the store once the store lists it.
        """

    def vanish(self, group: str) -> None:
        """Take a group away as a whole, if there is one; raises as `clear`."""

    def move(self, target: "Files") -> None:
        """Give all files another place, as a whole, in which there is nothing."""

    def remove(self, name: str) -> None:
        """Remove a file, if there is one.

        Raises
        ------
        StoreError
            If there is a folder in its place.
        """

    def clear(self, known: re.Pattern) -> None:
        """Remove all files, each of which must have a name that `known` matches.

        Raises
        ------
        StoreError
            If one has not; then nothing is removed.
        """

    def beside(self, what: str) -> "Files":
        """A place of the store's own beside it, which lists of stores leave out."""

    def within(self, group: str) -> "Files":
        """The files of a group alone."""

    def log(self, name: str) -> Log:
        """Lines of this name."""

    def zarr(self) -> Any:
        """What zarr and xarray open, for reading."""

    def room(self) -> tuple[int, Path] | None:
        """Free bytes, and where; None where there is no such limit."""

    def refusal(self) -> str:
        """Why stores cannot be written below this place, as far as it is known without trying; else empty."""

    def is_shared(self) -> bool:
        """Whether other processes see the same files."""

    def known_writable(self) -> bool:
        """Whether stores can be written beside this one, as far as it is known without trying."""


def files_at(place: "Place | str") -> Files:
    """The files of a store at a path, or at a URL.

    Raises
    ------
    ConfigurationError
        If it is a URL and obstore is not installed.
    """
    place = as_place(place)
    if isinstance(place, ObjectPlace):
        try:
            from pipeline.store.object_files import ObjectFiles  # what it stands on takes a while to load
        except ModuleNotFoundError as error:
            if error.name != "obstore":
                raise
            raise ConfigurationError(
                f"{place} is in an object store, which needs obstore, not installed here: "
                "pip install 'bevelmap[objects]'"
            ) from None
        return ObjectFiles(place)
    return FolderFiles(place)
