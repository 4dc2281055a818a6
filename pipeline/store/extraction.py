"""One layer of a volume taken out as a store of its own, to which every stage may add."""

import numpy as np

from pipeline import store
from pipeline.config.places import Place
from pipeline.plan.layers import Layer
from pipeline.plan.plan import Block, Plan
from pipeline.store.files import files_at
from pipeline.store.names import STORE_FILE

__all__ = ["extract_layer"]


def extract_layer(layer: Layer, path: Place, plan: Plan, name: str, configuration: str) -> None:
    """Copy a layer of a volume, as far as it is computed, into a store of its own.

    Parameters
    ----------
    layer : Layer
    path : Place
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
    draft = files_at(path).beside("layer")
    draft.clear(STORE_FILE)
    store.create(draft.place, plan, name, configuration)
    first = layer.index * plan.rows
    for block in plan.blocks:
        values = store.read_rows(layer.volume, volume, Block(first + block.start, first + block.stop))
        if np.any(values["status"] != store.PENDING):
            rows = [{name: found[i, ...] for name, found in values.items()} for i in range(block.stop - block.start)]
            store.write_block(draft.place, plan, block, rows)
    draft.move(files_at(path))
