"""Linear resonances of a system in contact: natural frequencies, names, and the share of each mode in the contact."""

import dataclasses
import functools
from dataclasses import dataclass

import numpy as np

from pipeline.plan.numerics import row_system
from pipeline.plan.plan import Plan
from solver import ContactSystem, Model
from solver.model.contact_system import reduced

__all__ = ["Resonance", "common_resonances", "contact_modes", "mesh_shares", "resonances", "resonances_of"]

# Rows whose natural frequencies differ by no more than this share have the same modes.
_SAME = 1e-9
# A mode of a system with less of its strain energy in the contact is none that a figure shows.
_SILENT = 0.005


@dataclass(frozen=True)
class Resonance:
    """One resonance: its name, linear natural frequency, and the part low <= omega < high it is given."""

    name: str
    natural: float
    low: float
    high: float

    def window(self, low: float, high: float) -> tuple[float, float]:
        """Its part of an axis that runs from `low` to `high`."""
        return max(self.low, low), min(self.high, high)


def resonances_of(*naturals: float) -> tuple[Resonance, ...]:
    """The resonances of natural frequencies, ascending; the axis is split at their geometric means.

    The two of a bevel pair are called mesh and shaft; others are numbered.

    Examples
    --------
    >>> [(one.name, one.low, one.high) for one in resonances_of(0.5, 2.0)]
    [('mesh', 0.0, 1.0), ('shaft', 1.0, inf)]
    >>> [(one.name, one.low, one.high) for one in resonances_of(1.0)]
    [('mode 1', 0.0, inf)]
    """
    names = ("mesh", "shaft") if len(naturals) == 2 else [f"mode {i}" for i in range(1, len(naturals) + 1)]
    splits = [0.0, *(float(np.sqrt(a * b)) for a, b in zip(naturals[:-1], naturals[1:], strict=True)), np.inf]
    return tuple(
        Resonance(name, float(natural), low, high)
        for name, natural, low, high in zip(names, naturals, splits[:-1], splits[1:], strict=True)
    )


def resonances(plan: Plan, value: float) -> tuple[Resonance, ...]:
    """The resonances of one row of a plane over omega: of the system that the mean load keeps in contact."""
    return resonances_of(*(natural for natural, _ in contact_modes(row_system(plan, value))))


def contact_modes(system: Model | ContactSystem) -> tuple[tuple[float, float], ...]:
    """Natural frequency of every linear mode in contact that a figure shows, ascending, and the share of its strain
    energy that is in the contact.

    Of a bevel pair the lowest and the highest one. Of another system the share is how much of its squared frequency is
    due to the contact, (l h)(w r)/(l M r omega^2) with the left and the right mode l and r: the energy, where the
    equations have one.
    """
    if isinstance(system, Model):
        return _pair_modes(dataclasses.replace(system, **_UNFELT))
    kept = reduced(system)
    squares, right = np.linalg.eig(np.linalg.solve(kept.mass, kept.stiffness + np.outer(kept.force, kept.contact)))
    # The rows of the inverse are the left modes, of l M r = 1.
    left = np.linalg.inv(right) @ np.linalg.inv(kept.mass)
    with np.errstate(all="ignore"):
        shares = ((left @ kept.force) * (kept.contact @ right) / squares).real
    heard = (squares.real > 0.0) & (shares > _SILENT)
    found = sorted(zip(np.sqrt(squares.real[heard]).tolist(), shares[heard].tolist(), strict=True))
    return tuple((natural, min(share, 1.0)) for natural, share in found)


#: What most planes have along their rows and modes do not depend on: so all rows are one pair.
_UNFELT = {"b": 1.0, "alpha": 0.0, "f_e": 0.0, "f_pm": 1.0}


@functools.lru_cache(maxsize=1024)
def _pair_modes(pair: Model) -> tuple[tuple[float, float], ...]:
    return tuple(zip(pair.mesh_modes(), mesh_shares(pair), strict=True))


def mesh_shares(model: Model) -> tuple[float, float]:
    """Share of strain energy in the mesh of the loaded pair's lower and upper mode (docs/physics.md, section 10).

    With x_j = -d_j kappa_g/(k_j - w^2) lambda the share is lambda^2/(lambda^2 + sum k_j x_j^2/kappa_g).
    """
    stiffness, kappa = np.array(model.k_support), np.repeat(model.kappa, 3)
    found = []
    for frequency in model.mesh_modes():
        with np.errstate(all="ignore"):
            x = model.direction * kappa / (stiffness - frequency**2)
        supports = np.sum(np.where(model.direction != 0.0, stiffness * x * x / kappa, 0.0))
        found.append(float(1.0 / (1.0 + supports)))
    return found[0], found[1]


def common_resonances(plan: Plan) -> tuple[Resonance, ...] | None:
    """The resonances of all rows; None where the modes move with the row parameter, so that no one split serves."""
    values = plan.parameter.values
    modes = [[one.natural for one in resonances(plan, value)] for value in values]
    if len({len(row) for row in modes}) > 1 or np.any(np.ptp(modes, axis=0) > _SAME * np.array(modes[0])):
        return None
    return resonances(plan, float(values[0]))
