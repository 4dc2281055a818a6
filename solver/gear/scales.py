"""From dimensionless parameters of a gear pair to physical ones and back."""

import math
from dataclasses import dataclass, fields

from solver.gear.pair import GearPair
from solver.model.checks import ParameterError, finite_number, instance_of, number_array, one_of

__all__ = ["Scale", "Scales", "SystemScales"]


@dataclass(frozen=True)
class Scale:
    """What 1 means of one dimensionless parameter.

    Parameters
    ----------
    size : float
        SI units that 1 stands for.
    name : str
        The physical quantity.
    unit : str
        In which it is shown.
    unit_size : float
        SI units of that unit.

    Raises
    ------
    ParameterError
        If a size is no finite number other than 0, or a text is none.
    """

    size: float
    name: str
    unit: str
    unit_size: float

    def __post_init__(self):
        for name in ("size", "unit_size"):
            if finite_number(name, getattr(self, name)) == 0.0:
                raise ParameterError(name, 0.0, "a finite number other than 0")
        for name in ("name", "unit"):
            instance_of(name, getattr(self, name), str)

    @property
    def shown(self) -> float:
        """Shown units that 1 stands for."""
        return self.size / self.unit_size

    def physical(self, value):
        """SI value of a dimensionless one, numbers or arrays; raises ParameterError if it is neither."""
        number_array("value", value)
        return value * self.size

    def dimensionless(self, value):
        """Dimensionless value of an SI one, numbers or arrays; raises ParameterError if it is neither."""
        number_array("value", value)
        return value / self.size


class _Scales:
    """What is done with a table of scales."""

    def __contains__(self, name: str) -> bool:
        return name in self.table

    def __getitem__(self, name: str) -> Scale:
        return self.table[name]

    def physical(self, name: str, value):
        """SI value of a dimensionless parameter; raises ParameterError where it has no unit."""
        table = self.table
        return table[one_of("name", name, tuple(table))].physical(value)

    def dimensionless(self, name: str, value):
        """Dimensionless parameter of an SI value; raises ParameterError where it has no unit."""
        table = self.table
        return table[one_of("name", name, tuple(table))].dimensionless(value)


@dataclass(frozen=True)
class SystemScales(_Scales):
    """The scales of a geared rotor, by the names of its axes; `omega` is shown as mesh frequency.

    Parameters
    ----------
    frequency : float
        rad/s that Omega = 1 stands for.
    length : float
        m that 1 stands for.
    stiffness : float
        Mean mesh stiffness in N/m.
    radius : float
        Base radius of the driver in m, for its torque.

    Raises
    ------
    ParameterError
        If one is no finite number above 0.
    """

    frequency: float
    length: float
    stiffness: float
    radius: float

    def __post_init__(self):
        for field in fields(self):
            finite_number(field.name, getattr(self, field.name), above=0.0)

    @property
    def table(self) -> dict[str, Scale]:
        """Name -> scale."""
        frequency = Scale(self.frequency / (2.0 * math.pi), "mesh frequency", "Hz", 1.0)
        force = self.stiffness * self.length
        return {
            "omega": frequency,
            "mesh_frequency": frequency,
            "length": Scale(self.length, "displacement", "µm", 1e-6),
            "velocity": Scale(self.length * self.frequency, "speed", "m/s", 1.0),
            "force": Scale(force, "force", "N", 1.0),
            "gap": Scale(self.length, "half backlash", "µm", 1e-6),
            "alpha": Scale(self.stiffness, "mesh stiffness amplitude", "N/µm", 1e6),
            "mean_load": Scale(force * self.radius, "driving torque", "N·m", 1.0),
            "contact_damping": Scale(self.stiffness / self.frequency, "mesh damping", "N·s/m", 1.0),
        }


@dataclass(frozen=True)
class Scales(_Scales):
    """The scale of every parameter of one gear pair that has a unit, by `solver.Model`'s names and `omega`.

    `omega` is shown as pinion speed; its SI value is in rad/s of the pinion. `mesh_frequency` is Omega as well, in Hz.
    `length`, `velocity` and `force` are of displacements, of their speeds, and of forces in units of k_m b_c. f_pm
    stands for the driving torque with the load torque in the pair's proportion to it, f_pv for the fluctuating driving
    torque. Support parameters are the pinion's, whose mass they refer to.

    Parameters
    ----------
    gear : GearPair

    Raises
    ------
    ParameterError
        If it is none.
    """

    gear: GearPair

    def __post_init__(self):
        instance_of("gear", self.gear, GearPair)

    @property
    def table(self) -> dict[str, Scale]:
        """Name -> scale."""
        gear = self.gear
        unit, length, stiffness = gear.frequency_unit, gear.length_unit, gear.mesh_stiffness
        drive, load = gear.torques if gear.torque != 0.0 else gear.mean_radii
        support = gear.mass[0] * unit
        damping = Scale(2.0 * gear.equivalent_mass * unit, "mesh damping", "N·s/m", 1.0)
        return {
            "omega": Scale(unit / gear.teeth[0], "pinion speed", "rpm", math.pi / 30.0),
            "mesh_frequency": Scale(unit / (2.0 * math.pi), "mesh frequency", "Hz", 1.0),
            "length": Scale(length, "displacement", "µm", 1e-6),
            "velocity": Scale(length * unit, "speed", "m/s", 1.0),
            "force": Scale(stiffness * length, "force", "N", 1.0),
            "b": Scale(length, "half backlash", "µm", 1e-6),
            "f_e": Scale(length, "transmission error amplitude", "µm", 1e-6),
            "alpha": Scale(stiffness, "mesh stiffness amplitude", "N/µm", 1e6),
            "f_pm": Scale(drive / gear.load(drive, load), "driving torque", "N·m", 1.0),
            "f_pv": Scale(1.0 / gear.load(1.0, 0.0), "driving torque amplitude", "N·m", 1.0),
            "xi_mesh": damping,
            "mesh_damping": damping,
            "xi_support": Scale(2.0 * support, "support damping of the pinion", "N·s/m", 1.0),
            "k_support": Scale(support * unit, "support stiffness of the pinion", "N/µm", 1e6),
        }
