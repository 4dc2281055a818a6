"""Folders as users type them."""

import re

from pipeline.config.places import is_url, place_of
from pipeline.errors import refused

__all__ = ["local_folder", "quoted_home"]

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
    >>> local_folder("output.root", "results")
    'results'
    >>> local_folder("output.root", "s3://bucket/results")  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ...
    pipeline.errors.ConfigurationError: output.root = 's3://bucket/results' is not allowed: it must be a folder of ...
    """
    if is_url(text):
        raise refused(key, text, "a folder of this machine; store.root alone may be a URL")
    return str(place_of(key, text))
