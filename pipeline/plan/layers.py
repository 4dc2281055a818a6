"""Which layer of a volume a configuration asks for, and the configuration of its plane."""

from dataclasses import dataclass, replace

import numpy as np

from pipeline.config.compose import Settings
from pipeline.config.places import Place
from pipeline.errors import ConfigurationError
from pipeline.plan.plan import Plan

__all__ = ["Layer", "layer_name", "layer_of", "of_layer"]


@dataclass(frozen=True)
class Layer:
    """Where a layer is: the store of its volume, and its number there."""

    volume: Place
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


def layer_name(name: str, volume: Plan, index: int) -> str:
    """What the plane of a layer is called, from what its volume is called."""
    return f"{name}-{volume.parameter2.name}={volume.parameter2.values[index]:.6g}"


def of_layer(settings: Settings, volume: Plan, layer: Layer) -> Settings:
    """The same settings for the plane of a layer, whose store is named after it."""
    name = layer_name(settings.store_name, volume, layer.index)
    config = settings.config
    return replace(settings, config=replace(config, store=replace(config.store, name=name)))
