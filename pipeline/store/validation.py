"""The plan that a store describes, if a configuration could have asked for it: the store may come from someone else."""

import math

from pipeline.config.allowed import check_one
from pipeline.config.physical import PATHS
from pipeline.config.schema import Solver, Store
from pipeline.plan.axes import Axis
from pipeline.plan.kinds import BEVEL, GearKind, kind_of
from pipeline.plan.plan import Plan, plan_of
from pipeline.plan.planning import check_numbers

__all__ = ["validate_plan"]


def validate_plan(numbers: dict) -> Plan:
    """The plan that `Plan.inputs` came from.

    Raises
    ------
    ArithmeticError, AttributeError, LookupError, TypeError, ValueError, ConfigurationError
        If no plan of this program has such numbers.
    """
    plan = plan_of(numbers)
    for axis in plan.axes:
        _check_axis(axis, kind_of(plan))
    names = [axis.name for axis in plan.axes]
    if len(set(names)) < len(names):
        raise ValueError(f"axes {' x '.join(names)}")
    for name in ("max_solutions", "max_branches", "max_points"):
        _check_whole(Store, name, getattr(plan, name))
    if (plan.omega is None) != ("omega" in (plan.sweep.name, plan.parameter.name)) or not _finite(plan.omega or 1.0):
        raise ValueError(f"omega = {str(plan.omega)[:40]}")
    for name in ("order", "period"):
        _check_whole(Solver, name, plan.solver[name])
    check_numbers(plan)
    return plan


def _check_whole(section: type, name: str, value) -> None:
    """It is a number that a configuration could have had."""
    if type(value) is not int:
        raise ValueError(f"{name} = {str(value)[:40]}")
    check_one(section, name, value)


def _check_axis(axis: Axis, kind: GearKind) -> None:
    if axis.name not in ("omega", *kind.axes, *(PATHS if kind is BEVEL else ())):
        raise ValueError(f"an axis {str(axis.name)[:40]!r}")
    if type(axis.num) is not int or axis.num < 2:
        raise ValueError(f"{str(axis.num)[:40]} values of {axis.name}")
    if not all(map(_finite, (axis.low, axis.high))) or axis.low >= axis.high:
        raise ValueError(f"{axis.name} from {str(axis.low)[:40]} to {str(axis.high)[:40]}")


def _finite(value) -> bool:
    return type(value) in (int, float) and math.isfinite(value)
