"""States of the rows of a block, in the file that says whether the block is stored; read and written without zarr."""

import numpy as np

from pipeline.plan.plan import Block, Plan
from pipeline.store.arrays import status_layout
from pipeline.store.chunk_files import encoded, read_chunk
from pipeline.store.files import Files
from pipeline.store.states import PENDING

__all__ = ["is_stored", "read_states", "write_states"]


def is_stored(files: Files, plan: Plan, block: Block) -> bool:
    """Whether rows of a block are stored, complete or failed; raises as `read_states`."""
    return bool(np.any(read_states(files, plan, block) != PENDING))


def read_states(files: Files, plan: Plan, block: Block) -> np.ndarray:
    """State of every row of a block, by its chunk of `status`; pending where there is none, which was never written.

    Raises
    ------
    DamagedError
        If that chunk is damaged.
    """
    status = status_layout(plan)
    (file,) = status.files(*plan.place(block))
    count = block.stop - block.start
    if not files.has(file):
        return np.full(count, PENDING, np.uint8)
    return read_chunk(files, file, status).reshape(-1)[:count]


def write_states(files: Files, plan: Plan, block: Block, states: np.ndarray | int) -> None:
    """Write the state of every row of a block, on the disk when this returns.

    Parameters
    ----------
    files : Files
        Of the store.
    plan : Plan
    block : Block
    states : (rows,) ndarray or int
    """
    status = status_layout(plan)
    (file,) = status.files(*plan.place(block))
    files.write({file: encoded(np.broadcast_to(states, block.stop - block.start), status)})
