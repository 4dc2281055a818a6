"""Object stores as obstore opens them, and what is said where one does not do as asked.

What an object store answers may quote keys and signatures: no message has any of it but the status.
"""

import contextlib
import re
import time
from collections.abc import Callable, Iterator, Mapping
from datetime import timedelta
from functools import lru_cache
from typing import Any

import obstore
from obstore.store import MemoryStore, from_url

from pipeline.config.places import ObjectPlace, place_of
from pipeline.errors import ConfigurationError, Unreachable

__all__ = ["asked", "explained", "object_store", "of_bucket", "said_of"]

#: Options that are sections of their own, with those of their keys that are times: seconds.
_SECTIONS = {"client_options": ("timeout", "connect_timeout"), "retry_config": ("retry_timeout",)}
#: What is missing where a list is.
_NO_BUCKET = ", there is no such bucket"
#: Seconds before a request is made again whose answer was cut.
_WAITS = (0.1, 0.3, 1.0, 3.0, 9.0)
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
        If obstore does not know an option.
    """
    place = place_of("store.root", url, options)
    return _opened(place)


def of_bucket(place: ObjectPlace) -> Any:
    """The object store of the whole bucket that a place is in; names in it begin with `place.key`."""
    return _opened(ObjectPlace(place.bucket, place.options))


@lru_cache(maxsize=32)
def _opened(place: ObjectPlace) -> Any:
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


def asked(place: ObjectPlace, request: Callable[[], Any]) -> Any:
    """What a request gives; raises as `explained`.

    obstore tries again what fails with 5xx or is not answered, and goes on with an object that was cut in the middle.
    Of lists and refusals that are cut it does not, which is done here: every request may be made twice.
    """
    waits = iter(_WAITS)
    while True:
        with explained(place):
            try:
                return request()
            except Exception as error:
                wait = next(waits, None)
                if wait is None or "body error" not in str(error):
                    raise
        time.sleep(wait)


def said_of(error: BaseException) -> str | None:
    """What an error of obstore means, without what it quotes; None of any other error."""
    if not type(error).__module__.startswith("obstore"):
        return None
    name, text = type(error).__name__, str(error)
    status = re.search(r"\b[45]\d\d [A-Z][A-Za-z]+(?: [A-Z][A-Za-z]+)*", text)
    if name in ("PermissionDeniedError", "UnauthenticatedError") or (status and status[0][:3] in ("401", "403")):
        return (
            "may not be used: the object store refuses access; the keys in store.storage_options or the environment "
            "must allow it to be listed, read and written"
        )
    if status:
        return f"cannot be used: the object store answers {status[0]}{_NO_BUCKET if status[0][:3] == '404' else ''}"
    if "kind: Connect" in text:
        return (
            "cannot be reached: nothing answers at the address of the object store; store.storage_options.endpoint "
            "gives another"
        )
    if "timed out" in text or "Timeout" in text:
        return "cannot be used: the object store does not answer in time"
    return "cannot be used: the object store does not answer as it should"
