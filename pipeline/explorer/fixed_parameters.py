"""Parameters of a plane that are no axis: what may be changed in the explorer, within which range."""

from collections.abc import Mapping
from dataclasses import dataclass

from pipeline.analysis.margins.distances import further_axis
from pipeline.analysis.margins.options import Design, nominal_value, replaced
from pipeline.errors import ConfigurationError, refused
from pipeline.plan.kinds import APART, kind_of
from pipeline.plan.numerics import row_axis
from pipeline.plan.plan import Plan
from pipeline.store import axis_attributes
from solver import ParameterError

__all__ = ["FixedParameter", "changed_plan", "fixed_parameters"]


@dataclass(frozen=True)
class FixedParameter:
    """One of them.

    Parameters
    ----------
    name : str
        As axes are called.
    value : float
        In the plane.
    low, high : float
        Between which it may be changed.
    words : str
        What it is.
    """

    name: str
    value: float
    low: float
    high: float
    words: str


def fixed_parameters(plan: Plan) -> tuple[FixedParameter, ...]:
    """Those of a plane that have one number, the same everywhere in it.

    Parameters
    ----------
    plan : Plan
        Of a plane, not of a volume.
    """
    axis, kind = row_axis(plan), kind_of(plan)
    taken = {plan.sweep.name, plan.parameter.name, *(() if isinstance(axis, str) else axis.uses)}
    for one, other in APART:
        # They move the same numbers: one of them is enough.
        taken.add(one if other in taken else other)
    x, p = _middle(plan)
    found = []
    for name in ("omega", *kind.axes):
        if name in taken or (name == "omega" and plan.omega is None):
            continue
        try:
            value = nominal_value(plan, x, p, name)
        except (ValueError, TypeError, AttributeError):
            # A number for each gear, or no number at all.
            continue
        within = further_axis(plan, Design(x, p, x, x), name)
        if within.low <= value <= within.high and within.low < within.high:
            text = axis_attributes(name, plan.kind)["long_name"]
            found.append(FixedParameter(name, value, within.low, within.high, text))
    return tuple(found)


def changed_plan(plan: Plan, fixed: Mapping[str, float]) -> Plan:
    """The same plane with such parameters changed.

    Parameters
    ----------
    plan : Plan
    fixed : mapping
        Name -> value.

    Raises
    ------
    ConfigurationError
        One line that names the parameter, its value and what is allowed.
    """
    if not fixed:
        return plan
    allowed = {one.name: one for one in fixed_parameters(plan)}
    for name, value in fixed.items():
        if name not in allowed:
            raise ConfigurationError(f"{name} is not allowed here: it must be one of {', '.join(allowed)}")
        one = allowed[name]
        if not one.low <= value <= one.high:
            raise refused(name, value, f"from {one.low:g} to {one.high:g}")
    try:
        return replaced(plan, dict(fixed), *_middle(plan))
    except ParameterError as error:
        raise ConfigurationError(str(error)) from None


def _middle(plan: Plan) -> tuple[float, float]:
    return 0.5 * (plan.sweep.low + plan.sweep.high), 0.5 * (plan.parameter.low + plan.parameter.high)
