"""Kinds of attractors, and what is recorded of one."""

import math
from dataclasses import dataclass

import numpy as np

from solver.contact.impact import ImpactState, impact_state
from solver.explained import Explained
from solver.model.checks import ParameterError, instance_of, number_array
from solver.model.contact_system import ContactSystem
from solver.timedomain.integrator import Status

__all__ = ["Attractor", "AttractorKind", "contact_impact"]


class AttractorKind(Explained):
    """What a motion settles on."""

    FAILED = 0, "The integrator could not continue the motion; its status says why."
    PERIOD_1 = 1, "The motion repeats after every forcing period."
    PERIOD_2 = 2, "The motion repeats after two forcing periods."
    PERIOD_3 = 3, "The motion repeats after three forcing periods."
    PERIOD_4 = 4, "The motion repeats after four forcing periods."
    PERIOD_HIGHER = 5, "The motion repeats after more than four forcing periods."
    QUASI_PERIODIC = 6, "The motion never repeats, and neighbouring motions neither part nor meet: a torus."
    CHAOTIC = 7, "Neighbouring motions part exponentially: the largest Lyapunov exponent is above 0."
    UNBOUNDED = 8, "The contact coordinate grew above the ceiling."
    UNSETTLED = 9, "The motion still converges, slowly: it had not settled after the allowed periods."

    @property
    def periodic(self) -> bool:
        """Whether the motion repeats."""
        return AttractorKind.PERIOD_1 <= self <= AttractorKind.PERIOD_HIGHER


@dataclass(frozen=True, eq=False)
class Attractor:
    """What one motion settled on; numbers that do not apply are nan.

    Parameters
    ----------
    kind : AttractorKind
    period : int
        Forcing periods after which the motion repeats; 0 if it does not.
    periods_used : int
        Forcing periods integrated before the kind was known.
    mean, amplitude : float
        Lambda_0 and |Lambda_1| at the forcing frequency, over the orbit or over the window of an aperiodic motion.
    half_order_amplitude : float
        |Lambda_{1/2}| at half the forcing frequency; 0 where the motion repeats after one period.
    lowest, highest : float
        Extremes of lambda.
    impact : int
        `solver.contact.impact.ImpactState` of these extremes for the gaps of the system; -1 if unknown.
    lyapunov, lyapunov_error : float
        Largest Lyapunov exponent per unit of tau and its standard error; of periodic motions from the multipliers.
    largest_multiplier : float
        Largest modulus of the multipliers over `period`.
    state : (2 n,) array
        The last state, at tau = 0 modulo the forcing period; of a periodic motion the point of the orbit itself.
    points : (period, 2 n) array
        All sections of a periodic motion; a sample of those of another.
    status : Status
        How the integration ended.
    """

    kind: AttractorKind
    period: int
    periods_used: int
    mean: float
    amplitude: float
    half_order_amplitude: float
    lowest: float
    highest: float
    impact: int
    lyapunov: float
    lyapunov_error: float
    largest_multiplier: float
    state: np.ndarray
    points: np.ndarray
    status: Status


def contact_impact(system: ContactSystem, lowest: float, highest: float) -> ImpactState | int:
    """Impact state for the two gaps of the system, which need not be alike.

    Parameters
    ----------
    system : ContactSystem
    lowest, highest : float
        Extremes of lambda.

    Returns
    -------
    ImpactState, or -1 where an extreme is nan.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    instance_of("system", system, ContactSystem)
    for name, value in (("lowest", lowest), ("highest", highest)):
        if number_array(name, value).ndim:
            raise ParameterError(name, value, "one number")
    if not system.two_sided:
        if math.isnan(lowest) or math.isnan(highest):
            return -1
        if lowest > system.front_gap:
            return ImpactState.PERMANENT
        return ImpactState.SINGLE_SIDED if highest > system.front_gap else ImpactState.FREE
    # Seen from the middle of the dead zone both gaps are alike.
    middle, half = 0.5 * (system.front_gap - system.back_gap), 0.5 * (system.front_gap + system.back_gap)
    code = int(impact_state(lowest - middle, highest - middle, half))
    return ImpactState(code) if code >= 0 else -1
