"""A point of a plane as users write it: two values in the order of the axes or by name, with or without units."""

from pipeline.config.physical import value_of
from pipeline.errors import refused
from pipeline.plan.plan import Plan
from pipeline.plan.scales import scales_of

__all__ = ["point_on"]


def point_on(key: str, given, plan: Plan) -> tuple[float, float]:
    """The place that a setting names, on the swept axis and on the row axis.

    Parameters
    ----------
    key : str
        What the user typed it for; messages begin with it.
    given
        As typed: [0.8, 0.2] or {omega: 0.8, f_e: 0.2}.
    plan : Plan

    Raises
    ------
    ConfigurationError
        One line that names the key, its value and what is allowed.
    """
    axes, scales = (plan.sweep, plan.parameter), scales_of(plan)
    names = [axis.name for axis in axes]
    allowed = f"[{', '.join(names)}] within " + ", ".join(f"{a.name} = {a.low:g} ... {a.high:g}" for a in axes)
    values = given
    if isinstance(given, dict) and sorted(map(str, given)) == sorted(names):
        values = [given[name] for name in names]
    if not isinstance(values, list) or len(values) != 2:
        raise refused(key, given, allowed)
    point = [value_of(key, name, value, scales, allowed) for name, value in zip(names, values, strict=True)]
    if not all(axis.low <= value <= axis.high for axis, value in zip(axes, point, strict=True)):
        raise refused(key, given, allowed)
    return point[0], point[1]
