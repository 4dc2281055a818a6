"""Types of the keys of `gear`: a bevel pair in either units, and other systems; values live in conf/gear/."""

from dataclasses import dataclass
from typing import Any

from omegaconf import MISSING

from pipeline.config.allowed import allowed

__all__ = ["Gear", "PhysicalGear", "Rotor", "Spur", "System"]


@dataclass
class Variation:
    """How much of the stiffness variation enters the translation rows and the mesh row."""

    translation: float = MISSING
    rotation: float = MISSING


@dataclass
class ThermalBacklash:
    """Law of the backlash over temperature; keys of other laws than `law` are not read."""

    law: str = MISSING
    gears: Any = MISSING
    housing: Any = MISSING
    distances: Any = MISSING
    valid: Any = MISSING
    table: Any = MISSING


@dataclass
class ThermalStiffness:
    """Law of the mesh stiffness over temperature."""

    law: str = MISSING
    slope: Any = MISSING
    valid: Any = MISSING
    table: Any = MISSING


@dataclass
class ThermalDamping:
    """Law of the mesh damping over temperature."""

    law: str = MISSING
    constant: Any = MISSING
    offset: Any = MISSING
    exponent: Any = MISSING
    valid: Any = MISSING
    table: Any = MISSING


@dataclass
class Thermal:
    """What temperature does to a gear in physical units; see `solver.gear.thermal`. Quantities have units."""

    reference: Any = MISSING
    housing_share: float = MISSING
    backlash: ThermalBacklash = MISSING
    stiffness: ThermalStiffness = MISSING
    damping: ThermalDamping = MISSING


@dataclass
class Teeth:
    """Teeth and bodies of both gears for `mesh_stiffness`; see `solver.GearTeeth`. One value, or one per gear."""

    bore: Any = MISSING
    profile_shift: Any = MISSING
    addendum: Any = MISSING
    dedendum: Any = MISSING
    edge_radius: Any = MISSING
    youngs_modulus: Any = MISSING
    poisson: Any = MISSING


@dataclass
class PhysicalGear:
    """Gear pair in physical units; see `solver.GearPair`. Texts are numbers with units, some keys take lists."""

    teeth: Any = MISSING
    module: Any = MISSING
    diametral_pitch: Any = MISSING
    shaft_angle: Any = MISSING
    pressure_angle: Any = MISSING
    face_width: Any = MISSING
    blanks: Any = MISSING
    density: Any = MISSING
    mass: Any = MISSING
    inertia: Any = MISSING
    support_stiffness: Any = MISSING
    support_damping: Any = MISSING
    mesh_stiffness: Any = MISSING
    mesh_stiffness_harmonics: Any = MISSING
    tooth: Teeth = MISSING
    mesh_damping_ratio: float | None = MISSING
    mesh_cycle: str | None = MISSING
    mesh_cycle_harmonics: int = MISSING
    mesh_cycle_length: Any = MISSING
    half_backlash: Any = MISSING
    error_harmonics: Any = MISSING
    torque: Any = MISSING
    load_torque: Any = MISSING
    torque_fluctuation: Any = MISSING
    reference_length: Any = MISSING


@dataclass
class Spur:
    """Spur pair of one degree of freedom; see `solver.spur_pair`. Harmonics are lists of [amplitude, phase in rad]."""

    damping_ratio: float = allowed(0.0)
    gap: float = allowed(0.0)
    back_stiffness: float = allowed(0.0, above=True)
    contact_dashpot: float = allowed(0.0)
    mean_load: float = MISSING
    alpha: float = MISSING
    alpha_phase: float = MISSING
    alpha_harmonics: Any = MISSING
    excitation: float = MISSING
    error_harmonics: Any = MISSING
    load_harmonics: Any = MISSING


@dataclass
class Rotor:
    """Geared rotor; see `solver.geared_rotor`. Numbers in any consistent units, or texts with units; one, or two."""

    inertia: Any = MISSING
    base_radius: Any = MISSING
    mesh_stiffness: Any = MISSING
    mesh_damping_ratio: float = allowed(0.0)
    half_backlash: Any = MISSING
    back_stiffness: float = allowed(0.0, above=True)
    contact_dashpot: float = allowed(0.0)
    torque: Any = MISSING
    mass: Any = MISSING
    support_stiffness: Any = MISSING
    support_damping: Any = MISSING
    far_inertia: Any = MISSING
    shaft_stiffness: Any = MISSING
    shaft_damping: Any = MISSING
    alpha: float = MISSING
    alpha_phase: float = MISSING
    alpha_harmonics: Any = MISSING
    excitation: float = MISSING
    error_harmonics: Any = MISSING
    torque_harmonics: Any = MISSING


@dataclass
class System:
    """System of one's own with one contact; see `solver.ContactSystem`. Arrays are lists, or files of them."""

    file: str | None = MISSING
    mass: Any = MISSING
    damping: Any = MISSING
    stiffness: Any = MISSING
    contact: Any = MISSING
    force: Any = MISSING
    varying_force: Any = MISSING
    load: Any = MISSING
    inertial_load: Any = MISSING
    front_gap: float | None = MISSING
    back_gap: float | None = MISSING
    back_stiffness: float = allowed(0.0, above=True)
    contact_dashpot: float = allowed(0.0)
    alpha: float = MISSING
    alpha_phase: float = MISSING
    alpha_harmonics: Any = MISSING
    contact_damping: float = MISSING


@dataclass
class Gear:
    """What turns: a bevel pair, dimensionless (see `solver.Model`) or in physical units, or another system.

    Keys of type Any take one number or a list. Of a gear in physical units, and of another system, the keys of the
    dimensionless bevel pair are null.
    """

    b: float | None = None
    alpha: float | None = None
    alpha_phase: float | None = None
    alpha_harmonics: Any = None
    f_e: float | None = None
    f_e_phase: float | None = None
    f_e_harmonics: Any = None
    f_pm: float | None = None
    f_pv: float | None = None
    kappa: Any = None
    xi_mesh: float | None = None
    xi_translation: Any = None
    xi_support: Any = None
    k_support: Any = None
    pitch_cone_angle: float | None = None
    pressure_angle: float | None = None
    translation_coupling: Any = None
    rotation_coupling: Any = None
    variation: Variation | None = None
    physical: PhysicalGear | None = None
    thermal: Thermal | None = None
    spur: Spur | None = None
    rotor: Rotor | None = None
    system: System | None = None
