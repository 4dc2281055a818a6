"""One layer of a volume taken out as a store of its own, to which every stage may add."""

import shutil
from pathlib import Path

import zarr

from pipeline import store
from pipeline.plan.layers import Layer
from pipeline.plan.plan import Plan
from pipeline.store.arrays import arrays_of
from pipeline.store.codecs import every_chunk

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
    """
    store.refuse_to_write_older(layer.volume)
    draft = path.with_name(f".{path.name}.layer")
    shutil.rmtree(draft, ignore_errors=True)
    store.create(draft, plan, name, configuration)
    source, target = zarr.open_group(layer.volume, mode="r"), zarr.open_group(draft, mode="r+")
    with every_chunk():
        for block in plan.blocks:
            (rows,) = plan.place(block)
            for array in arrays_of(plan):
                target[array][rows] = source[array][layer.index, rows]
    draft.rename(path)
