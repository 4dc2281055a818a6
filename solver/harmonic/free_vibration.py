"""Free vibration at order H: the backbone of any system with one contact, with a mean load or without.

Without damping a free vibration may be started at rest, so that it is even in time: lambda = Lambda_0 + sum_k c_k
cos k theta, theta = Omega tau, and of the Galerkin balance (`solver.harmonic.galerkin`) only the rows E_0 and Re E_k
are are left. With the largest displacement given, lambda(0) = A, they are as many equations as the unknowns (Lambda_0,
c_1 ... c_H, Omega). Newton's method starts from the first order, and where that is too far off harmonics are added one
by one. At first order, with the gain N of a motion of amplitude a and the mean that carries the load, Omega^2 is an
eigenvalue of M^-1 (K + N h w^T).
"""

import dataclasses
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from solver.contact.dead_zone import contact_functions
from solver.explained import Explained
from solver.harmonic.galerkin import Galerkin
from solver.model.checks import ParameterError, finite_array, instance_of, whole_number
from solver.model.contact_system import ContactSystem, gear_system, reduced
from solver.model.gear_model import Model

__all__ = ["FreeVibration", "FreeVibrationStatus", "free_vibration"]

_MOST_STEPS, _TOLERANCE = 60, 1e-12


class FreeVibrationStatus(Explained):
    """How the search for a free vibration ended."""

    CONVERGED = 0, "The motion solves the balance."
    NO_MEAN = 1, "At first order no mean displacement carries the load, so that there is nothing to start from."
    NOT_SETTLED = 2, "Newton's method did not settle, or came to a singular Jacobian."
    OTHER_HARMONIC = 3, "Newton's method came to a motion that is mostly another harmonic than the first."


@dataclass(frozen=True, eq=False)
class FreeVibration:
    """Free vibration over its largest displacement.

    Parameters
    ----------
    highest : (k,) array
        The largest lambda of each motion.
    omega : (k,) array
        Its frequency; nan where none was found.
    motions : (k, 2 H + 1) array
        (Lambda_0, c_1, s_1, ...) with s_k = 0; nan where none was found.
    status : (k,) int8 array
        `FreeVibrationStatus`: why none was found where that is so.
    """

    highest: np.ndarray
    omega: np.ndarray
    motions: np.ndarray
    status: np.ndarray


def free_vibration(system: Model | ContactSystem, highest, *, order: int = 15, mode: int = 0) -> FreeVibration:
    """Free vibration of the system without damping, stiffness variation and oscillating loads, at order H.

    Parameters
    ----------
    system : Model or ContactSystem
        Its mean load stays, and may be 0.
    highest : (k,) array_like
        Largest displacements lambda, above that at rest and above the front gap.
    order : int
        H, 1 to 64.
    mode : int
        Which mode, from 0 for the lowest of those with a frequency.

    Returns
    -------
    FreeVibration

    Raises
    ------
    ParameterError
        If there is no such mode, a displacement is not above the front gap, or another argument is not allowed.

    Notes
    -----
    x'' + f(x) = 0 with a gap of half width 1 has Omega = 1/(1 + (2/pi)/(A - 1)).
    """
    instance_of("system", system, Model, ContactSystem)
    whole_number("order", order, 1, 64)
    bare = reduced(gear_system(system) if isinstance(system, Model) else system)
    bare = dataclasses.replace(
        bare,
        damping=0.0 * bare.damping,
        contact_dashpot=0.0,
        load=bare.load[:1],
        inertial_load=0.0 * bare.load[:1],
        stiffness_harmonics=(),
    )
    whole_number("mode", mode, 0, bare.degrees - 1)
    highest = finite_array("highest", highest, (None,))
    if np.any(highest <= bare.front_gap):
        raise ParameterError("highest", float(highest.min()), f"above the front gap, {bare.front_gap:g}")
    omega, motions = np.full(highest.size, np.nan), np.full((highest.size, 2 * order + 1), np.nan)
    status = np.full(highest.size, FreeVibrationStatus.NO_MEAN, dtype=np.int8)
    before = None
    for i in np.argsort(highest, kind="stable").tolist():
        first = _first_order(bare, highest[i], mode, order)
        found = None
        if first is not None and first[0] - first[1] >= bare.front_gap and bare.cubic == 0.0:
            # In permanent contact the motion is that of a linear system, and the first order all of it.
            found, status[i] = first, FreeVibrationStatus.CONVERGED
        for start in (first, before):
            if found is None and start is not None:
                found, status[i] = _settled(bare, highest[i], start, order)
        if found is None and first is not None:
            found, status[i] = _raised(bare, highest[i], first, order)
        if found is not None:
            before, omega[i] = found, found[-1]
            motions[i] = 0.0
            motions[i, 0], motions[i, 1::2] = found[0], found[1:-1]
    return FreeVibration(highest, omega, motions, status)


def _law(system: ContactSystem, mean: float, amplitude: float) -> tuple[float, float]:
    """f_0 and N, of a cubic spring as well."""
    far, back = (system.back_stiffness, system.back_gap) if system.two_sided else (0.0, 0.0)
    force, gain = contact_functions(mean, amplitude, system.front_gap, back, far, 0.0, 0.0)[:2]
    square = amplitude * amplitude
    return (
        force + system.cubic * mean * (mean * mean + 1.5 * square),
        gain + system.cubic * (3.0 * mean * mean + 0.75 * square),
    )


def _first_order(system: ContactSystem, highest: float, mode: int, order: int) -> np.ndarray | None:
    """(Lambda_0, c_1 ... c_H, Omega) at first order; None if there is none."""
    closed = system.stiffness + np.outer(system.force, system.contact)
    receptance = system.contact @ np.linalg.solve(closed, np.column_stack([system.force, system.load[0].real]))

    def mean_row(mean: float) -> float:
        # (1 - A) lambda_m + A f_0 = G, grows with lambda_m.
        force = _law(system, mean, highest - mean)[0]
        return (1.0 - receptance[0]) * mean + receptance[0] * force - receptance[1]

    # At the lower end the amplitude is as large as the motion may become on the other side: against a spring softer by
    # a factor it is larger by the root of that.
    high, gap = highest, abs(system.back_gap if system.two_sided else system.front_gap)
    lows = (-factor * (highest + 2.0 * gap) for factor in 4.0 ** np.arange(10))
    low = next((low for low in lows if mean_row(low) * mean_row(high) < 0.0), None)
    if low is None:
        return None
    mean = float(brentq(mean_row, low, high, xtol=1e-14))
    gain = _law(system, mean, highest - mean)[1]
    matrix = np.linalg.solve(system.mass, system.stiffness + gain * np.outer(system.force, system.contact))
    squares = np.sort(np.linalg.eigvals(matrix).real)
    squares = squares[squares > 1e-12 * np.max(np.abs(squares))]
    if mode >= squares.size:
        raise ParameterError("mode", mode, f"below {squares.size}, the number of modes")
    start = np.zeros(order + 2)
    start[0], start[1], start[-1] = mean, highest - mean, np.sqrt(squares[mode])
    return start


def _raised(
    system: ContactSystem, highest: float, start: np.ndarray, order: int
) -> tuple[np.ndarray | None, FreeVibrationStatus]:
    """What Newton's method reaches when harmonics are added one by one, None if that ends on the way, and how it ended.

    A contact that is much stiffer than what holds the mass has motions far from a single harmonic.
    """
    for harmonics in range(1, order + 1):
        guess = np.zeros(harmonics + 2)
        guess[-1] = start[-1]
        shared = min(start.size - 1, harmonics + 1)
        guess[:shared] = start[:shared]
        start, status = _settled(system, highest, guess, harmonics)
        if start is None:
            break
    return start, status


def _settled(
    system: ContactSystem, highest: float, start: np.ndarray, order: int
) -> tuple[np.ndarray | None, FreeVibrationStatus]:
    """What Newton's method reaches from (Lambda_0, c_1 ... c_H, Omega), None if nothing, and how it ended."""
    x = start.copy()
    problem = Galerkin(order).problem(system, "omega", 0.5 * x[-1], 1.5 * x[-1])
    n = problem.unknowns
    kept = np.array([0, *range(1, n, 2)])
    y, size = np.zeros(n + 1), max(abs(highest), 1e-300)
    for _ in range(_MOST_STEPS):
        y[0], y[1:n:2], y[n] = x[0], x[1:-1], x[-1]
        residual, jacobian = problem.evaluated(y)
        matrix = np.zeros((order + 2, order + 2))
        matrix[:-1] = jacobian[np.ix_(kept, np.append(kept, n))]
        matrix[-1, :-1] = 1.0
        right = np.append(residual[kept], np.sum(x[:-1]) - highest)
        if not np.all(np.isfinite(matrix)) or np.linalg.cond(matrix) > 1e14:
            break
        step = np.linalg.solve(matrix, -right)
        # No step moves the frequency by more than a fifth, or the motion by more than half its size.
        length = max(np.max(np.abs(step[:-1])) / (0.5 * size), abs(step[-1]) / (0.2 * x[-1]))
        x += step / max(length, 1.0)
        if length < _TOLERANCE * 10.0:
            # Of a motion that is mostly another harmonic this is no free vibration of the mode.
            if abs(x[1]) >= np.max(np.abs(x[1:-1])):
                return x, FreeVibrationStatus.CONVERGED
            return None, FreeVibrationStatus.OTHER_HARMONIC
    return None, FreeVibrationStatus.NOT_SETTLED
