"""States of rows, and which of them are still due. Rows of a volume are numbered through, layer by layer."""

from pathlib import Path

import numpy as np
import zarr

from pipeline.plan.plan import Block, Plan

__all__ = [
    "COMPLETE",
    "FAILED",
    "PENDING",
    "certified_rows",
    "failures",
    "kept_rows",
    "pending_blocks",
    "rows_to_certify",
    "statuses",
]

PENDING, COMPLETE, FAILED = 0, 1, 2


def statuses(path: Path) -> np.ndarray:
    """State of every row."""
    return zarr.open_group(path, mode="r")["status"][...].ravel()


def pending_blocks(path: Path, plan: Plan) -> list[Block]:
    """Blocks with a row that is not complete; each is computed again as a whole, failed rows included."""
    status = statuses(path)
    return [block for block in plan.blocks if np.any(status[block.start : block.stop] != COMPLETE)]


def kept_rows(path: Path, plan: Plan, block: Block, every_column: frozenset[int]) -> frozenset[int]:
    """Rows of a block that are stored as they shall be: complete, and looked at in every column where that is asked."""
    root, place = zarr.open_group(path, mode="r"), plan.place(block)
    complete, looked = root["status"][place] == COMPLETE, root["branches/n_gained"][place] >= 0
    rows = np.arange(block.start, block.stop)
    return frozenset(rows[complete & (looked | ~np.isin(rows, list(every_column)))].tolist())


def rows_to_certify(path: Path) -> np.ndarray:
    """Rows not yet looked at everywhere next to which, in their plane, something comes or goes that their own seeds
    may have missed.

    A row is one if the folds found from its evenly spaced seeds differ in number from a neighbour's, or if looking
    everywhere brought a neighbour a new branch. Looking at them everywhere can only add rows, and the order does not
    matter, so that a run that was interrupted arrives at the same store.
    """
    root = zarr.open_group(path, mode="r")
    complete = root["status"][...] == COMPLETE
    folds, gained = root["branches/n_folds"][...], root["branches/n_gained"][...]
    step = (np.diff(folds) != 0) & complete[..., 1:] & complete[..., :-1]
    wanted = np.zeros(folds.shape, dtype=bool)
    wanted[..., 1:] |= step | (gained[..., :-1] > 0)
    wanted[..., :-1] |= step | (gained[..., 1:] > 0)
    return np.flatnonzero(wanted & complete & (gained < 0))


def certified_rows(path: Path) -> np.ndarray:
    """Rows in which every column was looked at."""
    return np.flatnonzero(zarr.open_group(path, mode="r")["branches/n_gained"][...] >= 0)


def failures(path: Path) -> list[tuple[int, str]]:
    """Failed rows and their reasons."""
    root = zarr.open_group(path, mode="r")
    rows = np.flatnonzero(root["status"][...] == FAILED)
    messages = root["message"][...].ravel() if rows.size else []
    return [(int(row), str(messages[row])) for row in rows]
