"""The Poincare map of a system under a periodic load: states at the start of every forcing period.

The map restarts the clock at each period, so that phases do not lose digits over thousands of them. Extremes and
Fourier integrals of lambda are taken from the polynomials of each step, exactly up to rounding; small deviations are
carried along by the linear equation of the zone. Where a cubic spring makes it nonlinear,
`solver.timedomain.series_map` carries one motion after the other.
"""

import math
from dataclasses import dataclass

import numpy as np

from solver.flow.switched_system import FREQUENCY
from solver.flow.tabulation import loaded_flows
from solver.flow.zone_flows import ZONE_FLOWS, ZoneFlows, apply_map
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.model.checks import ParameterError, finite_number, frequency, instance_of, whole_number
from solver.model.contact_system import ContactSystem
from solver.timedomain.integrator import (
    COMPLETE,
    Status,
    checked_state,
    checked_states,
    checked_system,
    checked_tolerance,
)
from solver.timedomain.polynomial import add_fourier
from solver.timedomain.section_map import (
    BEGIN,
    END,
    MAP_ROOM,
    ROW,
    STATE,
    carry_period,
    new_room,
    new_steps,
    widen_over,
)
from solver.timedomain.series_map import carry_by_series, measured_by_series

__all__ = ["Measurement", "Sections", "add_harmonics", "advance", "growth", "measure", "monodromy"]

_F, _I = types.float64, types.int64


@kernel(types.void(ZONE_FLOWS, MATRIX, _F, types.float64[:, :, ::1], types.int64[::1]))
def _advance(flows, states, ceiling, sections, status):
    """Sections (k, periods, 2 n) of k states, which are overwritten; nan after the first period that fails."""
    room, none = new_room(flows), states[:0]
    for row in range(states.shape[0]):
        status[row] = COMPLETE
        for count in range(sections.shape[1]):
            if status[row] == COMPLETE:
                status[row], _ = carry_period(flows, states[row], none, none, ceiling, room)
            for i in range(states.shape[1]):
                sections[row, count, i] = states[row, i] if status[row] == COMPLETE else math.nan


@kernel(types.void(ZONE_FLOWS, MATRIX, _I, _F, _F, MATRIX, MAP_ROOM), inner=True)
def add_harmonics(flows, steps, count, start, base, sums, room):
    """Add the Fourier integrals of lambda over the steps of a period that starts at a time."""
    half, intervals = flows.half[0], flows.count[0]
    for s in range(count):
        step, row = steps[s], int(steps[s, ROW])
        apply_map(flows.contact, row, step[STATE:], room.powers)
        middle = start + (2.0 * (row % intervals) + 1.0) * half
        add_fourier(room.powers, step[BEGIN], step[END], half, middle, base, sums)


@kernel(_I(ZONE_FLOWS, ARRAY, _I, _F, ARRAY, MATRIX, _F, types.int64[::1]))
def _measure(flows, state, periods, ceiling, extremes, sums, base, switches):
    """Carry a state, which is overwritten, over some periods.

    extremes (2,) of lambda are widened, Fourier integrals at multiples of `base` are added to sums (H + 1, 2), and
    contact switches to switches (1,).
    """
    room, steps, span = new_room(flows), new_steps(flows), 2.0 * math.pi / flows.system.numbers[FREQUENCY]
    for period in range(periods):
        status, count = carry_period(flows, state, steps[:0], steps, ceiling, room)
        if status != COMPLETE:
            return status
        widen_over(flows, steps, count, extremes, room)
        add_harmonics(flows, steps, count, period * span, base, sums, room)
        for s in range(1, count):
            switches[0] += int(steps[s, ROW]) // flows.count[0] != int(steps[s - 1, ROW]) // flows.count[0]
    return COMPLETE


@kernel(_I(ZONE_FLOWS, ARRAY, MATRIX, _I, _F, ARRAY))
def _carry(flows, state, tangents, periods, ceiling, logarithms):
    """Carry a state and deviations (k, 2 n), which are overwritten, over some periods.

    Where `logarithms` (periods,) is not empty, the first deviation is brought back to length 1 after every period and
    the logarithm of its length is kept.
    """
    room, none = new_room(flows), tangents[:0]
    for count in range(periods):
        status, _ = carry_period(flows, state, tangents, none, ceiling, room)
        if status != COMPLETE:
            return status
        if logarithms.shape[0] > 0:
            length = 0.0
            for i in range(state.shape[0]):
                length += tangents[0, i] ** 2
            length = math.sqrt(length)
            logarithms[count] = math.log(length)
            for i in range(state.shape[0]):
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


def checked_flows(system: ContactSystem, omega: float, tolerance: float) -> ZoneFlows:
    """The flows of a system at one frequency.

    Raises
    ------
    ParameterError
        If it is no ContactSystem, omega is not a finite number above 0, or the tolerance is not allowed.
    """
    instance_of("system", system, ContactSystem)
    return loaded_flows(system, frequency(omega), checked_tolerance(tolerance))


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
        A motion is given up where |lambda| exceeds it at the end of a period.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    current = checked_states(system, states)
    sections = np.empty((len(current), checked_count("periods", periods), current.shape[1]))
    status = np.empty(len(current), np.int64)
    ceiling = checked_ceiling(ceiling)
    if system.cubic != 0.0:
        loaded, tolerance = checked_system(system, omega), checked_tolerance(tolerance)
        for row, state in enumerate(current):
            sections[row], _, status[row] = carry_by_series(
                loaded, state, sections.shape[1], tolerance, ceiling, deviations=False
            )
        return Sections(sections, status)
    flows = checked_flows(system, omega, tolerance)
    _advance(flows, current, ceiling, sections, status)
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
    ceiling, switches = checked_ceiling(ceiling), np.zeros(1, np.int64)
    if system.cubic != 0.0:
        rates, tolerance = np.arange(len(sums)) * frequency(omega) / divisor, checked_tolerance(tolerance)
        current, integrals, *extremes, switches[0], status = measured_by_series(
            system, omega, current, periods, rates, tolerance
        )
        sums[:, 0], sums[:, 1] = integrals.real, -integrals.imag
        if not abs(system.contact @ current[: system.degrees]) <= ceiling:
            status = Status.CEILING
    else:
        flows = checked_flows(system, omega, tolerance)
        status = Status(_measure(flows, current, periods, ceiling, extremes, sums, omega / divisor, switches))
    if status is not Status.COMPLETE:
        return Measurement(current, np.full(len(sums), np.nan + 0j), math.nan, math.nan, 0, status)
    harmonics = (sums[:, 0] - 1j * sums[:, 1]) * omega / (math.pi * periods)
    harmonics[0] *= 0.5
    return Measurement(current, harmonics, float(extremes[0]), float(extremes[1]), int(switches[0]), status)


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
    The matrices of the smooth pieces multiply, and those of the switches where they are not 1 (docs/physics.md, section
    6.2).
    """
    current = checked_state(system, state)
    periods, ceiling = checked_count("periods", periods), checked_ceiling(ceiling)
    if system.cubic != 0.0:
        loaded, tolerance = checked_system(system, omega), checked_tolerance(tolerance)
        sections, matrix, status = carry_by_series(loaded, current, periods, tolerance, ceiling, deviations=True)
        return sections[-1], matrix, status
    flows = checked_flows(system, omega, tolerance)
    # Rows of the kernel's array are columns of the matrix.
    tangents = np.eye(current.size)
    status = _carry(flows, current, tangents, periods, ceiling, np.empty(0))
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
    flows, ceiling = checked_flows(system, omega, tolerance), checked_ceiling(ceiling)
    status = _carry(flows, current, tangent, periods, ceiling, logarithms)
    return logarithms, current, Status(status)
