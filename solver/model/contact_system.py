"""Any linear system with one contact coordinate: the form in which stability and direct integration see a gear pair.

    M y'' + C y' + K y + h [f(lambda) + c_c f(lambda)' + k_3 lambda^3] + h_v s(tau) f(lambda) = load
    load = sum_l Re[(F_l + (l Omega)^2 F^i_l) exp(i l Omega tau)]
    lambda = w . y,    s(tau) = sum_l alpha_l cos(l Omega tau + Phi_kl)
    f(lambda) = lambda - front for lambda > front,  r (lambda + back) for lambda < -back,  0 between

A one-sided contact has an infinite back gap; r is the stiffness of the back flank over that of the front one. c_c is a
damper that acts while the teeth touch only: f' is lambda' at the front flank, r lambda' at the back one and 0 between.
Its force jumps where contact begins and ends, and pulls where the teeth part fast enough: the plain law, nothing is cut
off. k_3 is a cubic spring beside the contact, which acts in the gap as well; with it there is no first-order balance,
no proof, no boundary and no search for attractors.

The spur pair of one degree of freedom, the geared rotor, and a mass against a stop are instances; so is the bevel pair
(`gear_system`), whose supports of equal frequency and damping move only along d and merge into one coordinate each,
exactly (docs/physics.md, section 3): with all of them alike, two coordinates remain of seven.
"""

import dataclasses
import math
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from solver.model.checks import (
    ParameterError,
    finite_array,
    finite_number,
    frequency,
    instance_of,
    one_of,
    whole_number,
)
from solver.model.condensation import NO_COUPLING
from solver.model.gear_model import Harmonics, Model, harmonic_pairs

__all__ = ["SYSTEM_AXES", "ContactSystem", "gear_system", "in_motion", "reduced", "refuse_cubic", "support_kinds"]

#: What may be varied of a `ContactSystem`: the frequency; both gaps, or a factor on them; amplitude and phase (rad) of
#: the first harmonic of the stiffness; factors on the mean load and on all that oscillates of the load; a damper that
#: acts as the contact's spring does, in the gap as well, over its stiffness; factors on C and on K.
SYSTEM_AXES = (
    "omega",
    "gap",
    "gap_scale",
    "alpha",
    "alpha_phase",
    "mean_load",
    "excitation",
    "contact_damping",
    "damping",
    "stiffness",
)


@dataclass(frozen=True, eq=False)
class ContactSystem:
    """A linear system of n degrees of freedom with one contact; see the module for the equation.

    Parameters
    ----------
    mass, damping, stiffness : (n, n) array_like
        M, C, K without the contact; M must be invertible. K may be singular where the contact carries the load.
    contact : (n,) array_like
        w; the contact coordinate is lambda = w . y.
    force : (n,) array_like
        h, the direction and stiffness of the contact force.
    varying_force : (n,) array_like, optional
        h_v; how the periodic part s of the contact stiffness acts. Zero unless given.
    front_gap, back_gap : float
        Contact at lambda > front_gap and, unless infinite, at lambda < -back_gap; -back_gap <= front_gap.
    stiffness_harmonics : sequence of (amplitude, phase)
        alpha_l, Phi_kl for l = 1, 2, ...
    load, inertial_load : (L + 1, n) complex array_like
        F_0 ... F_L (one-sided, F_0 real) and F^i_0 ... F^i_L; the latter grow with (l Omega)^2.
    back_stiffness : float
        r > 0, the stiffness of the back flank over that of the front one.
    contact_dashpot : float
        c_c >= 0, the damping of touching teeth over the stiffness of the contact, in units of tau. A damper that acts
        the gap as well is a part of `damping`.
    cubic : float
        k_3, the stiffness of a cubic spring of lambda over that of the contact, per square of length.

    Raises
    ------
    ParameterError
        Naming the parameter, its value and what is allowed.
    """

    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    contact: np.ndarray
    force: np.ndarray
    front_gap: float
    back_gap: float = math.inf
    varying_force: np.ndarray | None = None
    stiffness_harmonics: Harmonics = ()
    load: np.ndarray = field(default_factory=lambda: np.zeros((1, 0)))
    inertial_load: np.ndarray = field(default_factory=lambda: np.zeros((1, 0)))
    back_stiffness: float = 1.0
    contact_dashpot: float = 0.0
    cubic: float = 0.0

    def __post_init__(self):
        n = finite_array("contact", self.contact, (None,)).size
        if n == 0:
            raise ParameterError("contact", self.contact, "a vector of at least one number")
        if self.varying_force is None:
            object.__setattr__(self, "varying_force", np.zeros(n))
        for name, shape in (
            ("mass", (n, n)),
            ("damping", (n, n)),
            ("stiffness", (n, n)),
            ("contact", (n,)),
            ("force", (n,)),
            ("varying_force", (n,)),
        ):
            self._set(name, shape, float)
        for name in ("load", "inertial_load"):
            value = getattr(self, name)
            if isinstance(value, np.ndarray) and value.size == 0:
                object.__setattr__(self, name, np.zeros((1, n)))
            self._set(name, (None, n), complex)
            if len(getattr(self, name)) == 0:
                raise ParameterError(name, value, "of at least one row, the mean")
            if np.any(getattr(self, name)[0].imag != 0.0):
                raise ParameterError(name, getattr(self, name)[0], "real in its first row, the mean")
        if not abs(np.linalg.det(self.mass)) > 0.0:
            raise ParameterError("mass", self.mass, "an invertible matrix")
        object.__setattr__(self, "front_gap", finite_number("front_gap", self.front_gap))
        if self.back_gap != math.inf:
            object.__setattr__(self, "back_gap", finite_number("back_gap", self.back_gap))
        if not -self.front_gap <= self.back_gap:
            allowed = "finite in front, and at the back at least -front_gap (infinite for a one-sided contact)"
            raise ParameterError("front_gap, back_gap", (self.front_gap, self.back_gap), allowed)
        object.__setattr__(self, "stiffness_harmonics", harmonic_pairs("stiffness_harmonics", self.stiffness_harmonics))
        for name, bound in (("back_stiffness", {"above": 0.0}), ("contact_dashpot", {"at_least": 0.0}), ("cubic", {})):
            object.__setattr__(self, name, finite_number(name, getattr(self, name), **bound))

    def _set(self, name, shape, kind):
        value = finite_array(name, getattr(self, name), shape, kind)
        value.setflags(write=False)
        object.__setattr__(self, name, value)

    @property
    def degrees(self) -> int:
        """Number n of coordinates."""
        return self.contact.size

    @property
    def motion_size(self) -> float:
        """Size of lambda to expect, for the scaling of continuation: gap and static response, or 1 where both are 0."""
        closed = self.stiffness + np.outer(self.force, self.contact)
        static = self.contact @ np.linalg.lstsq(closed, self.load[0].real, rcond=None)[0]
        size = abs(self.front_gap) + abs(float(static))
        return size if size > 0.0 else 1.0

    @property
    def two_sided(self) -> bool:
        """Whether there is a contact at the back."""
        return math.isfinite(self.back_gap)

    @property
    def bounded_change(self) -> bool:
        """Whether the contact force is a linear one but for a bounded part, so that a balance has a known degree."""
        return self.two_sided and self.back_stiffness == 1.0 and self.cubic == 0.0

    @property
    def held(self) -> bool:
        """Whether K holds lambda without the contact, by more than 1e-12 of what the contact does."""
        kept = reduced(self)
        closed = kept.stiffness + np.outer(kept.force, kept.contact)
        return bool(abs(np.linalg.det(kept.stiffness)) > 1e-12 * abs(np.linalg.det(closed)))

    def at(self, axis: str, value: float) -> "ContactSystem":
        """The system at one value of an axis; `contact_damping` adds to what C has, factors multiply what there is.

        Raises
        ------
        ParameterError
            If there is no such axis, or the value is not allowed.
        """
        one_of("axis", axis, SYSTEM_AXES)
        value = finite_number(axis, value)
        if axis == "omega":
            return self
        if axis in ("gap", "gap_scale"):
            if axis == "gap_scale" or self.two_sided:
                finite_number(axis, value, at_least=0.0)
            front = value if axis == "gap" else value * self.front_gap
            back = self.back_gap if not self.two_sided else value if axis == "gap" else value * self.back_gap
            return dataclasses.replace(self, front_gap=front, back_gap=back)
        if axis in ("alpha", "alpha_phase"):
            (amplitude, phase), *others = self.stiffness_harmonics or ((0.0, 0.0),)
            first = (value, phase) if axis == "alpha" else (amplitude, value)
            return dataclasses.replace(self, stiffness_harmonics=(first, *others))
        if axis in ("mean_load", "excitation"):
            loads = self.load.copy(), self.inertial_load.copy()
            for load in loads:
                load[slice(0, 1) if axis == "mean_load" else slice(1, None)] *= value
            return dataclasses.replace(self, load=loads[0], inertial_load=loads[1])
        if axis == "contact_damping":
            return dataclasses.replace(self, damping=self.damping + value * np.outer(self.force, self.contact))
        return dataclasses.replace(self, **{axis: value * getattr(self, axis)})

    def contact_force(self, displacement) -> np.ndarray:
        """f alone, at displacements of any shape; raises ParameterError if they are no finite numbers."""
        displacement = finite_array("displacement", displacement, None)
        front = np.maximum(displacement - self.front_gap, 0.0)
        if not self.two_sided:
            return front
        return front + self.back_stiffness * np.minimum(displacement + self.back_gap, 0.0)

    def load_harmonics(self, omega: float, order: int) -> np.ndarray:
        """One-sided harmonics 0 ... order of the load at one frequency, complex (order + 1, n).

        Raises
        ------
        ParameterError
            If the frequency is not a finite number above 0, or the order is not a whole number from 0.
        """
        omega, order = frequency(omega), whole_number("order", order, 0, 10_000)
        total = np.zeros((order + 1, self.degrees), dtype=complex)
        for array, power in ((self.load, 0.0), (self.inertial_load, 2.0)):
            rows = min(len(array), order + 1)
            total[:rows] += array[:rows] * (np.arange(rows)[:, None] * omega) ** power
        return total

    def dynamic_stiffness(self, omega) -> np.ndarray:
        """Z = K - omega^2 M + i omega C, complex (n, n); omega may be an array of shape (..., 1, 1).

        Raises
        ------
        ParameterError
            If omega is no finite number, or an array of another shape.
        """
        omega = finite_array("omega", omega, None)
        if omega.ndim and omega.shape[-2:] != (1, 1):
            raise ParameterError("omega", f"array of shape {omega.shape}", "a number or of shape (..., 1, 1)")
        return self.stiffness - omega**2 * self.mass + 1j * omega * self.damping


def refuse_cubic(system: Model | ContactSystem, purpose: str) -> None:
    """Raise ParameterError if a system has a cubic spring, which serves no such purpose."""
    if isinstance(system, ContactSystem) and system.cubic != 0.0:
        raise ParameterError("cubic", system.cubic, f"0 {purpose}")


@lru_cache(maxsize=8)
def in_motion(system: ContactSystem) -> np.ndarray:
    """Which coordinates are part of the motion, (n,) bool.

    Those that the contact force reaches, and of those that the load alone reaches the ones that are seen at lambda.
    What nothing reaches stays at rest: no start of it belongs to the motion (docs/physics.md, section 9).
    """
    forces = np.column_stack([system.force, system.varying_force])
    loads = np.vstack([system.load, system.inertial_load]).T
    reached, loaded = (np.any(np.linalg.solve(system.mass, part) != 0.0, axis=1) for part in (forces, loads))
    coupled = np.any([np.linalg.solve(system.mass, part) != 0.0 for part in (system.stiffness, system.damping)], axis=0)
    seen = system.contact != 0.0
    for _ in range(system.degrees):
        reached, loaded = (part | np.any(coupled & part[None, :], axis=1) for part in (reached, loaded))
        seen = seen | np.any(coupled & seen[:, None], axis=0)
    kept = reached | (loaded & seen)
    kept.setflags(write=False)
    return kept


def reduced(system: ContactSystem) -> ContactSystem:
    """The system of the coordinates that are `in_motion`: itself where all are, else written with M = I."""
    kept = in_motion(system)
    if np.all(kept) or not np.any(kept):
        return system

    def part(matrix):
        return np.linalg.solve(system.mass, matrix)[kept]

    return dataclasses.replace(
        system,
        mass=np.eye(int(np.sum(kept))),
        damping=part(system.damping)[:, kept],
        stiffness=part(system.stiffness)[:, kept],
        contact=system.contact[kept],
        force=part(system.force),
        varying_force=part(system.varying_force),
        load=part(system.load.T).T,
        inertial_load=part(system.inertial_load.T).T,
    )


def support_kinds(model: Model, *, separate: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Which coordinate of `gear_system` each of the six supports moves with, and its share.

    Parameters
    ----------
    model : Model
    separate : bool
        As for `gear_system`.

    Returns
    -------
    member : (6,) int array
        Index of the coordinate; -1 where the contact does not reach the support.
    share : (6,) array
        d_j / sum d_i^2 over the kind: x_j over the coordinate, where all of a kind move alike.
    """
    squares = model.direction**2
    member, kinds = _kinds(model, squares > NO_COUPLING, separate)
    share = np.zeros(6)
    for g in range(len(kinds)):
        here = member == g
        share[here] = model.direction[here] / np.sum(squares[here])
    return member, share


def _kinds(model: Model, reached: np.ndarray, separate: bool) -> tuple[np.ndarray, list]:
    """Kind of each support, -1 where it is not reached, and what supports of a kind have in common."""
    numbers = [model.xi_support, model.k_support]
    if separate:
        numbers += [np.repeat(model.kappa, 3).tolist(), np.repeat(model.xi_translation, 3).tolist()]
    common = list(zip(*numbers, strict=True))
    kinds = list(dict.fromkeys(key for key, part in zip(common, reached, strict=True) if part))
    return np.array([kinds.index(key) if part else -1 for key, part in zip(common, reached, strict=True)]), kinds


def gear_system(model: Model, *, separate: bool = False) -> ContactSystem:
    """The bevel pair, supports of equal (xi_j, k_j) merged; coordinates are one u = sum d_j x_j per kind, then lambda.

    u'' + 2 xi u' + k u = -sum_j d_j^2 [kappa_g k_t f + 2 xi_hg lambda'] over the supports j of that kind, and all u''
    together act on lambda. The other directions of the translations are neither driven nor seen and decay on their own;
    nor are supports without a share in d, of which there is no coordinate: with sigma = 0 lambda alone is left.

    Parameters
    ----------
    model : Model
    separate : bool
        Whether supports also need equal kappa_g and xi_hg to be merged. Then every x_j can be told from its u:
        x_j = d_j u / sum d_i^2 over its kind.

    Raises
    ------
    ParameterError
        If it is no Model, or `separate` is no truth value.
    """
    instance_of("model", model, Model)
    instance_of("separate", separate, bool)
    squares = model.direction**2
    # What the contact does not reach is no part of the motion; cos 90 degrees is 6e-17.
    reached = squares > NO_COUPLING
    kappa, xi_mesh = np.repeat(model.kappa, 3), np.repeat(model.xi_translation, 3)
    member, kinds = _kinds(model, reached, separate)
    groups = len(kinds)
    n, c = groups + 1, model.rotation
    mass, damping, stiffness = np.eye(n), np.zeros((n, n)), np.zeros((n, n))
    mass[-1, :groups] = -1.0
    force, varying = np.zeros(n), np.zeros(n)
    for g, (xi, k, *_) in enumerate(kinds):
        here = member == g
        damping[g, g], stiffness[g, g] = 2.0 * xi, k
        damping[g, -1] = 2.0 * np.sum((squares * xi_mesh)[here])
        force[g] = np.sum((squares * kappa)[here])
    damping[-1, -1], force[-1] = 2.0 * c * model.xi_mesh, c
    varying[:groups], varying[-1] = model.variation_translation * force[:groups], model.variation_rotation * c
    errors = model.error_harmonics()
    load, inertial = np.zeros((2, n)), np.zeros((len(errors) + 1, n), dtype=complex)
    load[:, -1] = model.f_pm, model.f_pv
    for l, (amplitude, phase) in enumerate(errors, start=1):
        inertial[l, -1] = amplitude * np.exp(1j * phase)
    return ContactSystem(
        mass,
        damping,
        stiffness,
        np.eye(n)[-1],
        force,
        model.b,
        model.b,
        varying,
        model.stiffness_harmonics(),
        load,
        inertial,
    )
