"""From the key gear.thermal to laws of temperature: units here, laws and names in `solver.gear.thermal_laws`."""

import math
from dataclasses import asdict

from pipeline.config.units import celsius, quantity
from pipeline.errors import ConfigurationError, refused
from solver import GearPair, ParameterError
from solver.gear.thermal import ThermalPair
from solver.gear.thermal_laws import LAWS, law_of

__all__ = ["thermal_numbers", "thermal_pair"]

_TEMPERATURE, _NUMBER = "temperature", "number"
_DIFFERENCE, _COEFFICIENT = "temperature difference", "thermal coefficient"
#: Law -> keys that it reads, and what kind of number each is. Of a list that is every entry.
_READS = {
    "expansion": {"gears": _COEFFICIENT, "housing": _COEFFICIENT, "distances": "length", "valid": _TEMPERATURE},
    "linear": {"slope": _COEFFICIENT, "valid": _TEMPERATURE},
    "vogel": {"constant": _DIFFERENCE, "offset": _DIFFERENCE, "exponent": _NUMBER, "valid": _TEMPERATURE},
    "none": {},
}


def thermal_numbers(thermal, pair: GearPair) -> dict:
    """The laws of a gear in SI units and degrees Celsius, as plain data that a store can keep.

    Parameters
    ----------
    thermal : pipeline.config.gear_schema.Thermal
    pair : GearPair

    Returns
    -------
    dict

    Raises
    ------
    ConfigurationError
        Naming the key, its value and what is allowed.
    """
    key = "gear.thermal"
    numbers = {
        "length": pair.length_unit,
        "reference": celsius(f"{key}.reference", thermal.reference),
        "housing_share": thermal.housing_share,
        **{role: _law(f"{key}.{role}", role, asdict(getattr(thermal, role)), pair) for role in LAWS},
    }
    try:
        thermal_pair(numbers)
    except ParameterError as error:
        raise ConfigurationError(f"{key}.{error}") from None
    return numbers


def _law(key: str, role: str, given: dict, pair: GearPair) -> dict:
    law = given["law"]
    if law not in LAWS[role]:
        raise refused(f"{key}.law", law, f"one of {', '.join(LAWS[role])}")
    if law == "table":
        kinds = (_DIFFERENCE, "length") if role == "backlash" else (_TEMPERATURE, _NUMBER)
        return {"law": law, "table": _table(f"{key}.table", given["table"], kinds)}
    reads, geometry = dict(_READS[law]), {}
    if law == "expansion":
        geometry = {"cone_angles": list(pair.cone_angles), "pressure_angle": pair.pressure_angle}
        if given["distances"] is None:
            middle = pair.cone_distance - 0.5 * pair.face_width
            del reads["distances"]
            geometry["distances"] = [middle * math.cos(math.radians(angle)) for angle in pair.cone_angles]
    read = {name: _measured(f"{key}.{name}", given[name], kind) for name, kind in reads.items()}
    return {"law": law, **read, **geometry}


def _measured(key: str, value, kind: str):
    if isinstance(value, list):
        return [_measured(f"{key}[{i}]", entry, kind) for i, entry in enumerate(value)]
    if kind == _TEMPERATURE:
        return celsius(key, value)
    if kind != _NUMBER:
        return quantity(key, value, kind)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise refused(key, value, "a number")
    return float(value)


def _table(key: str, rows, kinds: tuple[str, str]) -> list[list[float]]:
    if not isinstance(rows, list) or not all(isinstance(row, list) and len(row) == 2 for row in rows):
        raise refused(key, rows, "a list of [temperature, value] pairs")
    return [[_measured(f"{key}[{i}][{j}]", row[j], kinds[j]) for j in range(2)] for i, row in enumerate(rows)]


def thermal_pair(numbers: dict) -> ThermalPair:
    """The laws that `thermal_numbers` describes; raises ParameterError as they do."""
    laws = {role: law_of(role, **numbers[role]) for role in LAWS}
    return ThermalPair(numbers["length"], numbers["reference"], numbers["housing_share"], **laws)
