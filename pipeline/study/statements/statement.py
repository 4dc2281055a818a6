"""What a published number says, and how closely ours has to meet it."""

from dataclasses import dataclass
from typing import Protocol

from pipeline.study.statements.planes import Planes

__all__ = ["Quantity", "Statement"]


class Quantity(Protocol):
    """How numbers are computed from stored planes; `pipeline.study.statements.quantities` holds those there are."""

    @property
    def how(self) -> str:
        """In words."""

    def values(self, planes: Planes) -> tuple[float, ...]:
        """The numbers; raises `pipeline.errors.StoreError` where they cannot be computed."""


@dataclass(frozen=True)
class Statement:
    """One published number, or several that belong together.

    Parameters
    ----------
    key : str
        Unique, in order of the list.
    text : str
        What is said, in our own words.
    plane : str
        Name of the plane that it is about; empty for one row of a gear.
    quantity : Quantity
    article : tuple of float
        The published values; a single one stands against each of ours.
    tolerance : tuple of float
        How far ours may be from each of them, absolute; a single one for all.
    agreement : str
        The same in words.
    source : str
        "article", or "reference" for the digits on which two independent programs agree.
    """

    key: str
    text: str
    plane: str
    quantity: Quantity
    article: tuple[float, ...]
    tolerance: tuple[float, ...]
    agreement: str
    source: str = "article"
