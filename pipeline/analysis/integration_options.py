"""What may be asked of the stages that integrate, checked before anything is computed."""

import math

from pipeline.config.schema import Basins, Jumps, Verify
from pipeline.errors import ConfigurationError
from pipeline.plan.plan import Plan

__all__ = ["check_basins", "check_jumps", "check_verify"]

#: Fewer periods leave no window over which a Lyapunov exponent says anything.
FEWEST_PERIODS = 300
#: Twice this is the highest order of the balance.
HIGHEST_ORDER = 32


def _check(key: str, value, low, high) -> None:
    if not low <= value <= high:
        raise ConfigurationError(f"{key} = {value} is not allowed: it must be from {low:g} to {high:g}")


def check_verify(options: Verify) -> None:
    """Raise ConfigurationError, one line, unless these settings are allowed."""
    bounds = {
        "samples": (1, 10**6),
        "beside": (0, 10**6),
        "seed": (0, 2**63 - 1),
        "order": (1, HIGHEST_ORDER),
        "columns": (2, 10**6),
        "delta": (0.0, 1.0),
        "max_periods": (FEWEST_PERIODS, 10**7),
    }
    for name, ends in bounds.items():
        _check(f"verify.{name}", getattr(options, name), *ends)
    if not 0.0 < options.tolerance <= 1.0:
        raise ConfigurationError(
            f"verify.tolerance = {options.tolerance} is not allowed: it must be above 0 and at most 1"
        )


def check_basins(options: Basins, plan: Plan) -> None:
    """Raise ConfigurationError, one line, unless these settings are allowed for this plane."""
    bounds = {"cells": (1, 10**6), "starts": (1, 10**6), "seed": (0, 2**63 - 1), "max_periods": (FEWEST_PERIODS, 10**7)}
    for name, ends in bounds.items():
        _check(f"basins.{name}", getattr(options, name), *ends)
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
    _check("jumps.max_periods", options.max_periods, FEWEST_PERIODS, 10**7)
    row = plan.parameter
    if options.values is None:
        _check("jumps.rows", options.rows, 1, row.num)
        return
    if not options.values:
        raise ConfigurationError("jumps.values = [] is not allowed: it must be null or hold at least one value")
    for value in options.values:
        if not (math.isfinite(value) and row.low <= value <= row.high):
            raise ConfigurationError(
                f"jumps.values = {value} is not allowed: it must lie within {row.name} = {row.low:g} ... {row.high:g}"
            )
