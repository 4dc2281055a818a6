"""What is read of a system beside lambda: the error, supports and static force that a motion's quantities need."""

import math
from typing import NamedTuple

import numpy as np

from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.model.condensation import NO_COUPLING, direction_squares, rotation_coupling
from solver.model.contact_system import ContactSystem
from solver.model.parameters import (
    F_PM,
    GEAR,
    K_SUPPORT,
    KAPPA,
    KIND,
    LOADS,
    VARIATION_T,
    XI_SUPPORT,
    XI_TRANSLATION,
    error_slot,
    gear_numbers,
    number_at,
)

__all__ = ["GAUGE", "Gauge", "gauge_at", "system_gauges"]

_F, _B = types.float64, types.boolean


class Gauge(NamedTuple):
    """What is read of a system beside lambda.

    `numbers` (3,): eps_t, the static force f_pm/c, and 1 where supports can be told from the coordinates. `error`
    (L, 2): cos and sin amplitudes of e, l = 1 ... L. `seen` (n,): d.x of the coordinates. `supports` (S, 2 n): forces
    from the state. Of a system that is no gear pair `seen` has no elements: it has no transmission error.
    """

    numbers: np.ndarray
    error: np.ndarray
    seen: np.ndarray
    supports: np.ndarray


GAUGE = types.NamedTuple((ARRAY, MATRIX, ARRAY, MATRIX), Gauge)


@kernel(GAUGE(ARRAY, ARRAY, _F, _B), shared=True)
def gauge_at(parameters, parameter_slope, p, separate):
    """What is read of a system of packed parameters at one axis value.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Of `solver.model.packing.packed`. Of a system that is no gear pair only lambda is read.
    p : float
        Axis value.
    separate : bool
        Whether the coordinates are those of `gear_system(model, separate=True)`. If not, the forces of supports that
        are merged though their gears differ are not told.
    """
    numbers = np.zeros(3)
    if parameters[KIND] != GEAR:
        return Gauge(numbers, np.empty((0, 2)), np.empty(0), np.empty((0, 0)))
    gear, slope = gear_numbers(parameters, parameters), gear_numbers(parameters, parameter_slope)
    numbers[0] = number_at(gear, slope, p, VARIATION_T)[0]
    numbers[1] = number_at(gear, slope, p, F_PM)[0] / rotation_coupling(gear, slope, p)[0]
    error = np.empty((int(parameters[LOADS]), 2))
    for l in range(error.shape[0]):
        at = error_slot(parameters, l + 1)
        (size, _), (phase, _) = (
            number_at(parameters, parameter_slope, p, at),
            number_at(parameters, parameter_slope, p, at + 1),
        )
        error[l, 0], error[l, 1] = size * math.cos(phase), -size * math.sin(phase)
    # Of each kind: xi, k, kappa and xi_hg, the sum of d_j^2 and the largest of them, whose support has the most force.
    kinds, count, told = np.empty((6, 6)), 0, True
    squares = direction_squares(gear, slope, p)
    for j in range(6):
        square = squares[j % 3]
        if not square > NO_COUPLING:
            continue
        xi, k = number_at(gear, slope, p, XI_SUPPORT + j)[0], number_at(gear, slope, p, K_SUPPORT + j)[0]
        kappa = number_at(gear, slope, p, KAPPA + j // 3)[0]
        drag = number_at(gear, slope, p, XI_TRANSLATION + j // 3)[0]
        kind = 0
        while kind < count:
            alike = kinds[kind, 2] == kappa and kinds[kind, 3] == drag
            if kinds[kind, 0] == xi and kinds[kind, 1] == k and (alike or not separate):
                told = told and alike
                break
            kind += 1
        if kind == count:
            kinds[kind, 0], kinds[kind, 1], kinds[kind, 2], kinds[kind, 3] = xi, k, kappa, drag
            kinds[kind, 4], kinds[kind, 5] = 0.0, 0.0
            count += 1
        kinds[kind, 4] += square
        kinds[kind, 5] = max(kinds[kind, 5], square)
    numbers[2] = 1.0 if told else 0.0
    seen, supports = np.ones(count + 1), np.zeros((count if told else 0, 2 * count + 2))
    seen[count] = 0.0
    for kind in range(supports.shape[0]):
        # In units of k_m b_c, those of gear g being m_g b_c Omega_n^2.
        share = math.sqrt(kinds[kind, 5]) / (kinds[kind, 4] * kinds[kind, 2])
        supports[kind, kind] = share * kinds[kind, 1]
        supports[kind, count + 1 + kind] = 2.0 * share * kinds[kind, 0]
    return Gauge(numbers, error, seen, supports)


def system_gauges(system: ContactSystem, rest: np.ndarray, front: np.ndarray) -> tuple[Gauge, ...]:
    """What is read of a system that is no gear pair: the force over that at rest, where that presses the front flank.

    Parameters
    ----------
    system : ContactSystem
    rest : (X, n) array
        Coordinates at rest under the mean load with the front flank closed.
    front : (X,) array
        Front gap.
    """
    force, varying = system.force, system.varying_force
    # The stiffness varies in the mesh force where both act along one direction; elsewhere there is no one mesh force.
    share = float(varying @ force / (force @ force))
    share = share if np.allclose(varying, share * force, rtol=1e-12, atol=0.0) else np.nan
    closed = rest @ system.contact - front
    closed = np.where(closed > 0.0, closed, np.nan)
    return tuple(Gauge(np.array([share, at, 0.0]), np.empty((0, 2)), np.empty(0), np.empty((0, 0))) for at in closed)
