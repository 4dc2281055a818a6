"""A system with one contact as kernels see it at one parameter: linear within each contact zone.

With M^-1 multiplied through, y obeys, with lambda = w . y and in zone z (-1 back, 0 free, 1 front)

    y'' + D_z y' + S_z y + r_z q s(tau) lambda = g_z(tau),    s(tau) = Re sum_l S_l exp(i l Omega tau)

where S_z = M^-1 (K + r_z h w^T), D_z = M^-1 (C + r_z c_c h w^T), q = M^-1 h_v, and g holds the load and the offset of
the zone's law. r_z is how stiff the zone's flank is: 1 in front, the back flank's stiffness over that, and 0 between.
Small deviations obey the same equation without g. Where c_c is not 0 they jump at a switch,

    delta y' -> delta y' - (r_after - r_before) c_c M^-1 h delta lambda

whatever lambda' is: y' + c_c M^-1 h f(lambda) has a derivative without a jump. A cubic spring adds k_3 M^-1 h lambda^3
in every zone, and to deviations from a motion lambda_0 3 k_3 M^-1 h lambda_0^2 delta lambda.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import eliminate_rows
from solver.model.condensation import NO_COUPLING, direction_squares, rotation_coupling
from solver.model.contact_system import ContactSystem
from solver.model.parameters import (
    BACK_GAP,
    BACK_STIFFNESS,
    DEGREES,
    FRONT_GAP,
    GEAR,
    K_SUPPORT,
    KAPPA,
    KIND,
    MESH_FREQUENCY,
    VARIATION_R,
    VARIATION_T,
    XI_MESH,
    XI_SUPPORT,
    XI_TRANSLATION,
    gear_numbers,
    number_at,
    stiffness_slot,
    system_matrices,
)
from solver.model.parameters import CUBIC as PACKED_CUBIC
from solver.model.parameters import DASHPOT as PACKED_DASHPOT

__all__ = [
    "SWITCHED_SYSTEM",
    "SwitchedSystem",
    "count_degrees",
    "loaded_system",
    "new_system",
    "strength_of",
    "system_at",
]

_I, _F = types.int64, types.float64

# Slots of `numbers`.
FREQUENCY, LOW, HIGH, LENGTH, ONE_ZONE, STRENGTH, DASHPOT, CUBIC, NUMBERS = range(9)


class SwitchedSystem(NamedTuple):
    """A system of n coordinates at one parameter; see the module.

    `numbers` (8,): Omega, the ends of the dead zone (low, high), a length that errors of motions are compared with, 1
    where the dead zone is empty between equal flanks so that there is one zone, how stiff the back flank is, c_c, and
    k_3. `matrices` (6 n, n): S and then D of the zones free, front, back. `vectors` (3, n): w, M^-1 h, q. `variation`
    (L, 2): real and imaginary parts of S_l. `load` (2 (L' + 1), n): real and imaginary parts of M^-1 F_l; without rows
    for deviations alone.
    """

    numbers: np.ndarray
    matrices: np.ndarray
    vectors: np.ndarray
    variation: np.ndarray
    load: np.ndarray


SWITCHED_SYSTEM = types.NamedTuple((ARRAY, MATRIX, MATRIX, MATRIX, MATRIX), SwitchedSystem)


@kernel(SWITCHED_SYSTEM(_I, _I), inner=True)
def new_system(degrees, stiffnesses):
    """Room for a system of n coordinates, of so many harmonics of the stiffness, without a load."""
    return SwitchedSystem(
        np.empty(NUMBERS),
        np.empty((6 * degrees, degrees)),
        np.empty((3, degrees)),
        np.empty((stiffnesses, 2)),
        np.empty((0, degrees)),
    )


@kernel(_F(SWITCHED_SYSTEM, _I), inline=True)
def strength_of(system, zone):
    """r_z, how stiff the flank of a zone is; 0 of the free one."""
    return 1.0 if zone > 0 else (system.numbers[STRENGTH] if zone < 0 else 0.0)


@kernel(_I(ARRAY, ARRAY, _F, MATRIX), inner=True)
def _supports(model, slope, p, groups):
    """Merge supports of equal damping ratio and stiffness that the contact reaches; their number.

    groups (4, 6): xi, k, sum_j d_j^2 kappa_g and 2 sum_j d_j^2 xi_hg of each, as in
    `solver.model.contact_system.gear_system`.
    """
    radial, axial, tangential = direction_squares(model, slope, p)
    count = 0
    for j in range(6):
        square = radial if j % 3 == 0 else (axial if j % 3 == 1 else tangential)
        if not square > NO_COUPLING:
            continue
        xi = model[XI_SUPPORT + j] + p * slope[XI_SUPPORT + j]
        k = model[K_SUPPORT + j] + p * slope[K_SUPPORT + j]
        group = 0
        while group < count and not (groups[0, group] == xi and groups[1, group] == k):
            group += 1
        if group == count:
            groups[0, group], groups[1, group], groups[2, group], groups[3, group] = xi, k, 0.0, 0.0
            count += 1
        g = j // 3
        groups[2, group] += square * (model[KAPPA + g] + p * slope[KAPPA + g])
        groups[3, group] += 2.0 * square * (model[XI_TRANSLATION + g] + p * slope[XI_TRANSLATION + g])
    return count


@kernel(_I(ARRAY, ARRAY, _F), inner=True, shared=True)
def count_degrees(parameters, parameter_slope, p):
    """Number n of coordinates of a system that the contact reaches, from vectors of `solver.model.packing.packed`."""
    if parameters[KIND] != GEAR:
        return int(parameters[DEGREES])
    gear, slope = gear_numbers(parameters, parameters), gear_numbers(parameters, parameter_slope)
    return 1 + _supports(gear, slope, p, np.empty((4, 6)))


@kernel(types.void(ARRAY, ARRAY, _F, SWITCHED_SYSTEM), inner=True, shared=True)
def system_at(parameters, parameter_slope, p, system):
    """Fill a system of `new_system` at one axis value.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Of `solver.model.packing.packed`.
    p : float
        Axis value.
    system : SwitchedSystem
        Of `count_degrees` coordinates.
    """
    numbers, variation = system.numbers, system.variation
    (back, _), (high, _) = (
        number_at(parameters, parameter_slope, p, BACK_GAP),
        number_at(parameters, parameter_slope, p, FRONT_GAP),
    )
    low, (omega, _) = -back, number_at(parameters, parameter_slope, p, MESH_FREQUENCY)
    numbers[FREQUENCY], numbers[LOW], numbers[HIGH] = omega, low, high
    numbers[STRENGTH], numbers[DASHPOT] = parameters[BACK_STIFFNESS], parameters[PACKED_DASHPOT]
    numbers[CUBIC] = parameters[PACKED_CUBIC]
    numbers[LENGTH], numbers[ONE_ZONE] = 1.0, 1.0 if low == high and numbers[STRENGTH] == 1.0 else 0.0
    for l in range(variation.shape[0]):
        at = stiffness_slot(l + 1)
        (size, _), (phase, _) = (
            number_at(parameters, parameter_slope, p, at),
            number_at(parameters, parameter_slope, p, at + 1),
        )
        variation[l, 0], variation[l, 1] = size * math.cos(phase), size * math.sin(phase)
    if parameters[KIND] == GEAR:
        _gear(gear_numbers(parameters, parameters), gear_numbers(parameters, parameter_slope), p, system)
    else:
        _system(parameters, parameter_slope, p, system)
    matrices, vectors = system.matrices, system.vectors
    n = vectors.shape[1]
    for zone in (1, -1):
        first, strength = n * (zone % 3), strength_of(system, zone)
        for i in range(n):
            for j in range(n):
                stiffer = strength * (vectors[1, i] * vectors[0, j])
                matrices[first + i, j] = matrices[i, j] + stiffer
                matrices[3 * n + first + i, j] = matrices[3 * n + i, j] + numbers[DASHPOT] * stiffer


@kernel(types.void(ARRAY, ARRAY, _F, SWITCHED_SYSTEM), inner=True)
def _gear(model, slope, p, system):
    """The gear pair with equal supports merged: M^-1 has ones on its diagonal and in the row of lambda."""
    groups = np.empty((4, 6))
    last = _supports(model, slope, p, groups)
    n = last + 1
    matrices, vectors = system.matrices, system.vectors
    matrices[:, :] = 0.0
    vectors[:, :] = 0.0
    c = rotation_coupling(model, slope, p)[0]
    eps_t = model[VARIATION_T] + p * slope[VARIATION_T]
    eps_r = model[VARIATION_R] + p * slope[VARIATION_R]
    force, drag = 0.0, 0.0
    for g in range(last):
        damping = 2.0 * groups[0, g]
        matrices[g, g], matrices[last, g] = groups[1, g], groups[1, g]
        matrices[3 * n + g, g], matrices[3 * n + last, g] = damping, damping
        matrices[3 * n + g, last] = groups[3, g]
        vectors[1, g], vectors[2, g] = groups[2, g], eps_t * groups[2, g]
        force += groups[2, g]
        drag += groups[3, g]
    matrices[3 * n + last, last] = drag + 2.0 * c * (model[XI_MESH] + p * slope[XI_MESH])
    vectors[0, last], vectors[1, last], vectors[2, last] = 1.0, force + c, eps_t * force + eps_r * c


@kernel(types.void(ARRAY, ARRAY, _F, SWITCHED_SYSTEM), inner=True)
def _system(parameters, parameter_slope, p, system):
    """A `ContactSystem`, from its M, C, K, w, h and h_v; an axis may change C and K."""
    matrices, vectors = system.matrices, system.vectors
    n = vectors.shape[1]
    (mass, damping, stiffness), (contact, force, varying) = system_matrices(parameters, parameters)
    (_, d_damping, d_stiffness), _ = system_matrices(parameters, parameter_slope)
    left, rights = np.empty((n, n)), np.empty((2 * n + 2, n))
    for i in range(n):
        vectors[0, i] = contact[i]
        rights[2 * n, i], rights[2 * n + 1, i] = force[i], varying[i]
        for j in range(n):
            left[i, j] = mass[i, j]
            rights[j, i] = stiffness[i, j] + p * d_stiffness[i, j]
            rights[n + j, i] = damping[i, j] + p * d_damping[i, j]
    eliminate_rows(left, rights)
    for i in range(n):
        vectors[1, i], vectors[2, i] = rights[2 * n, i], rights[2 * n + 1, i]
        for j in range(n):
            matrices[i, j], matrices[3 * n + i, j] = rights[j, i], rights[n + j, i]


@lru_cache(maxsize=4)
def loaded_system(system: ContactSystem, omega: float) -> SwitchedSystem:
    """A system under its load at one frequency. A motion is followed in many calls; no kernel writes into it."""
    inverse = np.linalg.inv(system.mass)
    stiffness, damping = inverse @ system.stiffness, inverse @ system.damping
    force, varying = inverse @ system.force, inverse @ system.varying_force
    rows = max(len(system.load), len(system.inertial_load))
    harmonics = system.load_harmonics(omega, rows - 1) @ inverse.T
    load = np.empty((2 * rows, system.degrees))
    load[0::2], load[1::2] = harmonics.real, harmonics.imag
    sizes, phases = np.array(system.stiffness_harmonics if np.any(varying) else (), dtype=float).reshape(-1, 2).T
    low, high = -system.back_gap, system.front_gap
    length = max(abs(high), abs(low) if system.two_sided else 0.0, np.max(np.abs(load)))
    strengths, closing = (0.0, 1.0, system.back_stiffness), np.outer(force, system.contact)
    one_zone = low == high and system.back_stiffness == 1.0
    law = system.back_stiffness, system.contact_dashpot, system.cubic
    return SwitchedSystem(
        np.array([omega, low, high, length, float(one_zone), *law]),
        np.concatenate(
            [
                *(stiffness + strength * closing for strength in strengths),
                *(damping + system.contact_dashpot * (strength * closing) for strength in strengths),
            ]
        ),
        np.array([system.contact, force, varying]),
        np.column_stack([sizes * np.cos(phases), sizes * np.sin(phases)]),
        load,
    )
