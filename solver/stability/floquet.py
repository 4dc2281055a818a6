"""Floquet multipliers of a given periodic motion, from its monodromy matrix.

A motion u = (Lambda_0, c_1, s_1, ...) of theta = Omega tau/nu need not be a true one: it tells when there is contact,
exactly. f is continuous, so that the monodromy matrix is the product of smooth pieces between contact switches
(docs/physics.md, section 6). Each piece is integrated by the Taylor series of the solution, which are entire: their
coefficients follow from a recurrence, the rank-one contact term needs one product of scalar series, and the last terms
tell the step (Jorba and Zou, Experimental Mathematics 14, 2005). Where the coefficients are constant this is the scaled
series of the exponential.
"""

import math

import numpy as np
from numba import types

from solver.contact.spectrum import COMPLEX, contact_arcs
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.model.contact_system import ContactSystem
from solver.model.gear_model import Model
from solver.stability.system_row import SystemRow, system_row

__all__ = ["SYSTEMS", "contact_shares", "monodromies", "motion_multipliers", "multipliers"]

_I, _F = types.int64, types.float64
_CUBE = types.float64[:, :, ::1]

#: Signature of `SystemRow.systems`.
SYSTEMS = (_CUBE, _CUBE, MATRIX, MATRIX, MATRIX, types.complex128[:, ::1])

# Terms of the series, and the size of the last ones against the first: together they cost least near these values, and
# leave about 1e-12 in the matrix over a period.
_ORDER = 20
_TOLERANCE = 1e-14
_TURN = 2.0 * math.pi


@kernel(
    types.void(MATRIX, MATRIX, ARRAY, ARRAY, ARRAY, COMPLEX, _F, types.boolean, _F, _F, MATRIX, _CUBE, MATRIX, ARRAY),
    inner=True,
)
def _advance(damping, stiffness, force, varying, contact, phasors, omega, closed, begin, end, state, y, reach, wave):
    """Advance the 2n solutions in the columns of `state` (displacements above velocities) from one time to another.

    y (order + 1, n, 2n), reach (order + 1, 2n) and wave (order + 1,) are work arrays: the series of y, lambda and s.
    """
    n, columns = force.shape[0], 2 * force.shape[0]
    varied = False
    if closed:
        for l in range(phasors.shape[0]):
            varied = varied or phasors[l] != 0.0
    time = begin
    pulse = np.empty(columns)
    while time < end:
        for i in range(n):
            for column in range(columns):
                y[0, i, column], y[1, i, column] = state[i, column], state[n + i, column]
        if varied:
            wave[:] = 0.0
            for l in range(phasors.shape[0]):
                rate = (l + 1) * omega
                real, imag = math.cos(rate * time), math.sin(rate * time)
                term = phasors[l] * complex(real, imag)
                for j in range(_ORDER - 1):
                    wave[j] += term.real
                    term = term * complex(0.0, rate / (j + 1))
        for j in range(_ORDER - 1):
            if closed:
                for column in range(columns):
                    reach[j, column] = 0.0
                    pulse[column] = 0.0
                for i in range(n):
                    for column in range(columns):
                        reach[j, column] += contact[i] * y[j, i, column]
                if varied:
                    for i in range(j + 1):
                        for column in range(columns):
                            pulse[column] += wave[i] * reach[j - i, column]
            factor = -1.0 / ((j + 1) * (j + 2))
            for i in range(n):
                for column in range(columns):
                    y[j + 2, i, column] = 0.0
                if closed:
                    for column in range(columns):
                        y[j + 2, i, column] = force[i] * reach[j, column] + varying[i] * pulse[column]
                for l in range(n):
                    drag, spring = (j + 1) * damping[i, l], stiffness[i, l]
                    for column in range(columns):
                        y[j + 2, i, column] += drag * y[j + 1, l, column] + spring * y[j, l, column]
                for column in range(columns):
                    y[j + 2, i, column] *= factor
        first, before, last = 0.0, 0.0, 0.0
        for i in range(n):
            for column in range(columns):
                first = max(first, abs(y[0, i, column]), abs(y[1, i, column]))
                before = max(before, abs(y[_ORDER - 1, i, column]))
                last = max(last, abs(y[_ORDER, i, column]))
        step = end - time
        if before > 0.0:
            step = min(step, (_TOLERANCE * first / before) ** (1.0 / (_ORDER - 1)))
        if last > 0.0:
            step = min(step, (_TOLERANCE * first / last) ** (1.0 / _ORDER))
        for i in range(n):
            for column in range(columns):
                state[i, column], state[n + i, column] = y[_ORDER, i, column], _ORDER * y[_ORDER, i, column]
        for j in range(_ORDER - 1, -1, -1):
            for i in range(n):
                for column in range(columns):
                    state[i, column] = state[i, column] * step + y[j, i, column]
        for j in range(_ORDER - 1, 0, -1):
            for i in range(n):
                for column in range(columns):
                    state[n + i, column] = state[n + i, column] * step + j * y[j, i, column]
        if not (step < end - time and step > 0.0):
            return
        time += step


@kernel(types.void(*SYSTEMS, types.int64[::1], ARRAY, MATRIX, MATRIX, _I, _CUBE))
def _monodromies(damping, stiffness, force, varying, contact, phasors, which, omega, gaps, motions, period, found):
    """Fill found (k, 2n, 2n) with the monodromy matrices of `motions` (k, 2 H + 1)."""
    n, columns = force.shape[1], 2 * force.shape[1]
    room = 2 * motions.shape[1] + 8
    angles, zones = np.empty(room), np.empty(room, np.int64)
    y, reach, wave = np.empty((_ORDER + 1, n, columns)), np.empty((_ORDER + 1, columns)), np.empty(_ORDER + 1)
    for k in range(motions.shape[0]):
        g, state = which[k], found[k]
        state[:] = 0.0
        for i in range(columns):
            state[i, i] = 1.0
        count = contact_arcs(motions[k], gaps[k, 0], gaps[k, 1], angles, zones)
        # A motion that starts in the middle of a piece: the piece before the first switch is the end of the last one.
        zone, begin = zones[max(count - 1, 0)], 0.0
        for piece in range(count + 1):
            end = angles[piece] if piece < count else _TURN
            if end > begin:
                scale = period / omega[k]
                _advance(
                    damping[g],
                    stiffness[g],
                    force[g],
                    varying[g],
                    contact[g],
                    phasors[g],
                    omega[k],
                    zone != 0,
                    begin * scale,
                    end * scale,
                    state,
                    y,
                    reach,
                    wave,
                )
            if piece < count:
                zone, begin = zones[piece], angles[piece]


@kernel(types.void(MATRIX, MATRIX, ARRAY))
def _contact_shares(gaps, motions, found):
    room = 2 * motions.shape[1] + 8
    angles, zones = np.empty(room), np.empty(room, np.int64)
    for k in range(motions.shape[0]):
        count = contact_arcs(motions[k], gaps[k, 0], gaps[k, 1], angles, zones)
        if count == 0:
            found[k] = abs(zones[0])
            continue
        closed = 0.0
        for i in range(count):
            if zones[i] != 0:
                closed += (angles[i + 1] if i + 1 < count else angles[0] + _TURN) - angles[i]
        # Exactly 0 and 1 are for motions that never switch.
        found[k] = min(max(closed / _TURN, 1e-12), 1.0 - 1e-12)


def contact_shares(row: SystemRow, motions: np.ndarray) -> np.ndarray:
    """Share of the period in contact, (k,): exactly 1 for motions always in it, exactly 0 for those never in it."""
    found = np.empty(len(motions))
    _contact_shares(row.gaps, np.ascontiguousarray(motions, dtype=float), found)
    return found


def monodromies(row: SystemRow, motions: np.ndarray, period: int = 1) -> np.ndarray:
    """Monodromy matrices over the period nu 2 pi/Omega from theta = 0.

    Parameters
    ----------
    row : SystemRow
        Of k motions.
    motions : (k, 2 H + 1) array
        (Lambda_0, c_1, s_1, ...) of harmonics of Omega/nu.
    period : int
        nu.

    Returns
    -------
    (k, 2n, 2n) array
        On the states (y, y').
    """
    found = np.empty((len(motions), row.states, row.states))
    _monodromies(
        *row.systems, row.which, row.omega, row.gaps, np.ascontiguousarray(motions, dtype=float), period, found
    )
    return found


def multipliers(row: SystemRow, motions: np.ndarray, period: int = 1) -> np.ndarray:
    """Floquet multipliers, the eigenvalues of `monodromies`: complex (k, 2n), conjugates side by side."""
    return np.linalg.eigvals(monodromies(row, motions, period)).astype(complex)


def motion_multipliers(system: Model | ContactSystem, omega, motions, period: int = 1) -> np.ndarray:
    """Floquet multipliers of motions of one system.

    Parameters
    ----------
    system : Model or ContactSystem
        A gear pair is taken with equal supports merged (`gear_system`): the multipliers left out are those of the
        supports' motion across the contact direction, exp[(-xi_j +- sqrt(xi_j^2 - k_j)) nu 2 pi/Omega].
    omega : float or (k,) array
        Frequency of the forcing.
    motions : (2 H + 1,) or (k, 2 H + 1) array
    period : int
        nu.

    Returns
    -------
    (2n,) or (k, 2n) complex array
    """
    many = np.atleast_2d(np.asarray(motions, dtype=float))
    row = system_row(system, "omega", np.broadcast_to(np.asarray(omega, dtype=float), len(many)))
    found = multipliers(row, many, period)
    return found[0] if np.ndim(motions) == 1 else found
