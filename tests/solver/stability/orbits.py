"""Motions to judge, and systems to compare with, for the tests of this folder."""

import numpy as np

from solver import Model, all_solutions
from solver.harmonic.galerkin import Galerkin
from solver.model.contact_system import ContactSystem


def first_order(model: Model, omega: float):
    """All first-order motions (S, 3) at one frequency, and their static stability (S,)."""
    found = all_solutions(model, omega)
    return np.stack([found.mean, found.cos, found.sin], axis=1), np.asarray(found.stable)


def solved(problem, guess, p: float) -> np.ndarray:
    """The solution of a balance next to a guess at one axis value, by Newton's method."""
    n = problem.unknowns
    y, residual, jacobian = np.append(guess, p), np.empty(n), np.empty((n, n + 1))
    for _ in range(40):
        problem.residual_and_jacobian(problem.parameters, problem.parameter_slope, y, residual, jacobian)
        y[:n] -= np.linalg.solve(jacobian[:, :n], residual)
        if np.max(np.abs(residual)) < 1e-13:
            return y[:n]
    raise ArithmeticError(f"Newton's method does not settle at {p}")


def galerkin_motion(system, balance: Galerkin, omega: float, guess) -> np.ndarray:
    """The motion of a balance next to a first-order one (3,) or to one of its own."""
    guess = np.asarray(guess, dtype=float)
    start = balance.lifted(guess) if guess.size == 3 else guess
    return solved(balance.problem(system, "omega", 0.5 * omega, 1.5 * omega), start, omega)


def unmerged(model: Model) -> ContactSystem:
    """The gear pair with all seven coordinates, from its matrices."""
    translation, rotation = model.mesh_vectors()
    varying = model.variation_translation * translation + model.variation_rotation * rotation
    load = np.zeros((1, 7))
    load[0, 6] = model.f_pm
    return ContactSystem(
        *model.matrices(),
        np.eye(7)[6],
        translation + rotation,
        model.b,
        model.b,
        varying,
        model.stiffness_harmonics(),
        load,
    )


def oscillator(stiffness=0.0, damping=0.0, force=1.0, varying=0.0, harmonics=(), gap=1.0, back=1.0) -> ContactSystem:
    """One mass of 1 with a contact."""
    return ContactSystem([[1.0]], [[damping]], [[stiffness]], [1.0], [force], gap, back, [varying], harmonics)


def padded(motion, harmonics: int) -> np.ndarray:
    """A motion with zeros for higher harmonics, (1, 2 H + 1)."""
    return np.pad(motion, (0, 2 * harmonics + 1 - len(motion)))[None]


def matched(found, expected) -> float:
    """Largest distance between two sets of numbers, each taken in the order of the other's nearest."""
    found, left = list(found), 0.0
    for value in sorted(expected, key=lambda z: -abs(z)):
        nearest = min(range(len(found)), key=lambda i, value=value: abs(found[i] - value))
        left = max(left, abs(found.pop(nearest) - value))
    return left
