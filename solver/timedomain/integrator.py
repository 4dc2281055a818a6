"""Direct integration of a system with one contact, with located contact switches.

Each step uses the law of one zone (back contact, free, front contact) and ends, at the latest, where the motion leaves
that zone. Where the dead zone is empty the system is linear and has one zone.
"""

import enum
import math
from dataclasses import dataclass

import numpy as np

from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import copy_into
from solver.model.checks import ParameterError, finite_array, finite_number, instance_of, whole_number
from solver.model.contact_system import ContactSystem
from solver.timedomain.polynomial import evaluate, first_exit
from solver.timedomain.taylor import ORDER, PACKED, WORK, land, new_work, pack, series, step_length

__all__ = ["Status", "Trajectory", "Zone", "advance_step", "checked_states", "integrate", "zone_of"]

COMPLETE, STEP_TOO_SMALL, NOT_FINITE, TOO_MANY_STEPS, CEILING = 0, 1, 2, 3, 4


class Status(enum.IntEnum):
    """How an integration ended."""

    COMPLETE = COMPLETE
    STEP_TOO_SMALL = STEP_TOO_SMALL
    NOT_FINITE = NOT_FINITE
    TOO_MANY_STEPS = TOO_MANY_STEPS
    CEILING = CEILING

    @property
    def sentence(self) -> str:
        """What happened, for the reader of a log."""
        return _SENTENCES[self]


_SENTENCES = {
    Status.COMPLETE: "The integration reached its end.",
    Status.STEP_TOO_SMALL: "The step that the tolerance asks for is lost in rounding.",
    Status.NOT_FINITE: "The motion is not finite any more.",
    Status.TOO_MANY_STEPS: "The integration needs more steps than there is room for.",
    Status.CEILING: "The motion rose above the ceiling of the contact coordinate.",
}


class Zone(enum.IntEnum):
    """Where the contact coordinate is."""

    BACK = -1
    FREE = 0
    FRONT = 1


@kernel(types.int64(PACKED, ARRAY), inner=True)
def zone_of(packed, state):
    """The zone that a state is in; on a border, the one that it moves into."""
    n = packed.vectors.shape[1]
    low, high = packed.numbers[1], packed.numbers[2]
    if packed.numbers[4] != 0.0:
        return 1
    value, slope = 0.0, 0.0
    for i in range(n):
        value += packed.vectors[0, i] * state[i]
        slope += packed.vectors[0, i] * state[n + i]
    if value > high or (value == high and slope > 0.0):
        return 1
    if value < low or (value == low and slope < 0.0):
        return -1
    return 0


@kernel(
    types.Tuple((types.float64, types.int64, types.int64))(
        PACKED, types.int64, types.float64, types.float64, types.float64, types.float64, ARRAY, WORK
    ),
    inner=True,
)
def advance_step(packed, zone, time, stop, tolerance, longest, state, work):
    """Series of the motion from (time, state), and how far it may be used.

    Parameters
    ----------
    packed : Packed
    zone : int
    time, stop, tolerance : float
    longest : float
        No step is longer.
    state : (2 n,) array
    work : Work

    Returns
    -------
    step : float
        At most stop - time; the series is in `work`. Not positive and finite if there is none.
    zone : int
        The zone at the end of the step; another one if the step ends at a contact switch.
    status : int
    """
    series(packed, zone, time, state, work)
    step = step_length(packed, state, tolerance, work)
    if not (step > 0.0 and math.isfinite(work.contact[-1])):
        return 0.0, zone, NOT_FINITE
    step = min(step, longest, stop - time)
    if time + step == time:
        return 0.0, zone, STEP_TOO_SMALL
    if packed.numbers[4] != 0.0:
        return step, zone, COMPLETE
    low = packed.numbers[2] if zone > 0 else (packed.numbers[1] if zone == 0 else -math.inf)
    high = packed.numbers[1] if zone < 0 else (packed.numbers[2] if zone == 0 else math.inf)
    step, side = first_exit(work.contact, step, low, high)
    return step, zone + side, COMPLETE


@kernel(
    types.UniTuple(types.int64, 3)(
        PACKED, ARRAY, types.float64, types.float64, types.float64, MATRIX, ARRAY, MATRIX, types.int64[::1]
    )
)
def _integrate(packed, start, begin, stop, tolerance, series_table, times, states, zones):
    """Fill times (m + 1,), states (m + 1, 2 n), zones (m + 1,) of the steps and the series of lambda (m, ORDER + 1).

    Returns the status, the number of steps and the zone at the end. Steps of length 0 (switches that follow at once)
    are kept: they are switches.
    """
    room, n = series_table.shape[0], packed.vectors.shape[1]
    work, state = new_work(n), start.copy()
    zone, time, count = zone_of(packed, state), begin, 0
    times[0] = time
    copy_into(states[0], state)
    while time < stop:
        if count == room:
            return TOO_MANY_STEPS, count, zone
        step, after, status = advance_step(packed, zone, time, stop, tolerance, math.inf, state, work)
        if status != COMPLETE:
            return status, count, zone
        land(work, step, state)
        last = after == zone and step >= stop - time
        time = stop if last else time + step
        zones[count] = zone
        copy_into(series_table[count], work.contact)
        count += 1
        times[count] = time
        copy_into(states[count], state)
        zone = after
    return COMPLETE, count, zone


@kernel(types.float64[::1](MATRIX, ARRAY, types.int64[::1], ARRAY))
def _dense(series_table, times, steps, at):
    """lambda at times, each within the named step."""
    values = np.empty(at.shape[0])
    for i in range(at.shape[0]):
        values[i], _ = evaluate(series_table[steps[i]], at[i] - times[steps[i]])
    return values


@dataclass(frozen=True, eq=False)
class Trajectory:
    """One integrated motion.

    Parameters
    ----------
    times : (m + 1,) array
        tau at the start and at the end of every step.
    states : (m + 1, 2 n) array
        y, then y', at these times.
    zones : (m,) int array
        `Zone` of every step.
    switch_times : (s,) array
        Contact switches.
    switch_zones : (s,) int array
        `Zone` after each of them.
    status : Status
        Where it is not COMPLETE, the arrays hold the motion up to there.
    series : (m, ORDER + 1) array
        Taylor coefficients of lambda from the start of each step.
    """

    times: np.ndarray
    states: np.ndarray
    zones: np.ndarray
    switch_times: np.ndarray
    switch_zones: np.ndarray
    status: Status
    series: np.ndarray

    def displacement(self, at) -> np.ndarray:
        """lambda at times within the trajectory, as accurate as the states.

        Raises
        ------
        ParameterError
            If a time lies outside.
        """
        at = finite_array("at", at, None)
        if not (np.all(at >= self.times[0]) and np.all(at <= self.times[-1])) or self.zones.size == 0:
            raise ParameterError("at", at, f"within the trajectory, from {self.times[0]} to {self.times[-1]}")
        flat = np.ascontiguousarray(at.ravel())
        steps = np.clip(np.searchsorted(self.times, flat, side="right") - 1, 0, self.zones.size - 1)
        return _dense(self.series, self.times, steps, flat).reshape(at.shape)


def checked_states(system: ContactSystem, states, name: str = "states") -> np.ndarray:
    """Initial states as a fresh (k, 2 n) array; one state may come as (2 n,).

    Parameters
    ----------
    system : ContactSystem
    states : (k, 2 n) or (2 n,) array_like
        y, then y'.
    name : str
        The parameter as the user knows it.

    Raises
    ------
    ParameterError
        If they are not finite numbers of that shape.
    """
    size = 2 * instance_of("system", system, ContactSystem).degrees
    array = np.atleast_2d(finite_array(name, states, None))
    if array.ndim != 2 or array.shape[1] != size:
        raise ParameterError(name, states, f"finite numbers, {size} for each state (y, y')")
    return array


def checked_state(system: ContactSystem, state, name: str = "state") -> np.ndarray:
    """One initial state as a fresh (2 n,) array.

    Parameters
    ----------
    system : ContactSystem
    state : (2 n,) array_like
        y, then y'.
    name : str
        The parameter as the user knows it.

    Raises
    ------
    ParameterError
        If it is none.
    """
    states = checked_states(system, state, name)
    if len(states) != 1:
        raise ParameterError(name, state, "one state")
    return states[0]


def checked_tolerance(tolerance: float, name: str = "tolerance") -> float:
    """A tolerance of the integration.

    Raises
    ------
    ParameterError
        If it is not from 1e-15 to 1e-2.
    """
    return finite_number(name, tolerance, at_least=1e-15, at_most=1e-2)


def integrate(
    system: ContactSystem,
    omega: float,
    state,
    start: float,
    stop: float,
    *,
    tolerance: float = 1e-10,
    max_steps: int = 100_000,
) -> Trajectory:
    """Motion from one state.

    Parameters
    ----------
    system : ContactSystem
    omega : float
        Frequency Omega of load and stiffness variation.
    state : (2 n,) array_like
        y, then y', at `start`.
    start, stop : float
        Times tau; stop must not be before start.
    tolerance : float
        Truncation error of one step relative to max(|state|, gaps, load amplitude).
    max_steps : int

    Returns
    -------
    Trajectory

    Raises
    ------
    ParameterError
        If an argument is not allowed. A motion that cannot be continued is told by the status.
    """
    initial = checked_state(system, state)
    start = finite_number("start", start)
    stop = finite_number("stop", stop, at_least=start)
    max_steps = whole_number("max_steps", max_steps, 1, 10**8)
    tolerance = checked_tolerance(tolerance)
    packed, room = pack(system, omega), min(256, max_steps)
    while True:
        table = np.empty((room, ORDER + 1))
        times, states, zones = np.empty(room + 1), np.empty((room + 1, initial.size)), np.empty(room, np.int64)
        status, count, end = _integrate(packed, initial, start, stop, tolerance, table, times, states, zones)
        if status != TOO_MANY_STEPS or room == max_steps:
            break
        # Cheaper than to grow the arrays within the kernel: the first attempts are small.
        room = min(8 * room, max_steps)
    zones = zones[:count].copy()
    following = np.append(zones[1:], end)[:count]
    switches = np.flatnonzero(following != zones)
    return Trajectory(
        times[: count + 1].copy(),
        states[: count + 1].copy(),
        zones,
        times[switches + 1],
        following[switches],
        Status(status),
        table[:count].copy(),
    )
