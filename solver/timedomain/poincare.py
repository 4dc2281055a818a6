"""The Poincare map of a system under a periodic load: states at the start of every forcing period.

The map restarts the clock at each period, so that phases do not lose digits over thousands of them. Extremes and
Fourier integrals of lambda are taken from the series of each step, exactly up to rounding; small deviations are carried
along by the linear equation of the zone. The contact force is continuous, so nothing jumps in them at a switch.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from solver.flow.switched_system import FREQUENCY, SWITCHED_SYSTEM
from solver.flow.taylor import SERIES, column_at, new_series
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.model.checks import ParameterError, finite_number, whole_number
from solver.model.contact_system import ContactSystem
from solver.timedomain.integrator import (
    CEILING,
    COMPLETE,
    DEVIATIONS,
    TOO_MANY_STEPS,
    Status,
    advance_step,
    checked_state,
    checked_states,
    checked_system,
    checked_tolerance,
    deviation_series,
    new_deviations,
    zone_of,
)
from solver.timedomain.polynomial import fourier, widen

__all__ = ["MAX_STEPS", "Measurement", "Sections", "advance", "growth", "measure", "monodromy"]

_F, _I = types.float64, types.int64

#: Steps allowed in one forcing period.
MAX_STEPS = 100_000


class Watch(NamedTuple):
    """What is gathered along a motion.

    Extremes (2,) of lambda are widened; Fourier integrals at multiples of `base`, time counted from -offset, are added
    to `sums` (H + 1, 2); contact switches are counted in `switches` (1,). Arrays without elements ask for nothing.
    """

    extremes: np.ndarray
    sums: np.ndarray
    switches: np.ndarray
    base: float


WATCH = types.NamedTuple((ARRAY, MATRIX, types.int64[::1], _F), Watch)


@kernel(WATCH(), inner=True)
def watch_nothing():
    return Watch(np.empty(0), np.empty((0, 2)), np.empty(0, np.int64), 0.0)


@kernel(_I(SWITCHED_SYSTEM, ARRAY, DEVIATIONS, _F, _F, _F, WATCH, SERIES), inner=True)
def carry_over_period(system, state, deviations, tolerance, ceiling, offset, watch, series):
    """Carry a state, and deviations with it, over one forcing period."""
    stop, time = 2.0 * math.pi / system.numbers[FREQUENCY], 0.0
    zone = zone_of(system, state)
    for _ in range(MAX_STEPS):
        step, after, status = advance_step(system, zone, time, stop, tolerance, state, series, deviations)
        if status != COMPLETE:
            return status
        if watch.extremes.shape[0] == 2:
            watch.extremes[0], watch.extremes[1] = widen(series.contact, step, watch.extremes[0], watch.extremes[1])
            fourier(series.contact, step, time + offset, watch.base, watch.sums)
        column_at(series, step, state)
        for k in range(deviations.states.shape[0]):
            column_at(deviation_series(deviations, k, series), step, deviations.states[k])
        displacement = 0.0
        for i in range(system.vectors.shape[1]):
            displacement += system.vectors[0, i] * state[i]
        if not abs(displacement) <= ceiling:
            return CEILING
        if after != zone:
            if watch.switches.shape[0] > 0:
                watch.switches[0] += 1
        elif step >= stop - time:
            return COMPLETE
        zone = after
        time += step
        if time >= stop:
            return COMPLETE
    return TOO_MANY_STEPS


@kernel(types.void(SWITCHED_SYSTEM, MATRIX, _F, _F, types.float64[:, :, ::1], types.int64[::1]))
def _advance(system, states, tolerance, ceiling, sections, status):
    """Sections (k, periods, 2 n) of k states, which are overwritten; nan after the first period that fails."""
    size, nothing = states.shape[1], watch_nothing()
    none, series = new_deviations(np.empty((0, size))), new_series(size // 2)
    for row in range(states.shape[0]):
        status[row] = COMPLETE
        for count in range(sections.shape[1]):
            if status[row] == COMPLETE:
                status[row] = carry_over_period(system, states[row], none, tolerance, ceiling, 0.0, nothing, series)
            for i in range(size):
                sections[row, count, i] = states[row, i] if status[row] == COMPLETE else math.nan


@kernel(_I(SWITCHED_SYSTEM, ARRAY, _I, _F, _F, WATCH))
def _measure(system, state, periods, tolerance, ceiling, watch):
    """Carry a state, which is overwritten, over some periods and gather what is watched."""
    size, span = state.shape[0], 2.0 * math.pi / system.numbers[FREQUENCY]
    none, series = new_deviations(np.empty((0, size))), new_series(size // 2)
    for count in range(periods):
        status = carry_over_period(system, state, none, tolerance, ceiling, count * span, watch, series)
        if status != COMPLETE:
            return status
    return COMPLETE


@kernel(_I(SWITCHED_SYSTEM, ARRAY, MATRIX, _I, _F, _F, ARRAY))
def _carry(system, state, tangents, periods, tolerance, ceiling, logarithms):
    """Carry a state and deviations (k, 2 n), which are overwritten, over some periods.

    Where `logarithms` (periods,) is not empty, the first deviation is brought back to length 1 after every period and
    the logarithm of its length is kept.
    """
    size, nothing = state.shape[0], watch_nothing()
    deviations, series = new_deviations(tangents), new_series(size // 2)
    for count in range(periods):
        status = carry_over_period(system, state, deviations, tolerance, ceiling, 0.0, nothing, series)
        if status != COMPLETE:
            return status
        if logarithms.shape[0] > 0:
            length = 0.0
            for i in range(size):
                length += tangents[0, i] ** 2
            length = math.sqrt(length)
            logarithms[count] = math.log(length)
            for i in range(size):
                tangents[0, i] /= length
    return COMPLETE


@dataclass(frozen=True, eq=False)
class Sections:
    """Poincare sections of k motions.

    Parameters
    ----------
    states : (k, periods, 2 n) array
        The state after 1, 2, ... periods; nan from the first that was not reached.
    status : (k,) int array
        `Status` of every motion.
    """

    states: np.ndarray
    status: np.ndarray


@dataclass(frozen=True, eq=False)
class Measurement:
    """What one motion does over a window of forcing periods.

    Parameters
    ----------
    state : (2 n,) array
        At the end of the window.
    harmonics : (H + 1,) complex array
        One-sided harmonics Lambda_0 ... Lambda_H of lambda over the window, at multiples of Omega / divisor.
    lowest, highest : float
        Extremes of lambda.
    switches : int
        Contact switches in the window.
    status : Status
        All but the state is nan or 0 where it is not COMPLETE.
    """

    state: np.ndarray
    harmonics: np.ndarray
    lowest: float
    highest: float
    switches: int
    status: Status


def checked_count(name: str, value, lowest: int = 1, highest: int = 10**9) -> int:
    """An integer within bounds.

    Raises
    ------
    ParameterError
        If it is none.
    """
    return whole_number(name, value, lowest, highest)


def checked_ceiling(ceiling: float) -> float:
    """A ceiling of |lambda|, above 0 and infinite where there is none; raises ParameterError otherwise."""
    return ceiling if ceiling == math.inf else finite_number("ceiling", ceiling, above=0.0)


def advance(
    system: ContactSystem, omega: float, states, periods: int, *, tolerance: float = 1e-10, ceiling: float = math.inf
) -> Sections:
    """Sections of a batch of motions over whole forcing periods from tau = 0.

    Parameters
    ----------
    system : ContactSystem
    omega : float
    states : (k, 2 n) array_like
        Initial states.
    periods : int
    tolerance : float
        As for `integrate`.
    ceiling : float
        A motion is given up where |lambda| exceeds it at the end of a step.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    current = checked_states(system, states)
    sections = np.empty((len(current), checked_count("periods", periods), current.shape[1]))
    status = np.empty(len(current), np.int64)
    tolerance, ceiling = checked_tolerance(tolerance), checked_ceiling(ceiling)
    _advance(checked_system(system, omega), current, tolerance, ceiling, sections, status)
    return Sections(sections, status)


def measure(
    system: ContactSystem,
    omega: float,
    state,
    periods: int,
    *,
    divisor: int = 1,
    order: int = 4,
    tolerance: float = 1e-10,
    ceiling: float = math.inf,
) -> Measurement:
    """Extremes, contact switches and Fourier harmonics 0 ... order of lambda over a window from tau = 0.

    The harmonics are those of the multiples of Omega / divisor; they are amplitudes of lines of the spectrum where
    `periods` is a multiple of `divisor`.

    Parameters
    ----------
    system, omega, tolerance, ceiling
        As for `advance`.
    state : (2 n,) array_like
        y, then y', at tau = 0.
    periods : int
        Forcing periods.
    divisor : int
        The lowest harmonic is that of Omega / divisor.
    order : int
        Highest harmonic.

    Returns
    -------
    Measurement

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    current = checked_state(system, state)
    periods, divisor = checked_count("periods", periods), checked_count("divisor", divisor)
    sums, extremes = np.zeros((checked_count("order", order, 0, 10_000) + 1, 2)), np.array([math.inf, -math.inf])
    loaded = checked_system(system, omega)
    watch = Watch(extremes, sums, np.zeros(1, np.int64), omega / divisor)
    tolerance, ceiling = checked_tolerance(tolerance), checked_ceiling(ceiling)
    status = Status(_measure(loaded, current, periods, tolerance, ceiling, watch))
    if status is not Status.COMPLETE:
        return Measurement(current, np.full(len(sums), np.nan + 0j), math.nan, math.nan, 0, status)
    harmonics = (sums[:, 0] - 1j * sums[:, 1]) * omega / (math.pi * periods)
    harmonics[0] *= 0.5
    return Measurement(current, harmonics, float(extremes[0]), float(extremes[1]), int(watch.switches[0]), status)


def monodromy(
    system: ContactSystem, omega: float, state, periods: int = 1, *, tolerance: float = 1e-12, ceiling: float = math.inf
) -> tuple[np.ndarray, np.ndarray, Status]:
    """The state (2 n,) after some periods from tau = 0 and its derivative (2 n, 2 n) by the initial state.

    Parameters
    ----------
    system, omega, tolerance, ceiling
        As for `advance`.
    state : (2 n,) array_like
        y, then y', at tau = 0.
    periods : int
        Forcing periods.

    Returns
    -------
    state : (2 n,) array
    matrix : (2 n, 2 n) array
    status : Status
        Where it is not COMPLETE, the others are of no use.

    Raises
    ------
    ParameterError
        If an argument is not allowed.

    Notes
    -----
    The contact force is continuous, so that the matrices of the smooth pieces multiply (docs/physics.md, section 6.2).
    """
    current = checked_state(system, state)
    periods, loaded = checked_count("periods", periods), checked_system(system, omega)
    tolerance, ceiling = checked_tolerance(tolerance), checked_ceiling(ceiling)
    # Rows of the kernel's array are columns of the matrix.
    tangents = np.eye(current.size)
    status = _carry(loaded, current, tangents, periods, tolerance, ceiling, np.empty(0))
    return current, tangents.T.copy(), Status(status)


def growth(
    system: ContactSystem,
    omega: float,
    state,
    periods: int,
    *,
    tolerance: float = 1e-10,
    ceiling: float = math.inf,
    direction=None,
) -> tuple[np.ndarray, np.ndarray, Status]:
    """Logarithm of the growth of one small deviation in every period, renormalised after each.

    Their mean over Omega / 2 pi is the largest Lyapunov exponent (G. Benettin, L. Galgani, A. Giorgilli,
    J.-M. Strelcyn, Meccanica 15 (1980) 9-20).

    Parameters
    ----------
    system, omega, state, periods, tolerance, ceiling
        As for `advance`.
    direction : (2 n,) array_like, optional
        The initial deviation; all components alike unless given.

    Returns
    -------
    logarithms : (periods,) array
    state : (2 n,) array
        At the end.
    status : Status
        Where it is not COMPLETE, the logarithms end with nan.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    current, periods = checked_state(system, state), checked_count("periods", periods)
    deviation = np.ones(current.size) if direction is None else checked_state(system, direction, "direction")
    if not np.any(deviation):
        raise ParameterError("direction", direction, "other than 0")
    tangent, logarithms = deviation[None, :] / np.linalg.norm(deviation), np.full(periods, np.nan)
    tolerance, ceiling = checked_tolerance(tolerance), checked_ceiling(ceiling)
    status = _carry(checked_system(system, omega), current, tangent, periods, tolerance, ceiling, logarithms)
    return logarithms, current, Status(status)
