"""Object stores as obstore opens them, and what is said where one does not do as asked.

What an object store answers may quote keys and signatures: no message has any of it but the status.
"""

import contextlib
import re
from collections.abc import Iterator, Mapping
from datetime import timedelta
from functools import lru_cache
from typing import Any

from pipeline.config.places import ObjectPlace, place_of
from pipeline.errors import ConfigurationError, Unreachable

__all__ = ["explained", "object_store", "of_bucket", "said_of"]

#: Options that are sections of their own, with those of their keys that are times: seconds.
_SECTIONS = {"client_options": ("timeout", "connect_timeout"), "retry_config": ("retry_timeout",)}
#: Buckets in this process.
_MEMORY: dict[str, Any] = {}


def object_store(url: str, options: Mapping) -> Any:
    """An object store at a prefix; of `memory://`, the whole bucket.

    Parameters
    ----------
    url : str
        Such as "s3://bucket/prefix".
    options : mapping
        `store.storage_options`.

    Returns
    -------
    obstore.store.ObjectStore

    Raises
    ------
    ConfigurationError
        If obstore is not installed, or does not know an option.
    """
    place = place_of("store.root", url, options)
    return _opened(place)


def of_bucket(place: ObjectPlace) -> Any:
    """The object store of the whole bucket that a place is in; names in it begin with `place.key`."""
    return _opened(ObjectPlace(place.bucket, place.options))


@lru_cache(maxsize=32)
def _opened(place: ObjectPlace) -> Any:
    try:
        import obstore
        from obstore.store import MemoryStore, from_url
    except ImportError:
        raise ConfigurationError(
            f"store.root = {str(place)!r} is not allowed: an object store needs obstore, which pip install "
            "'bevelmap[objects]' installs"
        ) from None
    if place.scheme == "memory":
        return _MEMORY.setdefault(place.bucket, MemoryStore())
    options = place.storage_options
    sections = {name: _section(name, options.pop(name)) for name in _SECTIONS if name in options}
    for name, value in options.items():
        if not isinstance(value, str | int | float | bool):
            raise ConfigurationError(f"store.storage_options.{name} is not allowed: it must be a text or a number")
    texts = {name: str(value).lower() if isinstance(value, bool) else str(value) for name, value in options.items()}
    try:
        return from_url(place.url, config=texts, **sections)
    except obstore.exceptions.UnknownConfigurationKeyError as error:
        name = re.search(r"key: '(\w+)'", str(error))
        raise ConfigurationError(
            f"store.storage_options.{name[1] if name else '?'} is not allowed: {place.scheme}:// has no such option"
        ) from None
    except (obstore.exceptions.BaseError, TypeError, ValueError) as error:
        # Its first line names what is missing; a value of an option may follow.
        lacking = "an account name is missing" if "Account must be" in str(error) else "they do not fit together"
        raise ConfigurationError(f"store.storage_options is not allowed for {place}: {lacking}") from None


def _section(name: str, values: Any) -> dict:
    """A section of options as obstore takes it."""
    if not isinstance(values, Mapping):
        raise ConfigurationError(f"store.storage_options.{name} is not allowed: it must be a section of options")
    return {key: _time(name, key, value) if key in _SECTIONS[name] else value for key, value in values.items()}


def _time(name: str, key: str, value: Any) -> timedelta:
    try:
        return timedelta(seconds=float(value))
    except (TypeError, ValueError, OverflowError):
        raise ConfigurationError(f"store.storage_options.{name}.{key} is not allowed: it must be seconds") from None


@contextlib.contextmanager
def explained(place: ObjectPlace) -> Iterator[None]:
    """What obstore raises inside is raised as an error with one line; that there is no such object, as it is.

    Raises
    ------
    Unreachable
    """
    try:
        yield
    except (OSError, ConfigurationError):
        raise
    except Exception as error:
        if (said := said_of(error)) is None:
            raise
        raise Unreachable(f"{place} {said}") from None


def said_of(error: BaseException) -> str | None:
    """What an error of obstore means, without what it quotes; None of any other error."""
    if not type(error).__module__.startswith("obstore"):
        return None
    name, text = type(error).__name__, str(error)
    if name in ("PermissionDeniedError", "UnauthenticatedError"):
        return (
            "may not be used: the object store refuses access; the keys in store.storage_options or the environment "
            "must allow it to be listed, read and written"
        )
    status = re.search(r"\b(?:status(?: code)?:? |HTTP error: )?([45]\d\d) [A-Z][A-Za-z ]+", text)
    if status:
        return f"cannot be used: the object store answers {status[0].rpartition(': ')[2].strip()}"
    if "timed out" in text or "Timeout" in text:
        return "cannot be used: the object store does not answer in time"
    return "cannot be used: the object store does not answer as it should"
