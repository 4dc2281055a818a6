"""How the change of a parameter is typed: the keys of the configuration that give it, whatever system they describe.

A dimensionless pair and its like have a key for every parameter. In a pair with units one torque, one length or one
stiffness gives it, and factors on parts of a system are factors on what was given. What comes out is compared with the
plane that was meant: a parameter that no key gives by itself is refused.
"""

import dataclasses
from collections.abc import Iterable, Mapping

import numpy as np

from pipeline.config.gear_schema import Gear
from pipeline.errors import ConfigurationError
from pipeline.plan.kinds import kind_of
from pipeline.plan.numerics import model_at
from pipeline.plan.plan import Plan
from pipeline.plan.scales import scales_of

__all__ = ["check_same", "typed_changes"]

#: Unit -> SI units of it.
_UNITS = {"um": 1e-6, "N/um": 1e6, "N*m": 1.0, "rad": 1.0}
#: Parameters that are one value with a unit, of a pair with units: key and unit.
_ONE = {"b": ("half_backlash", "um"), "f_pm": ("torque", "N*m"), "f_pv": ("torque_fluctuation", "N*m")}
#: Those of a first harmonic: its key, its part, and the units of both parts.
_FIRST = {
    "alpha": ("mesh_stiffness_harmonics", 0, ("N/um", "rad")),
    "alpha_phase": ("mesh_stiffness_harmonics", 1, ("N/um", "rad")),
    "f_e": ("error_harmonics", 0, ("um", "rad")),
    "f_e_phase": ("error_harmonics", 1, ("um", "rad")),
}
#: Those that what was given is multiplied for, by section.
_FACTORS = {
    "physical": {"k_support": ("support_stiffness",), "xi_support": ("support_damping",)},
    "rotor": {
        "mean_load": ("torque",),
        "damping": ("mesh_damping_ratio", "support_damping", "shaft_damping"),
        "stiffness": ("support_stiffness", "shaft_stiffness"),
    },
    "system": {"damping": ("damping",), "stiffness": ("stiffness",)},
}
_SAME = 1e-9


def typed_changes(config: Gear, plan: Plan, changed: Plan) -> dict[str, str]:
    """Keys and values that make one plane of another.

    Parameters
    ----------
    config : Gear
        Of the plane.
    plan, changed : Plan
        The plane, and the one that is meant, with other numbers of the gear or another omega.

    Returns
    -------
    dict of str to str
        Key -> value as it is typed.
    """
    found: dict[str, object] = {}
    if changed.omega != plan.omega:
        found["plane.omega"] = changed.omega
    for name, value in changed.gear.items():
        if plan.gear.get(name) != value:
            found |= _keys(config, plan, name, value, found)
    return {key: _text(value) for key, value in found.items()}


def _keys(config: Gear, plan: Plan, name: str, value: float, found: Mapping) -> dict[str, object]:
    section = "physical" if config.physical is not None else plan.kind
    given, prefix = getattr(config, section, None), f"gear.{section}."

    def scaled(key: str):
        """What was given for a key, as many times as the parameter is what it was; factors on parts were 1."""
        return _times(getattr(given, key), value / (float(np.ravel(plan.gear.get(name, 1.0))[0]) or 1.0))

    if name in (keys := _FACTORS.get(section, {})):
        return {prefix + key: scaled(key) for key in keys[name] if getattr(given, key)}
    if section == "system" and name == "gap":
        one_sided = given.back_gap is not None and np.isinf(given.back_gap)
        return {prefix + "front_gap": value, prefix + "back_gap": given.back_gap if one_sided else None}
    if section == "system" and name == "mean_load" and isinstance(given.load, list):
        return {prefix + "load": [scaled("load")[0], *given.load[1:]]}
    if section != "physical":
        key = kind_of(plan).key(name)
        # A rotor's gap is its unit of length.
        return {key: value} if given is None or hasattr(given, key.rpartition(".")[2]) else {}
    scales = scales_of(plan)
    if name in _ONE:
        key, unit = _ONE[name]
        keys = {prefix + key: _measured(value * scales[name].size, unit)}
        if name == "b" and given.reference_length is None:
            # Otherwise the half backlash is the unit of all lengths.
            keys[prefix + "reference_length"] = _measured(scales[name].size, unit)
        return keys
    if name in _FIRST:
        key, part, units = _FIRST[name]
        first, *others = found.get(prefix + key) or getattr(given, key) or [[_measured(0.0, unit) for unit in units]]
        size = scales[name].size if name in scales else 1.0
        first = [*first[:part], _measured(value * size, units[part]), *first[part + 1 :]]
        return {prefix + key: [first, *others]}
    return {}


def check_same(made: Plan, meant: Plan, names: Iterable[str]) -> None:
    """Raise ConfigurationError unless two planes are of the same systems."""
    ends = (meant.sweep.low, meant.parameter.low), (meant.sweep.high, meant.parameter.high)
    pairs = [(_parts(model_at(made, p, x)), _parts(model_at(meant, p, x))) for x, p in ends]
    pairs.append((_ends(made), _ends(meant)))
    if not all(len(made) == len(meant) and all(map(_same, made, meant)) for made, meant in pairs):
        raise ConfigurationError(
            f"{', '.join(names)}: no key of this configuration gives that by itself, as it follows from several "
            "values; curves and motions are of the changed gear, but no command makes its plane"
        )


def _ends(plan: Plan) -> list:
    axes = (plan.sweep, plan.parameter)
    return [plan.omega or 0.0, *(end for axis in axes for end in (axis.low, axis.high, axis.num))]


def _parts(system) -> list:
    return [getattr(system, field.name) for field in dataclasses.fields(system)]


def _same(one, other) -> bool:
    """Whether two parts of systems, words, numbers or arrays, are the same but for rounding."""
    if isinstance(one, str) or isinstance(other, str) or one is None or other is None:
        return one == other
    one, other = np.asarray(one), np.asarray(other)
    return one.shape == other.shape and np.allclose(one, other, rtol=_SAME, atol=_SAME)


def _measured(value: float, unit: str) -> str:
    """A value in SI units as a text with a unit."""
    return f"{value / _UNITS[unit]:.12g} {unit}"


def _times(value, factor: float):
    """A number, a text with a unit, or a list of such, so many times."""
    if isinstance(value, list | tuple):
        return [_times(one, factor) for one in value]
    if isinstance(value, str):
        number, _, unit = value.partition(" ")
        return f"{float(number) * factor:.12g} {unit}".strip()
    return float(f"{value * factor:.12g}")


def _text(value) -> str:
    """A value as Hydra reads it."""
    if isinstance(value, list | tuple):
        return f"[{','.join(map(_text, value))}]"
    if value is None:
        return "null"
    return f"'{value}'" if isinstance(value, str) else repr(value)
