"""The kinds of systems that a plane can be made of: what a configuration's gear becomes, and what may be its axes.

A plan keeps the name of its kind and plain numbers. Everything that is done with a plan asks its kind for the system,
and the system itself for what it is (`pipeline.plan.traits`): nothing else tells kinds apart.
"""

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

import numpy as np

from solver import SCALAR_PARAMETERS, ContactSystem, Model, geared_rotor, spur_pair
from solver.model.contact_system import SYSTEM_AXES

__all__ = ["APART", "BEVEL", "KINDS", "GearKind", "kind_of"]


@dataclass(frozen=True)
class GearKind:
    """One kind of system.

    Parameters
    ----------
    name : str
        As plans have it, and but for the bevel pair the section of `gear` that describes it.
    axes : mapping of str to str
        What may be an axis of a plane, omega apart: its name, and what the solver calls it.
    keys : mapping of str to str
        Axis -> the key of its section, where that has another name.
    drives : str
        What drives its motion besides the stiffness.
    lacks : tuple of str
        Quantities of motions that it does not have, of `pipeline.config.quantities.QUANTITIES`.
    built : callable
        built(numbers) -> the system; of a `ContactSystem` every number that is an axis is 1 in it, or 0 where that
        adds to something, as `ContactSystem.at` takes it.
    """

    name: str
    axes: Mapping[str, str]
    keys: Mapping[str, str]
    drives: str
    lacks: tuple[str, ...]
    built: Callable[[dict], Model | ContactSystem]

    def key(self, parameter: str) -> str:
        """What the user types for a number of the gear."""
        if self.name == BEVEL.name:
            return f"gear.{parameter.replace('variation_', 'variation.')}"
        return f"gear.{self.name}.{self.keys.get(parameter, parameter)}"

    def solver_axis(self, name: str) -> str:
        """What the solver calls an axis."""
        return self.axes.get(name, name)

    def value(self, numbers: Mapping, system: Model | ContactSystem, name: str) -> float:
        """What a parameter is that is no axis of the plane; raises ValueError where it has several values."""
        if self.name != BEVEL.name:
            return float(numbers.get(name, system.front_gap if name == "gap" else 1.0))
        values = {"translation_coupling": system.sigma, "rotation_coupling": system.rotation}
        value = values[name] if name in values else getattr(system, name)
        (value,) = set(value) if isinstance(value, tuple) else (value,)
        return float(value)

    def system(self, numbers: Mapping, values: Mapping, varied: Collection[str] = ()) -> Model | ContactSystem:
        """The system at some values of its axes.

        Parameters
        ----------
        numbers : mapping
            As a plan keeps them.
        values : mapping
            Axis -> value; of `omega`, which is no number of the system, nothing is read.
        varied : collection of str
            Axes that the solver varies from here on, so that they must not be in the system yet.

        Raises
        ------
        solver.ParameterError
            If a number or a value is not allowed.
        """
        values = {name: value for name, value in values.items() if name != "omega"}
        if self.name == BEVEL.name:
            # A gear is not built without them; the solver replaces those that it varies.
            return self.built({**numbers, **values})
        fixed = {name: value for name, value in numbers.items() if name not in self.axes}
        moved = {**{name: numbers[name] for name in self.axes if name in numbers}, **values}
        system = self.built(fixed)
        for name, axis in self.axes.items():
            if name in moved and name not in varied:
                system = system.at(axis, moved[name])
        return system


def _spur(numbers: dict) -> ContactSystem:
    others = {name: value for name, value in numbers.items() if name != "alpha_harmonics"}
    return spur_pair(1.0, 1.0, 1.0, stiffness_harmonics=[(0.0, 0.0), *numbers["alpha_harmonics"]], **others)


#: A factor on the mean load of 1 is the mean load, one on the damping of ratio 1 the damping ratio.
_OF_SPUR = {
    "gap": "gap",
    "damping_ratio": "damping",
    "mean_load": "mean_load",
    "alpha": "alpha",
    "alpha_phase": "alpha_phase",
    "excitation": "excitation",
}

_OF_ROTOR = {
    "gap": "gap",
    "mean_load": "mean_load",
    "alpha": "alpha",
    "alpha_phase": "alpha_phase",
    "excitation": "excitation",
    "contact_damping": "contact_damping",
    "damping": "damping",
    "stiffness": "stiffness",
}
_OF_ANY = {name: name for name in SYSTEM_AXES if name != "omega"}


def _rotor(numbers: dict) -> ContactSystem:
    """Of unit mesh stiffness, gap, base radii and mean load, without mesh damping."""
    others = {name: value for name, value in numbers.items() if name not in ("inertia", "alpha_harmonics")}
    harmonics = [(0.0, 0.0), *numbers["alpha_harmonics"]]
    return geared_rotor(numbers["inertia"], 1.0, 1.0, 0.0, 1.0, 1.0, stiffness_harmonics=harmonics, **others)


def _system(numbers: dict) -> ContactSystem:
    arrays = numbers["matrices"]
    loads = {name: np.array(arrays[name]) @ (1.0, 1.0j) for name in ("load", "inertial_load") if name in arrays}
    back = math.inf if numbers["back_gap"] is None else numbers["back_gap"]
    harmonics = [(0.0, 0.0), *numbers["alpha_harmonics"]]
    law = {name: numbers[name] for name in ("front_gap", "back_stiffness", "contact_dashpot") if name in numbers}
    return ContactSystem(**{**arrays, **loads}, **law, back_gap=back, stiffness_harmonics=harmonics)


#: Of a system that is no bevel pair only lambda and the contact force are read.
_NO_SUPPORTS = ("error_lowest", "error_highest", "error_rms", "error_peak_to_peak", "support_force")
BEVEL = GearKind(
    "bevel", {name: name for name in SCALAR_PARAMETERS}, {}, "transmission error", (), lambda numbers: Model(**numbers)
)
#: Axes that move the same numbers, so that a plane has one of them.
APART = (("gap", "gap_scale"), ("damping", "contact_damping"))
#: Name -> kind.
KINDS = {
    kind.name: kind
    for kind in (
        BEVEL,
        GearKind("spur", _OF_SPUR, {}, "error and load", _NO_SUPPORTS, _spur),
        GearKind(
            "rotor",
            _OF_ROTOR,
            {"mean_load": "torque", "contact_damping": "mesh_damping_ratio"},
            "error and torque",
            _NO_SUPPORTS,
            _rotor,
        ),
        GearKind("system", _OF_ANY, {}, "load", _NO_SUPPORTS, _system),
    )
}


def kind_of(plan) -> GearKind:
    """The kind of a plan's system."""
    return KINDS[plan.kind]
