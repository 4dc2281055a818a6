"""What the map of a plane can show, and each of it as plain data."""

from pipeline.analysis.attractors.dataset import read_attractors
from pipeline.config.quantities import QUANTITIES
from pipeline.errors import ConfigurationError, refused
from pipeline.explorer.cell_layers import attractor_layer, credibility_layer, quantity_layer
from pipeline.explorer.layer_data import Layer
from pipeline.explorer.map_frame import frame_of_map
from pipeline.explorer.region_layers import region_layer, sketch
from pipeline.plan.kinds import kind_of
from pipeline.plane.stored import StoredPlane

__all__ = ["layer", "layer_names", "layer_sketch"]

_LABELS = ("domains", "dynamic")


def layer_names(plane: StoredPlane) -> tuple[str, ...]:
    """The layers that the store of a plane has, in the order in which a reader asks for them.

    Returns
    -------
    tuple of str
        "domains", "dynamic", "attractors" and "credibility" where attractors are stored, then the quantities that
        motions of this gear have.
    """
    found = ("attractors", "credibility") if read_attractors(plane.path) is not None else ()
    return (*_LABELS, *found, *(name for name in QUANTITIES if name not in kind_of(plane.plan).lacks))


def layer(plane: StoredPlane, name: str, *, physical: bool = False, of: str = "worst") -> Layer:
    """One layer of the map.

    Parameters
    ----------
    plane : StoredPlane
        A plane, not a volume.
    name : str
        One of `layer_names`.
    physical : bool
        Whether axes and quantities are in physical units.
    of : str
        Where several stable motions coexist, a quantity is the "worst", the largest, or the "mildest", the smallest.

    Raises
    ------
    ConfigurationError
        If the store has no such layer, or the gear has no physical units.
    """
    names = layer_names(plane)
    if name not in names:
        raise refused("layer", name, f"one of {', '.join(names)}")
    if physical and plane.plan.physical is None:
        raise ConfigurationError(
            "physical = True is not allowed: it must be False, as this plane's gear is dimensionless"
        )
    frame = frame_of_map(plane, physical)
    if name in _LABELS:
        return region_layer(plane.counting(dynamic=name == "dynamic"), name, frame)
    static = plane.counting(dynamic=False)
    if name == "attractors":
        return attractor_layer(static, frame)
    if name == "credibility":
        return credibility_layer(static, frame)
    return quantity_layer(static, QUANTITIES[name], of, frame)


def layer_sketch(plane: StoredPlane, name: str, *, physical: bool = False) -> Layer | None:
    """What can be shown of a layer at once, before its boundaries are put together; None of a layer without labels.

    Parameters
    ----------
    plane, name, physical
        As of `layer`.
    """
    if name not in _LABELS:
        return None
    return sketch(plane.counting(dynamic=name == "dynamic"), name, frame_of_map(plane, physical))
