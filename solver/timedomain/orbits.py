"""Newton's method on the Poincare map, for kernels: the periodic orbit near a state, with its monodromy matrix.

    orbit = new_orbit(flows)                             once; allocates
    status = close_orbit(flows, state, periods, ..., orbit, room)       as often as wanted

An iteration takes one motion over the period with its 2 n deviations, some microseconds.
"""

import math
from typing import NamedTuple

import numpy as np

from solver.explained import Explained
from solver.flow.zone_flows import ZONE_FLOWS
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import copy_into, eliminate
from solver.timedomain.integrator import COMPLETE
from solver.timedomain.section_map import MAP_ROOM, carry_period

__all__ = ["ORBIT", "Orbit", "ShootingStatus", "carry_orbit", "close_orbit", "minimal_period", "new_orbit"]

_F, _I = types.float64, types.int64


class ShootingStatus(Explained):
    """How the search for a periodic orbit ended."""

    CONVERGED = 0, "The orbit closes to the tolerance."
    NOT_CONVERGED = 1, "Newton's method did not close the orbit."
    INTEGRATION_FAILED = 2, "The motion from the last iterate could not be integrated."


CONVERGED, NOT_CONVERGED, INTEGRATION_FAILED = map(int, ShootingStatus)


class Orbit(NamedTuple):
    """What `close_orbit` works in, and its result: `matrix` (2 n, 2 n), the monodromy matrix over the period, and
    `outcome` (2,): the distance between the orbit's end and start, and the number of iterations."""

    matrix: np.ndarray
    outcome: np.ndarray
    tangents: np.ndarray
    system: np.ndarray
    correction: np.ndarray
    trial: np.ndarray
    end: np.ndarray


ORBIT = types.NamedTuple((MATRIX, ARRAY, MATRIX, MATRIX, ARRAY, ARRAY, ARRAY), Orbit)


@kernel(ORBIT(ZONE_FLOWS), inner=True, shared=True)
def new_orbit(flows):
    """Room for orbits along flows of so many coordinates."""
    size = flows.backward.shape[2]
    return Orbit(
        np.empty((size, size)),
        np.empty(2),
        np.empty((size, size)),
        np.empty((size, size)),
        np.empty(size),
        np.empty(size),
        np.empty(size),
    )


@kernel(_I(ZONE_FLOWS, _I, _F, ORBIT, MAP_ROOM), inner=True)
def carry_orbit(flows, periods, ceiling, orbit, room):
    """Carry `orbit.end` over some periods, and the unit matrix in `orbit.tangents` with it; the status."""
    tangents = orbit.tangents
    for i in range(tangents.shape[0]):
        for j in range(tangents.shape[0]):
            tangents[i, j] = 1.0 if i == j else 0.0
    for _ in range(periods):
        status, _ = carry_period(flows, orbit.end, tangents, tangents[:0], ceiling, room)
        if status != COMPLETE:
            return status
    return COMPLETE


@kernel(_F(ARRAY, ARRAY), inline=True)
def _distance(left, right):
    largest = 0.0
    for i in range(left.shape[0]):
        gap = abs(left[i] - right[i])
        # A gap that is not a number is one.
        largest = largest if gap <= largest else gap
    return largest


@kernel(_F(ARRAY), inline=True)
def _scale(state):
    largest = 1.0
    for i in range(state.shape[0]):
        largest = max(largest, abs(state[i]))
    return largest


@kernel(_I(ZONE_FLOWS, ARRAY, _I, _F, _I, _I, _F, ORBIT, MAP_ROOM), inner=True)
def close_orbit(flows, state, periods, tolerance, iterations, halvings, ceiling, orbit, room):
    """The periodic orbit near a state.

    Parameters
    ----------
    flows : ZoneFlows
    state : (2 n,) array
        y, then y', at tau = 0; overwritten by that of the orbit, or of the last iterate.
    periods : int
        Forcing periods of the orbit.
    tolerance : float
        The orbit is closed when its ends differ by less than this times max(1, |state|). Newton goes on to rounding
        as long as the gap falls.
    iterations, halvings : int
        Newton's steps, and how often each is halved while it does not shorten the gap.
    ceiling : float
        As for `carry_period`.
    orbit : Orbit
        Its matrix and outcome are those of the returned state.
    room : MapRoom

    Returns
    -------
    int
        `ShootingStatus`.
    """
    trial, end, outcome, n = orbit.trial, orbit.end, orbit.outcome, state.shape[0]
    outcome[0], outcome[1] = math.nan, 0.0
    copy_into(end, state)
    if carry_orbit(flows, periods, ceiling, orbit, room) != COMPLETE:
        return INTEGRATION_FAILED
    gap, wanted = _distance(end, state), tolerance * _scale(state)
    _keep(orbit)
    for iteration in range(iterations):
        if gap <= 1e-14 * _scale(state):
            break
        # (1 - M) x = end - state
        for i in range(n):
            orbit.correction[i] = end[i] - state[i]
            for j in range(n):
                orbit.system[i, j] = (1.0 if i == j else 0.0) - orbit.matrix[i, j]
        if not abs(eliminate(orbit.system, orbit.correction)) > 0.0:
            break
        factor, shorter = 1.0, False
        for _ in range(halvings + 1):
            for i in range(n):
                trial[i] = state[i] + factor * orbit.correction[i]
            copy_into(end, trial)
            if carry_orbit(flows, periods, ceiling, orbit, room) == COMPLETE and _distance(end, trial) < gap:
                shorter = True
                break
            # Below the tolerance a longer gap is rounding and nothing is left to gain.
            if gap <= wanted:
                break
            factor *= 0.5
        outcome[1] = iteration + 1.0
        if not shorter:
            break
        gap = _distance(end, trial)
        copy_into(state, trial)
        wanted = tolerance * _scale(state)
        _keep(orbit)
    outcome[0] = gap
    return CONVERGED if gap <= wanted else NOT_CONVERGED


@kernel(types.void(ORBIT), inline=True)
def _keep(orbit):
    """Rows of the tangents are columns of the matrix."""
    for i in range(orbit.matrix.shape[0]):
        for j in range(orbit.matrix.shape[0]):
            orbit.matrix[i, j] = orbit.tangents[j, i]


@kernel(_I(ZONE_FLOWS, ARRAY, _I, _F, _F, ORBIT, MAP_ROOM), inner=True)
def minimal_period(flows, state, periods, tolerance, ceiling, orbit, room):
    """The smallest divisor of so many periods after which an orbit of `close_orbit` repeats.

    `orbit.matrix` is kept.
    """
    for divisor in range(1, periods):
        if periods % divisor != 0:
            continue
        copy_into(orbit.end, state)
        if carry_orbit(flows, divisor, ceiling, orbit, room) != COMPLETE:
            continue
        # A gap over a part of the period betrays a shorter orbit only if it is no larger than Newton's own error.
        size = _scale(state)
        for i in range(state.shape[0]):
            size = max(size, _scale(orbit.tangents[i]))
        if _distance(orbit.end, state) < 1e3 * tolerance * size:
            return divisor
    return periods
