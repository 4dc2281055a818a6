"""What may be asked of the stage `margins`, checked before anything is computed."""

import dataclasses
from dataclasses import dataclass, field

from pipeline.config.physical import value_of
from pipeline.config.schema import Margins
from pipeline.errors import ConfigurationError, refused
from pipeline.plan.axes import Axis
from pipeline.plan.kinds import kind_of
from pipeline.plan.numerics import model_at, row_axis
from pipeline.plan.plan import Plan
from pipeline.plan.points import point_on
from pipeline.plan.scales import scales_of
from solver import ParameterError, Scales

__all__ = ["Design", "design_of", "nominal_value", "replaced"]

#: Every further tolerance doubles the number of planes that are traced.
_MOST_FURTHER = 6


@dataclass(frozen=True)
class Design:
    """A design point of a plane.

    Parameters
    ----------
    x, p : float
        The point, on the swept axis and on the row axis.
    low, high : float
        Operating range on the swept axis; both x without one.
    tolerance : float
        Of p, plus or minus.
    further : dict of str to float
        Parameters that are no axis and their tolerances, plus or minus.
    reach : float
        Such parameters are looked at up to so many times their value.
    """

    x: float
    p: float
    low: float
    high: float
    tolerance: float = 0.0
    further: dict[str, float] = field(default_factory=dict)
    reach: float = 3.0


def design_of(options: Margins, plan: Plan) -> Design:
    """The design that the settings describe.

    Raises
    ------
    ConfigurationError
        One line that names the key, its value and what is allowed.
    """
    scales = scales_of(plan)
    x, p = point_on("margins.point", options.point, plan)
    low, high = _range(options.range, plan.sweep, x, scales)
    tolerances = options.tolerances or {}
    if not isinstance(tolerances, dict):
        raise refused("margins.tolerances", tolerances, "numbers by name, such as {f_e: 0.02}")
    allowed = "a number, at least 0"
    names = dict.fromkeys(("omega", *kind_of(plan).axes, plan.parameter.name))
    for name in tolerances:
        if name not in names:
            raise ConfigurationError(f"margins.tolerances.{name} is not allowed: it must be one of {', '.join(names)}")
    read = {
        name: value_of(f"margins.tolerances.{name}", name, size, scales, allowed) for name, size in tolerances.items()
    }
    for name, size in read.items():
        if size < 0.0:
            raise refused(f"margins.tolerances.{name}", tolerances[name], "a number, at least 0")
        if name not in (plan.sweep.name, plan.parameter.name):
            row = float(read.get(plan.parameter.name, 0.0))
            _check_further(name, size, tolerances[name], plan, x, (p - row, p, p + row))
    spread, tolerance = read.pop(plan.sweep.name, 0.0), read.pop(plan.parameter.name, 0.0)
    for axis, value, size in ((plan.sweep, x, spread), (plan.parameter, p, tolerance)):
        if not axis.low <= value - size <= value + size <= axis.high:
            raise refused(
                f"margins.tolerances.{axis.name}",
                size,
                f"so small that {axis.name} = {value:g} +- it stays within {axis.low:g} ... {axis.high:g}",
            )
    if len(read) > _MOST_FURTHER:
        raise refused("margins.tolerances", list(tolerances), f"of at most {_MOST_FURTHER} parameters that are no axis")
    return Design(x, p, min(low, x - spread), max(high, x + spread), tolerance, read, float(options.reach))


def _range(given, axis: Axis, x: float, scales: Scales | None) -> tuple[float, float]:
    if given is None:
        return x, x
    allowed = f"null or [{axis.name} low, {axis.name} high] around {x:g} within {axis.low:g} ... {axis.high:g}"
    if not isinstance(given, list) or len(given) != 2:
        raise refused("margins.range", given, allowed)
    low, high = (value_of("margins.range", axis.name, value, scales, allowed) for value in given)
    if not axis.low <= low <= x <= high <= axis.high:
        raise refused("margins.range", given, allowed)
    return low, high


def _check_further(name: str, size: float, given, plan: Plan, x: float, rows: tuple[float, float, float]) -> None:
    """Raise unless a parameter that is no axis has one value in the middle row, and may have those at the ends of its
    tolerance in all three."""
    key, p = f"margins.tolerances.{name}", rows[1]
    try:
        value = nominal_value(plan, x, p, name)
    except ValueError:
        raise refused(key, given, "left out: this gear has several values of it") from None
    if name in _moved(plan) and name not in row_axis(plan).shifts:
        raise refused(key, given, f"left out: {name} varies with {plan.parameter.name}, its tolerance with it")
    for end in (value - size, value + size):
        try:
            if name == "omega" and not end > 0.0:
                raise ParameterError(name, end, "a finite number above 0")
            changed = replaced(plan, {name: end}, x, p)
            for row in rows:
                model_at(changed, row, x)
        except ParameterError as error:
            stays = f"it leaves {error.name} =" if error.name == plan.parameter.name else "it stays"
            raise refused(key, given, f"so small that {name} = {value:g} +- {stays} {error.allowed}") from None


def _moved(plan: Plan) -> tuple[str, ...]:
    """Parameters that are no axis and that the row parameter moves."""
    axis = row_axis(plan)
    return () if isinstance(axis, str) else axis.uses


def nominal_value(plan: Plan, x: float, p: float, name: str) -> float:
    """A parameter's value at a place of the plane; raises ValueError where it has several."""
    named = {"omega": plan.omega, plan.sweep.name: x, plan.parameter.name: p}
    return float(named[name]) if name in named else kind_of(plan).value(plan.gear, model_at(plan, p, x), name)


def replaced(plan: Plan, values: dict[str, float], x: float, p: float) -> Plan:
    """The same plane with parameters that are no axis changed to values that they have at (x, p); raises ParameterError
    if (x, p) does not allow it."""
    gear = {**plan.gear, **{name: value for name, value in values.items() if name != "omega"}}
    for name in values.keys() & set(_moved(plan)):
        # The reference is moved by as much.
        gear[name] = plan.gear[name] + (values[name] - nominal_value(plan, x, p, name))
    changed = dataclasses.replace(plan, gear=gear, omega=values.get("omega", plan.omega))
    model_at(changed, p, x)
    return changed
