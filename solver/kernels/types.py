"""Numba's types by name, so that a signature can be declared without numba, which takes a third of a second to import.

`types.float64[::1]`, `types.UniTuple(types.int64, 2)` and `types.void(ARRAY, MATRIX)` are written as with
`numba.types`, and become what they name when a kernel is compiled.
"""

import functools

__all__ = ["Declared"]


class Declared:
    """A numba type or signature that is made when it is needed.

    Parameters
    ----------
    text : str
        How it is written; equal texts are equal types.
    make : callable
        Makes the numba type.
    """

    def __init__(self, text: str, make):
        self._text, self._make = text, make

    def __repr__(self):
        return self._text

    def __getitem__(self, index):
        return Declared(f"{self}[{index}]", lambda: self.numba[index])

    def __call__(self, *parts):
        return Declared(f"{self}({', '.join(map(_described, parts))})", lambda: self.numba(*map(_made, parts)))

    @functools.cached_property
    def numba(self):
        """The numba type or signature."""
        return self._make()


def _described(part) -> str:
    """Text of an argument: a type, a number, several of them, or the class of a named tuple."""
    if isinstance(part, tuple):
        return f"({', '.join(map(_described, part))})"
    return f"{part.__qualname__}{part._fields}" if isinstance(part, type) else repr(part)


def _made(part):
    if isinstance(part, tuple):
        return tuple(map(_made, part))
    return part.numba if isinstance(part, Declared) else part


def __getattr__(name: str) -> Declared:
    if name.startswith("_"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

    def make():
        from numba import types

        return getattr(types, name)

    return Declared(name, make)
