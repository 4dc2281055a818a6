"""Places of a plane given by the names of its axes, as `omega=0.6, f_e=0.2`, and the cells nearest to them."""

import numpy as np

from pipeline.plan.axes import Axis
from pipeline.plan.plan import Plan
from solver.model.checks import ParameterError, finite_number

__all__ = ["cell_of", "nearest", "place_of", "value_of"]


def place_of(plan: Plan, given: dict) -> tuple[float, float]:
    """Column value and row value of a place.

    Raises
    ------
    solver.ParameterError
        If it is not given by the names of both axes, or lies outside of the plane.
    """
    axes = (plan.sweep, plan.parameter)
    _check_names(given, {axis.name for axis in axes})
    return tuple(_within(axis, given[axis.name]) for axis in axes)


def cell_of(plan: Plan, given: dict) -> tuple[int, int]:
    """Row and column of the nearest cell; raises as `place_of`."""
    x, p = place_of(plan, given)
    return nearest(plan.parameter, p), nearest(plan.sweep, x)


def value_of(axis: Axis, given: dict) -> float:
    """The value of one axis, given by its name; raises as `place_of`."""
    _check_names(given, {axis.name})
    return _within(axis, given[axis.name])


def nearest(axis: Axis, value: float) -> int:
    """Which value of an axis is nearest to one."""
    return int(np.argmin(np.abs(axis.values - value)))


def _check_names(given: dict, names: set[str]) -> None:
    if set(given) != names:
        raise ParameterError("place", given, f"given by {' and '.join(sorted(names))}, each with a value")


def _within(axis: Axis, value) -> float:
    return finite_number(axis.name, value, at_least=axis.low, at_most=axis.high)
