"""The two resonances, named from the linear modes of the loaded pair: the lower one mesh, the upper one shaft."""

from dataclasses import dataclass

import numpy as np

from pipeline.plan.numerics import model_at
from pipeline.plan.plan import Plan
from solver import Model

__all__ = ["Resonance", "common_resonances", "mesh_shares", "resonances", "resonances_of"]

# Rows whose natural frequencies differ by no more than this share have the same modes.
_SAME = 1e-9


@dataclass(frozen=True)
class Resonance:
    """One of the two resonances: its name, linear natural frequency, and the part low <= omega < high it is given."""

    name: str
    natural: float
    low: float
    high: float

    def window(self, low: float, high: float) -> tuple[float, float]:
        """Its part of an axis that runs from `low` to `high`."""
        return max(self.low, low), min(self.high, high)


def resonances_of(lower: float, upper: float) -> tuple[Resonance, Resonance]:
    """Both resonances of two natural frequencies; the axis is split at their geometric mean.

    Examples
    --------
    >>> [(one.name, one.low, one.high) for one in resonances_of(0.5, 2.0)]
    [('mesh', 0.0, 1.0), ('shaft', 1.0, inf)]
    """
    split = float(np.sqrt(lower * upper))
    return Resonance("mesh", float(lower), 0.0, split), Resonance("shaft", float(upper), split, np.inf)


def resonances(plan: Plan, value: float) -> tuple[Resonance, Resonance]:
    """Both resonances of one row of a plane over omega: of the pair that the mean load keeps in contact."""
    return resonances_of(*model_at(plan, value, plan.sweep.low).mesh_modes())


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


def common_resonances(plan: Plan) -> tuple[Resonance, Resonance] | None:
    """Both resonances of all rows; None where the modes move with the row parameter, so that no one split serves."""
    values = plan.parameter.values
    modes = np.array([[one.natural for one in resonances(plan, value)] for value in values])
    if np.any(np.ptp(modes, axis=0) > _SAME * modes[0]):
        return None
    return resonances(plan, float(values[0]))
