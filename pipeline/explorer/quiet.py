"""Telling apart what a view sets in a page from what the reader asks for: widgets report both."""

__all__ = ["Quiet"]


class Quiet:
    """True while entered: what widgets report meanwhile is nothing that the reader has asked for."""

    def __init__(self):
        self._entered = 0

    def __enter__(self) -> None:
        self._entered += 1

    def __exit__(self, *error) -> None:
        self._entered -= 1

    def __bool__(self) -> bool:
        return self._entered > 0
