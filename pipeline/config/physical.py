"""A gear in physical units: from its configuration to SI numbers; and values with units as dimensionless numbers."""

import math
import sys
from dataclasses import asdict, fields

from pipeline.config.gear_schema import PhysicalGear
from pipeline.config.mesh_cycle import read_mesh_cycle
from pipeline.config.teeth import METHODS, DrawnMesh, drawn_mesh
from pipeline.config.units import quantities, quantity, speed
from pipeline.errors import ConfigurationError, refused
from solver import Blank, GearPair, ParameterError, PitchCones, Scales

__all__ = ["AXIS_KEYS", "MESH_DAMPING", "PATHS", "TEMPERATURE", "describe", "place_of", "value_of"]

_PREFIX = "gear.physical."
#: Row parameters that move several numbers of the gear.
TEMPERATURE, MESH_DAMPING = "temperature", "mesh_damping"
PATHS = (TEMPERATURE, MESH_DAMPING)
#: Axis of a plane -> the key whose value it replaces.
AXIS_KEYS = {
    "mesh_damping": "mesh_damping_ratio",
    "f_pm": "torque",
    "f_pv": "torque_fluctuation",
    "k_support": "support_stiffness",
    "xi_support": "support_damping",
}
_BLANK = ("large_diameter", "small_diameter", "width", "bore")
#: Kind of the physical value of a parameter that may be an axis.
_KINDS = {
    "b": "length",
    "f_e": "length",
    "alpha": "stiffness",
    "f_pm": "torque",
    "f_pv": "torque",
    "xi_mesh": "damping",
    "mesh_damping": "damping",
    "xi_support": "damping",
    "k_support": "stiffness",
    "gap": "length",
    "mean_load": "torque",
    "contact_damping": "damping",
}


def value_of(
    key: str, name: str, value, scales: Scales | None, allowed: str = "a finite number, or a text with a unit"
) -> float:
    """A value of parameter `name` as the user wrote it, a number or a text with a unit, as a dimensionless number.

    Raises
    ------
    ConfigurationError
        One line that names the key, its value and what is allowed.
    """
    if isinstance(value, str):
        return place_of(key, name, value, scales)
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= sys.float_info.max:
        raise refused(key, value, allowed)
    return float(value)


def describe(config: PhysicalGear) -> dict:
    """What a plan keeps of a gear in physical units, as plain data.

    Returns
    -------
    dict
        `gear`, the fields of `solver.GearPair`; `mesh_cycle`, what was fitted to a mesh cycle, or None; and `teeth`, a
        `DrawnMesh` as plain data, only where the mesh stiffness comes from the teeth.

    Raises
    ------
    ConfigurationError
        One line that names the key.
    """
    values, cycle, drawn = _values(config), None, None
    try:
        cones = PitchCones(**{field.name: values[field.name] for field in fields(PitchCones)})
        if config.mesh_cycle is not None:
            cycle = read_mesh_cycle(config.mesh_cycle, config.mesh_cycle_harmonics, cones, config.mesh_cycle_length)
            values |= _of_cycle(config, cycle)
        if config.mesh_stiffness in METHODS:
            bores = None if config.blanks is None else [blank.bore for blank in _blanks(config)]
            drawn = drawn_mesh(
                config.mesh_stiffness, config.tooth, cones, values["pressure_angle"], bores, config.mesh_cycle_harmonics
            )
            values |= _of_teeth(config, drawn)
        if values["mesh_stiffness"] is None:
            raise _without("mesh_stiffness")
        pair = GearPair(**values)
    except ParameterError as error:
        raise ConfigurationError(f"{_PREFIX}{error}") from None
    found = {"gear": asdict(pair), "mesh_cycle": None if cycle is None else asdict(cycle)}
    return found if drawn is None else found | {"teeth": asdict(drawn)}


def place_of(key: str, name: str, value: str, scales: Scales | None) -> float:
    """The dimensionless value of a parameter that was given with a unit, such as "500 rpm" for omega.

    Raises
    ------
    ConfigurationError
        One line: the gear is dimensionless, the parameter has no unit, or the text is not allowed.
    """
    if scales is None:
        why = "units need a gear in physical units, such as gear=miter"
        raise refused(key, value, f"a number; {why}")
    if name == TEMPERATURE:
        # In K as it is.
        return quantity(key, value, "temperature difference")
    if name == "omega":
        which, number = speed(key, value)
        if which == "omega" and not isinstance(scales, Scales):
            raise refused(key, value, "a mesh frequency, such as '1.2 kHz', since the gear has no numbers of teeth")
        return scales.dimensionless(which, number)
    if name not in _KINDS:
        raise refused(key, value, f"a number, {name} has no unit")
    return scales.dimensionless(name, quantity(key, value, _KINDS[name]))


def _without(name: str) -> ConfigurationError:
    return ConfigurationError(f"{_PREFIX}{name} has no value")


def _values(config: PhysicalGear) -> dict:
    """Keyword arguments of GearPair, without what a mesh cycle gives."""
    return {
        "teeth": _given(config, "teeth"),
        "module": _module(config),
        **{name: _angle(config, name) for name in ("shaft_angle", "pressure_angle")},
        "face_width": _one(config, "face_width", "length"),
        "mass": _of_gears(config, "mass"),
        "inertia": _of_gears(config, "inertia"),
        "support_stiffness": _several(config, "support_stiffness", "stiffness", 6),
        "support_damping": _several(config, "support_damping", "damping", 6),
        "mesh_stiffness": _mesh_stiffness(config),
        "mesh_stiffness_harmonics": _harmonics(config, "mesh_stiffness_harmonics", "stiffness"),
        "mesh_damping_ratio": _given(config, "mesh_damping_ratio"),
        "half_backlash": _one(config, "half_backlash", "length"),
        "error_harmonics": _harmonics(config, "error_harmonics", "length"),
        "torque": _one(config, "torque", "torque"),
        "load_torque": _optional(config, "load_torque", "torque"),
        "torque_fluctuation": _one(config, "torque_fluctuation", "torque"),
        "reference_length": _optional(config, "reference_length", "length"),
    }


def _given(config, name: str):
    value = getattr(config, name)
    if value is None:
        raise _without(name)
    return value


def _one(config, name: str, kind: str) -> float:
    return quantity(f"{_PREFIX}{name}", _given(config, name), kind)


def _several(config, name: str, kind: str, count: int) -> list[float]:
    return quantities(f"{_PREFIX}{name}", _given(config, name), kind, count)


def _optional(config, name: str, kind: str) -> float | None:
    return None if getattr(config, name) is None else _one(config, name, kind)


def _mesh_stiffness(config) -> float | None:
    """None where a mesh cycle or the teeth give it."""
    value = config.mesh_stiffness
    if value in METHODS:
        return None
    if isinstance(value, str) and value.isidentifier():
        raise refused(
            f"{_PREFIX}mesh_stiffness",
            value,
            f"a number with a unit of stiffness, such as '300 N/um', or one of {', '.join(METHODS)}",
        )
    return _optional(config, "mesh_stiffness", "stiffness")


def _angle(config, name: str) -> float:
    """In degrees, an angle of whole degrees exactly."""
    return round(math.degrees(_one(config, name, "angle")), 12)


def _module(config) -> float:
    if (config.module is None) == (config.diametral_pitch is None):
        both = "one of them, not both" if config.module is not None else "given, or gear.physical.diametral_pitch"
        raise refused(f"{_PREFIX}module", config.module, both)
    if config.module is not None:
        return _one(config, "module", "length")
    pitch = _one(config, "diametral_pitch", "diametral pitch")
    if pitch <= 0.0:
        raise refused(f"{_PREFIX}diametral_pitch", config.diametral_pitch, "above 0")
    return 1.0 / pitch


def _of_gears(config, name: str) -> list[float]:
    """Mass or inertia of both gears, as given or of their blanks."""
    if config.blanks is not None and config.mass is not None and config.inertia is not None:
        raise ConfigurationError(
            f"{_PREFIX}blanks is not allowed: mass and inertia are given, of which at least one must then be null"
        )
    if getattr(config, name) is not None:
        return _several(config, name, name, 2)
    if config.blanks is None:
        raise ConfigurationError(f"{_PREFIX}{name} has no value: give it, or {_PREFIX}blanks")
    return [getattr(blank, name) for blank in _blanks(config)]


def _blanks(config) -> list[Blank]:
    key, blanks = f"{_PREFIX}blanks", config.blanks
    if not isinstance(blanks, list) or len(blanks) != 2 or not all(isinstance(blank, dict) for blank in blanks):
        raise refused(key, blanks, f"a list of two, each with {', '.join(_BLANK)}")
    density, result = _one(config, "density", "density"), []
    for i, blank in enumerate(blanks):
        for name in [*(set(blank) ^ set(_BLANK))]:
            what = "is not a key of a blank, which has" if name in blank else "has no value; a blank has"
            raise ConfigurationError(f"{key}[{i}].{name} {what} {', '.join(_BLANK)}")
        sizes = {name: quantity(f"{key}[{i}].{name}", blank[name], "length") for name in _BLANK}
        try:
            result.append(Blank(**sizes, density=density))
        except ParameterError as error:
            where = _PREFIX if error.name == "density" else f"{key}[{i}]."
            raise ConfigurationError(f"{where}{error}") from None
    return result


def _harmonics(config, name: str, kind: str) -> list[tuple[float, float]]:
    key, pairs = f"{_PREFIX}{name}", _given(config, name)
    if not isinstance(pairs, list) or not all(isinstance(pair, list) and len(pair) == 2 for pair in pairs):
        raise refused(key, pairs, "a list of [amplitude, phase], each a number with its unit")
    return [
        (quantity(f"{key}[{i}][0]", amplitude, kind), quantity(f"{key}[{i}][1]", phase, "angle"))
        for i, (amplitude, phase) in enumerate(pairs)
    ]


def _of_cycle(config, cycle) -> dict:
    """What a mesh cycle gives; it may not be given as well."""
    found = {}
    if cycle.stiffness is not None:
        found = {"mesh_stiffness": cycle.stiffness.mean, "mesh_stiffness_harmonics": cycle.stiffness.harmonics}
    if cycle.error is not None:
        found["error_harmonics"] = cycle.error.harmonics
    _alone(config, found, "mesh_cycle")
    return found


def _of_teeth(config, drawn: DrawnMesh) -> dict:
    """What the teeth give; harmonics may not be given as well, unless the method has none."""
    if drawn.harmonics is None:
        return {"mesh_stiffness": drawn.stiffness}
    _alone(config, ("mesh_stiffness_harmonics",), f"mesh_stiffness {drawn.method}")
    return {"mesh_stiffness": drawn.stiffness, "mesh_stiffness_harmonics": drawn.harmonics}


def _alone(config, names, giver: str) -> None:
    for name in names:
        if getattr(config, name) not in (None, []):
            raise refused(f"{_PREFIX}{name}", getattr(config, name), f"null or [], the {giver} gives it")
