"""What quantities of motions are in physical units."""

from pipeline.config.quantities import Quantity
from solver import Scale, Scales

__all__ = ["scale_of"]


def scale_of(quantity: Quantity, scales: Scales | None) -> Scale | None:
    """What 1 means of a quantity in physical units; None without scales, and of a ratio."""
    return None if scales is None or quantity.scale is None else scales[quantity.scale]
