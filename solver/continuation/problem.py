"""What a solution curve is, as compiled kernels see it, and what a harmonic balance is, as rows and seeds see it."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

__all__ = ["Balance", "Problem"]


@dataclass(frozen=True)
class Problem:
    """A curve E(u, p) = 0 as compiled kernels see it.

    Parameters
    ----------
    balance, monitor : compiled kernels
        With the signatures `solver.kernels.compile.BALANCE` and `MONITOR`; values[0] of the monitor is the amplitude,
        each of the others has a grazing where it vanishes.
    theta, direction : arrays
        Parameters at p = 0 and what p adds to them.
    scale : (n + 1,) array
        Typical size of each unknown and of p.
    monitors : int
        Number of monitor values, >= 1.
    """

    balance: object
    monitor: object
    theta: np.ndarray
    direction: np.ndarray
    scale: np.ndarray
    monitors: int

    @property
    def unknowns(self) -> int:
        """Number n of unknowns u."""
        return self.scale.size - 1


class Balance(Protocol):
    """A harmonic balance: which harmonics of lambda are unknown, and how their equations are made.

    `solver.harmonic.describing_function.DescribingFunction` and `solver.harmonic.galerkin.Galerkin` are the two there
    are.
    """

    order: int
    """Harmonics of the mesh frequency."""
    period: int
    """Forcing periods after which a motion repeats, nu."""
    harmonics: int
    """Harmonics of the base frequency Omega/nu."""
    unknowns: int
    """Number n = 2 harmonics + 1 of unknowns (Lambda_0, c_1, s_1, ...)."""
    truncated: bool
    """Whether the force is truncated to these harmonics before the stiffness multiplies it."""
    fundamental: tuple[int, int]
    """Slots of the cosine and sine amplitude of the mesh frequency."""

    def problem(self, model, axis: str, low: float, high: float, omega: float | None = None) -> Problem:
        """The balance as a curve over one axis."""

    def extremes(self, motions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest lambda of motions (..., n)."""

    def linear_solution(self, problem: Problem, p: float) -> tuple[float, np.ndarray]:
        """Degree of the balance and solution (n,) without backlash at one axis value."""

    def degree(self, problem: Problem, grid: np.ndarray) -> np.ndarray:
        """Degree of the balance at every axis value (X,)."""
