"""Options of an object store may be secrets: where they are typed, quoted or written down, their values are not."""

import re
from collections.abc import Iterable, Mapping

from pipeline.config.typed import key_of

__all__ = ["HIDDEN", "hidden", "hidden_values", "without_secrets"]

#: What stands for a value.
HIDDEN = "***"
_KEY = "store.storage_options"


def _has_secrets(override: str) -> bool:
    return key_of(override).startswith(_KEY) or "storage_options" in override


def without_secrets(override: str) -> str:
    """An override as it may be shown.

    Examples
    --------
    >>> without_secrets("store.storage_options.secret_access_key=abc"), without_secrets("gear.b=0.5")
    ('store.storage_options.secret_access_key=***', 'gear.b=0.5')
    """
    return f"{override.partition('=')[0]}={HIDDEN}" if _has_secrets(override) else override


def hidden(text: str, overrides: Iterable[str]) -> str:
    """A message without the values of storage options that these overrides have.

    Examples
    --------
    >>> hidden("'abcd' is no number", ["store.storage_options.timeout=abcd"])
    "'***' is no number"
    """
    values = [override.partition("=")[2] for override in overrides if _has_secrets(override)]
    words = {word for value in values for word in (value, *re.findall(r"[^\s{}\[\],:'\"]+", value)) if len(word) > 3}
    for word in sorted(words, key=len, reverse=True):
        text = text.replace(word, HIDDEN)
        # Messages cut what is too long to be quoted.
        for end in range(len(word) - 1, 3, -1):
            text = text.replace(f"{word[:end]}…", HIDDEN)
    return text


def hidden_values(options: Mapping) -> dict:
    """Options with their names alone."""
    return dict.fromkeys(options, HIDDEN)
