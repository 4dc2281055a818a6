"""What came of all rows of a store. Rows of a volume are numbered through, layer by layer."""

import numpy as np

from pipeline.config.places import Place
from pipeline.store.states import COMPLETE, FAILED
from pipeline.store.stored_arrays import open_arrays

__all__ = ["failures", "notes", "proven_cells", "statuses"]


def statuses(path: Place) -> np.ndarray:
    """State of every row."""
    return open_arrays(path).read("status").ravel()


def proven_cells(path: Place) -> tuple[int, int] | None:
    """Number of cells whose solutions are proven to be all, and of all cells; None where proofs are not asked for."""
    arrays = open_arrays(path)
    if "certified" not in arrays:
        return None
    certified = arrays.read("certified")
    return int(np.sum(certified[arrays.read("status") == COMPLETE] == 1)), certified.size


def notes(path: Place) -> list[tuple[int, str]]:
    """Complete rows in which something could not be decided, and what."""
    return [(row, message) for row, message in _messages(path, COMPLETE) if message]


def failures(path: Place) -> list[tuple[int, str]]:
    """Failed rows and their reasons."""
    return _messages(path, FAILED)


def _messages(path: Place, state: int) -> list[tuple[int, str]]:
    arrays = open_arrays(path)
    rows = np.flatnonzero(arrays.read("status") == state)
    messages = arrays.read("message").ravel() if rows.size else []
    return [(int(row), messages[row]) for row in rows]
