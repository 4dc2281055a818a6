"""One layer of a volume taken out as a store of its own, to which every stage may add."""

from pathlib import Path

import numpy as np

from pipeline import store
from pipeline.plan.layers import Layer
from pipeline.plan.plan import Block, Plan
from pipeline.store.names import STORE_FILE
from pipeline.store.removal import remove_known

__all__ = ["extract_layer"]


def extract_layer(layer: Layer, path: Path, plan: Plan, name: str, configuration: str) -> None:
    """Copy a layer of a volume, as far as it is computed, into a store of its own.

    Parameters
    ----------
    layer : Layer
    path : Path
        Where the plane's store shall be; must not exist. It appears when it is whole.
    plan : Plan
        Of the layer.
    name, configuration : str
        As for `store.create`.

    Raises
    ------
    DamagedError
        If anything that is stored of the layer is missing or damaged.
    """
    volume = store.read_layout(layer.volume).plan
    draft = path.with_name(f".{path.name}.layer")
    remove_known(draft, STORE_FILE)
    store.create(draft, plan, name, configuration)
    first = layer.index * plan.rows
    for block in plan.blocks:
        values = store.read_rows(layer.volume, volume, Block(first + block.start, first + block.stop))
        if np.any(values["status"] != store.PENDING):
            rows = [{name: found[i, ...] for name, found in values.items()} for i in range(block.stop - block.start)]
            store.write_block(draft, plan, block, rows)
    draft.rename(path)
