"""How attractors of a row are sought, and what is found."""

import enum
from dataclasses import dataclass

import numpy as np

from solver.model.checks import finite_number, whole_number
from solver.timedomain.attractor import AttractorKind
from solver.timedomain.integrator import checked_tolerance
from solver.timedomain.settling import Limits

__all__ = ["AttractorRow", "AttractorSearch", "SeenFrom"]

_LAST = int(AttractorKind.CHAOTIC)


class SeenFrom(enum.IntFlag):
    """What led to an attractor."""

    REST = 1
    UPWARDS = 2
    DOWNWARDS = 4
    MOTION = 8
    RANDOM = 16
    NEIGHBOUR = 32


@dataclass(frozen=True)
class AttractorSearch:
    """How attractors are sought.

    Parameters
    ----------
    starts : int
        Random initial states in each cell.
    transient : int
        Forcing periods that a motion has to settle.
    watched : int
        Forcing periods, after these, over which the growth of a deviation tells chaos from a torus.
    floor : float
        Growth per forcing period below which a motion counts as a torus: deviations on a torus grow like powers of
        time, which over N periods looks like a growth of some (log N) / N.
    near : float
        A return within this distance, as a share of the length of the system, is polished by Newton's method.
    tolerance : float
        Of the integration.
    ceiling : float
        A motion is unbounded when |lambda| exceeds this many times the length of the system.
    room : int
        Attractors that can be told apart in a cell.

    Raises
    ------
    ParameterError
        If a setting is not allowed.
    """

    starts: int = 4
    transient: int = 300
    watched: int = 2000
    floor: float = 4e-3
    near: float = 0.03
    tolerance: float = 1e-9
    ceiling: float = 1e4
    room: int = 8

    def __post_init__(self):
        whole_number("starts", self.starts, 0, 10**6)
        whole_number("transient", self.transient, 100, 10**7)
        whole_number("watched", self.watched, 600, 10**7)
        whole_number("room", self.room, 2, 100)
        checked_tolerance(self.tolerance)
        for name in ("near", "floor", "ceiling"):
            finite_number(name, getattr(self, name), above=0.0)

    def limits(self) -> Limits:
        """For kernels."""
        return Limits(
            self.tolerance, float(self.ceiling), float(self.near), int(self.transient), int(self.watched), self.floor
        )


@dataclass(frozen=True, eq=False)
class AttractorRow:
    """Attractors of the X cells of a row, in the order in which they were found; A slots a cell.

    Numbers that do not apply are nan; amplitudes, extremes and RMS are those of lambda over the own period of a motion,
    or over 128 forcing periods of an aperiodic one.

    Parameters
    ----------
    kind : (X, A) int8 array
        `AttractorKind`.
    impact : (X, A) int8 array
        `ImpactState`; -1 for none.
    seen : (X, A) uint8 array
        Bits of `SeenFrom`.
    round : (X, A) int16 array
        Round in which it was found; -1 for none.
    lowest, highest, mean, rms, peak_to_peak, amplitude : (X, A) arrays
        Of lambda: RMS and peak to peak of what varies, amplitude at the forcing frequency.
    error_lowest, error_highest, error_rms, error_peak_to_peak : (X, A) arrays
        Of the dynamic transmission error likewise.
    force : (X, A) array
        Largest mesh force over the static one: K_v.
    contact_loss : (X, A) array
        Share of the period.
    impact_velocity : (X, A) array
        Largest speed of lambda where teeth meet again.
    support_force : (X, A) array
        Largest force of a support, in units of k_m b_c.
    lyapunov, lyapunov_error : (X, A) arrays
        Largest Lyapunov exponent per unit of tau and its standard error; of periodic motions from the multipliers.
    hits : (X, A) int32 array
        Random starts that ended on it.
    upwards, downwards : (X, A) int8 arrays
        Slot that it leads to in the next and in the previous column; -1 where there is none.
    state : (X, A, m) array
        On the section tau = 0 mod 2 pi / Omega, in the coordinates of `solver.model.contact_system.reduced`.
    starts : (X,) int32 array
        Random starts that the integrator could carry on.
    motion : (X, S) int8 array
        Slot that each motion of the map leads to; -1 where it is not known.
    box : (X, 2) array
        Half widths of the box of random states: of coordinates and of speeds.
    overflow : (X,) bool array
        Where there are more attractors than slots.
    failures : (X,) int32 array
        Starts that the integrator could not carry on.
    """

    kind: np.ndarray
    impact: np.ndarray
    seen: np.ndarray
    round: np.ndarray
    lowest: np.ndarray
    highest: np.ndarray
    mean: np.ndarray
    rms: np.ndarray
    peak_to_peak: np.ndarray
    error_lowest: np.ndarray
    error_highest: np.ndarray
    error_rms: np.ndarray
    error_peak_to_peak: np.ndarray
    force: np.ndarray
    contact_loss: np.ndarray
    impact_velocity: np.ndarray
    support_force: np.ndarray
    amplitude: np.ndarray
    lyapunov: np.ndarray
    lyapunov_error: np.ndarray
    hits: np.ndarray
    upwards: np.ndarray
    downwards: np.ndarray
    state: np.ndarray
    starts: np.ndarray
    motion: np.ndarray
    box: np.ndarray
    overflow: np.ndarray
    failures: np.ndarray

    def gains(self, round: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Columns (K,), kinds (K,) and states (K, m) of the bounded attractors found in one round.

        Parameters
        ----------
        round : int

        Raises
        ------
        ParameterError
            If it is no round.
        """
        whole_number("round", round, 0, 2**15 - 1)
        columns, slots = np.nonzero((self.round == round) & (self.kind >= 1) & (self.kind <= _LAST))
        return columns, self.kind[columns, slots], self.state[columns, slots]
