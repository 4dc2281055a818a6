"""What is drawn of a motion: lambda, its speed and the mesh force in time, Poincaré points, and the spectrum."""

import math
from dataclasses import dataclass

import numpy as np

from pipeline.plan.numerics import System
from pipeline.plan.traits import contact_force, contact_system
from solver import ContactSystem
from solver.timedomain import advance, trajectory
from solver.timedomain.integrator import with_the_rest
from solver.timedomain.orders import order_spectrum

__all__ = ["APERIODIC", "HIGHEST_ORDER", "Curves", "harmonic_curves", "integrated_curves", "own_period"]

#: Samples of a period, and periods of a motion without one: those whose path is drawn, those of its spectrum (as many
#: as its quantities are taken over), and its Poincaré points.
_SAMPLES, _PATH, APERIODIC, _POINTS = 256, 48, 128, 1500
#: Of the mesh frequency, in spectra.
HIGHEST_ORDER = 8.0


@dataclass(frozen=True, eq=False)
class Curves:
    """A motion over its own period, or over some periods where it has none; M samples, each of them counted once.

    Parameters
    ----------
    repeats : int or None
        Forcing periods after which it repeats; None where it does not.
    periods : (M,) array
        Time in forcing periods, from 0.
    displacement, speed, force : (M,) arrays
        lambda, lambda' and the mesh force k_t f.
    points : (k, 2) array
        lambda and lambda' at the start of every forcing period.
    orders, amplitudes : (K,) arrays
        Amplitudes of lambda by order of the mesh frequency, without the mean: lines of a motion that repeats.
    """

    repeats: int | None
    periods: np.ndarray
    displacement: np.ndarray
    speed: np.ndarray
    force: np.ndarray
    points: np.ndarray
    orders: np.ndarray
    amplitudes: np.ndarray

    def over(self, shown: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Time in periods, lambda and force over so many periods."""
        each = round(1.0 / (self.periods[1] - self.periods[0]))
        count = shown * each + 1
        times = -(-count // self.periods.size)
        return np.arange(count) / each, *(np.tile(part, times)[:count] for part in (self.displacement, self.force))


def integrated_curves(system: System, omega: float, state: np.ndarray, repeats: int | None) -> Curves:
    """Curves of the motion from a state on an attractor.

    Parameters
    ----------
    system : Model or ContactSystem
    omega : float
    state : (2 n,) array
        At the start of a forcing period, in the coordinates of `contact_system(system)` that are in motion.
    repeats : int or None
        Forcing periods after which the motion repeats; None where it does not.
    """
    state = with_the_rest(contact_system(system), state)
    found = trajectory(system, omega, state, repeats or APERIODIC, _SAMPLES)
    orders, amplitudes = order_spectrum(found.displacement, repeats or APERIODIC, None if repeats else "hann")
    drawn = slice(None if repeats else _PATH * _SAMPLES)
    displacement, speed = found.displacement[drawn], found.speed[drawn]
    points = np.stack([displacement, speed], axis=1)[::_SAMPLES]
    if repeats is None:
        points = _sections(contact_system(system), omega, state)
    kept = (orders > 0.0) & (orders <= HIGHEST_ORDER)
    return Curves(
        repeats, found.periods[drawn], displacement, speed, found.force[drawn], points, orders[kept], amplitudes[kept]
    )


def _sections(system: ContactSystem, omega: float, state: np.ndarray) -> np.ndarray:
    states = advance(system, omega, state, _POINTS, tolerance=1e-12).states[0]
    n = system.degrees
    return np.stack([states[:, :n] @ system.contact, states[:, n:] @ system.contact], axis=1)


def own_period(motion: np.ndarray, period: int) -> tuple[np.ndarray, int]:
    """A motion of a balance over the fewest periods after which it repeats, and their number.

    Parameters
    ----------
    motion : (2 H + 1,) array
        Lambda_0, c_1, s_1, ... over `period` forcing periods.
    period : int

    Examples
    --------
    >>> own_period(np.array([1.0, 0.0, 0.0, 0.3, 0.1]), 2)
    (array([1. , 0.3, 0.1]), 1)
    """
    sizes = np.hypot(motion[1::2], motion[2::2])
    # Newton's method leaves that much of harmonics that are not there.
    there = np.flatnonzero(sizes > 1e-7 * max(1.0, float(np.max(np.abs(motion))))) + 1
    times = math.gcd(period, *there.tolist())
    kept = np.arange(times, sizes.size + 1, times)
    return np.concatenate(
        [motion[:1], np.stack([motion[2 * kept - 1], motion[2 * kept]], axis=1).ravel()]
    ), period // times


def harmonic_curves(system: System, omega: float, motion: np.ndarray, repeats: int) -> Curves:
    """Curves of a motion of a harmonic balance.

    Parameters
    ----------
    system : Model or ContactSystem
    omega : float
    motion : (2 H + 1,) array
        Lambda_0, c_1, s_1, ... of lambda over theta = Omega tau / repeats.
    repeats : int
        Forcing periods of the motion.
    """
    periods = np.arange(repeats * _SAMPLES) / _SAMPLES
    theta = 2.0 * np.pi * periods / repeats
    k, cosines, sines = np.arange(1, motion.size // 2 + 1), motion[1::2], motion[2::2]
    wave, slope = np.cos(theta[:, None] * k), np.sin(theta[:, None] * k)
    displacement = motion[0] + wave @ cosines + slope @ sines
    speed = (wave @ (k * sines) - slope @ (k * cosines)) * omega / repeats
    force = contact_force(system, displacement, 2.0 * np.pi * periods)
    points, orders = np.stack([displacement, speed], axis=1)[::_SAMPLES], k / repeats
    kept = orders <= HIGHEST_ORDER
    amplitudes = np.hypot(cosines, sines)
    return Curves(repeats, periods, displacement, speed, force, points, orders[kept], amplitudes[kept])
