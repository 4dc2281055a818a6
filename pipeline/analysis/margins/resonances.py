"""Linear resonances over which a range of frequencies lies, named by the mesh strain energy of their modes."""

from dataclasses import dataclass

import numpy as np

from pipeline.plan.numerics import System
from pipeline.plan.traits import excitation_harmonics, stiffness_harmonics
from pipeline.plane.resonances import contact_modes
from solver import Model

__all__ = ["Resonance", "mesh_modes", "resonances_in"]

#: A mode with less than this share of its strain energy in the mesh is none of the mesh.
_SILENT = 1e-6


@dataclass(frozen=True)
class Resonance:
    """A mesh frequency at which a linear mode of the loaded pair resonates.

    Parameters
    ----------
    omega : float
    natural : float
        Natural frequency of the mode.
    mesh_energy : float
        Share of its strain energy that is in the mesh.
    """

    omega: float
    natural: float
    mesh_energy: float

    @property
    def words(self) -> str:
        """For a sentence."""
        ratio = self.natural / self.omega
        how = "" if ratio > 0.99 and ratio < 1.01 else f", {ratio:.0f}Ω" if ratio > 1.0 else ", Ω/2"
        return f"Ω = {self.omega:.4g} (mode of {100.0 * self.mesh_energy:.0f} % mesh strain energy{how})"


def mesh_modes(system: System) -> list[tuple[float, float]]:
    """Natural frequency of every linear mode in contact that strains the mesh, and the share of its strain energy that
    does, ascending: of a bevel pair λ²/(λ² + Σ k_j x_j²/κ_g) (docs/physics.md, section 10).

    The weights are those of the pair's energy (section 2).
    """
    return _modes_of_pair(system) if isinstance(system, Model) else list(contact_modes(system))


def _modes_of_pair(model: Model) -> list[tuple[float, float]]:
    mass, _, stiffness = model.matrices()
    stiffness[:, 6] += sum(model.mesh_vectors())
    squares, shapes = np.linalg.eig(np.linalg.solve(mass, stiffness))
    found = []
    for number in np.argsort(squares.real):
        shape = np.abs(shapes[:, number]) ** 2
        energies = np.array([*(model.k_support / np.repeat(model.kappa, 3)), 1.0]) * shape
        share = float(energies[6] / energies.sum())
        if share > _SILENT:
            found.append((float(np.sqrt(squares[number].real)), share))
    return found


def resonances_in(system: System, low: float, high: float) -> list[Resonance]:
    """Resonances within a range of the mesh frequency, ascending: k Ω on a natural frequency for every harmonic k of
    the excitation, and Ω on twice one where the stiffness varies."""
    harmonics = (stiffness_harmonics(system), excitation_harmonics(system))
    orders = {k for one in harmonics for k, (amplitude, _) in enumerate(one, start=1) if amplitude} | {1}
    varies = any(amplitude for amplitude, _ in harmonics[0])
    ratios = [1.0 / k for k in orders] + ([2.0] if varies else [])
    found = [Resonance(ratio * natural, natural, share) for natural, share in mesh_modes(system) for ratio in ratios]
    return sorted((one for one in found if low <= one.omega <= high), key=lambda one: one.omega)
