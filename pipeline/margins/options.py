"""What may be asked of the stage `margins`, checked before anything is computed."""

import dataclasses
import math
from dataclasses import dataclass, field

from pipeline.errors import ConfigurationError
from pipeline.plan import Axis, Plan
from pipeline.schema import Margins
from pipeline.sweep import model_at
from solver import SCALAR_PARAMETERS, ParameterError

__all__ = ["Design", "design_of", "nominal_value", "replaced"]

#: Every further tolerance doubles the number of planes that are traced.
_MOST_FURTHER = 6
_LEAST_REACH, _MOST_REACH = 1.1, 100.0


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
    axes = (plan.sweep, plan.parameter)
    x, p = _point(options.point, axes)
    low, high = _range(options.range, plan.sweep, x)
    tolerances = options.tolerances or {}
    if not isinstance(tolerances, dict):
        raise _refused("tolerances", tolerances, "numbers by name, such as {f_e: 0.02}")
    allowed = "a number, at least 0"
    read = {name: _number(f"tolerances.{name}", size, name, allowed) for name, size in tolerances.items()}
    for name, size in read.items():
        if size < 0.0:
            raise _refused(f"tolerances.{name}", size, "a number, at least 0")
        if name not in ("omega", *SCALAR_PARAMETERS):
            names = ", ".join(("omega", *SCALAR_PARAMETERS))
            raise ConfigurationError(f"margins.tolerances.{name} is not allowed: it must be one of {names}")
        value = {plan.sweep.name: x, plan.parameter.name: p}.get(name)
        if value is None:
            _check_further(name, size, plan, x, p)
    spread, tolerance = read.pop(plan.sweep.name, 0.0), read.pop(plan.parameter.name, 0.0)
    for axis, value, size in ((plan.sweep, x, spread), (plan.parameter, p, tolerance)):
        if not axis.low <= value - size <= value + size <= axis.high:
            raise _refused(
                f"tolerances.{axis.name}", size,
                f"so small that {axis.name} = {value:g} +- it stays within {axis.low:g} ... {axis.high:g}",
            )  # fmt: skip
    if len(read) > _MOST_FURTHER:
        raise _refused("tolerances", list(tolerances), f"of at most {_MOST_FURTHER} parameters that are no axis")
    if not _LEAST_REACH <= options.reach <= _MOST_REACH:
        raise _refused("reach", options.reach, f"from {_LEAST_REACH:g} to {_MOST_REACH:g}")
    return Design(x, p, min(low, x - spread), max(high, x + spread), tolerance, read, float(options.reach))


def _point(given, axes: tuple[Axis, Axis]) -> tuple[float, float]:
    names = [axis.name for axis in axes]
    allowed = f"[{', '.join(names)}] within " + ", ".join(f"{a.name} = {a.low:g} ... {a.high:g}" for a in axes)
    if isinstance(given, dict) and sorted(given) == sorted(names):
        given = [given[name] for name in names]
    if not isinstance(given, list) or len(given) != 2:
        raise _refused("point", given, allowed)
    point = [_number("point", value, name, allowed) for name, value in zip(names, given, strict=True)]
    if not all(axis.low <= value <= axis.high for axis, value in zip(axes, point, strict=True)):
        raise _refused("point", given, allowed)
    return point[0], point[1]


def _range(given, axis: Axis, x: float) -> tuple[float, float]:
    if given is None:
        return x, x
    allowed = f"null or [{axis.name} low, {axis.name} high] around {x:g} within {axis.low:g} ... {axis.high:g}"
    if not isinstance(given, list) or len(given) != 2:
        raise _refused("range", given, allowed)
    low, high = (_number("range", value, axis.name, allowed) for value in given)
    if not axis.low <= low <= x <= high <= axis.high:
        raise _refused("range", given, allowed)
    return low, high


def _number(key: str, given, name: str, allowed: str) -> float:
    """A value of parameter `name` as the user wrote it: the one place where values of designs are read."""
    if isinstance(given, bool) or not isinstance(given, int | float) or not math.isfinite(given):
        raise _refused(key, given, allowed)
    return float(given)


def _check_further(name: str, size: float, plan: Plan, x: float, p: float) -> None:
    """Raise unless a parameter that is no axis has one value, and may have those at the ends of its tolerance."""
    try:
        value = nominal_value(plan, x, p, name)
    except ValueError:
        raise _refused(f"tolerances.{name}", size, "left out: this gear has several values of it") from None
    for end in (value - size, value + size):
        try:
            if name == "omega" and not end > 0.0:
                raise ParameterError(name, end, "a finite number above 0")
            replaced(plan, {name: end}, x, p)
        except ParameterError as error:
            allowed = f"so small that {name} = {value:g} +- it stays {error.allowed}"
            raise _refused(f"tolerances.{name}", size, allowed) from None


def nominal_value(plan: Plan, x: float, p: float, name: str) -> float:
    """A parameter's value at a place of the plane; raises ValueError where it has several."""
    model = model_at(plan, p, x)
    named = {"omega": plan.omega, "translation_coupling": model.sigma, "rotation_coupling": model.rotation}
    named |= {plan.sweep.name: x, plan.parameter.name: p}
    values = named[name] if name in named else getattr(model, name)
    (value,) = set(values) if isinstance(values, tuple) else (values,)
    return float(value)


def replaced(plan: Plan, values: dict[str, float], x: float, p: float) -> Plan:
    """The same plane with parameters that are no axis changed; raises ParameterError if (x, p) does not allow it."""
    gear = {**plan.gear, **{name: value for name, value in values.items() if name != "omega"}}
    changed = dataclasses.replace(plan, gear=gear, omega=values.get("omega", plan.omega))
    model_at(changed, p, x)
    return changed


def _refused(key: str, given, allowed: str) -> ConfigurationError:
    return ConfigurationError(f"margins.{key} = {given} is not allowed: it must be {allowed}")
