"""What a published number says, and how closely ours has to meet it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from pipeline.study.statements.planes import Planes

__all__ = ["Quantity", "Statement"]


class Quantity(Protocol):
    """How numbers are computed from stored planes; `pipeline.study.statements.quantities` holds those there are."""

    @property
    def how(self) -> str:
        """In words."""

    def shown(self, values: Sequence[float]) -> str:
        """Such numbers for a cell of a table, to the digits that they deserve; lines are kept."""

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
        The same in words, for a sentence such as "differs by more than 5 % of the article's value".
    reference : str
        What docs/physics.md, section 7, prints for it, first order with the calibrated numbers; empty if nothing.
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
    reference: str = ""
    source: str = "article"
