"""What may be asked of the stages that integrate, checked before anything is computed."""

import math

from pipeline.config.schema import Basins, Jumps
from pipeline.errors import ConfigurationError
from pipeline.plan.plan import Plan

__all__ = ["check_basins", "check_jumps"]


def check_basins(options: Basins, plan: Plan) -> None:
    """Raise ConfigurationError, one line, unless these settings are allowed for this plane."""
    if options.points is None:
        return
    axes = (plan.sweep, plan.parameter)
    names = f"[{axes[0].name}, {axes[1].name}]"
    if not isinstance(options.points, list) or not options.points:
        raise ConfigurationError(
            f"basins.points = {options.points} is not allowed: it must be null or a list of {names}"
        )
    for point in options.points:
        if not _inside(point, axes):
            allowed = ", ".join(f"{axis.name} = {axis.low:g} ... {axis.high:g}" for axis in axes)
            raise ConfigurationError(f"basins.points = {point} is not allowed: it must be {names} within {allowed}")


def _inside(point, axes) -> bool:
    """Whether it is a pair of numbers within the plane."""
    if not isinstance(point, list) or len(point) != 2:
        return False
    return all(
        isinstance(value, int | float) and not isinstance(value, bool) and axis.low <= value <= axis.high
        for value, axis in zip(point, axes, strict=True)
    )


def check_jumps(options: Jumps, plan: Plan) -> None:
    """Raise ConfigurationError, one line, unless these settings are allowed for this plane."""
    row = plan.parameter
    if options.values is None:
        if options.rows > row.num:
            raise ConfigurationError(
                f"jumps.rows = {options.rows} is not allowed: it must be from 1 to {row.num}, as the plane has"
            )
        return
    if not options.values:
        raise ConfigurationError("jumps.values = [] is not allowed: it must be null or hold at least one value")
    for value in options.values:
        if not (math.isfinite(value) and row.low <= value <= row.high):
            raise ConfigurationError(
                f"jumps.values = {value} is not allowed: it must lie within {row.name} = {row.low:g} ... {row.high:g}"
            )
