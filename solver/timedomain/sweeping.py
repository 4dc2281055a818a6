"""Attractors along a parameter, followed up and down as a slow run-up and run-down would find them."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from solver.model.checks import ParameterError, finite_array, instance_of
from solver.model.contact_system import ContactSystem
from solver.timedomain.attractor import Attractor, AttractorKind
from solver.timedomain.integrator import checked_state
from solver.timedomain.settling import Settling, settle

__all__ = ["AttractorSweep", "resting_state", "sweep_attractors"]


@dataclass(frozen=True, eq=False)
class AttractorSweep:
    """Attractors of a sweep; both directions are in the order of `values`.

    Parameters
    ----------
    values : (m,) array
        Of the swept parameter.
    up, down : tuple of m Attractor
        Followed from the first value to the last, and back.
    """

    values: np.ndarray
    up: tuple[Attractor, ...]
    down: tuple[Attractor, ...]

    @property
    def hysteresis(self) -> np.ndarray:
        """Where the two directions found different motions, (m,) bool: in kind, or in mean or amplitude by 1e-6."""
        different = []
        for one, other in zip(self.up, self.down, strict=True):
            numbers = np.array([one.mean - other.mean, one.amplitude - other.amplitude])
            aperiodic = one.kind is other.kind and not one.kind.periodic
            different.append(one.kind is not other.kind or (not aperiodic and bool(np.max(np.abs(numbers)) > 1e-6)))
        return np.array(different)


def resting_state(system: ContactSystem) -> np.ndarray:
    """State (2 n,) at rest under the mean load with the front contact closed.

    Raises
    ------
    ParameterError
        If it is no ContactSystem.
    """
    instance_of("system", system, ContactSystem)
    closed = system.stiffness + np.outer(system.force, system.contact)
    right = system.load[0].real + system.force * system.front_gap
    return np.concatenate([np.linalg.lstsq(closed, right, rcond=None)[0], np.zeros(system.degrees)])


def sweep_attractors(
    system_at: Callable[[float], tuple[ContactSystem, float]], values, *, start=None, settling: Settling | None = None
) -> AttractorSweep:
    """Follow the attractor up and down along a list of values.

    Parameters
    ----------
    system_at : callable
        value -> (system, omega); all systems have the same coordinates.
    values : (m,) array_like
    start : (2 n,) array_like, optional
        State from which the first value is settled; `resting_state` unless given.
    settling : Settling, optional

    Returns
    -------
    AttractorSweep
        Each value starts where the previous one ended, the way down from the end of the way up. After an unbounded
        motion or a failure the last state that was settled is taken again.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    if not callable(system_at):
        raise ParameterError("system_at", system_at, "a function of a value that gives (system, omega)")
    values = finite_array("values", values, (None,))
    if values.size == 0:
        raise ParameterError("values", values, "a list of at least one finite number")
    first, _ = system_at(float(values[0]))
    state = checked_state(first, resting_state(first) if start is None else start, "start")
    up, state = _follow(system_at, values, state, settling)
    down, _ = _follow(system_at, values[::-1], state, settling)
    return AttractorSweep(values, up, down[::-1])


def _follow(system_at, values, state, settling):
    found = []
    for value in values:
        system, omega = system_at(float(value))
        (attractor,) = settle(system, omega, state, settling=settling)
        if attractor.kind not in (AttractorKind.UNBOUNDED, AttractorKind.FAILED):
            state = attractor.state
        found.append(attractor)
    return tuple(found), state
