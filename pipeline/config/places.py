"""Where stores are: a folder of this machine as a `Path`, or a prefix in an object store as its counterpart."""

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePosixPath
from urllib.parse import unquote, urlsplit

from pipeline.errors import ConfigurationError, shown

__all__ = ["SCHEMES", "ObjectPlace", "Place", "as_place", "is_url", "place_of"]

#: What a URL may begin with, beside `file`, which is a folder.
SCHEMES = ("s3", "gs", "az", "memory")

#: A letter alone may be a drive.
_URL = re.compile(r"([A-Za-z][A-Za-z0-9+.-]+):[:/]")


@dataclass(frozen=True)
class ObjectPlace:
    """A prefix in an object store, named and joined as a `Path` is; it says nothing of what is there.

    Parameters
    ----------
    url : str
        Without a `/` at its end, such as "s3://bucket/planes/omega_fe.zarr".
    options : str
        `store.storage_options` in JSON. They may hold secrets: no text of this place has them.
    """

    url: str
    options: str = field(default="{}", repr=False)

    def __str__(self) -> str:
        return self.url

    def __truediv__(self, name: str) -> "ObjectPlace":
        return replace(self, url=f"{self.url}/{name}")

    @property
    def bucket(self) -> str:
        """Scheme and bucket, "s3://bucket"."""
        return "/".join(self.url.split("/", 3)[:3])

    @property
    def key(self) -> str:
        """The prefix in the bucket; empty for all of it."""
        return self.url[len(self.bucket) :].lstrip("/")

    @property
    def scheme(self) -> str:
        """What the URL begins with."""
        return self.url.partition(":")[0]

    @property
    def storage_options(self) -> dict:
        """As they were given."""
        return json.loads(self.options)

    @property
    def parts(self) -> tuple[str, ...]:
        """Bucket, and the names in it."""
        return (self.bucket, *PurePosixPath(self.key).parts)

    @property
    def name(self) -> str:
        """The last part."""
        return PurePosixPath(self.key).name

    @property
    def stem(self) -> str:
        """The last part without its suffix."""
        return PurePosixPath(self.key).stem

    @property
    def suffix(self) -> str:
        """The suffix of the last part, ".zarr"."""
        return PurePosixPath(self.key).suffix

    @property
    def parent(self) -> "ObjectPlace":
        """Without the last part."""
        return replace(self, url=self.url.rpartition("/")[0]) if self.key else self

    def with_name(self, name: str) -> "ObjectPlace":
        """With another last part."""
        return self.parent / name

    def resolve(self) -> "ObjectPlace":
        """It is absolute already."""
        return self


Place = Path | ObjectPlace


def is_url(text: str) -> bool:
    """Whether a text is a URL and no path.

    Examples
    --------
    >>> is_url("s3://bucket/store"), is_url("outputs/store"), is_url("C:/store")
    (True, False, False)
    """
    return _URL.match(text) is not None


def place_of(key: str, text: str, options: Mapping | None = None) -> Place:
    """A place as users type it: a path, with ~ expanded, or a URL.

    Parameters
    ----------
    key : str
        Whose value it is, for messages.
    text : str
    options : mapping, optional
        `store.storage_options`; of a folder they must be empty.

    Raises
    ------
    ConfigurationError
        If it is no path, a URL of another scheme or with secrets in it, or the home of a user that is not known.

    Examples
    --------
    >>> place_of("store.root", "results/store").as_posix(), str(place_of("store.root", "s3://bucket/store/"))
    ('results/store', 's3://bucket/store')
    >>> place_of("store.root", "file:///data/store").as_posix()
    '/data/store'
    >>> place_of("store.root", "ftp://host/store")  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ...
    pipeline.errors.ConfigurationError: store.root = 'ftp://host/store' is not allowed: ...
    """
    if not is_url(text):
        found = _folder(key, text)
    elif urlsplit(text).scheme.lower() == "file":
        parts = urlsplit(text)
        if parts.netloc not in ("", "localhost") or not parts.path:
            raise _refused(key, text, "of a file:// URL there must be nothing but a path: file:///data/store")
        found = _folder(key, unquote(parts.path))
    else:
        return _objects(key, text, options or {})
    if options:
        raise ConfigurationError(f"store.storage_options is not allowed: {key} = {shown(text)!r} is a folder")
    return found


def as_place(value: "Place | str") -> Place:
    """A place from a path, a text or a place."""
    if isinstance(value, Path | ObjectPlace):
        return value
    return place_of("store", value) if is_url(value) else Path(value)


def _folder(key: str, text: str) -> Path:
    if not text or "\0" in text:
        raise _refused(key, text, "it must be the path of a folder")
    try:
        return Path(text).expanduser()
    except RuntimeError:
        raise _refused(key, text, "there is no such user") from None


def _objects(key: str, text: str, options: Mapping) -> ObjectPlace:
    parts = urlsplit(text)
    if "@" in parts.netloc or parts.query or parts.fragment:
        # Not quoted: what stands there may be a secret.
        raise ConfigurationError(
            f"{key} is not allowed: its URL must be scheme, bucket and prefix alone; keys of the object store go into "
            "store.storage_options or the environment"
        )
    names = [name for name in parts.path.split("/") if name]
    if parts.scheme.lower() not in SCHEMES or not parts.netloc or {".", ".."} & set(names):
        allowed = ", ".join(f"{scheme}://" for scheme in (*SCHEMES, "file"))
        raise _refused(key, text, f"it must be a folder, or a URL of {allowed} with a bucket and a prefix")
    try:
        written = json.dumps(dict(options), sort_keys=True)
    except (TypeError, ValueError):
        raise ConfigurationError("store.storage_options is not allowed: it must have plain values") from None
    return ObjectPlace("/".join([f"{parts.scheme.lower()}://{parts.netloc}", *names]), written)


def _refused(key: str, text: str, allowed: str) -> ConfigurationError:
    return ConfigurationError(f"{key} = {shown(text)!r} is not allowed: {allowed}")
