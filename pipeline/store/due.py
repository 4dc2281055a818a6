"""Which blocks and rows are still due: those not complete, and those to be enumerated at every column.

Everything that is read for it is verified.
"""

from pathlib import Path

import numpy as np

from pipeline.plan.plan import Block, Plan
from pipeline.store.blocks import RowValues, is_stored, read_rows, read_states
from pipeline.store.states import COMPLETE

__all__ = ["certified_rows", "kept_rows", "pending_blocks", "rows_to_certify"]

_GAINED = "branches/n_gained"


def pending_blocks(path: Path, plan: Plan, done: tuple[int, ...] = (COMPLETE,)) -> list[Block]:
    """Blocks with a row whose state is not `done`; each is computed again as a whole, as far as its rows are not kept.

    Raises
    ------
    DamagedError
        If a chunk of `status` is damaged.
    """
    return [block for block in plan.blocks if not np.all(np.isin(read_states(path, plan, block), done))]


def rows_to_certify(path: Path, plan: Plan) -> np.ndarray:
    """Rows not yet looked at everywhere next to which, in their plane, something comes or goes that their own seeds
    may have missed.

    A row is one if the folds found from its evenly spaced seeds differ in number from a neighbour's, or if looking
    everywhere brought a neighbour a new branch. Looking at them everywhere can only add rows, and the order does not
    matter, so that a run that was interrupted arrives at the same store.

    Raises
    ------
    DamagedError
        If a chunk of a stored row is missing or damaged.
    """
    status, folds, gained = (_by_layer(path, plan, name) for name in ("status", "branches/n_folds", _GAINED))
    complete = status == COMPLETE
    step = (np.diff(folds) != 0) & complete[:, 1:] & complete[:, :-1]
    wanted = np.zeros(folds.shape, dtype=bool)
    wanted[:, 1:] |= step | (gained[:, :-1] > 0)
    wanted[:, :-1] |= step | (gained[:, 1:] > 0)
    return np.flatnonzero(wanted & complete & (gained < 0))


def certified_rows(path: Path, plan: Plan) -> np.ndarray:
    """Rows in which every column was looked at; raises as `rows_to_certify`."""
    return np.flatnonzero(_by_layer(path, plan, _GAINED) >= 0)


def kept_rows(path: Path, plan: Plan, block: Block, every_column: frozenset[int]) -> dict[int, RowValues]:
    """Up-to-date rows of a block and what is stored of them: complete, and looked at in every column where that is
    asked.

    Raises
    ------
    DamagedError
        If anything that is stored of the block is missing or damaged.
    """
    if not is_stored(path, plan, block):
        return {}
    looked = read_rows(path, plan, block, ("status", _GAINED))
    rows = np.arange(block.start, block.stop)
    kept = (looked["status"] == COMPLETE) & ((looked[_GAINED] >= 0) | ~np.isin(rows, list(every_column)))
    stored = read_rows(path, plan, block) if np.any(kept) else {}
    return {int(rows[i]): {name: values[i, ...] for name, values in stored.items()} for i in np.flatnonzero(kept)}


def _by_layer(path: Path, plan: Plan, name: str) -> np.ndarray:
    """One value per row of every layer, (layers, P)."""
    layer = plan.parameter.num
    blocks = [Block(first, first + layer) for first in range(0, plan.rows, layer)]
    return np.stack([read_rows(path, plan, block, (name,))[name] for block in blocks])
