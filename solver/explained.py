"""Numbered outcomes that explain themselves: the base class of every status, kind and reason of the solver."""

import enum

__all__ = ["Explained"]


class Explained(enum.IntEnum):
    """An `enum.IntEnum` whose members carry a sentence for the reader of a log or a legend.

    Members are written as ``NAME = number, "sentence"``. They are equal to their numbers, so that compiled kernels and
    stored arrays hold plain integers.

    Examples
    --------
    >>> class Light(Explained):
    ...     RED = 0, "Stop."
    ...     GREEN = 1, "Go."
    >>> Light(1), Light.GREEN == 1, Light.RED.sentence
    (<Light.GREEN: 1>, True, 'Stop.')
    """

    def __new__(cls, number: int, sentence: str):
        member = int.__new__(cls, number)
        member._value_ = number
        member._sentence = sentence
        return member

    @property
    def sentence(self) -> str:
        """What the member means."""
        return self._sentence
