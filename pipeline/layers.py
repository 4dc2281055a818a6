"""One layer of a volume taken out as a plane: a store of its own, to which every stage may add."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from pipeline import store
from pipeline.config import Settings
from pipeline.errors import ConfigurationError
from pipeline.plan import Block, Plan
from pipeline.store.names import STORE_FILE
from pipeline.store.removal import remove_known

__all__ = ["Layer", "extract_layer", "layer_of", "of_layer"]


@dataclass(frozen=True)
class Layer:
    """Where a layer is: the store of its volume, and its number there."""

    volume: Path
    index: int


def layer_of(settings: Settings, volume: Plan) -> Layer:
    """The layer nearest to `plane.layer`.

    Raises
    ------
    ConfigurationError
        If the plane has no layers, or none there.
    """
    value, axis = settings.config.plane.layer, volume.parameter2
    where = f"plane.layer = {value} is not allowed"
    if axis is None:
        raise ConfigurationError(f"{where}: this plane has no third axis, plane.parameter2")
    if not axis.low <= value <= axis.high:
        raise ConfigurationError(f"{where}: it must lie within {axis.name} = {axis.low:g} ... {axis.high:g}")
    return Layer(settings.store_path.resolve(), int(np.abs(axis.values - value).argmin()))


def of_layer(settings: Settings, volume: Plan, layer: Layer) -> Settings:
    """The same settings for the plane of a layer, whose store is named after it."""
    axis = volume.parameter2
    name = f"{settings.store_name}-{axis.name}={axis.values[layer.index]:.6g}"
    config = settings.config
    return replace(settings, config=replace(config, store=replace(config.store, name=name)))


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
    volume = store.read_plan(layer.volume)
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
