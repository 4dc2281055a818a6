"""What a system says of itself, whichever kind it is: the one place that knows a bevel pair from other systems."""

import numpy as np

from solver import ContactSystem, Model, gear_system
from solver.model.gear_model import Harmonics
from solver.model.packing import dead_zone_ends

__all__ = [
    "contact_force",
    "contact_system",
    "dead_zone",
    "excitation_harmonics",
    "feels",
    "force_share",
    "is_loaded_pair",
    "lowest_stiffness",
    "squeezed",
    "static_force",
    "stiffness_harmonics",
]

#: Angles of a mesh cycle at which the stiffness is looked at.
_ANGLES = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)


def contact_system(system: Model | ContactSystem) -> ContactSystem:
    """The equations of motion of a system, as integration takes them."""
    if isinstance(system, Model):
        return gear_system(system)
    return system


def is_loaded_pair(system) -> bool:
    """Whether there is a backbone: a bevel pair under mean load."""
    return isinstance(system, Model) and system.f_pm != 0.0


def dead_zone(system: Model | ContactSystem) -> tuple[float, float]:
    """Ends of the gap, low and high; low is -inf where there is no back flank."""
    low, high = dead_zone_ends(system, "omega", np.ones(1))
    return float(low[0]), float(high[0])


def static_force(system: Model | ContactSystem) -> float:
    """The contact force f at rest under the mean load, with the front flank closed; 0 where that does not press it."""
    if isinstance(system, Model):
        return system.f_pm / system.rotation
    closed = np.linalg.pinv(system.stiffness + np.outer(system.force, system.contact))
    rest = closed @ (system.load[0].real + system.force * system.front_gap)
    return max(float(system.contact @ rest) - system.front_gap, 0.0)


def contact_force(system: Model | ContactSystem, displacement: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """The mesh force k_t f at displacements lambda and mesh phases `angle` (rad), arrays of one shape.

    Of a `ContactSystem` nan where the stiffness does not vary along the force: there is no one mesh force then.
    """
    varied = sum((a * np.cos(l * angle + p) for l, (a, p) in enumerate(stiffness_harmonics(system), start=1)), 0.0)
    return (1.0 + force_share(system) * varied) * squeezed(system, displacement)


def squeezed(system: Model | ContactSystem, displacement: np.ndarray) -> np.ndarray:
    """f at displacements lambda."""
    if isinstance(system, Model):
        return np.maximum(displacement - system.b, 0.0) + np.minimum(displacement + system.b, 0.0)
    return system.contact_force(displacement)


def force_share(system: Model | ContactSystem) -> float:
    """How much of the stiffness variation enters the mesh force."""
    if isinstance(system, Model):
        return system.variation_translation
    strength = float(system.force @ system.force)
    share = float(system.varying_force @ system.force) / strength if strength > 0.0 else 0.0
    along = np.allclose(system.varying_force, share * system.force, rtol=1e-12, atol=0.0)
    return share if along else float("nan")


def feels(system: Model | ContactSystem, axis: str) -> bool:
    """Whether an axis, as the solver calls it, changes anything of a system."""
    if isinstance(system, Model):
        return True
    if axis == "omega":
        return True
    if axis in ("alpha", "alpha_phase"):
        return bool(np.any(system.varying_force))
    one, two = (vars(system.at(axis, value)) for value in (1.0, 2.0))
    return any(not np.array_equal(one[name], two[name]) for name in one)


def stiffness_harmonics(system: Model | ContactSystem) -> Harmonics:
    """(amplitude, phase) of harmonics 1, 2, ... of the contact stiffness, as far as they act at all."""
    if isinstance(system, Model):
        acts = system.variation_translation or system.variation_rotation
        return system.stiffness_harmonics() if acts else ()
    return system.stiffness_harmonics if np.any(system.varying_force) else ()


def excitation_harmonics(system: Model | ContactSystem) -> Harmonics:
    """(amplitude, phase) of harmonics 1, 2, ... of what drives the motion besides the stiffness; of a load on several
    coordinates the largest amplitude."""
    if isinstance(system, Model):
        return system.error_harmonics()
    rows = max(len(system.load), len(system.inertial_load))
    both = [np.zeros((rows, system.degrees), complex) for _ in range(2)]
    for whole, part in zip(both, (system.load, system.inertial_load), strict=True):
        whole[: len(part)] = part
    largest = [row[np.argmax(np.abs(row))] for row in np.concatenate(both, axis=1)[1:]]
    return tuple((float(np.abs(number)), float(np.angle(number))) for number in largest)


def lowest_stiffness(system: Model | ContactSystem) -> float:
    """Smallest contact stiffness over a mesh cycle, over its mean; below 0 it is unphysical."""
    if isinstance(system, Model):
        return system.lowest_stiffness()
    varied = sum((a * np.cos(l * _ANGLES + p) for l, (a, p) in enumerate(system.stiffness_harmonics, start=1)), 0.0)
    share = force_share(system)
    return 1.0 if np.isnan(share) else 1.0 + float(np.min(share * varied))
