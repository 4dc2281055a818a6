"""A straight bevel gear pair in SI units, and its dimensionless model (docs/physics.md, sections 1 and 2)."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from solver.gear.pitch_cones import PitchCones
from solver.model.checks import ParameterError, finite_number, finite_numbers
from solver.model.gear_model import GEOMETRIC, Harmonics, Model, harmonic_pairs

__all__ = ["GearPair"]


@dataclass(frozen=True)
class GearPair:
    """One gear pair in SI units; angles of the geometry in degrees, phases in radians. Gear 1 is the driving pinion.

    Parameters
    ----------
    teeth : (int, int)
        z_1 and z_2, > 0.
    module : float
        Outer transverse module (m), > 0.
    shaft_angle, pressure_angle : float
        Sigma within (0, 180) and alpha_n within [0, 90) (degrees).
    face_width : float
        m, > 0 and at most the cone distance.
    mass, inertia : float or (2,)
        m_g (kg) and J_g (kg m^2) of what turns with each gear, > 0.
    support_stiffness, support_damping : float or (6,)
        Of x1, y1, z1, x2, y2, z2: N/m > 0 and N s/m >= 0.
    mesh_stiffness : float
        Mean k_m (N/m), > 0.
    mesh_stiffness_harmonics : sequence of (amplitude, phase)
        (A_kl, Phi_kl) in N/m and rad, of k_m + sum_l A_kl cos(l Omega_h t + Phi_kl), which may not fall below 0.
    mesh_damping_ratio : float
        xi_h, >= 0; the mesh damping c_h follows.
    half_backlash : float
        b_h along the line of action (m), >= 0.
    error_harmonics : sequence of (amplitude, phase)
        (A_l, Phi_l) in m and rad, of e_n = sum_l A_l cos(l Omega_h t + Phi_l).
    torque : float
        Driving torque T_1 (N m).
    load_torque : float or None
        T_2 (N m); None balances T_1: T_2 = T_1 r_2/r_1.
    torque_fluctuation : float
        Amplitude (N m) of a part of the driving torque that varies as cos(Omega_h t).
    reference_length : float or None
        b_c (m), > 0; None is the half backlash, which must then not be 0.

    Raises
    ------
    ParameterError
        Naming the field, its value and what is allowed.
    """

    teeth: tuple[int, int]
    module: float
    shaft_angle: float
    pressure_angle: float
    face_width: float
    mass: tuple[float, float]
    inertia: tuple[float, float]
    support_stiffness: tuple[float, ...]
    support_damping: tuple[float, ...]
    mesh_stiffness: float
    mesh_damping_ratio: float
    half_backlash: float
    torque: float
    mesh_stiffness_harmonics: Harmonics = ()
    error_harmonics: Harmonics = ()
    load_torque: float | None = None
    torque_fluctuation: float = 0.0
    reference_length: float | None = None

    def __post_init__(self):
        anything, above, least = {}, {"above": 0.0}, {"at_least": 0.0}
        for name in ("teeth", "module", "shaft_angle", "face_width"):
            self._set(name, getattr(self.cones, name))
        for name, bounds in {
            "pressure_angle": least,
            "mesh_stiffness": above,
            "mesh_damping_ratio": least,
            "half_backlash": least,
            "torque": anything,
            "torque_fluctuation": anything,
        }.items():
            self._set(name, finite_number(name, getattr(self, name), **bounds))
        for name, count, bounds in (
            ("mass", 2, above),
            ("inertia", 2, above),
            ("support_stiffness", 6, above),
            ("support_damping", 6, least),
        ):
            self._set(name, finite_numbers(name, getattr(self, name), count, **bounds))
        for name in ("mesh_stiffness_harmonics", "error_harmonics"):
            self._set(name, harmonic_pairs(name, getattr(self, name)))
        for name, bounds in (("load_torque", anything), ("reference_length", above)):
            if getattr(self, name) is not None:
                self._set(name, finite_number(name, getattr(self, name), **bounds))
        if self.pressure_angle >= 90.0:
            raise ParameterError("pressure_angle", self.pressure_angle, "an angle in degrees, at least 0 and below 90")
        self._check_loads()
        lowest = self.model().lowest_stiffness() * self.mesh_stiffness
        if lowest < 0.0:
            raise ParameterError(
                "mesh_stiffness_harmonics",
                self.mesh_stiffness_harmonics,
                f"small enough that the mesh stiffness stays at least 0 all cycle: it falls to {lowest:.4g} N/m",
            )

    def _check_loads(self):
        if self.reference_length is None and self.half_backlash == 0.0:
            raise ParameterError("reference_length", None, "a number above 0 where half_backlash is 0")
        if self.load_torque is not None and self.torque == 0.0:
            raise ParameterError("torque", self.torque, "other than 0 where load_torque is given")

    def _set(self, name, value):
        object.__setattr__(self, name, value)

    @cached_property
    def cones(self) -> PitchCones:
        """The pitch cones."""
        return PitchCones(self.teeth, self.module, self.shaft_angle, self.face_width)

    @property
    def ratio(self) -> float:
        """u = z_2/z_1."""
        return self.cones.ratio

    @property
    def cone_angles(self) -> tuple[float, float]:
        """Pitch cone angles (degrees)."""
        return self.cones.cone_angles

    @property
    def cone_distance(self) -> float:
        """Outer cone distance (m)."""
        return self.cones.cone_distance

    @property
    def mean_radii(self) -> np.ndarray:
        """r_g at mid face (m), (2,)."""
        return self.cones.mean_radii

    @property
    def tangential(self) -> float:
        """a_3 = cos alpha_n, the tangential component of the contact normal."""
        return math.cos(math.radians(self.pressure_angle))

    @property
    def equivalent_mass(self) -> float:
        """m_e = J_1 J_2/(r_1^2 J_2 + r_2^2 J_1) (kg)."""
        return float(1.0 / np.sum(self.mean_radii**2 / self.inertia))

    @property
    def frequency_unit(self) -> float:
        """Omega_n = sqrt(k_m/m_e) (rad/s)."""
        return math.sqrt(self.mesh_stiffness / self.equivalent_mass)

    @property
    def length_unit(self) -> float:
        """b_c (m)."""
        return self.half_backlash if self.reference_length is None else self.reference_length

    @property
    def mesh_damping(self) -> float:
        """c_h = 2 xi_h m_e Omega_n (N s/m)."""
        return 2.0 * self.mesh_damping_ratio * self.equivalent_mass * self.frequency_unit

    @property
    def torques(self) -> tuple[float, float]:
        """T_1 and T_2 (N m)."""
        first, second = self.mean_radii
        return self.torque, float(self.torque * second / first) if self.load_torque is None else self.load_torque

    def load(self, drive: float, load: float) -> float:
        """a_3 m_e (r_1 T_1/J_1 + r_2 T_2/J_2)/(k_m b_c), the dimensionless load of two torques (N m).

        Raises
        ------
        ParameterError
            If a torque is no finite number.
        """
        drive, load = finite_number("drive", drive), finite_number("load", load)
        shares = self.mean_radii * (drive, load) / self.inertia
        return float(self.tangential * self.equivalent_mass * shares.sum() / (self.mesh_stiffness * self.length_unit))

    def model(self) -> Model:
        """The model, geometric and with one mesh force, so that xi_hg = xi_h kappa_g, d.d = 1, c = a_3^2."""
        unit, mass = self.frequency_unit, np.repeat(self.mass, 3)
        kappa = self.equivalent_mass / np.array(self.mass)
        (alpha, alpha_phase), *alphas = _scaled(self.mesh_stiffness_harmonics, self.mesh_stiffness)
        (f_e, f_e_phase), *errors = _scaled(self.error_harmonics, self.length_unit)
        return Model(
            b=self.half_backlash / self.length_unit,
            alpha=alpha,
            alpha_phase=alpha_phase,
            alpha_harmonics=alphas,
            f_e=f_e,
            f_e_phase=f_e_phase,
            f_e_harmonics=errors,
            f_pm=self.load(*self.torques),
            f_pv=self.load(self.torque_fluctuation, 0.0),
            kappa=kappa,
            xi_mesh=self.mesh_damping_ratio,
            xi_translation=self.mesh_damping_ratio * kappa,
            xi_support=self.support_damping / (2.0 * mass * unit),
            k_support=self.support_stiffness / (mass * unit**2),
            pitch_cone_angle=self.cone_angles[0],
            pressure_angle=self.pressure_angle,
            translation_coupling=GEOMETRIC,
            rotation_coupling=GEOMETRIC,
            variation_translation=1.0,
            variation_rotation=1.0,
        )


def _scaled(harmonics: Harmonics, unit: float) -> list[tuple[float, float]]:
    """Amplitudes over their unit; one of amplitude 0 where there is none."""
    return [(amplitude / unit, phase) for amplitude, phase in harmonics] or [(0.0, 0.0)]
