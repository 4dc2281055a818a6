"""Numbers with units, as users write them, into SI numbers: the only place that knows pint.

A text is a number and a unit and nothing else. It is matched before pint sees it, because pint evaluates what stands in
a unit, powers of powers included.
"""

import functools
import math
import re

from pipeline.errors import refused

__all__ = ["KINDS", "celsius", "quantities", "quantity", "speed", "unit_size"]

#: Kind -> an example, whose unit has the dimension that is asked for, and the SI unit.
KINDS = {
    "length": ("12 um", "m"),
    "angle": ("20 deg", "rad"),
    "time": ("1.2 ms", "s"),
    "mass": ("0.7 kg", "kg"),
    "inertia": ("4.5e-4 kg*m^2", "kg*m^2"),
    "density": ("7850 kg/m^3", "kg/m^3"),
    "stiffness": ("300 N/um", "N/m"),
    "stiffness over face width": ("14 N/mm/um", "N/m^2"),
    "Young's modulus": ("206 GPa", "Pa"),
    "damping": ("900 N*s/m", "N*s/m"),
    "torque": ("45 N*m", "N*m"),
    "torsional stiffness": ("2e4 N*m/rad", "N*m/rad"),
    "torsional damping": ("5 N*m*s/rad", "N*m*s/rad"),
    "diametral pitch": ("8 1/inch", "1/m"),
    "temperature difference": ("20 K", "K"),
    "thermal coefficient": ("11.2e-6 1/K", "1/K"),
}

_LONGEST = 60
_WORD = r"[A-Za-zµμ°]+(?:(?:\^|\*\*)[1-4]|[²³⁴])?"
_UNIT = re.compile(rf"(?:1?\s*/\s*)?{_WORD}(?:(?:\s*[*/·]\s*|\s+){_WORD})*")
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?(?=\s|[^\d.\s]|$)")


@functools.cache
def _registry():
    import pint

    return pint.UnitRegistry()


def quantity(key: str, value, kind: str) -> float:
    """The SI number of a text such as "45 N*m".

    Parameters
    ----------
    key : str
        What the user typed it for; messages begin with it.
    value
        As typed.
    kind : str
        Of `KINDS`.

    Raises
    ------
    ConfigurationError
        One line: no number, no unit, one that is not known, or one of another dimension.
    """
    allowed = f"a number with a unit of {kind}, such as {KINDS[kind][0]!r}"
    number, unit = _split(key, value, allowed)
    return _finite(key, value, number * _size(key, value, unit, kind, allowed), allowed)


def quantities(key: str, value, kind: str, count: int) -> list[float]:
    """One text for all or a list of `count` texts, as SI numbers; raises as `quantity` does."""
    if not isinstance(value, list):
        return [quantity(key, value, kind)] * count
    if len(value) != count:
        raise refused(key, value, f"a number with a unit of {kind}, such as {KINDS[kind][0]!r}, or a list of {count}")
    return [quantity(f"{key}[{i}]", entry, kind) for i, entry in enumerate(value)]


def unit_size(key: str, text: str, kind: str) -> float:
    """SI units of a unit that stands alone; raises as `quantity` does."""
    allowed = f"a unit of {kind}, such as {KINDS[kind][0].partition(' ')[2]!r}"
    if len(text) > _LONGEST or not _UNIT.fullmatch(text):
        raise refused(key, text[:_LONGEST], allowed)
    return _size(key, text, text, kind, allowed)


def speed(key: str, value) -> tuple[str, float]:
    """A pinion speed ("1500 rpm") or a mesh frequency ("1.2 kHz").

    Returns
    -------
    name : str
        "omega" or "mesh_frequency", as `solver.Scales` calls them.
    number : float
        rad/s of the pinion, or Hz.

    Raises
    ------
    ConfigurationError
        One line; 1/s alone is refused, since it may mean either.
    """
    allowed = "a number with a unit of pinion speed or mesh frequency, such as '1500 rpm' or '1.2 kHz'"
    number, unit = _split(key, value, allowed)
    parsed = _parsed(key, value, unit, allowed)
    names = dict(parsed._units)
    hertz = [name for name in names if name.endswith("hertz")]
    turning = [name for name in names if name.startswith("revolutions_per_") or _is_angle(name)]
    if parsed.dimensionality != {"[time]": -1.0} or bool(hertz) == bool(turning):
        raise refused(key, value, allowed)
    # For pint, Hz is 1/s and an angle is 1: cycles of the mesh and radians of the pinion.
    size = _registry().Quantity(1.0, parsed).to("1/s").magnitude
    return ("mesh_frequency" if hertz else "omega"), _finite(key, value, number * size, allowed)


def celsius(key: str, value) -> float:
    """The degrees Celsius of a temperature such as "40 degC" or "313.15 K"; raises as `quantity` does."""
    allowed = "a temperature with its unit, such as '40 degC' or '313.15 K'"
    number, unit = _split(key, value, allowed)
    parsed = _parsed(key, value, unit, allowed)
    if dict(parsed._units) not in ({"degree_Celsius": 1}, {"kelvin": 1}, {"degree_Fahrenheit": 1}):
        raise refused(key, value, allowed)
    return _finite(key, value, float(_registry().Quantity(number, parsed).to("degC").magnitude), allowed)


def _finite(key: str, value, number: float, allowed: str) -> float:
    if not math.isfinite(number):
        raise refused(key, value, allowed)
    return number


def _split(key: str, value, allowed: str) -> tuple[float, str]:
    """Number and unit of a text."""
    if not isinstance(value, str) or len(value) > _LONGEST:
        raise refused(key, value, allowed)
    text = value.strip()
    number = _NUMBER.match(text)
    unit = text[number.end() :] if number else ""
    # "81/inch" is 81 per inch, since the number takes all digits; "8 1/inch" needs its space.
    if not number or not _UNIT.fullmatch(unit.strip()):
        raise refused(key, value, allowed)
    return float(number.group()), unit.strip()


def _parsed(key: str, value, unit: str, allowed: str):
    import pint

    unit = f"1{unit}" if unit.startswith("/") else unit
    try:
        return _registry().parse_units(unit)
    except pint.UndefinedUnitError as error:
        unknown = error.unit_names if isinstance(error.unit_names, str) else ", ".join(error.unit_names)
        raise refused(key, value, f"{allowed} ({unknown!r} is not a known unit)") from None
    except (pint.PintError, ValueError, AssertionError, TypeError):
        raise refused(key, value, allowed) from None


def _is_angle(name: str) -> bool:
    return not _registry().parse_units(name).dimensionality


def _size(key: str, value, unit: str, kind: str, allowed: str) -> float:
    """SI units of a unit, which must have the kind's dimension; only an angle may have units without one in it."""
    parsed, wanted = _parsed(key, value, unit, allowed), _registry().parse_units(KINDS[kind][1])
    angles = [name for name in dict(parsed._units) if _is_angle(name)]
    wrong = list(dict(parsed._units).values()) != [1] or angles == []
    if kind != "angle":
        wrong = bool(angles) and not kind.startswith("torsional")
    if wrong or parsed.dimensionality != wanted.dimensionality:
        raise refused(key, value, allowed)
    zero, one = (_registry().Quantity(size, parsed).to(wanted).magnitude for size in (0.0, 1.0))
    if zero != 0.0:
        # On the scales of thermometers 0 means something else.
        raise refused(key, value, allowed)
    return float(one)
