"""What is wrong with one file of a store, and the error that says so."""

from dataclasses import dataclass

from pipeline.config.places import Place
from pipeline.errors import DamagedError
from pipeline.plan.plan import Block

__all__ = ["Damage", "damaged"]


@dataclass(frozen=True)
class Damage:
    """One damaged file.

    Parameters
    ----------
    file : str
        Its name in the store.
    fault : str
        What is wrong with it.
    block : Block or None
        The rows that it belongs to; None for metadata and axes, and for groups.
    group : str or None
        The added group that it belongs to.
    """

    file: str
    fault: str
    block: Block | None = None
    group: str | None = None

    @property
    def sentence(self) -> str:
        """For the terminal."""
        whose = f" (rows {self.block.start}-{self.block.stop - 1})" if self.block else ""
        return f"{self.file} {self.fault}{whose}"


def damaged(place: Place, what: str) -> DamagedError:
    """The error for a store of which `what` is damaged."""
    error = DamagedError(f"{place} is damaged: {what}; stages=[check] lists and check.repair=true mends it")
    error.what = what
    return error
