"""The quantities of a motion (`solver.contact.quantities`) by integration over its own period.

Within a step lambda, the other coordinates, the stiffness and the error are polynomials of sixteen coefficients
(`solver.flow.zone_flows`), so that the transmission error, the supports' forces and the mesh force k_t f are too.
Extremes are taken from their Bernstein coefficients, integrals of squares from the Gram matrix of that basis: nothing
is sampled.

For kernels:

    gauge = gauge_at(parameters, parameter_slope, p, False)     of `solver.timedomain.gauge`; allocates
    work = new_work(flows)                                 once for systems of one size; allocates
    clear(work)
    gather(flows, gauge, steps, count, work, room)         after each `carry_period` that kept its steps
    read(gauge, work, values)                              the numbers, by `solver.contact.quantities.Slot`
"""

import math
from typing import NamedTuple

import numpy as np

from solver.contact.quantities import Quantities, Slot
from solver.flow.switched_system import DASHPOT, FREQUENCY, HIGH, LOW, strength_of
from solver.flow.zone_flows import COEFFICIENTS, ZONE_FLOWS, apply_map, change_basis
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import copy_into
from solver.model.checks import frequency, instance_of, whole_number
from solver.model.contact_system import ContactSystem, gear_system, support_kinds
from solver.model.gear_model import Model
from solver.model.packing import packed
from solver.timedomain.bernstein import restrict, widen_by_hull
from solver.timedomain.gauge import GAUGE, Gauge, gauge_at, system_gauges
from solver.timedomain.integrator import COMPLETE, Status, checked_state, checked_tolerance
from solver.timedomain.poincare import checked_flows
from solver.timedomain.section_map import (
    BEGIN,
    END,
    MAP_ROOM,
    ROW,
    STATE,
    carry_period,
    hull_of_step,
    new_room,
    new_steps,
    widen_over,
)
from solver.timedomain.shooting import ShootingStatus, shoot

__all__ = ["QUANTITY_WORK", "Quantities", "clear", "gather", "motion_quantities", "new_work", "read"]

_F, _I = types.float64, types.int64


class _Work(NamedTuple):
    """What `gather` works in: `totals`, and polynomials over an interval: powers (16,), those of all components of the
    state (2 n, 16), and Bernstein coefficients over an interval and over a step."""

    totals: np.ndarray
    powers: np.ndarray
    state: np.ndarray
    whole: np.ndarray
    hull: np.ndarray


QUANTITY_WORK = types.NamedTuple((ARRAY, ARRAY, MATRIX, ARRAY, ARRAY), _Work)

# Slots of `totals`: pairs of extremes, then time, and integrals of the deviation from a first value and of its square.
_LAMBDA, _PSI, _FORCE, _SUPPORT, _TIME, _FREE, _IMPACT, _ZONE = 0, 2, 4, 6, 8, 9, 10, 11
_LAMBDA_FIRST, _LAMBDA_SUM, _LAMBDA_SQUARE, _PSI_FIRST, _PSI_SUM, _PSI_SQUARE, _TOTALS = range(12, 19)


def _gram() -> np.ndarray:
    """Integrals over [0, 1] of products of two functions of the basis, (16, 16)."""
    degree = COEFFICIENTS - 1
    choose = np.array([math.comb(degree, i) for i in range(COEFFICIENTS)], dtype=float)
    both = np.array([[math.comb(2 * degree, i + j) for j in range(COEFFICIENTS)] for i in range(COEFFICIENTS)])
    return choose[:, None] * choose / both / (2.0 * degree + 1.0)


_GRAM = _gram()


@kernel(QUANTITY_WORK(ZONE_FLOWS), inner=True)
def new_work(flows):
    """Room for `gather` along flows of so many coordinates."""
    size = flows.backward.shape[2]
    return _Work(
        np.empty(_TOTALS),
        np.empty(COEFFICIENTS),
        np.empty((size, COEFFICIENTS)),
        np.empty(COEFFICIENTS),
        np.empty(COEFFICIENTS),
    )


@kernel(types.void(QUANTITY_WORK), inner=True)
def clear(work):
    """Begin with nothing gathered."""
    totals = work.totals
    for i in range(_TOTALS):
        totals[i] = 0.0
    for pair in (_LAMBDA, _PSI, _FORCE, _SUPPORT):
        totals[pair], totals[pair + 1] = math.inf, -math.inf
    # Not yet known, as are the values that integrals count from.
    totals[_ZONE], totals[_LAMBDA_FIRST], totals[_PSI_FIRST] = math.nan, math.nan, math.nan


@kernel(types.void(QUANTITY_WORK, _I, _F), inline=True)
def _integrate(work, first, length):
    """Add the integrals of the polynomial of `work.hull`, less a constant, and of its square, to three slots."""
    totals, hull, total, square = work.totals, work.hull, 0.0, 0.0
    if math.isnan(totals[first]):
        totals[first] = hull[0]
    for i in range(hull.shape[0]):
        value, row = hull[i] - totals[first], 0.0
        for j in range(hull.shape[0]):
            row += _GRAM[i, j] * (hull[j] - totals[first])
        total += value
        square += value * row
    totals[first + 1] += length * total / COEFFICIENTS
    totals[first + 2] += length * square


@kernel(types.void(ZONE_FLOWS, ARRAY, _I, QUANTITY_WORK, MAP_ROOM), inline=True)
def _widen(flows, step, pair, work, room):
    """Widen a pair of extremes by the polynomial of `work.powers`, and leave its hull over the step in `work.hull`."""
    begin, end = step[BEGIN], step[END]
    change_basis(work.powers, work.whole)
    restrict(work.whole, -1.0, 1.0, begin, end, work.hull)
    pair_of = work.totals[pair : pair + 2]
    widen_by_hull(work.hull, work.powers, begin, end, flows.slack[0], pair_of, room.piece)


@kernel(types.void(ZONE_FLOWS, ARRAY, QUANTITY_WORK), inline=True)
def _expand(flows, step, work):
    """Fill in the powers of all components of the state over a step."""
    row, size = int(step[ROW]), work.state.shape[0]
    for r in range(size):
        for j in range(COEFFICIENTS):
            total = flows.forward[row, j, size, r]
            for c in range(size):
                total += flows.forward[row, j, c, r] * step[STATE + c]
            work.state[r, j] = total


@kernel(types.void(ZONE_FLOWS, GAUGE, MATRIX, _I, QUANTITY_WORK, MAP_ROOM), inner=True, shared=True)
def gather(flows, gauge, steps, count, work, room):
    """Add what a motion does over the steps of one period, tau counted from its start.

    Parameters
    ----------
    flows : ZoneFlows
    gauge : Gauge
        Of the same system.
    steps, count
        Of `carry_period`.
    work : QUANTITY_WORK
    room : MapRoom
    """
    totals, powers, half, intervals = work.totals, work.powers, flows.half[0], flows.count[0]
    n, numbers = flows.system.vectors.shape[1], flows.system.numbers
    widen_over(flows, steps, count, totals[_LAMBDA : _LAMBDA + 2], room)
    for s in range(count):
        step, row = steps[s], int(steps[s, ROW])
        z, k, begin, end = row // intervals, row % intervals, step[BEGIN], step[END]
        length = (end - begin) * half
        totals[_TIME] += length
        hull_of_step(flows, step, work.hull)
        _integrate(work, _LAMBDA_FIRST, length)
        apply_map(flows.contact, row, step[STATE:], room.powers)
        if z == 0:
            totals[_FREE] += length
        else:
            if totals[_ZONE] == 0.0:
                speed = 0.0
                for j in range(COEFFICIENTS - 1, 0, -1):
                    speed = speed * begin + j * room.powers[j]
                totals[_IMPACT] = max(totals[_IMPACT], abs(speed) / half)
            flank = numbers[HIGH] if z == 1 else numbers[LOW]
            room.powers[0] -= flank
            _multiply(gauge.numbers[0], flows.stiffness[k], room.powers, powers)
            strength, dashpot = strength_of(flows.system, 1 if z == 1 else -1), numbers[DASHPOT] / half
            for j in range(COEFFICIENTS):
                rate = (j + 1.0) * room.powers[j + 1] if j < COEFFICIENTS - 1 else 0.0
                powers[j] = strength * (powers[j] + dashpot * rate)
            _widen(flows, step, _FORCE, work, room)
            room.powers[0] += flank
        totals[_ZONE] = z
        if gauge.seen.shape[0] == 0:
            continue
        _expand(flows, step, work)
        copy_into(powers, room.powers)
        for i in range(n):
            if gauge.seen[i] != 0.0:
                for j in range(COEFFICIENTS):
                    powers[j] -= gauge.seen[i] * work.state[i, j]
        _add_error(gauge.error, numbers[FREQUENCY], (2 * k + 1) * half, half, powers)
        _widen(flows, step, _PSI, work, room)
        _integrate(work, _PSI_FIRST, length)
        for row in range(gauge.supports.shape[0]):
            for j in range(COEFFICIENTS):
                powers[j] = 0.0
            for r in range(2 * n):
                if gauge.supports[row, r] != 0.0:
                    for j in range(COEFFICIENTS):
                        powers[j] += gauge.supports[row, r] * work.state[r, j]
            _widen(flows, step, _SUPPORT, work, room)


@kernel(types.void(_F, ARRAY, ARRAY, ARRAY), inline=True)
def _multiply(share, stiffness, squeezed, force):
    """Powers of (1 + share s) times what is squeezed; the product's further terms are below the tolerance."""
    for j in range(COEFFICIENTS):
        total = squeezed[j]
        for i in range(j + 1):
            total += share * stiffness[i] * squeezed[j - i]
        force[j] = total


@kernel(types.void(MATRIX, _F, _F, _F, ARRAY), inline=True)
def _add_error(error, omega, time, half, powers):
    """Add the powers of e about a time, in units of half an interval."""
    for l in range(error.shape[0]):
        rate = (l + 1.0) * omega
        cosine, sine = math.cos(rate * time), math.sin(rate * time)
        for j in range(COEFFICIENTS):
            powers[j] += error[l, 0] * cosine + error[l, 1] * sine
            factor = rate * half / (j + 1.0)
            cosine, sine = -sine * factor, cosine * factor


@kernel(types.void(GAUGE, QUANTITY_WORK, ARRAY), inner=True)
def read(gauge, work, values):
    """Fill values (13,), by `Slot`, from what was gathered."""
    totals, static = work.totals, gauge.numbers[1]
    values[0], values[1] = totals[_LAMBDA], totals[_LAMBDA + 1]
    values[4] = values[1] - values[0]
    values[5], values[6] = totals[_PSI], totals[_PSI + 1]
    values[8] = values[6] - values[5]
    if gauge.seen.shape[0] == 0:
        values[5], values[6], values[8] = math.nan, math.nan, math.nan
    time = totals[_TIME]
    for first, mean, rms in ((_LAMBDA_FIRST, 2, 3), (_PSI_FIRST, -1, 7)):
        average = totals[first + 1] / time
        if mean >= 0:
            values[mean] = totals[first] + average
        square = totals[first + 2] / time - average * average
        values[rms] = math.sqrt(square) if square > 0.0 else (math.nan if math.isnan(totals[first]) else 0.0)
    # Without contact there is no force; a negative static force is carried by the back flank.
    lowest, highest = min(totals[_FORCE], 0.0), max(totals[_FORCE + 1], 0.0)
    if totals[_FREE] == 0.0:
        lowest, highest = totals[_FORCE], totals[_FORCE + 1]
    values[9] = highest / static if static > 0.0 else (lowest / static if static < 0.0 else math.nan)
    values[10], values[11] = totals[_FREE] / time, totals[_IMPACT]
    support = max(abs(totals[_SUPPORT]), abs(totals[_SUPPORT + 1]))
    values[12] = (support if gauge.supports.shape[0] > 0 else 0.0) if gauge.numbers[2] > 0.0 else math.nan


@kernel(_I(ZONE_FLOWS, GAUGE, ARRAY, _I, ARRAY))
def _quantities(flows, gauge, state, periods, values):
    """Fill values (13,) with what a motion does over some periods; its state is overwritten."""
    room, steps, work = new_room(flows), new_steps(flows), new_work(flows)
    clear(work)
    for _ in range(periods):
        status, count = carry_period(flows, state, steps[:0], steps, math.inf, room)
        if status != COMPLETE:
            return status
        gather(flows, gauge, steps, count, work, room)
    read(gauge, work, values)
    return COMPLETE


def motion_quantities(
    system: Model | ContactSystem, omega: float, state, periods: int = 1, *, tolerance: float = 1e-12
) -> tuple[Quantities, Status]:
    """Quantities of the motion from a state, over some forcing periods.

    Parameters
    ----------
    system : Model or ContactSystem
    omega : float
        Mesh frequency, > 0.
    state : (2 n,) array_like
        y, then y', at tau = 0; of a Model of the coordinates of `gear_system(model)`, or of those with separate=True.
    periods : int
        Forcing periods: those of the motion itself, or many for a motion without a period.
    tolerance : float
        Of the integration, as for `solver.timedomain.integrate`.

    Returns
    -------
    quantities : Quantities
        All nan where the status is not COMPLETE. Of a ContactSystem there is no transmission error and no support. The
        support force is nan where the gears' masses differ and a state
        of `gear_system(model)` was given that is not on an orbit of so many periods: then the supports' own state is
        not known.
    status : Status

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    instance_of("system", system, Model, ContactSystem)
    omega, periods = frequency(omega), whole_number("periods", periods, 1, 10**9)
    tolerance = checked_tolerance(tolerance)
    read_of = _gear_reading if isinstance(system, Model) else _system_reading
    moving, gauge, current = read_of(system, omega, state, periods, tolerance)
    values = np.full(len(Slot), np.nan)
    status = Status(_quantities(checked_flows(moving, omega, tolerance), gauge, current, periods, values))
    return Quantities(*values.tolist()), status


def _system_reading(
    system: ContactSystem, omega: float, state, periods: int, tolerance: float
) -> tuple[ContactSystem, Gauge, np.ndarray]:
    """The system, what is read of it, and the state as it is carried on."""
    closed = np.linalg.pinv(system.stiffness + np.outer(system.force, system.contact))
    rest = closed @ (system.load[0].real + system.force * system.front_gap)
    (gauge,) = system_gauges(system, rest[None], np.array([system.front_gap]))
    return system, gauge, checked_state(system, state)


def _gear_reading(
    model: Model, omega: float, state, periods: int, tolerance: float
) -> tuple[ContactSystem, Gauge, np.ndarray]:
    """The same of a gear pair, with supports told apart where the motion allows that."""
    merged, apart = gear_system(model), gear_system(model, separate=True)
    size = np.size(state)
    system = apart if size == 2 * apart.degrees else merged
    current = checked_state(system, state)
    if system.degrees < apart.degrees:
        together = np.kron(np.eye(2), _merging(model, merged.degrees, apart.degrees))
        orbit = shoot(apart, omega, np.linalg.pinv(together) @ current, periods, integration_tolerance=tolerance)
        # Newton's method may have led to another motion.
        near = 1e-6 * max(1.0, float(np.max(np.abs(current))))
        if orbit.status is ShootingStatus.CONVERGED and np.max(np.abs(together @ orbit.state - current)) <= near:
            system, current = apart, orbit.state.copy()
    return system, gauge_at(*packed(model, "omega", None, 1, 1), omega, system is apart), current


def _merging(model: Model, merged: int, apart: int) -> np.ndarray:
    """Coordinates of `gear_system(model)` from those with separate=True, (merged, apart)."""
    members, parts = (support_kinds(model, separate=separate)[0] for separate in (False, True))
    matrix = np.zeros((merged, apart))
    for member, part in zip(members, parts, strict=True):
        if part >= 0:
            matrix[member, part] = 1.0
    matrix[-1, -1] = 1.0
    return matrix
