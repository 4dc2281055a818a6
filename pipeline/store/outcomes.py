"""What came of all rows of a store. Rows of a volume are numbered through, layer by layer."""

import numpy as np
import zarr

from pipeline.config.places import Place
from pipeline.store.files import files_at
from pipeline.store.states import COMPLETE, FAILED

__all__ = ["failures", "notes", "proven_cells", "statuses"]


def statuses(path: Place) -> np.ndarray:
    """State of every row."""
    return zarr.open_group(files_at(path).zarr(), mode="r", zarr_format=3)["status"][...].ravel()


def proven_cells(path: Place) -> tuple[int, int] | None:
    """Number of cells whose solutions are proven to be all, and of all cells; None where proofs are not asked for."""
    root = zarr.open_group(files_at(path).zarr(), mode="r", zarr_format=3)
    if "certified" not in root:
        return None
    certified = root["certified"][...][root["status"][...] == COMPLETE]
    return int(np.sum(certified == 1)), root["certified"].size


def notes(path: Place) -> list[tuple[int, str]]:
    """Complete rows in which something could not be decided, and what."""
    root = zarr.open_group(files_at(path).zarr(), mode="r", zarr_format=3)
    messages, complete = root["message"][...].ravel(), root["status"][...].ravel() == COMPLETE
    return [(int(row), str(messages[row])) for row in np.flatnonzero(complete) if messages[row]]


def failures(path: Place) -> list[tuple[int, str]]:
    """Failed rows and their reasons."""
    root = zarr.open_group(files_at(path).zarr(), mode="r", zarr_format=3)
    rows = np.flatnonzero(root["status"][...] == FAILED)
    messages = root["message"][...].ravel() if rows.size else []
    return [(int(row), str(messages[row])) for row in rows]
