"""A motion at even times of every forcing period: what pictures and spectra are made of.

The states are those of the flows' polynomials at these times, as accurate as the sections of `advance`; no step of an
integrator is taken for a sample.
"""

import math
from dataclasses import dataclass

import numpy as np

from solver.flow.switched_system import HIGH, LOW
from solver.flow.zone_flows import ZONE_FLOWS, matrix_at
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.model.checks import frequency, instance_of, whole_number
from solver.model.contact_system import ContactSystem, gear_system
from solver.model.gear_model import Model
from solver.model.packing import packed
from solver.timedomain.gauge import Gauge, gauge_at
from solver.timedomain.integrator import COMPLETE, Status, checked_state, checked_tolerance
from solver.timedomain.poincare import checked_flows
from solver.timedomain.row_systems import row_systems
from solver.timedomain.section_map import END, MAP_ROOM, ROW, STATE, carry_period, new_room, new_steps

__all__ = ["SampledMotion", "sample_period", "trajectory"]

_F, _I = types.float64, types.int64


@kernel(types.void(ZONE_FLOWS, MATRIX, _I, MATRIX, MAP_ROOM), inner=True)
def sample_period(flows, steps, count, states, room):
    """Fill in the states (N, 2 n) at N even times of a period, from its start on.

    Parameters
    ----------
    flows : ZoneFlows
    steps, count
        Of `carry_period`.
    states : (N, 2 n) array
    room : MapRoom
    """
    intervals, samples, size = flows.count[0], states.shape[0], states.shape[1]
    phi, s = room.phi, 0
    for j in range(samples):
        # In whole numbers: a sample at an interval's border belongs to the interval that begins there.
        k = j * intervals // samples
        u = 2.0 * (j * intervals - k * samples) / samples - 1.0
        while s < count - 1:
            of_step = int(steps[s, ROW]) % intervals
            if of_step > k or (of_step == k and u <= steps[s, END]):
                break
            s += 1
        matrix_at(flows.forward, int(steps[s, ROW]), 0, u, phi)
        for r in range(size):
            total = phi[size, r]
            for c in range(size):
                total += phi[c, r] * steps[s, STATE + c]
            states[j, r] = total


@kernel(_I(ZONE_FLOWS, ARRAY, _I, MATRIX))
def _sample(flows, state, periods, states):
    """Fill states (P N, 2 n) of P periods; nan from the first that fails. The state (2 n,) is overwritten."""
    room, steps, samples = new_room(flows), new_steps(flows), states.shape[0] // periods
    states[:, :] = math.nan
    for period in range(periods):
        status, count = carry_period(flows, state, steps[:0], steps, math.inf, room)
        if status != COMPLETE:
            return status
        sample_period(flows, steps, count, states[period * samples : (period + 1) * samples], room)
    return COMPLETE


@dataclass(frozen=True, eq=False)
class SampledMotion:
    """A motion at N even times of each of P forcing periods, M = P N.

    Lengths are in units of b_c, times of 1/Omega_n, as everywhere.

    Parameters
    ----------
    periods : (M,) array
        Times in forcing periods, from 0; sample N q is the Poincare point of period q.
    times : (M,) array
        tau.
    states : (M, 2 n) array
        y, then y'.
    displacement, speed : (M,) arrays
        lambda and lambda'.
    force : (M,) array
        Mesh force k_t(tau) f(lambda); nan of a system whose stiffness does not vary in one force.
    static_force : float
        What the force is at rest: f_pm/c of a gear pair.
    transmission_error : (M,) array
        psi = lambda - d.x + e; nan of a system that is no gear pair.
    support_forces : (M, S) array
        Of the most loaded support of each kind, k_j x_j + 2 xi_j x_j'; S = 0 where the coordinates do not tell them
        (`solver.timedomain.quantities.gauge_at`), or the contact reaches no support.
    end : (2 n,) array
        The state after the last period.
    status : Status
        Where it is not COMPLETE, samples are nan from the period that failed.
    """

    periods: np.ndarray
    times: np.ndarray
    states: np.ndarray
    displacement: np.ndarray
    speed: np.ndarray
    force: np.ndarray
    static_force: float
    transmission_error: np.ndarray
    support_forces: np.ndarray
    end: np.ndarray
    status: Status


def trajectory(
    system: Model | ContactSystem, omega: float, state, periods: int, samples: int, *, tolerance: float = 1e-12
) -> SampledMotion:
    """The motion from a state at tau = 0, sampled evenly over whole forcing periods.

    Parameters
    ----------
    system : Model or ContactSystem
    omega : float
        Mesh frequency, > 0.
    state : (2 n,) array_like
        y, then y', at tau = 0. Of a Model in the coordinates of `gear_system(model)`, or of those with separate=True.
    periods, samples : int
        Number of periods, and of samples in each; 1e8 in all at most.
    tolerance : float
        As for `advance`.

    Returns
    -------
    SampledMotion

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    instance_of("system", system, Model, ContactSystem)
    omega, tolerance = frequency(omega), checked_tolerance(tolerance)
    periods = whole_number("periods", periods, 1, 10**6)
    samples = whole_number("samples", samples, 1, 10**8 // periods)
    contact, gauge = _read_of(system, omega, np.size(state))
    end, flows = checked_state(contact, state), checked_flows(contact, omega, tolerance)
    states = np.empty((periods * samples, end.size))
    status = Status(_sample(flows, end, periods, states))
    loaded, n, phase = flows.system, contact.degrees, np.arange(samples) / samples
    counted = (np.arange(periods)[:, None] + phase).ravel()
    displacement, speed = states[:, :n] @ contact.contact, states[:, n:] @ contact.contact
    # Of the phase within the period, as the flows count it: no digits are lost over many periods.
    angle = np.tile(2.0 * np.pi * phase, periods)
    variation = _sum(loaded.variation[:, 0], -loaded.variation[:, 1], angle)
    low, high = loaded.numbers[LOW], loaded.numbers[HIGH]
    squeezed = np.maximum(displacement - high, 0.0) + np.minimum(displacement - low, 0.0)
    error = np.full(len(states), np.nan)
    if gauge.seen.size:
        error = displacement - states[:, :n] @ gauge.seen + _sum(*gauge.error.T, angle)
    return SampledMotion(
        periods=counted,
        times=2.0 * np.pi / omega * counted,
        states=states,
        displacement=displacement,
        speed=speed,
        force=squeezed * (1.0 + gauge.numbers[0] * variation if variation.any() else 1.0),
        static_force=float(gauge.numbers[1]),
        transmission_error=error,
        support_forces=states @ gauge.supports.T if gauge.supports.size else np.empty((len(states), 0)),
        end=end,
        status=status,
    )


def _read_of(system: Model | ContactSystem, omega: float, size: int) -> tuple[ContactSystem, Gauge]:
    """The system whose states have so many numbers, and what is read of it."""
    if isinstance(system, ContactSystem):
        return system, row_systems(system, "omega", np.array([omega]), None).gauges[0]
    merged, apart = gear_system(system), gear_system(system, separate=True)
    separate = size == 2 * apart.degrees
    gauge = gauge_at(*packed(system, "omega", None, 1, 1), omega, separate)
    return apart if separate else merged, gauge


def _sum(cosines: np.ndarray, sines: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """sum_l c_l cos(l angle) + s_l sin(l angle), l = 1 ..."""
    orders = np.arange(1, len(cosines) + 1)
    return np.cos(angle[:, None] * orders) @ cosines + np.sin(angle[:, None] * orders) @ sines
