"""What a user can get wrong and what can be wrong with a store, as exceptions with a one-line message."""

import re

__all__ = [
    "KEPT",
    "ComputationError",
    "ConfigurationError",
    "DamagedError",
    "LeaseLost",
    "StoreError",
    "Unreachable",
    "WorkerLost",
    "counted",
    "refused",
    "shown",
]

#: What is said of a run that ends early.
KEPT = "; what is stored is kept, and the same command goes on from there"


_LONG_WORD = re.compile(r"(\S{120})\S{200,}")
_LONGEST = 4000


def shown(text: str, longest: int = 120) -> str:
    """A text as a message quotes it: on one line, printable and not too long.

    Examples
    --------
    >>> shown("gear.b=1\\n2"), shown("9" * 1000, 8)
    ('gear.b=1\\\\n2', '99999999…')
    """
    short = text if len(text) <= longest else f"{text[:longest]}…"
    return "".join(c if c.isprintable() else c.encode("unicode_escape", "backslashreplace").decode() for c in short)


def counted(number: int, noun: str) -> str:
    """So many of something, as a message says it.

    Examples
    --------
    >>> counted(1, "row"), counted(2200, "row")
    ('1 row', '2,200 rows')
    """
    return f"{number:,} {noun}{'s' * (number != 1)}"


class ConfigurationError(Exception):
    """The configuration is not allowed; the message names the key, its value and what is allowed.

    It is one printable line whatever it quotes, and a long word is shortened, so that what follows it can be read.
    """

    def __init__(self, text: str = ""):
        super().__init__(shown(_LONG_WORD.sub(r"\1…", text), _LONGEST))

    #: Exit status of a run that ends with it.
    status = 2


class StoreError(ConfigurationError):
    """A store cannot be used as asked; the message names it and the way on."""


def refused(key: str, value, allowed: str) -> ConfigurationError:
    """That a key may not have a value: the one sentence that says so.

    Parameters
    ----------
    key : str
        As the user typed it.
    value
        As typed; a long one is shortened.
    allowed : str
        What it must be, as the end of the sentence.

    Examples
    --------
    >>> print(refused("cluster.workers", -1, "from 1 to 1024"))
    cluster.workers = -1 is not allowed: it must be from 1 to 1024
    """
    return ConfigurationError(f"{key} = {shown(repr(value))} is not allowed: it must be {allowed}")


class DamagedError(StoreError):
    """Files of a store are damaged; the message names the first one and the way on, `what` is the fault alone."""

    status = 1
    what = ""


class Unreachable(OSError):
    """An object store does not answer, or refuses; the message names the place and the way on."""


class LeaseLost(StoreError):
    """Another run writes into a store now; the message names both."""

    status = 1


class ComputationError(RuntimeError):
    """Something could not be computed; what could is stored."""


class WorkerLost(RuntimeError):
    """The process that ran a task ended before the task did."""


def unusable(library: str, error: Exception) -> ConfigurationError:
    """What is said where a library cannot be used as the user has configured it."""
    reason = " ".join(str(error).split())
    return ConfigurationError(
        f"{library}'s own configuration, of files and of variables {library.upper()}_..., is not allowed: "
        f"{type(error).__name__}: {reason[:300]}"
    )
