"""A geared rotor: from its section of the configuration, with or without units, to dimensionless numbers."""

import math

from pipeline.config.gear_schema import Rotor
from pipeline.config.harmonics import pairs_of
from pipeline.config.units import quantity
from pipeline.errors import ConfigurationError, refused
from solver import ParameterError
from solver.gear.geared_rotor import equivalent_mass

__all__ = ["rotor_numbers"]

#: Keys of a rotor that may have a unit, and of what kind; a number is in any consistent units.
_KINDS = {
    "inertia": "inertia",
    "base_radius": "length",
    "mesh_stiffness": "stiffness",
    "half_backlash": "length",
    "torque": "torque",
    "mass": "mass",
    "support_stiffness": "stiffness",
    "support_damping": "damping",
    "far_inertia": "inertia",
    "shaft_stiffness": "torsional stiffness",
    "shaft_damping": "torsional damping",
}
_OF_ONE = ("mesh_stiffness", "half_backlash", "torque")
_OPTIONAL = ("mass", "support_stiffness", "support_damping", "far_inertia", "shaft_stiffness", "shaft_damping")


def rotor_numbers(config: Rotor) -> tuple[dict, dict | None]:
    """Numbers of a rotor in units of the mean mesh stiffness, the half backlash and the natural frequency that the pair
    has on rigid supports; and what these are in SI units, where the numbers were given with units.

    Raises
    ------
    ConfigurationError
        Naming the key, its value and what is allowed.
    """
    given, sizes = {}, {}
    for name, kind in _KINDS.items():
        value = getattr(config, name)
        if value is None and name not in _OPTIONAL:
            raise ConfigurationError(f"gear.rotor.{name} has no value")
        given[name] = None if value is None else _measured(name, value, kind, sizes)
    _of_one_system(sizes)
    harmonics = {
        "alpha_harmonics": pairs_of("gear.rotor.alpha_harmonics", config.alpha_harmonics),
        **{
            name: [[_measured(name, a, kind, sizes)[0], phase] for a, phase in _raw_pairs(config, name)]
            for name, kind in (("error_harmonics", "length"), ("torque_harmonics", "torque"))
        },
    }
    _of_one_system(sizes)
    stiffness, gap, torque = (given[name][0] for name in _OF_ONE)
    for name, value in (("mesh_stiffness", stiffness), ("half_backlash", gap)):
        if not value > 0.0:
            raise refused(f"gear.rotor.{name}", getattr(config, name), "above 0")
    try:
        me = equivalent_mass(given["inertia"], given["base_radius"])
    except ParameterError as error:
        raise ConfigurationError(f"gear.rotor.{error}") from None
    radius, frequency = given["base_radius"], math.sqrt(stiffness / me)
    # What 1 of each kind is, base radii being 1.
    unit = {"mass": me, "stiffness": stiffness, "damping": me * frequency, "torque": stiffness * gap}
    squares = [r * r for r in radius]
    numbers = {
        "gap": 1.0,
        "mean_load": torque / radius[0] / unit["torque"],
        "back_stiffness": config.back_stiffness,
        "contact_dashpot": config.contact_dashpot,
        "alpha": config.alpha,
        "alpha_phase": config.alpha_phase,
        "excitation": config.excitation,
        "contact_damping": 2.0 * config.mesh_damping_ratio,
        "inertia": [i / s / me for i, s in zip(given["inertia"], squares, strict=True)],
        **{name: _over(given[name], unit[kind]) for name, kind in list(_KINDS.items())[5:8]},
        "far_inertia": _over(given["far_inertia"], me, squares),
        "shaft_stiffness": _over(given["shaft_stiffness"], stiffness, squares),
        "shaft_damping": _over(given["shaft_damping"], unit["damping"], squares),
        "alpha_harmonics": harmonics["alpha_harmonics"],
        "error_harmonics": [[a / gap, phase] for a, phase in harmonics["error_harmonics"]],
        "torque_harmonics": [[a / radius[0] / unit["torque"], p] for a, p in harmonics["torque_harmonics"]],
    }
    if not all(sizes.values()):
        return numbers, None
    return numbers, {"frequency": frequency, "length": gap, "stiffness": stiffness, "radius": radius[0]}


def _over(values: list[float] | None, size: float, squares: list[float] = (1.0, 1.0)) -> list[float] | None:
    return None if values is None else [value / square / size for value, square in zip(values, squares, strict=True)]


def _measured(name: str, value, kind: str, sizes: dict[str, bool]) -> list[float]:
    """A number or a text with a unit, or two of them, as numbers; notes in `sizes` whether there was a unit."""
    one = name in _OF_ONE or name.endswith("harmonics")
    values = value if isinstance(value, list) and not one else [value] * (1 if one else 2)
    if len(values) != (1 if one else 2):
        raise refused(f"gear.rotor.{name}", value, "one value or a list of 2")
    found = []
    for i, entry in enumerate(values):
        key = f"gear.rotor.{name}" + (f"[{i}]" if isinstance(value, list) else "")
        sizes[key] = isinstance(entry, str)
        if isinstance(entry, str):
            found.append(quantity(key, entry, kind))
        elif isinstance(entry, bool) or not isinstance(entry, int | float) or not math.isfinite(entry):
            raise refused(key, entry, "a finite number, or a text with a unit")
        else:
            found.append(float(entry))
    return found


def _of_one_system(sizes: dict[str, bool]) -> None:
    """Refuse units on some numbers and none on others."""
    if any(sizes.values()) and not all(sizes.values()):
        bare, full = (next(key for key, unit in sizes.items() if unit is kind) for kind in (False, True))
        raise ConfigurationError(f"{bare} is not allowed: it must have a unit, because {full} has one")


def _raw_pairs(config: Rotor, name: str) -> list:
    value = getattr(config, name)
    if not isinstance(value, list) or not all(isinstance(pair, list) and len(pair) == 2 for pair in value):
        raise refused(f"gear.rotor.{name}", value, "a list of [amplitude, phase in rad]")
    return [(pair[0], pairs_of(f"gear.rotor.{name}", [[0.0, pair[1]]])[0][1]) for pair in value]
