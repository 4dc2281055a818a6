"""The files of a store as objects: each is whole by itself, and none can be renamed.

What is to appear as a whole is put under its final names, its `zarr.json` last: without that it is not there. What is
to vanish loses it first. While a store appears or vanishes, an object beside it (`.<name>.partial`) says so, by which
what is left of a run that ended meanwhile is told from a store that has lost its `zarr.json`.
"""

import contextlib
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from typing import Any

import obstore

from pipeline.config.places import ObjectPlace
from pipeline.errors import Unreachable
from pipeline.store.lock import check_held
from pipeline.store.names import GROUP_FILE, METADATA, STORE_FILE, refuse_unknown
from pipeline.store.objects import asked, object_store, of_bucket
from pipeline.store.zarr_library import load_zarr

__all__ = ["ObjectFiles"]

#: Requests that wait for their answers at once.
_TOGETHER = 16
#: Longest object that is kept at hand.
_MOST_AT_HAND = 2**26
#: Short objects, and how others begin, of known versions: a store is looked over several times in a run.
_SEEN: dict[tuple[ObjectPlace, str, str, int | None], tuple[bytes, int]] = {}
_MOST_SEEN, _MOST_KEPT = 2**17, 2**12


@dataclass(frozen=True)
class ObjectFiles:
    """Objects below a prefix; see `pipeline.store.files.Files`."""

    place: ObjectPlace
    #: Whether this is a group in a store.
    _inner: bool = field(default=False, compare=False, repr=False)
    #: Name -> version, of the last list that was made of these files.
    _tags: dict[str, str] = field(default_factory=dict, compare=False, repr=False)
    #: What is at hand: name -> content or how it begins, and size; or why there is none.
    _known: Mapping[str, tuple[bytes, int] | OSError] = field(default_factory=dict, compare=False, repr=False)

    def exists(self) -> bool:
        return self.has(METADATA) or (self._has_any() and not self._is_marked())

    def has(self, name: str) -> bool:
        if name in self._known:
            return not isinstance(self._known[name], OSError)
        try:
            asked(self.place, lambda: obstore.head(self._bucket, self._key(name)))
        except FileNotFoundError:
            return False
        return True

    def read(self, name: str, most: int) -> bytes:
        content, size, *_ = self._at_hand(name) or self._get(name, most)
        if len(content) < min(size, most + 1):  # only how it begins was at hand
            content, *_ = self._get(name, most)
        return content[: most + 1]

    def head(self, name: str, count: int) -> tuple[bytes, int]:
        content, size, *_ = self._at_hand(name) or self._begin(name, count)
        return content[:count], size

    def at_hand(self, whole: Iterable[str] = (), heads: Iterable[str] = (), count: int = 0) -> "ObjectFiles":
        asked = [(name, None) for name in whole] + [(name, count) for name in heads]
        asked = [(name, most) for name, most in asked if name not in self._known]
        found = dict(_together(self._known_of, asked))
        return replace(self, _known={**self._known, **found}) if found else self

    def sizes(self) -> dict[str, int]:
        listed = self._listed()
        found = {name: status["size"] for name, status in listed}
        self._tags.clear()
        self._tags.update((name, status["e_tag"]) for name, status in listed if status["e_tag"])
        if not found:
            raise FileNotFoundError(f"{self.place}: nothing there")
        return found

    def versions(self) -> dict[str, tuple]:
        return {name: (one["size"], one["e_tag"], str(one["last_modified"])) for name, one in self._listed()}

    def folders(self) -> list[str]:
        found = asked(self.place, lambda: obstore.list_with_delimiter(self._bucket, self.place.key or None))
        return sorted(prefix.rstrip("/").rpartition("/")[2] for prefix in found["common_prefixes"])

    def write(self, contents: Mapping[str, bytes]) -> None:
        _together(self._put, contents.items())

    def appear(self, contents: Mapping[str, bytes], group: str = "") -> None:
        target = self.within(group) if group else self
        with target._marked():
            target._remove_all(GROUP_FILE if group else STORE_FILE)
            target.write({name: content for name, content in contents.items() if name != METADATA})
            target.write({METADATA: contents[METADATA]})

    def vanish(self, group: str) -> None:
        self.within(group).clear(GROUP_FILE)

    def move(self, target: "ObjectFiles") -> None:
        names = self.sizes()
        with target._marked():
            # Of an earlier run that ended here.
            target._remove_all(STORE_FILE)
            _together(lambda name: self._copy(name, target), names.keys() - {METADATA})
            _together(lambda name: self._copy(name, target), names.keys() & {METADATA})
        self._delete(names)

    def remove(self, name: str) -> None:
        self._delete([name])

    def clear(self, known: re.Pattern) -> None:
        if self._has_any():
            with self._marked():
                self._remove_all(known)

    def beside(self, what: str) -> "ObjectFiles":
        return ObjectFiles(self.place.with_name(f".{self.place.name}.{what}"))

    def within(self, group: str) -> "ObjectFiles":
        return ObjectFiles(self.place / group, _inner=True)

    def log(self, name: str) -> "_ObjectLog":
        return _ObjectLog(self, name)

    def zarr(self) -> Any:
        load_zarr()
        from zarr.storage import ObjectStore, StorePath

        if self.place.scheme == "memory":
            return StorePath(ObjectStore(self._bucket, read_only=True), self.place.key)
        return ObjectStore(object_store(self.place.url, self.place.storage_options), read_only=True)

    def room(self) -> None:
        return None

    def refusal(self) -> str:
        try:
            self.folders()
        except Unreachable as error:
            return str(error)
        return ""

    def known_writable(self) -> bool:
        # Only a try would tell.
        return False

    def is_shared(self) -> bool:
        return self.place.scheme != "memory"

    @property
    def _bucket(self) -> Any:
        return of_bucket(self.place)

    def _key(self, name: str) -> str:
        return "/".join(part for part in (self.place.key, name) if part)

    def _listed(self) -> list[tuple[str, dict]]:
        """Every object below the prefix: its name, and what the list says of it."""
        start = len(self._key("")) + 1 if self.place.key else 0
        found = asked(self.place, lambda: obstore.list(self._bucket, self.place.key or None).collect())
        return [(one["path"][start:], one) for one in found]

    def _has_any(self) -> bool:
        return asked(self.place, lambda: any(obstore.list(self._bucket, self.place.key or None, chunk_size=1)))

    def _at_hand(self, name: str) -> tuple[bytes, int] | None:
        found = self._known.get(name)
        if isinstance(found, OSError):
            raise type(found)(*found.args)
        return found

    def _known_of(self, asked: tuple[str, int | None]) -> tuple[str, tuple[bytes, int] | OSError]:
        name, count = asked
        version = (self.place, name, self._tags.get(name), count)
        if version in _SEEN:
            return name, _SEEN[version]
        try:
            *found, tag = self._get(name, _MOST_AT_HAND) if count is None else self._begin(name, count)
        except FileNotFoundError as missing:
            return name, FileNotFoundError(*missing.args)
        found = tuple(found)
        # Of another version than the one that was listed it may be, if somebody has written it meanwhile.
        if tag is not None and tag == self._tags.get(name) and len(found[0]) <= _MOST_KEPT:
            _SEEN[version] = found
            if len(_SEEN) > _MOST_SEEN:
                _SEEN.clear()
        return name, found

    def _get(self, name: str, most: int) -> tuple[bytes, int, str | None]:
        """An object, of a longer one its first `most` + 1 bytes; its size, and its version."""

        def request():
            found = obstore.get(self._bucket, self._key(name))
            if (size := found.meta["size"]) > most:
                return None
            return found.bytes().to_bytes(), size, found.meta["e_tag"]

        return asked(self.place, request) or self._begin(name, most + 1)

    def _begin(self, name: str, count: int) -> tuple[bytes, int, str | None]:
        """The first bytes of an object, its size, and its version."""

        def request():
            try:
                found = obstore.get(self._bucket, self._key(name), options={"range": (0, count)})
                return found.bytes().to_bytes(), found.meta["size"], found.meta["e_tag"]
            except obstore.exceptions.GenericError:
                # An empty one has no first byte.
                if obstore.head(self._bucket, self._key(name))["size"]:
                    raise
                return b"", 0, None

        return asked(self.place, request)

    def _put(self, item: tuple[str, bytes]) -> None:
        name, content = item
        # In one request, so that it is there whole or not at all.
        self._change(lambda: obstore.put(self._bucket, self._key(name), content, use_multipart=False))

    def _copy(self, name: str, target: "ObjectFiles") -> None:
        target._change(lambda: obstore.copy(self._bucket, self._key(name), target._key(name)))

    def _delete(self, names: Iterable[str]) -> None:
        """Remove objects, metadata of the whole first: without it, the others are not there."""
        parts = [[name for name in names if (name == METADATA) is first] for first in (True, False)]
        for keys in ([self._key(name) for name in part] for part in parts if part):
            with contextlib.suppress(FileNotFoundError):
                self._change(lambda keys=keys: obstore.delete(self._bucket, keys))

    def _change(self, request: Callable[[], Any]) -> None:
        """Make a request that changes something: not after another run has taken the store over."""

        def checked():
            check_held(self.place)
            request()

        asked(self.place, checked)

    def _remove_all(self, known: re.Pattern) -> None:
        names = [name for name, _ in self._listed()]
        refuse_unknown(self.place, names, known)
        self._delete(names)

    @contextlib.contextmanager
    def _marked(self) -> Iterator[None]:
        """Around what makes a store or takes it away. A group needs no mark: until it is whole, no store lists it."""
        if self._inner:
            yield
            return
        mark = self.beside("partial")
        mark._put(("", b""))
        yield
        mark._delete([""])

    def _is_marked(self) -> bool:
        return not self._inner and self.beside("partial").has("")


class _ObjectLog:
    """Lines in an object. It can only be written anew, and so it is written line by line only where an attempt has
    failed before; at a first attempt, there is nothing but that there was one, and at its end its lines."""

    def __init__(self, files: ObjectFiles, name: str):
        self._files, self._name, self._text = files, name, ""
        self._watched, self._sink = False, None

    def lines(self) -> list[str]:
        try:
            self._text = self._files.read(self._name, _MOST_AT_HAND).decode(errors="replace")
        except FileNotFoundError:
            self._text = ""
        self._watched = bool(self._text)
        return self._text.splitlines()

    def open(self) -> None:
        # What the watchdog of the C library writes goes nowhere: only Python can put an object.
        self._sink = os.open(os.devnull, os.O_WRONLY)
        self._add("attempt")
        self._save()

    def write(self, line: str) -> None:
        self._add(line)
        if self._watched:
            self._save()

    def fileno(self) -> int:
        return self._sink

    def close(self) -> None:
        os.close(self._sink)
        if self._text and not self._watched:
            self._save()

    def remove(self) -> None:
        self._text = ""
        self._files.remove(self._name)

    def _add(self, line: str) -> None:
        self._text += f"{line}\n"

    def _save(self) -> None:
        self._files.write({self._name: self._text.encode()})


def _together(function: Callable, items: Iterable) -> list:
    """What a function gives for every item, asked for several at a time."""
    items = list(items)
    if min(len(items), _TOGETHER) < 2:
        return [function(item) for item in items]
    with ThreadPoolExecutor(min(_TOGETHER, len(items))) as pool:
        return list(pool.map(function, items))
