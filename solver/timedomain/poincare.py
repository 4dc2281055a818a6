"""The Poincare map of a system under a periodic load: states at the start of every forcing period.

The map restarts the clock at each period, so that phases do not lose digits over thousands of them. Extremes and
Fourier integrals of lambda are taken from the series of each step, exactly up to rounding; small deviations are carried
along by the linear equation of the zone. The contact force is continuous, so nothing jumps in them at a switch.
"""

import math
from dataclasses import dataclass

import numpy as np

from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.model.checks import ParameterError, finite_number, whole_number
from solver.model.contact_system import ContactSystem
from solver.timedomain.integrator import (
    CEILING,
    COMPLETE,
    TOO_MANY_STEPS,
    Status,
    advance_step,
    checked_state,
    checked_states,
    checked_tolerance,
    zone_of,
)
from solver.timedomain.polynomial import fourier, widen
from solver.timedomain.taylor import PACKED, WORK, land, new_work, pack, tangent_series, tangent_step_length

__all__ = ["MAX_STEPS", "Measurement", "Sections", "advance", "growth", "measure", "monodromy"]

#: Steps allowed in one forcing period.
MAX_STEPS = 100_000


@kernel(
    types.int64(
        PACKED,
        ARRAY,
        types.float64,
        types.float64,
        types.float64,
        types.int64,
        MATRIX,
        types.float64,
        types.float64,
        MATRIX,
        ARRAY,
        types.int64[::1],
        WORK,
    ),
    inner=True,
)
def _period(
    packed, state, tolerance, longest, ceiling, max_steps, tangents, base, offset, sums, extremes, switches, work
):
    """Carry a state, and the rows of `tangents` with it, over one forcing period.

    No step is longer than `longest`. Where `extremes` (2,) is not empty it is widened, and Fourier integrals with
    frequency `base` and time counted from -offset are added to `sums` (H + 1, 2); the contact switches are counted in
    `switches` (1,).
    """
    stop, time = 2.0 * math.pi / packed.numbers[0], 0.0
    n = packed.vectors.shape[1]
    zone = zone_of(packed, state)
    for _ in range(max_steps):
        step, after, status = advance_step(packed, zone, time, stop, tolerance, longest, state, work)
        if status != COMPLETE:
            return status
        if extremes.shape[0] == 2:
            extremes[0], extremes[1] = widen(work.contact, step, extremes[0], extremes[1])
            if sums.shape[0] > 0:
                fourier(work.contact, step, time + offset, base, sums)
        land(work, step, state)
        for row in range(tangents.shape[0]):
            tangent_series(packed, zone, tangents[row], work)
            land(work, step, tangents[row])
        displacement = 0.0
        for i in range(n):
            displacement += packed.vectors[0, i] * state[i]
        if not abs(displacement) <= ceiling:
            return CEILING
        if after != zone:
            switches[0] += 1
        elif step >= stop - time:
            return COMPLETE
        zone = after
        time += step
        if time >= stop:
            return COMPLETE
    return TOO_MANY_STEPS


@kernel(
    types.void(PACKED, MATRIX, types.float64, types.float64, types.int64, types.float64[:, :, ::1], types.int64[::1])
)
def _advance(packed, states, tolerance, ceiling, max_steps, sections, status):
    """Sections (k, periods, 2 n) of k states, which are overwritten; nan after the first period that fails."""
    work, none, ends, switches = new_work(packed.vectors.shape[1]), np.empty((0, 0)), np.empty(0), np.zeros(1, np.int64)
    for row in range(states.shape[0]):
        status[row] = COMPLETE
        for count in range(sections.shape[1]):
            if status[row] == COMPLETE:
                status[row] = _period(
                    packed,
                    states[row],
                    tolerance,
                    math.inf,
                    ceiling,
                    max_steps,
                    none,
                    0.0,
                    0.0,
                    none,
                    ends,
                    switches,
                    work,
                )
            for i in range(states.shape[1]):
                sections[row, count, i] = states[row, i] if status[row] == COMPLETE else math.nan


@kernel(
    types.int64(
        PACKED, ARRAY, types.int64, types.float64, types.float64, types.float64, MATRIX, ARRAY, types.int64[::1]
    )
)
def _measure(packed, state, periods, tolerance, ceiling, base, sums, extremes, switches):
    """Carry a state over some periods and gather extremes, switches and Fourier integrals."""
    work, none = new_work(packed.vectors.shape[1]), np.empty((0, 0))
    span = 2.0 * math.pi / packed.numbers[0]
    for count in range(periods):
        status = _period(
            packed,
            state,
            tolerance,
            math.inf,
            ceiling,
            MAX_STEPS,
            none,
            base,
            count * span,
            sums,
            extremes,
            switches,
            work,
        )
        if status != COMPLETE:
            return status
    return COMPLETE


@kernel(types.int64(PACKED, ARRAY, types.int64, types.float64, types.float64, MATRIX, ARRAY))
def _tangents(packed, state, periods, tolerance, ceiling, tangents, logarithms):
    """Carry a state and deviations over some periods.

    Where `logarithms` (periods,) is not empty, the first deviation is brought back to length 1 after every period and
    the logarithm of its length is kept.
    """
    work, none, ends, switches = new_work(packed.vectors.shape[1]), np.empty((0, 0)), np.empty(0), np.zeros(1, np.int64)
    longest = tangent_step_length(packed, tolerance)
    for count in range(periods):
        status = _period(
            packed, state, tolerance, longest, ceiling, MAX_STEPS, tangents, 0.0, 0.0, none, ends, switches, work
        )
        if status != COMPLETE:
            return status
        if logarithms.shape[0] > 0:
            length = 0.0
            for i in range(tangents.shape[1]):
                length += tangents[0, i] ** 2
            length = math.sqrt(length)
            logarithms[count] = math.log(length)
            for i in range(tangents.shape[1]):
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
    _advance(pack(system, omega), current, tolerance, ceiling, MAX_STEPS, sections, status)
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
    switches = np.zeros(1, np.int64)
    status = Status(
        _measure(
            pack(system, omega),
            current,
            periods,
            checked_tolerance(tolerance),
            checked_ceiling(ceiling),
            omega / divisor,
            sums,
            extremes,
            switches,
        )
    )
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
    The contact force is continuous, so that the matrices of the smooth pieces multiply (docs/physics.md, section 6.2).
    """
    current = checked_state(system, state)
    # Rows of the kernel's array are columns of the matrix.
    tangents = np.eye(current.size)
    status = _tangents(
        pack(system, omega),
        current,
        checked_count("periods", periods),
        checked_tolerance(tolerance),
        checked_ceiling(ceiling),
        tangents,
        np.empty(0),
    )
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
    tangent = np.ones(current.size) if direction is None else checked_state(system, direction, "direction")
    if not np.any(tangent):
        raise ParameterError("direction", direction, "other than 0")
    tangent, logarithms = (tangent / np.linalg.norm(tangent))[None], np.full(periods, np.nan)
    tolerance, ceiling = checked_tolerance(tolerance), checked_ceiling(ceiling)
    status = _tangents(pack(system, omega), current, periods, tolerance, ceiling, tangent, logarithms)
    return logarithms, current, Status(status)
