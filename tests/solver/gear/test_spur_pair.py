"""The spur pair of one degree of freedom: its equation, and the numbers of docs/physics.md, section 9."""

import math

import numpy as np
import pytest

from solver import Galerkin, ParameterError, SolveStatus, solve, spur_pair

#: Kahraman and Singh 1991: three harmonics of stiffness and error.
PAIR = dict(
    damping_ratio=0.05,
    gap=1.0,
    mean_load=0.1,
    stiffness_harmonics=[(0.2, math.pi), (0.1, math.pi), (0.05, math.pi)],
    error_harmonics=[(0.01, 0.0), (0.004, 0.0), (0.002, 0.0)],
)


def test_the_equation_is_that_of_the_reference():
    """x'' + 0.1x' + [1 - 0.2 cos T - 0.1 cos 2T - 0.05 cos 3T] f(x) = 0.1 + sum (l Omega)^2 e_l cos lT."""
    pair, omega = spur_pair(**PAIR, load_harmonics=[(0.03, 0.5)]), 0.7
    assert (pair.degrees, pair.front_gap, pair.back_gap, pair.damping[0, 0]) == (1, 1.0, 1.0, 0.1)
    angle = np.linspace(0.0, 6.0, 7)
    varied = sum(a * np.cos(l * angle + p) for l, (a, p) in enumerate(pair.stiffness_harmonics, start=1))
    wanted = -0.2 * np.cos(angle) - 0.1 * np.cos(2 * angle) - 0.05 * np.cos(3 * angle)
    np.testing.assert_allclose(varied, wanted, atol=1e-15)
    load = pair.load_harmonics(omega, 3)[:, 0]
    wanted = [0.1, 0.01 * 0.49 + 0.03 * np.exp(0.5j), 0.004 * 4 * 0.49, 0.002 * 9 * 0.49]
    np.testing.assert_allclose(load, wanted, rtol=1e-14)


def test_the_motion_at_half_the_natural_frequency():
    """Physics, section 9: mean 1.09286, harmonics 0.03002, 0.12401, 0.00442; x from 0.95104 to 1.24239: teeth part."""
    found = solve(spur_pair(**PAIR), [1.09, 0.03, 0.0], 0.5, balance=Galerkin(25))
    assert found.status is SolveStatus.CONVERGED
    harmonics = np.hypot(found.motion[1::2], found.motion[2::2])
    np.testing.assert_allclose([found.motion[0], *harmonics[:3]], [1.09286, 0.03002, 0.12401, 0.00442], atol=6e-6)
    lowest, highest = Galerkin(25).extremes(found.motion)
    np.testing.assert_allclose([lowest, highest], [0.95104, 1.24239], atol=2e-5)


def test_wrong_values_are_named():
    for name, value in (("damping_ratio", -0.1), ("gap", -1.0), ("mean_load", math.nan), ("error_harmonics", [1.0])):
        with pytest.raises(ParameterError) as caught:
            spur_pair(**{**PAIR, name: value})
        assert caught.value.name == name
