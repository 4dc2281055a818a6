"""What gear engineers read of a motion (docs/physics.md, section 10): the numbers and their units."""

import enum
from dataclasses import dataclass

__all__ = ["Quantities", "Slot"]


class Slot(enum.IntEnum):
    """Where `read` puts each quantity of `Quantities`."""

    LOWEST = 0
    HIGHEST = 1
    MEAN = 2
    RMS = 3
    PEAK_TO_PEAK = 4
    ERROR_LOWEST = 5
    ERROR_HIGHEST = 6
    ERROR_RMS = 7
    ERROR_PEAK_TO_PEAK = 8
    DYNAMIC_FACTOR = 9
    CONTACT_LOSS = 10
    IMPACT_VELOCITY = 11
    SUPPORT_FORCE = 12


@dataclass(frozen=True)
class Quantities:
    """What a motion does over its own period. Lengths are in units of b_c, times of 1/Omega_n, as everywhere.

    Parameters
    ----------
    lowest, highest, mean : float
        Mesh deflection lambda. In units of b_c.
    rms, peak_to_peak : float
        Of its varying part.
    error_lowest, error_highest : float
        Dynamic transmission error psi = lambda - d.x + e, angular error times base radius. In units of b_c.
    error_rms, error_peak_to_peak : float
        Of its varying part.
    dynamic_factor : float
        K_v: the largest mesh force k_t f(lambda) over the static one, f_pm/c; nan where that is 0.
    contact_loss : float
        Share of the period without contact, |lambda| <= b.
    impact_velocity : float
        Largest |lambda'| at which teeth meet again, in units of b_c Omega_n; 0 where they never part.
    support_force : float
        Largest |k_j x_j + 2 xi_j x_j'|/kappa_g of the six supports, in units of k_m b_c as the mesh force is, whatever
        the masses of the gears; 0 where the contact reaches no support.
    """

    lowest: float
    highest: float
    mean: float
    rms: float
    peak_to_peak: float
    error_lowest: float
    error_highest: float
    error_rms: float
    error_peak_to_peak: float
    dynamic_factor: float
    contact_loss: float
    impact_velocity: float
    support_force: float
