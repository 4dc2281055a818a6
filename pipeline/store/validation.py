"""The plan that a store describes, if a configuration could have asked for it: the store may come from someone else."""

import math

from pipeline.config.physical import PATHS
from pipeline.plan.axes import Axis
from pipeline.plan.plan import Plan, plan_of
from pipeline.plan.planning import check_numbers
from solver import SCALAR_PARAMETERS

__all__ = ["validate_plan"]

#: Room per row: lowest and highest, as `store.max_...` may be.
_ROOM = {"max_solutions": (1, 100), "max_branches": (1, 100), "max_points": (2, 10**7)}


def validate_plan(numbers: dict) -> Plan:
    """The plan that `Plan.numbers` came from.

    Raises
    ------
    ArithmeticError, AttributeError, LookupError, TypeError, ValueError, ConfigurationError
        If no plan of this program has such numbers.
    """
    plan = plan_of(numbers)
    for axis in plan.axes:
        _check_axis(axis)
    names = [axis.name for axis in plan.axes]
    if len(set(names)) < len(names):
        raise ValueError(f"axes {' x '.join(names)}")
    for name, (low, high) in _ROOM.items():
        value = getattr(plan, name)
        if type(value) is not int or not low <= value <= high:
            raise ValueError(f"{name} = {str(value)[:40]}")
    if (plan.omega is None) != ("omega" in (plan.sweep.name, plan.parameter.name)) or not _finite(plan.omega or 1.0):
        raise ValueError(f"omega = {str(plan.omega)[:40]}")
    for name in ("order", "period"):
        if type(plan.solver[name]) is not int or not 1 <= plan.solver[name] <= 1000:
            raise ValueError(f"solver.{name} = {str(plan.solver[name])[:40]}")
    check_numbers(plan)
    return plan


def _check_axis(axis: Axis) -> None:
    if axis.name not in ("omega", *PATHS, *SCALAR_PARAMETERS):
        raise ValueError(f"an axis {str(axis.name)[:40]!r}")
    if type(axis.num) is not int or axis.num < 2:
        raise ValueError(f"{str(axis.num)[:40]} values of {axis.name}")
    if not all(map(_finite, (axis.low, axis.high))) or axis.low >= axis.high:
        raise ValueError(f"{axis.name} from {str(axis.low)[:40]} to {str(axis.high)[:40]}")


def _finite(value) -> bool:
    return type(value) in (int, float) and math.isfinite(value)
