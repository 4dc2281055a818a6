"""What the value of a key may be, said once beside its type, and the one sentence that is made of it."""

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass, field

from omegaconf import MISSING

from pipeline.errors import refused

__all__ = ["Allowed", "allowed", "check_all", "check_one", "sentence_of"]

_ALLOWED = "allowed"


@dataclass(frozen=True)
class Allowed:
    """What one value may be.

    Parameters
    ----------
    low, high : float
        Ends of a range, both allowed, unless `above` leaves the lower one out.
    above : bool
    names : tuple of str
        Words, instead of a range.
    """

    low: float = -math.inf
    high: float = math.inf
    above: bool = False
    names: tuple[str, ...] = ()

    def holds(self, value) -> bool:
        """Whether a value is allowed."""
        if self.names:
            return value in self.names
        return self.low <= value <= self.high and not (self.above and value == self.low)

    @property
    def sentence(self) -> str:
        """What is allowed, after "it must be".

        Examples
        --------
        >>> Allowed(1, 100).sentence, Allowed(0.0, 1.0, above=True).sentence, Allowed(2).sentence
        ('from 1 to 100', 'above 0 and at most 1', 'at least 2')
        >>> Allowed(names=("png", "pdf")).sentence
        'one of png, pdf'
        """
        if self.names:
            return f"one of {', '.join(self.names)}"
        if self.above:
            return f"above {_number(self.low)}{f' and at most {_number(self.high)}' if self.high < math.inf else ''}"
        return f"from {_number(self.low)} to {_number(self.high)}" if self.high < math.inf else f"at least {self.low:g}"


def _number(value: float) -> str:
    """As people write it; a bound of what a machine holds as its power of two."""
    exact = isinstance(value, int) and value > 2**30
    return f"2^{(value + 1).bit_length() - 1} - 1" if exact and value & (value + 1) == 0 else f"{value:g}"


def allowed(
    low: float = -math.inf, high: float = math.inf, above: bool = False, names: tuple[str, ...] = (), default=MISSING
):
    """A key of the schema with what its value may be; of a list, what each of its entries may be."""
    return field(default=default, metadata={_ALLOWED: Allowed(low, high, above, names)})


def sentence_of(section: type, name: str) -> str:
    """What a key of a section may be, in words; empty where its type says all."""
    (found,) = (one for one in dataclasses.fields(section) if one.name == name)
    return found.metadata[_ALLOWED].sentence if _ALLOWED in found.metadata else ""


def check_one(section: type, key: str, value) -> None:
    """Raise ConfigurationError unless a value is allowed for a key.

    Parameters
    ----------
    section : type
        The section of the schema that has the key.
    key : str
        The whole key, such as "figures.dpi".
    value
        What it is given; None and what is no number are left to the type.
    """
    (found,) = (one for one in dataclasses.fields(section) if one.name == key.rpartition(".")[2])
    bounds = found.metadata.get(_ALLOWED)
    for one in value if isinstance(value, list) else [value]:
        if bounds is not None and one is not None and not bounds.holds(one):
            many = "a list of " if isinstance(value, list) else ""
            words = f"{many}{', '.join(bounds.names)}" if many and bounds.names else bounds.sentence
            raise refused(key, one, words)


def check_all(config) -> None:
    """Raise ConfigurationError, one line, unless every value of a configuration is allowed."""
    for section, key, value in _leaves(config, ""):
        check_one(section, key, value)


def _leaves(section, prefix: str) -> Iterator[tuple[type, str, object]]:
    for one in dataclasses.fields(section):
        value = getattr(section, one.name)
        if dataclasses.is_dataclass(value):
            yield from _leaves(value, f"{prefix}{one.name}.")
        else:
            yield type(section), f"{prefix}{one.name}", value
