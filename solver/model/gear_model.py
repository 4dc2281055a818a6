"""Dimensionless 7-degree-of-freedom model of a straight bevel gear pair (docs/physics.md, section 2).

Coordinates are the six support translations x = (x1, y1, z1, x2, y2, z2) and the mesh displacement lambda; time is
in units of 1/Omega_n, lengths in units of a fixed reference length:

    x_j'' + 2 xi_j x_j' + k_j x_j = -d_j [kappa_g k_t f(lambda) + 2 xi_hg lambda']
    lambda'' - sum_j d_j x_j'' + c [k_r f(lambda) + 2 xi_h lambda'] = f_pm + f_pv cos(Omega tau) + f_e(tau)
"""

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from solver.model.checks import (
    ParameterError,
    finite_array,
    finite_number,
    finite_numbers,
    frequency,
    list_length,
    whole_number,
)

__all__ = ["GEOMETRIC", "Harmonics", "Model", "SCALAR_PARAMETERS", "harmonic_pairs"]

GEOMETRIC = "geometric"

#: Model fields that are one number (or may be given as one for all gears and axes), so that they can be a plane's axis.
SCALAR_PARAMETERS = (
    "b",
    "alpha",
    "alpha_phase",
    "f_e",
    "f_e_phase",
    "f_pm",
    "f_pv",
    "kappa",
    "xi_mesh",
    "xi_translation",
    "xi_support",
    "k_support",
    "pitch_cone_angle",
    "pressure_angle",
    "translation_coupling",
    "rotation_coupling",
    "variation_translation",
    "variation_rotation",
)

Harmonics = tuple[tuple[float, float], ...]

_UNBOUNDED = ("alpha", "alpha_phase", "f_e", "f_e_phase", "f_pm", "f_pv", "variation_translation", "variation_rotation")


@dataclass(frozen=True)
class Model:
    """One gear pair, dimensionless. Fields carry the names that users type under ``gear.``.

    Parameters
    ----------
    b : float
        Half backlash, >= 0.
    alpha, alpha_phase : float
        Amplitude and phase (rad) of the first harmonic of the mesh stiffness, alpha_1 and Phi_k1.
    alpha_harmonics : sequence of (amplitude, phase)
        Harmonics 2, 3, ... of the mesh stiffness. The first-order balance feels the second, not the higher ones.
    f_e, f_e_phase : float
        Amplitude and phase (rad) of the first harmonic of the transmission error, A_1/b_c and Phi_1.
    f_e_harmonics : sequence of (amplitude, phase)
        Harmonics 2, 3, ... of the transmission error; the first-order balance does not feel them.
    f_pm, f_pv : float
        Mean and fluctuating load.
    kappa : float or (2,) sequence
        kappa_g = m_e/m_g, > 0.
    xi_mesh : float
        xi_h, mesh damping ratio, >= 0.
    xi_translation : float or (2,) sequence
        xi_hg, mesh damping referred to the masses, >= 0.
    xi_support, k_support : float or (6,) sequence
        Damping ratios >= 0 and stiffnesses > 0 of the supports, ordered x1, y1, z1, x2, y2, z2.
    pitch_cone_angle, pressure_angle : float
        delta_1 and alpha_n in degrees; they give the contact normal (cos d sin a, sin d sin a, cos a).
    translation_coupling : float or "geometric"
        sigma = d.d of one gear, >= 0; geometric is 1.
    rotation_coupling : float or "geometric"
        c > 0; geometric is cos^2 of the pressure angle.
    variation_translation, variation_rotation : float
        eps_t and eps_r: how much of the stiffness variation enters the translation rows and the mesh row.

    Raises
    ------
    ParameterError
        Naming the parameter, its value and what is allowed.
    """

    b: float
    alpha: float
    f_e: float
    f_pm: float
    kappa: tuple[float, float]
    xi_mesh: float
    xi_translation: tuple[float, float]
    xi_support: tuple[float, ...]
    k_support: tuple[float, ...]
    pitch_cone_angle: float
    pressure_angle: float
    translation_coupling: float | str
    rotation_coupling: float | str
    variation_translation: float
    variation_rotation: float
    alpha_phase: float = 0.0
    alpha_harmonics: Harmonics = ()
    f_e_phase: float = 0.0
    f_e_harmonics: Harmonics = ()
    f_pv: float = 0.0

    def __post_init__(self):
        for name in ("b", "xi_mesh"):
            self._set(name, finite_number(name, getattr(self, name), at_least=0.0))
        for name in _UNBOUNDED:
            self._set(name, finite_number(name, getattr(self, name)))
        self._set("kappa", finite_numbers("kappa", self.kappa, 2, above=0.0))
        self._set("xi_translation", finite_numbers("xi_translation", self.xi_translation, 2, at_least=0.0))
        self._set("xi_support", finite_numbers("xi_support", self.xi_support, 6, at_least=0.0))
        self._set("k_support", finite_numbers("k_support", self.k_support, 6, above=0.0))
        for name in ("alpha_harmonics", "f_e_harmonics"):
            self._set(name, harmonic_pairs(name, getattr(self, name)))
        for name, top in (("pitch_cone_angle", 180.0), ("pressure_angle", 90.0)):
            value = finite_number(name, getattr(self, name))
            if not 0.0 <= value < top:
                raise ParameterError(name, value, f"an angle in degrees, at least 0 and below {top:g}")
            self._set(name, value)
        self._set("translation_coupling", _coupling("translation_coupling", self.translation_coupling, at_least=0.0))
        self._set("rotation_coupling", _coupling("rotation_coupling", self.rotation_coupling, above=0.0))

    def _set(self, name, value):
        object.__setattr__(self, name, value)

    def replace(self, **changes) -> "Model":
        """The same gear pair with some parameters changed; a single number stands for all gears and axes.

        Raises
        ------
        ParameterError
            If there is no such parameter, or its value is not allowed.
        """
        for name in changes:
            if name not in self.__dataclass_fields__:
                raise ParameterError(name, changes[name], f"one of {', '.join(self.__dataclass_fields__)}")
        return dataclasses.replace(self, **changes)

    @property
    def sigma(self) -> float:
        """Squared length of the translation direction of one gear, sigma."""
        return 1.0 if self.translation_coupling == GEOMETRIC else self.translation_coupling

    @property
    def rotation(self) -> float:
        """Rotation coupling c."""
        if self.rotation_coupling == GEOMETRIC:
            return math.cos(math.radians(self.pressure_angle)) ** 2
        return self.rotation_coupling

    @property
    def direction(self) -> np.ndarray:
        """Direction d of shape (6,): sqrt(sigma) (a1, -a2, -a3, -a1, a2, a3) with the unit contact normal a."""
        cone, pressure = math.radians(self.pitch_cone_angle), math.radians(self.pressure_angle)
        radial, axial = math.cos(cone) * math.sin(pressure), math.sin(cone) * math.sin(pressure)
        half = np.array([radial, -axial, -math.cos(pressure)])
        return math.sqrt(self.sigma) * np.concatenate([half, -half])

    @property
    def motion_size(self) -> float:
        """Size of lambda to expect, to scale continuation: b + |f_pm|/c + |f_pv| + |f_e|, or 1 where that is 0.

        It is homogeneous of degree one in (b, f_pm, f_pv, f_e), as lambda itself is.
        """
        size = self.b + abs(self.f_pm) / self.rotation + abs(self.f_pv) + abs(self.f_e)
        return size if size > 0.0 else 1.0

    def stiffness_harmonics(self) -> Harmonics:
        """All (alpha_l, Phi_kl), l = 1 ... N."""
        return ((self.alpha, self.alpha_phase), *self.alpha_harmonics)

    def error_harmonics(self) -> Harmonics:
        """All (f_el, Phi_l), l = 1 ... N."""
        return ((self.f_e, self.f_e_phase), *self.f_e_harmonics)

    def stiffness_variation(self, angle) -> np.ndarray:
        """s(theta) = sum_l alpha_l cos(l theta + Phi_kl) at mesh phases `angle` (rad, any shape).

        Raises
        ------
        ParameterError
            If an angle is no finite number.
        """
        angle = finite_array("angle", angle, None)
        terms = (a * np.cos(l * angle + p) for l, (a, p) in enumerate(self.stiffness_harmonics(), start=1))
        return sum(terms, np.zeros_like(angle))

    def lowest_stiffness(self) -> float:
        """Smallest value of k_t and k_r over a mesh cycle (sampled at 720 angles); negative ones are unphysical."""
        s = self.stiffness_variation(np.linspace(0.0, 2.0 * math.pi, 720, endpoint=False))
        return min(1.0 + float(np.min(e * s)) for e in (self.variation_translation, self.variation_rotation))

    def matrices(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Mass, damping and stiffness matrix without the contact.

        Returns
        -------
        mass, damping, stiffness : (7, 7) arrays
            Of M y'' + C y' + K y + (h_t k_t + h_r k_r) f(lambda) = e_7 load(tau), with y = (x, lambda) and the mesh
            vectors of `mesh_vectors`. The stiffness of lambda itself is 0: the contact carries it.
        """
        direction = self.direction
        mass, damping, stiffness = np.eye(7), np.zeros((7, 7)), np.zeros((7, 7))
        mass[6, :6] = -direction
        damping[:6, :6] = np.diag(2.0 * np.array(self.xi_support))
        damping[:6, 6] = 2.0 * direction * np.repeat(self.xi_translation, 3)
        damping[6, 6] = 2.0 * self.rotation * self.xi_mesh
        stiffness[:6, :6] = np.diag(self.k_support)
        return mass, damping, stiffness

    def mesh_vectors(self) -> tuple[np.ndarray, np.ndarray]:
        """(7,) vectors h_t and h_r through which the forces k_t f and k_r f act on y = (x, lambda)."""
        translation, rotation = np.zeros(7), np.zeros(7)
        translation[:6] = self.direction * np.repeat(self.kappa, 3)
        rotation[6] = self.rotation
        return translation, rotation

    def load_harmonics(self, omega: float, order: int = 1) -> np.ndarray:
        """One-sided harmonics F_0 ... F_order of the right-hand side of the mesh row, complex (order + 1,).

        Raises
        ------
        ParameterError
            If the frequency is not a finite number above 0, or the order is not a whole number from 0.
        """
        omega, order = frequency(omega), whole_number("order", order, 0, 10_000)
        load = np.zeros(order + 1, dtype=complex)
        load[0] = self.f_pm
        if order >= 1:
            load[1] = self.f_pv
        for l, (amplitude, phase) in enumerate(self.error_harmonics(), start=1):
            if l <= order:
                load[l] += amplitude * (l * omega) ** 2 * np.exp(1j * phase)
        return load

    def linear_frequencies(self, gain=1.0) -> np.ndarray:
        """Undamped natural frequencies with the mesh closed by a constant stiffness `gain`, ascending.

        Gain 1 is permanent contact with the mean stiffness. Supports that are alike leave only two modes that involve
        lambda, the lowest and the highest; the others lie at sqrt(k_j).

        Parameters
        ----------
        gain : float or array_like

        Returns
        -------
        (..., 7) array
            Of every gain.

        Raises
        ------
        ParameterError
            If a gain is no finite number.
        """
        gain = finite_array("gain", gain, None)
        mass, _, stiffness = self.matrices()
        translation, rotation = self.mesh_vectors()
        closed = np.tile(stiffness, (*gain.shape, 1, 1))
        closed[..., 6] += gain[..., None] * (translation + rotation)
        values = np.linalg.eigvals(np.linalg.solve(mass, closed))
        return np.sqrt(np.maximum(np.sort(values.real, axis=-1), 0.0))

    def mesh_modes(self, gain: float = 1.0) -> tuple[float, float]:
        """Lowest and highest natural frequency: the mesh-frequency and the shaft-frequency resonance of the study.

        Raises
        ------
        ParameterError
            If the gain is no finite number.
        """
        frequencies = self.linear_frequencies(finite_number("gain", gain))
        return float(frequencies[0]), float(frequencies[-1])


def harmonic_pairs(name: str, value) -> Harmonics:
    """`value` as pairs of finite numbers (amplitude, phase); raises ParameterError with `name` otherwise."""
    allowed = "a list of [amplitude, phase] pairs"
    if list_length(value) < 0:
        raise ParameterError(name, value, allowed)
    for pair in value:
        if list_length(pair) != 2:
            raise ParameterError(name, value, allowed)
    return tuple((finite_number(name, a), finite_number(name, p)) for a, p in value)


def _coupling(name: str, value, **bounds: float) -> float | str:
    if isinstance(value, str):
        if value != GEOMETRIC:
            raise ParameterError(name, value, f"a number or the word {GEOMETRIC}")
        return value
    return finite_number(name, value, **bounds)
