"""The quantities of motions of a balance (`solver.contact.quantities`), from their harmonics and contact angles.

A motion u = (Lambda_0, c_1, s_1, ...) is a trigonometric polynomial of theta = Omega tau/nu, and so is all that is
read of it: the mesh force (1 + eps_t s)(lambda - b) while the teeth touch, of order H + N nu; the supports, which
answer to the harmonics of the contact force that the balance balances,

    X_jk = -d_j [kappa_g R^t_k + 2 i k Omega/nu xi_hg Lambda_k] / Z_j(k Omega/nu),    R^t = f + eps_t q,  k = 0 ... H

and the transmission error, lambda - d.x + e. Extremes lie where the slope, a polynomial of the same order, vanishes;
mean squares are sums of squares. At first order (describing function) f is truncated before the stiffness multiplies
it, as in the balance.
"""

import math

import numpy as np

from solver.contact.quantities import Slot
from solver.contact.spectrum import COMPLEX, contact_arcs, contact_spectrum, displacement, extrema
from solver.continuation.problem import Balance
from solver.harmonic.contact_terms import coefficient, modulated
from solver.harmonic.impedance import base_frequency
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import eliminate
from solver.model.checks import finite_array, has_methods, instance_of, number_array
from solver.model.condensation import NO_COUPLING, direction_squares, rotation_coupling
from solver.model.contact_system import ContactSystem
from solver.model.gear_model import Model
from solver.model.packing import check_axis, packed
from solver.model.parameters import (
    BACK_GAP,
    CUBIC,
    DASHPOT,
    DEGREES,
    F_PM,
    FRONT_GAP,
    K_SUPPORT,
    KAPPA,
    LOADS,
    PERIOD,
    STIFFNESSES,
    VARIATION_T,
    XI_SUPPORT,
    XI_TRANSLATION,
    error_slot,
    gear_numbers,
    number_at,
    system_loads,
    system_matrices,
)

__all__ = ["balance_quantities", "fill_quantities", "fill_read", "fill_system_quantities"]

_F, _I, _B = types.float64, types.int64, types.boolean
_COMPLEX = np.complex128


@kernel(types.UniTuple(_F, 2)(ARRAY), inner=True)
def _range(u):
    """Lowest and highest value of a trigonometric polynomial."""
    if u.shape[0] == 3:
        size = math.sqrt(u[1] * u[1] + u[2] * u[2])
        return u[0] - size, u[0] + size
    room = 2 * u.shape[0] + 8
    slope, angles, zones = np.empty(u.shape[0]), np.empty(room), np.empty(room, np.int64)
    low, high = math.inf, -math.inf
    for i in range(extrema(u, slope, angles, zones)):
        value, _ = displacement(u, angles[i])
        low, high = min(low, value), max(high, value)
    return (low, high) if low <= high else (u[0], u[0])


@kernel(_F(ARRAY), inline=True)
def _spread(u):
    """Root mean square of the varying part of a trigonometric polynomial."""
    total = 0.0
    for i in range(1, u.shape[0]):
        total += u[i] * u[i]
    return math.sqrt(0.5 * total)


@kernel(_F(ARRAY, ARRAY, ARRAY, _F, _F, _F, _F, _I, ARRAY), inner=True)
def _largest_force(parameters, parameter_slope, u, p, share, level, side, count, switches):
    """Largest (1 + share s)(lambda - level) side, and what a damper of touching teeth adds, where side (lambda - level)
    > 0; 0 if it is nowhere.

    Such a damper's force begins with a jump, at one of the switches (count,) of contact.
    """
    order, reach = u.shape[0] // 2, int(parameters[STIFFNESSES]) * int(parameters[PERIOD])
    size = order + reach + 1
    squeezed, product, rest = np.zeros(size + reach, _COMPLEX), np.empty(size, _COMPLEX), np.empty(size, _COMPLEX)
    squeezed[0] = u[0] - level
    for k in range(1, order + 1):
        squeezed[k] = 0.5 * complex(u[2 * k - 1], -u[2 * k])
    modulated(parameters, parameter_slope, p, squeezed, product, rest)
    force, slope = np.empty(2 * size - 1), np.empty(2 * size - 1)
    force[0] = side * (squeezed[0] + share * product[0]).real
    dashpot = parameters[DASHPOT] * base_frequency(parameters, parameter_slope, p)[0]
    for k in range(1, size):
        value = 2.0 * side * (squeezed[k] + share * product[k])
        if dashpot != 0.0:
            value += 2.0j * side * k * dashpot * squeezed[k]
        force[2 * k - 1], force[2 * k] = value.real, -value.imag
    room = 4 * size + 8
    angles, zones = np.empty(room), np.empty(room, np.int64)
    largest = 0.0
    for i in range(extrema(force, slope, angles, zones)):
        if side * (displacement(u, angles[i])[0] - level) > 0.0:
            largest = max(largest, displacement(force, angles[i])[0])
    if dashpot != 0.0:
        for i in range(count):
            value, slope = displacement(u, switches[i])
            if side * slope > 0.0 and abs(value - level) < 1e-9 * (1.0 + abs(level)):
                largest = max(largest, displacement(force, switches[i])[0])
    # Where nothing varies there is no extreme.
    if side * (displacement(u, 0.0)[0] - level) > 0.0:
        largest = max(largest, displacement(force, 0.0)[0])
    return largest


@kernel(types.void(ARRAY, ARRAY, ARRAY, _F, _B, _I, ARRAY, types.int64[::1], COMPLEX), inner=True)
def _bearing_force(parameters, parameter_slope, u, p, truncated, count, angles, zones, force):
    """Two-sided harmonics 0 ... H of k_t f, from the motion's contact angles."""
    order = u.shape[0] // 2
    reach = order + int(parameters[STIFFNESSES]) * int(parameters[PERIOD])
    work, f = np.empty((3, order + reach + 1), _COMPLEX), np.zeros(reach + 1, _COMPLEX)
    contact_spectrum(count, angles, zones, work[0], work[1], work[2])
    (front, _), (back, _) = (
        number_at(parameters, parameter_slope, p, FRONT_GAP),
        number_at(parameters, parameter_slope, p, BACK_GAP),
    )
    for k in range(order + 1 if truncated else reach + 1):
        total = work[0, k] * u[0] - front * work[1, k] + back * work[2, k]
        for m in range(1, order + 1):
            half = 0.5 * complex(u[2 * m - 1], -u[2 * m])
            total += coefficient(work[0], k - m) * half + work[0, k + m] * half.conjugate()
        f[k] = total
    modulated(parameters, parameter_slope, p, f, force, work[1][: order + 1])
    share = number_at(gear_numbers(parameters, parameters), gear_numbers(parameters, parameter_slope), p, VARIATION_T)[
        0
    ]
    for k in range(order + 1):
        force[k] = f[k] + share * force[k]


@kernel(types.void(ARRAY, _I, types.complex128), inline=True)
def _add(u, k, value):
    """Add a one-sided amplitude to harmonic k of a trigonometric polynomial."""
    if k == 0:
        u[0] += value.real
    else:
        u[2 * k - 1] += value.real
        u[2 * k] -= value.imag


@kernel(_I(ARRAY, ARRAY, ARRAY, _F, ARRAY, types.int64[::1], ARRAY), inner=True)
def _read_displacement(parameters, parameter_slope, u, p, angles, zones, values):
    """Fill what is read of lambda alone; the number of switches of contact, with their angles and the zones beyond."""
    base = base_frequency(parameters, parameter_slope, p)[0]
    (front, _), (back, _) = (
        number_at(parameters, parameter_slope, p, FRONT_GAP),
        number_at(parameters, parameter_slope, p, BACK_GAP),
    )
    values[0], values[1] = _range(u)
    values[2], values[3], values[4] = u[0], _spread(u), values[1] - values[0]

    count = contact_arcs(u, front, back, angles, zones)
    touching, speed = (1.0 if zones[0] != 0 else 0.0) if count == 0 else 0.0, 0.0
    for i in range(count):
        if zones[i] == 0:
            continue
        end = angles[i + 1] if i + 1 < count else angles[0] + 2.0 * math.pi
        touching += (end - angles[i]) / (2.0 * math.pi)
        if zones[i - 1 if i > 0 else count - 1] == 0:
            speed = max(speed, abs(displacement(u, angles[i])[1]) * base)
    values[10], values[11] = 1.0 - touching, speed
    return count


@kernel(types.void(ARRAY, ARRAY, ARRAY, _F, _B, ARRAY), inner=True)
def _motion_quantities(parameters, parameter_slope, u, p, truncated, values):
    """Fill values (13,), by `Slot`, of one motion of a gear pair at one axis value."""
    order, period, loads = u.shape[0] // 2, int(parameters[PERIOD]), int(parameters[LOADS])
    room = 2 * u.shape[0] + 8
    angles, zones = np.empty(room), np.empty(room, np.int64)
    base = base_frequency(parameters, parameter_slope, p)[0]
    (front, _), (back, _) = (
        number_at(parameters, parameter_slope, p, FRONT_GAP),
        number_at(parameters, parameter_slope, p, BACK_GAP),
    )
    count = _read_displacement(parameters, parameter_slope, u, p, angles, zones, values)

    gear, slope = gear_numbers(parameters, parameters), gear_numbers(parameters, parameter_slope)
    share = number_at(gear, slope, p, VARIATION_T)[0]
    static = number_at(gear, slope, p, F_PM)[0] / rotation_coupling(gear, slope, p)[0]
    side = 1.0 if static > 0.0 else -1.0
    level = front if side > 0.0 else -back
    largest = _largest_force(parameters, parameter_slope, u, p, share, level, side, count, angles)
    values[9] = largest / abs(static) if static != 0.0 else math.nan

    force = np.empty(order + 1, _COMPLEX)
    _bearing_force(parameters, parameter_slope, u, p, truncated, count, angles, zones, force)
    error, support = np.zeros(2 * max(order, loads * period) + 1), np.empty(2 * order + 1)
    for i in range(2 * order + 1):
        error[i] = u[i]
    for l in range(1, loads + 1):
        at = error_slot(parameters, l)
        (size, _), (phase, _) = (
            number_at(parameters, parameter_slope, p, at),
            number_at(parameters, parameter_slope, p, at + 1),
        )
        _add(error, l * period, size * complex(math.cos(phase), math.sin(phase)))
    squares, values[12], resonant = direction_squares(gear, slope, p), 0.0, False
    for j in range(6):
        square, g = squares[j % 3], j // 3
        if not square > NO_COUPLING:
            continue
        k_support, xi = number_at(gear, slope, p, K_SUPPORT + j)[0], number_at(gear, slope, p, XI_SUPPORT + j)[0]
        kappa, drag = number_at(gear, slope, p, KAPPA + g)[0], number_at(gear, slope, p, XI_TRANSLATION + g)[0]
        for k in range(order + 1):
            rate = k * base
            one_sided = force[0] if k == 0 else 2.0 * force[k]
            motion = complex(u[0], 0.0) if k == 0 else complex(u[2 * k - 1], -u[2 * k])
            push = -(kappa * one_sided + 2.0j * rate * drag * motion)
            impedance = complex(k_support - rate * rate, 2.0 * xi * rate)
            if impedance == 0.0:
                # Dividing by it would raise.
                resonant = True
                break
            translation = push / impedance
            _add(error, k, -square * translation)
            # In units of k_m b_c, those of gear g being m_g b_c Omega_n^2.
            value = math.sqrt(square) * translation * complex(k_support, 2.0 * xi * rate) / kappa
            support[max(2 * k - 1, 0)], support[2 * k] = value.real, -value.imag
            if k == 0:
                support[0] = value.real
        low, high = _range(support)
        values[12] = max(values[12], abs(low), abs(high))
    values[5], values[6] = _range(error)
    values[7], values[8] = _spread(error), values[6] - values[5]
    if resonant:
        for i in (5, 6, 7, 8, 12):
            values[i] = math.nan


@kernel(types.void(ARRAY, ARRAY, ARRAY, MATRIX, _B, MATRIX))
def fill_quantities(parameters, parameter_slope, values, motions, truncated, found):
    """Fill found (k, 13), by `Slot`, for motions (k, n) at axis values (k,).

    nan where a motion is, and of a quantity that is infinite or none: a force over no load, a support at its undamped
    resonance.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Of `solver.model.packing.packed` for a gear pair and the balance.
    values, motions : (k,) and (k, n) arrays
    truncated : bool
        Whether the balance truncates the force before the stiffness multiplies it.
    found : (k, 13) array
    """
    for i in range(values.shape[0]):
        known = math.isfinite(motions[i, 0])
        if known:
            _motion_quantities(parameters, parameter_slope, motions[i], values[i], truncated, found[i])
        for j in range(found.shape[1]):
            if not known or not math.isfinite(found[i, j]):
                found[i, j] = math.nan


@kernel(types.UniTuple(_F, 2)(ARRAY, ARRAY, _F), inner=True)
def _static_force(parameters, parameter_slope, p):
    """f at rest under the mean load with the front flank closed, of a `ContactSystem`; how the stiffness varies in it.

    The second number is nan where h_v is no multiple of h: there is no one contact force then.
    """
    n = int(parameters[DEGREES])
    (_, _, stiffness), (contact, force, varying) = system_matrices(parameters, parameters)
    (_, _, d_stiffness), _ = system_matrices(parameters, parameter_slope)
    (load, _), (d_load, _) = system_loads(parameters, parameters), system_loads(parameters, parameter_slope)
    front = number_at(parameters, parameter_slope, p, FRONT_GAP)[0]
    closed, right, strength, product = np.empty((n, n)), np.empty(n), 0.0, 0.0
    for i in range(n):
        right[i] = load[0, i, 0] + p * d_load[0, i, 0] + force[i] * front
        strength += force[i] * force[i]
        product += force[i] * varying[i]
        for j in range(n):
            closed[i, j] = stiffness[i, j] + p * d_stiffness[i, j] + force[i] * contact[j]
    share, static = product / strength if strength > 0.0 else 0.0, -front
    for i in range(n):
        if abs(varying[i] - share * force[i]) > 1e-12 * math.sqrt(strength):
            share = math.nan
    if eliminate(closed, right) == 0.0:
        return math.nan, share
    for i in range(n):
        static += contact[i] * right[i]
    return static, share


@kernel(types.void(ARRAY, ARRAY, ARRAY, MATRIX, MATRIX))
def fill_system_quantities(parameters, parameter_slope, values, motions, found):
    """Fill found (k, 13), by `Slot`, for motions (k, n) of a `ContactSystem` at axis values (k,).

    Read of lambda and of the force at the front flank: there is no transmission error and no support, which are nan, as
    is a force over one that does not press the front flank at rest, and one beside a cubic spring.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Of `solver.model.packing.packed` for the balance.
    values, motions, found : arrays
        As for `fill_quantities`.
    """
    room = 2 * motions.shape[1] + 8
    angles, zones = np.empty(room), np.empty(room, np.int64)
    for i in range(values.shape[0]):
        for j in range(found.shape[1]):
            found[i, j] = math.nan
        if not math.isfinite(motions[i, 0]):
            continue
        p, u = values[i], motions[i]
        count = _read_displacement(parameters, parameter_slope, u, p, angles, zones, found[i])
        static, share = _static_force(parameters, parameter_slope, p)
        if static > 0.0 and math.isfinite(share) and parameters[CUBIC] == 0.0:
            front = number_at(parameters, parameter_slope, p, FRONT_GAP)[0]
            largest = _largest_force(parameters, parameter_slope, u, p, share, front, 1.0, count, angles)
            found[i, 9] = largest / static


def fill_read(system, balance: Balance, parameters, values: np.ndarray, motions: np.ndarray, found: np.ndarray) -> None:
    """`fill_quantities` of a gear pair, `fill_system_quantities` of a `ContactSystem`.

    Parameters
    ----------
    system : Model or ContactSystem
    balance : Balance
    parameters : (parameters, parameter_slope)
        Of `solver.model.packing.packed`.
    values, motions, found : arrays
        As for `fill_quantities`.
    """
    if isinstance(system, Model):
        fill_quantities(*parameters, values, motions, balance.truncated, found)
    else:
        fill_system_quantities(*parameters, values, motions, found)


def balance_quantities(
    balance: Balance, system: Model | ContactSystem, axis: str, values, motions, omega: float | None = None
) -> np.ndarray:
    """Quantities of motions, from their harmonics and contact angles.

    Parameters
    ----------
    balance : Balance
        That the motions are solutions of, with n unknowns.
    system : Model or ContactSystem
    axis : str
        The swept parameter, one of `solver.model.packing.AXES`, or of `SYSTEM_AXES` for a ContactSystem.
    values : (...) array_like
        Axis values of the motions.
    motions : (..., n) array_like
        (Lambda_0, c_1, s_1, ...); nan where there is none.
    omega : float, optional
        The mesh frequency; needed unless it is the axis.

    Returns
    -------
    (..., 13) array
        By `solver.contact.quantities.Slot`; nan where the motion is, and as `fill_quantities` says.
        `Quantities(*row)` names them and their units.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    has_methods("balance", balance, "problem", "extremes")
    instance_of("system", system, Model, ContactSystem)
    values, motions = finite_array("values", values, None), number_array("motions", motions, last=balance.unknowns)
    values = np.broadcast_to(values, motions.shape[:-1])
    low, high = (float(values.min()), float(values.max())) if values.size else (1.0, 2.0)
    check_axis(system, axis, low, np.nextafter(high, np.inf), omega)
    parameters = packed(system, axis, omega, balance.order, balance.period)
    flat = np.ascontiguousarray(motions.reshape(-1, balance.unknowns), dtype=float)
    found = np.empty((len(flat), len(Slot)))
    fill_read(system, balance, parameters, values.ravel().copy(), flat, found)
    return found.reshape(*motions.shape[:-1], len(Slot))
