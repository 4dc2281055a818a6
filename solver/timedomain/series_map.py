"""The Poincare map where zones are not affine, as with a cubic spring: by the Taylor series of each motion.

What `solver.timedomain.section_map` does for all motions of a system at once is done here for one motion after another.
Deviations have the recurrence of the motion without its sources, in which 3 k_3 lambda^2 takes the place of k_3
lambda^2; they are carried over the motion's own steps.
"""

import math

import numpy as np

from solver.flow.switched_system import CUBIC, DASHPOT, FREQUENCY, SWITCHED_SYSTEM, SwitchedSystem, strength_of
from solver.flow.taylor import MOTION_ORDER, SERIES, column_at, new_series
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import copy_into
from solver.model.contact_system import ContactSystem
from solver.timedomain.integrator import CEILING, COMPLETE, TOO_MANY_STEPS, Status, advance_step, integrate, zone_of

__all__ = ["carry_by_series", "closed_by_series", "measured_by_series"]

_F, _I = types.float64, types.int64

# Steps of one period, and Gauss nodes of a step that integrate its polynomial times a slow cosine.
_MOST_STEPS, _NODES = 100_000, 24


@kernel(types.void(SWITCHED_SYSTEM, _I, _F, SERIES, ARRAY, MATRIX, ARRAY, ARRAY), inner=True)
def _carry_deviation(system, zone, step, series, bend, y, contact, deviation):
    """Carry a deviation (2 n,) over a step of a motion; `bend` holds the series of 3 k_3 lambda^2."""
    n, order = y.shape[1], y.shape[0] - 1
    first, strength = n * (zone % 3), strength_of(system, zone)
    second, varied = first + 3 * n, zone != 0 and system.variation.shape[0] > 0
    contact[0], contact[1] = 0.0, 0.0
    for i in range(n):
        y[0, i], y[1, i] = deviation[i], deviation[n + i]
        contact[0] += system.vectors[0, i] * y[0, i]
        contact[1] += system.vectors[0, i] * y[1, i]
    for j in range(order - 1):
        varying, curved = 0.0, 0.0
        for i in range(j + 1):
            curved += bend[i] * contact[j - i]
            if varied:
                varying += strength * series.stiffness[i] * contact[j - i]
        contact[j + 2] = 0.0
        for i in range(n):
            value = -system.vectors[2, i] * varying - system.vectors[1, i] * curved
            for l in range(n):
                value -= system.matrices[first + i, l] * y[j, l]
                value -= (j + 1.0) * system.matrices[second + i, l] * y[j + 1, l]
            y[j + 2, i] = value / ((j + 2.0) * (j + 1.0))
            contact[j + 2] += system.vectors[0, i] * y[j + 2, i]
    for i in range(n):
        value, slope = y[order, i], 0.0
        for j in range(order - 1, -1, -1):
            slope = slope * step + value
            value = value * step + y[j, i]
        deviation[i], deviation[n + i] = value, slope


@kernel(_I(SWITCHED_SYSTEM, ARRAY, MATRIX, _I, _F, _F, MATRIX))
def _carry(system, state, deviations, periods, tolerance, ceiling, sections):
    """Carry a state (2 n,) and deviations (k, 2 n) over periods, from tau = 0; `sections` (periods, 2 n) is filled."""
    n, span = system.vectors.shape[1], 2.0 * math.pi / system.numbers[FREQUENCY]
    series, bend = new_series(n), np.empty(MOTION_ORDER + 1)
    y, contact = np.empty((MOTION_ORDER + 1, n)), np.empty(MOTION_ORDER + 1)
    for period in range(periods):
        zone, time, whole = zone_of(system, state), 0.0, False
        for _ in range(_MOST_STEPS):
            step, after, status = advance_step(system, zone, time, span, tolerance, state, series)
            if status != COMPLETE:
                return status
            for j in range(MOTION_ORDER + 1 if deviations.shape[0] > 0 else 0):
                bend[j] = 0.0
                for i in range(j + 1):
                    bend[j] += 3.0 * system.numbers[CUBIC] * series.contact[i] * series.contact[j - i]
            jump = system.numbers[DASHPOT] * (strength_of(system, after) - strength_of(system, zone))
            for k in range(deviations.shape[0]):
                _carry_deviation(system, zone, step, series, bend, y, contact, deviations[k])
                seen = 0.0
                for i in range(n):
                    seen += system.vectors[0, i] * deviations[k, i]
                for i in range(n):
                    deviations[k, n + i] -= jump * system.vectors[1, i] * seen
            whole = after == zone and step >= span - time
            column_at(series, step, state)
            time, zone = time + step, after
            if whole:
                break
        if not whole:
            return TOO_MANY_STEPS
        displacement = 0.0
        for i in range(n):
            displacement += system.vectors[0, i] * state[i]
        if not abs(displacement) <= ceiling:
            return CEILING
        copy_into(sections[period], state)
    return COMPLETE


def carry_by_series(
    system: SwitchedSystem, state: np.ndarray, periods: int, tolerance: float, ceiling: float, *, deviations: bool
) -> tuple[np.ndarray, np.ndarray, Status]:
    """Sections of a motion over forcing periods from tau = 0, and their derivative by its initial state.

    Parameters
    ----------
    system : SwitchedSystem
    state : (2 n,) array
    periods : int
    tolerance, ceiling : float
        As for `solver.timedomain.advance`.
    deviations : bool
        Whether the derivative is wanted.

    Returns
    -------
    sections : (periods, 2 n) array
        nan from the first that was not reached.
    matrix : (2 n, 2 n) array
        Of the last section; without rows if it is not wanted.
    status : Status
    """
    columns, sections = np.eye(state.size)[: state.size if deviations else 0], np.full((periods, state.size), np.nan)
    columns = np.ascontiguousarray(columns)
    status = Status(_carry(system, state.copy(), columns, periods, tolerance, ceiling, sections))
    return sections, columns.T.copy(), status


def closed_by_series(
    system: SwitchedSystem, state: np.ndarray, period: int, tolerance: float, iterations: int, accuracy: float
) -> tuple[np.ndarray, np.ndarray | None, float, int, int]:
    """The periodic orbit near a state, by Newton's method with steps halved up to six times while the gap grows.

    Parameters
    ----------
    system : SwitchedSystem
    state : (2 n,) array
    period : int
    tolerance : float
        As for `solver.timedomain.shoot`.
    iterations : int
        Of Newton's method.
    accuracy : float
        Tolerance of the integration.

    Returns
    -------
    state : (2 n,) array
    matrix : (2 n, 2 n) array or None
        The monodromy matrix; None if the motion from the last iterate cannot be integrated.
    gap : float
        Distance of the orbit's ends.
    steps, shortest : int
        Newton's steps, and the smallest divisor of the period after which the orbit repeats.
    """
    ceiling = 1e8 * max(1.0, float(np.max(np.abs(state))))

    def carried(start: np.ndarray, periods: int):
        sections, matrix, status = carry_by_series(system, start, periods, accuracy, ceiling, deviations=True)
        gap = sections[-1] - start
        return (gap, matrix) if status is Status.COMPLETE else (np.full(start.size, np.inf), None)

    gap, matrix = carried(state, period)
    if matrix is None:
        return state, None, np.nan, 0, period
    steps = 0
    while steps < iterations and np.max(np.abs(gap)) > 1e-14 * max(1.0, np.max(np.abs(state))):
        equation = np.eye(state.size) - matrix
        if np.linalg.det(equation) == 0.0:
            break
        correction, size, closer = np.linalg.solve(equation, gap), np.max(np.abs(gap)), False
        for halving in range(7):
            trial = state + 0.5**halving * correction
            trial_gap, trial_matrix = carried(trial, period)
            if trial_matrix is not None and np.max(np.abs(trial_gap)) < size:
                state, gap, matrix, closer = trial, trial_gap, trial_matrix, True
                break
            if size <= tolerance * max(1.0, np.max(np.abs(state))):
                break
        steps += 1
        if not closer:
            break
    shortest = period
    for divisor in range(period - 1, 0, -1):
        if period % divisor == 0:
            part, slope = carried(state, divisor)
            if slope is not None and np.max(np.abs(part)) < 1e3 * tolerance * max(1.0, np.max(np.abs(slope))):
                shortest = divisor
    return state, matrix, float(np.max(np.abs(gap))), steps, shortest


def measured_by_series(
    system: ContactSystem, omega: float, state: np.ndarray, periods: int, rates: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray, float, float, int, Status]:
    """What a motion does over some periods.

    Parameters
    ----------
    system : ContactSystem
    omega : float
    state : (2 n,) array
    periods : int
    rates : (k,) array
        Frequencies at which lambda is integrated.
    tolerance : float

    Returns
    -------
    state : (2 n,) array
        At the end.
    integrals : (k,) complex array
        Of lambda exp(-i rate tau).
    lowest, highest : float
    switches : int
    status : Status
    """
    span, integrals = 2.0 * math.pi / omega, np.zeros(rates.size, complex)
    lowest, highest, switches = math.inf, -math.inf, 0
    for period in range(periods):
        motion = integrate(system, omega, state, 0.0, span, tolerance=tolerance, max_steps=_MOST_STEPS)
        if motion.status is not Status.COMPLETE:
            return state, integrals, math.nan, math.nan, 0, motion.status
        lengths = np.diff(motion.times)
        nodes, weights = np.polynomial.legendre.leggauss(_NODES + int(np.max(rates, initial=0.0) * np.max(lengths)))
        for begin, length, series in zip(motion.times[:-1], lengths, motion.series, strict=True):
            local = 0.5 * length * (nodes + 1.0)
            place = np.polynomial.polynomial.polyval(local, series)
            turns = np.exp(-1j * np.multiply.outer(rates, period * span + begin + local))
            integrals += 0.5 * length * turns @ (weights * place)
            # In units of the step the coefficients have the sizes of what they contribute.
            turning = np.polynomial.polynomial.polyder(series * length ** np.arange(series.size))
            roots = np.roots(np.trim_zeros(turning[::-1], "f"))
            roots = roots.real[(np.abs(roots.imag) < 1e-6) & (roots.real > 0.0) & (roots.real < 1.0)]
            ends = np.polynomial.polynomial.polyval(length * np.concatenate([[0.0, 1.0], roots]), series)
            lowest, highest = min(lowest, float(ends.min())), max(highest, float(ends.max()))
        switches, state = switches + motion.switch_times.size, motion.states[-1]
    return state, integrals, lowest, highest, switches, Status.COMPLETE
