"""The load of a system at one axis value, as kernels that follow motions along a row need it."""

import math

import numpy as np

from solver.flow.switched_system import (
    HIGH,
    LENGTH,
    LOW,
    SWITCHED_SYSTEM,
    SwitchedSystem,
    count_degrees,
    new_system,
    system_at,
)
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import eliminate_rows
from solver.model.parameters import (
    F_PM,
    F_PV,
    GEAR,
    KIND,
    LOADS,
    MESH_FREQUENCY,
    STIFFNESSES,
    error_slot,
    gear_numbers,
    number_at,
    system_loads,
    system_matrices,
)

__all__ = ["loaded_system_at"]

_I, _F = types.int64, types.float64


@kernel(types.void(ARRAY, ARRAY, _F, MATRIX), inner=True)
def _gear_load(parameters, parameter_slope, p, load):
    """f_pm, f_pv and the transmission error act on lambda alone, the last coordinate; M^-1 keeps them there."""
    last = load.shape[1] - 1
    gear, slope = gear_numbers(parameters, parameters), gear_numbers(parameters, parameter_slope)
    omega, _ = number_at(parameters, parameter_slope, p, MESH_FREQUENCY)
    load[:, :] = 0.0
    load[0, last] = gear[F_PM] + p * slope[F_PM]
    for l in range(1, load.shape[0] // 2):
        at = error_slot(parameters, l)
        (size, _), (phase, _) = (
            number_at(parameters, parameter_slope, p, at),
            number_at(parameters, parameter_slope, p, at + 1),
        )
        size *= (l * omega) ** 2
        load[2 * l, last], load[2 * l + 1, last] = size * math.cos(phase), size * math.sin(phase)
    load[2, last] += gear[F_PV] + p * slope[F_PV]


@kernel(types.void(ARRAY, ARRAY, _F, MATRIX), inner=True)
def _system_load(parameters, parameter_slope, p, load):
    """M^-1 [F_l + (l Omega)^2 F^i_l] of a `ContactSystem`."""
    n = load.shape[1]
    (mass, _, _), _ = system_matrices(parameters, parameters)
    constant, inertial = system_loads(parameters, parameters)
    constant_slope, inertial_slope = system_loads(parameters, parameter_slope)
    omega, _ = number_at(parameters, parameter_slope, p, MESH_FREQUENCY)
    left = np.empty((n, n))
    for i in range(n):
        for j in range(n):
            left[i, j] = mass[i, j]
    for l in range(load.shape[0] // 2):
        square = (l * omega) ** 2
        for i in range(n):
            for part in range(2):
                load[2 * l + part, i] = (
                    constant[l, i, part]
                    + p * constant_slope[l, i, part]
                    + square * (inertial[l, i, part] + p * inertial_slope[l, i, part])
                )
    eliminate_rows(left, load)


@kernel(SWITCHED_SYSTEM(ARRAY, ARRAY, _F), inner=True, shared=True)
def loaded_system_at(parameters, parameter_slope, p):
    """The system with its load at one axis value.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Of `solver.model.packing.packed`.
    p : float
        Axis value.

    Returns
    -------
    SwitchedSystem
        As `solver.flow.switched_system.loaded_system` makes it of the reduced system.
    """
    n = count_degrees(parameters, parameter_slope, p)
    bare = new_system(n, int(parameters[STIFFNESSES]))
    system_at(parameters, parameter_slope, p, bare)
    load = np.empty((2 * (int(parameters[LOADS]) + 1), n))
    if parameters[KIND] == GEAR:
        _gear_load(parameters, parameter_slope, p, load)
    else:
        _system_load(parameters, parameter_slope, p, load)
    numbers = bare.numbers
    length = abs(numbers[HIGH])
    if math.isfinite(numbers[LOW]):
        length = max(length, abs(numbers[LOW]))
    for l in range(load.shape[0]):
        for i in range(n):
            length = max(length, abs(load[l, i]))
    # Without gaps and loads no length is better than another.
    numbers[LENGTH] = length if length > 0.0 else 1.0
    # Harmonics that vanish, or that no force feels, need not be summed in every step.
    felt = False
    for i in range(n):
        felt = felt or bare.vectors[2, i] != 0.0
    count = bare.variation.shape[0] if felt else 0
    while count > 0 and bare.variation[count - 1, 0] == 0.0 and bare.variation[count - 1, 1] == 0.0:
        count -= 1
    return SwitchedSystem(numbers, bare.matrices, bare.vectors, bare.variation[:count].copy(), load)
