"""States of rows. Rows of a volume are numbered through, layer by layer."""

from pathlib import Path

import numpy as np
import zarr

__all__ = ["COMPLETE", "FAILED", "PENDING", "failures", "statuses"]

PENDING, COMPLETE, FAILED = 0, 1, 2


def statuses(path: Path) -> np.ndarray:
    """State of every row."""
    return zarr.open_group(path, mode="r")["status"][...].ravel()


def failures(path: Path) -> list[tuple[int, str]]:
    """Failed rows and their reasons."""
    root = zarr.open_group(path, mode="r")
    rows = np.flatnonzero(root["status"][...] == FAILED)
    messages = root["message"][...].ravel() if rows.size else []
    return [(int(row), str(messages[row])) for row in rows]
