"""Periodic orbits of the true system: Newton's method on the Poincare map with the exact monodromy matrix."""

import math
from dataclasses import dataclass, replace

import numpy as np

from solver.flow.zone_flows import ZONE_FLOWS
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import copy_into
from solver.model.checks import ParameterError, finite_array, finite_number, frequency, instance_of
from solver.model.contact_system import ContactSystem, in_motion, reduced
from solver.timedomain.integrator import checked_state, checked_system, checked_tolerance, with_the_rest
from solver.timedomain.orbits import CONVERGED, ShootingStatus, close_orbit, minimal_period, new_orbit
from solver.timedomain.poincare import checked_count, checked_flows, measure
from solver.timedomain.section_map import new_room
from solver.timedomain.series_map import closed_by_series

__all__ = ["PeriodicOrbit", "ShootingStatus", "orbit_state", "shoot"]


_F, _I = types.float64, types.int64


@kernel(_I(ZONE_FLOWS, ARRAY, _I, _F, _I, _F, MATRIX, ARRAY))
def _shoot(flows, state, period, tolerance, iterations, ceiling, matrix, outcome):
    """`close_orbit`, with fresh room; then `outcome` (3,) also holds the smallest number of periods that repeats."""
    room, orbit = new_room(flows), new_orbit(flows)
    status = close_orbit(flows, state, period, tolerance, iterations, 6, ceiling, orbit, room)
    for i in range(matrix.shape[0]):
        copy_into(matrix[i], orbit.matrix[i])
    outcome[0], outcome[1] = orbit.outcome[0], orbit.outcome[1]
    if status == CONVERGED:
        outcome[2] = minimal_period(flows, state, period, tolerance, ceiling, orbit, room)
    return status


@dataclass(frozen=True, eq=False)
class PeriodicOrbit:
    """A periodic orbit, or the last iterate of a search that found none.

    Parameters
    ----------
    state : (2 n,) array
        y, then y', at tau = 0; 0 where a coordinate is no part of the motion
        (`solver.model.contact_system.in_motion`).
    period : int
        Forcing periods after which the motion repeats (not always the smallest number: see `minimal_period`).
    minimal_period : int
        The smallest divisor of `period` after which it repeats.
    multipliers : (2 m,) complex array
        Eigenvalues of the monodromy matrix of the m coordinates in motion over `period`, the largest modulus first.
    residual : float
        Distance between end and start of the orbit.
    harmonics : (H + 1,) complex array
        One-sided harmonics of lambda at multiples of Omega / period.
    lowest, highest : float
        Extremes of lambda.
    switches : int
        Contact switches over `period` forcing periods.
    iterations : int
    status : ShootingStatus
        Multipliers, harmonics and extremes are nan, and switches 0, unless it is CONVERGED.
    """

    state: np.ndarray
    period: int
    minimal_period: int
    multipliers: np.ndarray
    residual: float
    harmonics: np.ndarray
    lowest: float
    highest: float
    switches: int
    iterations: int
    status: ShootingStatus

    @property
    def largest_multiplier(self) -> float:
        """Largest modulus of the multipliers."""
        return float(abs(self.multipliers[0]))

    @property
    def stable(self) -> bool:
        """Whether every multiplier lies inside the unit circle."""
        return self.largest_multiplier < 1.0


def shoot(
    system: ContactSystem,
    omega: float,
    state,
    period: int = 1,
    *,
    order: int = 4,
    tolerance: float = 1e-10,
    integration_tolerance: float = 1e-13,
    max_iterations: int = 30,
) -> PeriodicOrbit:
    """Periodic orbit near a state.

    Parameters
    ----------
    system : ContactSystem
    omega : float
    state : (2 n,) array_like
        y, then y', at tau = 0; `orbit_state` gives one from harmonics.
    period : int
        Forcing periods of the orbit.
    order : int
        Highest harmonic of Omega / period that is returned.
    tolerance : float
        The orbit is closed when its ends differ by less than this times max(1, |state|).
    integration_tolerance : float
    max_iterations : int
        Newton steps; a step is halved up to six times while it lengthens the gap.

    Returns
    -------
    PeriodicOrbit
        Whether there is one is told by its status.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    period, max_iterations = checked_count("period", period), checked_count("max_iterations", max_iterations)
    tolerance = finite_number("tolerance", tolerance, above=0.0, below=1.0)
    order = checked_count("order", order, 0, 10_000)
    checked_tolerance(integration_tolerance, "integration_tolerance")
    current = checked_state(system, state)
    kept = np.tile(in_motion(system), 2)
    if not np.all(kept):
        settings = dict(
            order=order, tolerance=tolerance, integration_tolerance=integration_tolerance, max_iterations=max_iterations
        )
        orbit = shoot(reduced(system), omega, current[kept], period, **settings)
        return replace(orbit, state=with_the_rest(system, orbit.state))
    outcome = np.full(3, np.nan)
    if system.cubic != 0.0:
        loaded = checked_system(system, omega)
        current, matrix, *outcome = closed_by_series(
            loaded, current, period, tolerance, max_iterations, integration_tolerance
        )
        wanted = tolerance * max(1.0, float(np.max(np.abs(current))))
        status = ShootingStatus.CONVERGED if outcome[0] <= wanted else ShootingStatus.NOT_CONVERGED
        status = status if matrix is not None else ShootingStatus.INTEGRATION_FAILED
    else:
        matrix = np.empty((current.size, current.size))
        # A diverging iterate must not run into overflow: far above any length of the system it is given up.
        ceiling = 1e8 * max(1.0, float(np.max(np.abs(current))))
        flows = checked_flows(system, omega, integration_tolerance)
        status = ShootingStatus(_shoot(flows, current, period, tolerance, max_iterations, ceiling, matrix, outcome))
    gap, iterations = float(outcome[0]), int(outcome[1])
    if status is not ShootingStatus.CONVERGED:
        return _failure(current, period, order, gap, iterations, status)
    found = measure(system, omega, current, period, divisor=period, order=order, tolerance=integration_tolerance)
    values = np.linalg.eigvals(matrix).astype(complex)
    # Of a conjugate pair the one above the axis comes first.
    values = values[np.lexsort((-values.imag, -np.round(np.abs(values), 12)))]
    return PeriodicOrbit(
        current,
        period,
        int(outcome[2]),
        values,
        gap,
        found.harmonics,
        found.lowest,
        found.highest,
        found.switches,
        iterations,
        ShootingStatus.CONVERGED,
    )


def _failure(state, period, order, residual, iterations, status) -> PeriodicOrbit:
    nothing = np.full(state.size, np.nan + 0j)
    harmonics = np.full(order + 1, np.nan + 0j)
    return PeriodicOrbit(state, period, period, nothing, residual, harmonics, math.nan, math.nan, 0, iterations, status)


def orbit_state(
    system: ContactSystem, omega: float, coefficients, period: int = 1, *, samples: int = 4096
) -> np.ndarray:
    """State (2 n,) at tau = 0 that belongs to a harmonic-balance solution for lambda.

    The contact force f of that lambda acts on the linear system,

        Z(k Omega / p) Y_k = F_k - (1 + i (k Omega / p) c_c) h f_k - h_v (s f)_k - k_3 h (lambda^3)_k

    Where Z is singular (a mean that the contact alone carries) the harmonic of lambda itself is imposed instead.

    Parameters
    ----------
    system : ContactSystem
    omega : float
    coefficients : (2 H + 1,) array_like
        Lambda_0, then c_k, s_k of lambda = Lambda_0 + sum_k c_k cos k theta + s_k sin k theta, theta = Omega tau / p.
    period : int
        p.
    samples : int
        Points per period of the FFT that gives the force; the result is a start for `shoot`, not an orbit.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    instance_of("system", system, ContactSystem)
    omega, values = frequency(omega), finite_array("coefficients", coefficients, (None,))
    if values.size % 2 == 0:
        raise ParameterError("coefficients", coefficients, "an odd number of finite numbers")
    period = checked_count("period", period)
    order = values.size // 2
    samples = checked_count("samples", samples, 4 * max(order, 1))
    theta = 2.0 * np.pi * np.arange(samples) / samples
    wave = np.zeros(order + 1, dtype=complex)
    wave[0], wave[1:] = values[0], values[1::2] - 1j * values[2::2]
    # Two-sided amplitudes of the harmonics above the mean are half of the one-sided ones.
    displacement = np.fft.irfft(samples * wave * np.where(np.arange(order + 1) > 0, 0.5, 1.0), samples)
    force = system.contact_force(displacement)
    variation = np.zeros(samples)
    for l, (amplitude, phase) in enumerate(system.stiffness_harmonics, start=1):
        variation += amplitude * np.cos(l * period * theta + phase)
    highest = max(4 * order, 4 * period, period * (max(len(system.load), len(system.inertial_load)) - 1))
    highest = min(highest, samples // 2 - 1)
    plain, varied = (_one_sided(signal, highest) for signal in (force, variation * force))
    loads = np.zeros((highest + 1, system.degrees), dtype=complex)
    loads[::period] = system.load_harmonics(omega, highest // period)
    rates = np.arange(highest + 1) * omega / period
    plain = plain * (1.0 + 1j * rates * system.contact_dashpot)
    if system.cubic != 0.0:
        plain = plain + system.cubic * _one_sided(displacement**3, highest)
    right = loads - plain[:, None] * system.force - varied[:, None] * system.varying_force
    stiffness = system.dynamic_stiffness(rates[:, None, None])
    regular = np.linalg.cond(stiffness) < 1e12
    amplitude = np.zeros_like(loads)
    amplitude[regular] = np.linalg.solve(stiffness[regular], right[regular][:, :, None])[:, :, 0]
    for k in np.flatnonzero(~regular):
        bordered = np.block([[stiffness[k], system.force[:, None]], [system.contact[None, :], np.zeros((1, 1))]])
        imposed = wave[k] if k <= order else 0.0
        amplitude[k] = np.linalg.lstsq(bordered, np.append(right[k], imposed), rcond=None)[0][:-1]
    return np.concatenate([amplitude.real.sum(axis=0), np.real(1j * rates[:, None] * amplitude).sum(axis=0)])


def _one_sided(signal, highest: int) -> np.ndarray:
    harmonics = np.fft.rfft(signal)[: highest + 1] * (2.0 / signal.size)
    harmonics[0] *= 0.5
    return harmonics
