"""What the contact does not reach is no part of the system: its coordinates and multipliers are not there."""

import numpy as np
import pytest

from solver import ContactSystem, gear_system
from solver.harmonic.galerkin import Galerkin
from solver.model.contact_system import reduced
from solver.stability import Instability, assess, monodromies, motion_multipliers
from tests.conftest import consistent, published
from tests.solver.stability.orbits import matched, oscillator

#: One that loses contact, and one that does not.
MOTION, PRESSED = np.array([1.1, 0.5, 0.3]), np.array([5.0, 0.5, 0.3])


@pytest.mark.parametrize("supports", [{}, {"xi_support": [0.0, 0.01, 0.02, 0.0, 0.03, 0.04], "k_support": 1.7}])
def test_without_translation_coupling_lambda_alone_is_left(supports):
    model = consistent(translation_coupling=0.0, alpha=0.0, **supports)
    system = gear_system(model)
    assert system.degrees == 1
    single = oscillator(0.0, 2.0 * model.rotation * model.xi_mesh, model.rotation)
    found = motion_multipliers(model, 0.7, MOTION)
    assert matched(found, motion_multipliers(single, 0.7, MOTION)) < 1e-12
    # Undamped supports would leave a multiplier on the unit circle.
    assert assess(model, "omega", [0.7], PRESSED[None]).kind[0] == Instability.NONE


def test_supports_across_the_contact_direction_are_left_out():
    """A pressure angle of 0 leaves the tangential supports alone, a cone of 90 degrees takes the radial ones away."""
    unlike = dict(k_support=[0.5, 0.7, 0.9, 1.1, 1.3, 1.5])
    assert gear_system(published(**unlike)).degrees == 7
    assert gear_system(published(pressure_angle=0.0, **unlike)).degrees == 3
    assert gear_system(published(pitch_cone_angle=90.0, **unlike)).degrees == 5
    for model in (published(pressure_angle=0.0, **unlike), published(pitch_cone_angle=90.0, **unlike)):
        inside = monodromies(model, "omega", [0.7], MOTION[None])
        outside = monodromies(gear_system(model), "omega", [0.7], MOTION[None])
        np.testing.assert_allclose(inside, outside, rtol=0, atol=1e-12)


def test_a_coordinate_may_lose_its_coupling_along_an_axis():
    model = consistent()
    found = assess(model, "translation_coupling", [0.0, 0.5, 0.0, 1.0], np.tile(MOTION, (4, 1)), omega=0.7)
    for value, modulus in zip([0.0, 0.5, 0.0, 1.0], found.modulus, strict=True):
        alone = assess(model.replace(translation_coupling=value), "omega", [0.7], MOTION[None])
        assert modulus == pytest.approx(alone.modulus[0], rel=1e-12)


def coupled(extra: bool) -> ContactSystem:
    """Two masses in line with a stop at the first, and perhaps a third that neither feels nor moves them."""
    n = 3 if extra else 2
    mass, damping, stiffness = np.eye(n), np.zeros((n, n)), np.zeros((n, n))
    mass[:2, :2] = [[1.0, 0.2], [0.2, 2.0]]
    stiffness[:2, :2], damping[:2, :2] = [[1.0, -1.0], [-1.0, 2.0]], [[0.06, -0.06], [-0.06, 0.12]]
    load = np.zeros((2, n))
    load[1, 1] = 0.1
    if extra:
        # Undamped: it would leave its multipliers on the unit circle.
        stiffness[2, 2], load[0, 2] = 0.5, 0.3
    unit = np.eye(n)[0]
    return ContactSystem(mass, damping, stiffness, unit, 5.0 * unit, 1.0, load=load)


def test_a_coordinate_neither_reached_nor_seen_is_left_out_of_a_contact_system():
    small, large = coupled(False), coupled(True)
    assert reduced(small) is small and reduced(large).degrees == 2
    assert matched(motion_multipliers(large, 0.8, MOTION), motion_multipliers(small, 0.8, MOTION)) < 1e-12
    kinds = [assess(system, "omega", [0.8], PRESSED[None], balance=Galerkin(1)).kind[0] for system in (small, large)]
    assert kinds[0] == kinds[1] == Instability.NONE
    # Its frequency is a resonance of nothing that is left.
    problem = Galerkin(2).problem(large, "omega", 0.5, 1.0)
    y = np.append(np.array([0.9, 0.4, 0.1, 0.0, 0.1]), np.sqrt(0.5))
    residual, jacobian = np.empty(5), np.empty((5, 6))
    problem.residual_and_jacobian(problem.parameters, problem.parameter_slope, y, residual, jacobian)
    assert np.all(np.isfinite(residual)) and np.all(np.isfinite(jacobian))
