"""Folders as users type them."""

import re
from pathlib import Path

from pipeline.errors import ConfigurationError

__all__ = ["local_folder", "quoted_home"]

#: A letter alone may be a drive.
_URL = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+:[:/]")
#: A value that begins with ~, which Hydra's grammar has only between quotes.
_HOME = re.compile(r"([\w.+]+=)(~[^'\",\[\](){}]*)")


def quoted_home(override: str) -> str:
    """An override as typed, a path that begins with ~ between quotes.

    Examples
    --------
    >>> quoted_home("store.root=~/results"), quoted_home("gear.b=0.5"), quoted_home("~gear.thermal")
    ("store.root='~/results'", 'gear.b=0.5', '~gear.thermal')
    """
    found = _HOME.fullmatch(override)
    return override if found is None else f"{found[1]}'{found[2]}'"


def local_folder(key: str, text: str) -> str:
    """A folder of this machine, with ~ expanded.

    Raises
    ------
    ConfigurationError
        If it is a URL, which would be made as a folder of that name, or no path, or the home of a user that is not
        known.

    Examples
    --------
    >>> local_folder("store.root", "results/store")
    'results/store'
    >>> local_folder("store.root", "s3://bucket/store")  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ...
    pipeline.errors.ConfigurationError: store.root = 's3://bucket/store' is not allowed: it must be a folder of ...
    """
    if _URL.match(text):
        said = "it must be a folder of this machine; stores elsewhere are not supported"
    elif not text or "\0" in text:
        said = "it must be the path of a folder"
    else:
        try:
            return str(Path(text).expanduser())
        except RuntimeError:
            said = "there is no such user"
    raise ConfigurationError(f"{key} = {text!r} is not allowed: {said}")
