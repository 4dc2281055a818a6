"""A cubic spring beside the contact."""

import numpy as np
import pytest
from scipy.integrate import simpson
from scipy.special import ellipk

from solver import (
    ContactSystem,
    DescribingFunction,
    FreeVibrationStatus,
    LiftedSeeds,
    ParameterError,
    all_solutions,
    free_vibration,
    sweep_row,
)
from solver.boundaries.problem import Plane
from solver.harmonic.galerkin import Galerkin
from solver.timedomain import find_attractors, growth, integrate, measure, orbit_state, shoot, trajectory
from tests.solver.contact_laws.laws import CUBIC, OMEGA, pair


def test_free_vibration_of_a_cubic_spring():
    """x'' + x + k_3 x^3 = 0 has the period 4 K(m)/w, w^2 = 1 + k_3 A^2, m = k_3 A^2/(2 w^2) (Duffing's equation)."""
    duffing, highest = (
        ContactSystem([[1.0]], [[0.0]], [[0.0]], [1.0], [1.0], 0.0, 0.0, cubic=0.5),
        np.array([0.5, 2.0, 5.0]),
    )
    found = free_vibration(duffing, highest, order=21)
    square = 1.0 + 0.5 * highest**2
    expected = 0.5 * np.pi * np.sqrt(square) / ellipk(0.5 * 0.5 * highest**2 / square)
    assert np.all(found.status == FreeVibrationStatus.CONVERGED)
    np.testing.assert_allclose(found.omega, expected, rtol=1e-10)


def test_free_vibration_says_why_there_is_none():
    """The load presses the mass away from the only stop."""
    stop = ContactSystem([[1.0]], [[0.0]], [[0.0]], [1.0], [1.0], 1.0, load=[[-1.0]])
    found = free_vibration(stop, [2.0])
    assert np.isnan(found.omega[0])
    assert FreeVibrationStatus(int(found.status[0])) is FreeVibrationStatus.NO_MEAN


def test_a_motion_through_series_is_measured_as_by_its_trajectory():
    system, start, periods = pair(**CUBIC["cubic and dashpot"]), np.array([0.9, -0.4, 0.1, 0.6]), 3
    found = measure(system, OMEGA, start, periods, divisor=3, order=4, tolerance=1e-12)
    motion = integrate(system, OMEGA, start, 0.0, periods * 2.0 * np.pi / OMEGA, tolerance=1e-13)
    times = np.linspace(0.0, motion.times[-1], 60_001)
    place = motion.displacement(times)
    np.testing.assert_allclose(found.state, motion.states[-1], rtol=0, atol=1e-9)
    np.testing.assert_allclose([found.lowest, found.highest], [place.min(), place.max()], rtol=0, atol=1e-6)
    assert found.switches == motion.switch_times.size
    for k, harmonic in enumerate(found.harmonics):
        integral = simpson(place * np.exp(-1j * k * OMEGA / 3 * times), x=times)
        np.testing.assert_allclose(harmonic, integral / times[-1] * (2.0 if k else 1.0), rtol=0, atol=1e-6)


def test_a_subharmonic_orbit_of_a_cubic_spring_has_its_shortest_period():
    """A motion of one period repeats after two as well."""
    system = pair(**CUBIC["cubic"])
    once = shoot(system, OMEGA, np.zeros(4))
    twice = shoot(system, OMEGA, once.state, 2)
    assert (once.status.name, twice.status.name, twice.minimal_period) == ("CONVERGED", "CONVERGED", 1)
    np.testing.assert_allclose(np.poly(twice.multipliers), np.poly(once.multipliers**2), rtol=0, atol=1e-8)


def test_rows_of_order_h_with_a_cubic_spring():
    """x'' + 0.1 x' + x + 0.2 x^3 = 0.3 cos: one branch with two folds, and its motions are orbits."""
    duffing = ContactSystem([[1.0]], [[0.1]], [[0.0]], [1.0], [1.0], 0.0, 0.0, cubic=0.2, load=[[0.0], [0.3]])
    row = sweep_row(duffing, "omega", np.linspace(0.8, 2.0, 25), balance=Galerkin(5), seeds=LiftedSeeds(15))
    assert sorted(set(row.n_solutions)) == [1, 3]
    column = int(np.flatnonzero(row.n_solutions == 3)[0])
    omega = float(row.grid[column])
    for motion in row.motions[column]:
        orbit = shoot(duffing, omega, orbit_state(duffing, omega, motion))
        np.testing.assert_allclose(
            orbit.highest, np.max(Galerkin(5).displacement(motion, np.linspace(0, 7, 2000))), atol=1e-3
        )


@pytest.mark.parametrize(
    "asked",
    [
        lambda system: all_solutions(system, OMEGA),
        lambda system: DescribingFunction().problem(system, "omega", 0.5, 1.0),
        lambda system: Plane(system, "omega", "gap_scale", (0.5, 1.5), (0.4, 1.6)),
        lambda system: find_attractors(system, "omega", [OMEGA]),
        lambda system: trajectory(system, OMEGA, np.zeros(4), 1, 16),
        lambda system: growth(system, OMEGA, np.zeros(4), 3),
    ],
    ids=["proof", "first order", "boundaries", "attractors", "trajectory", "growth"],
)
def test_what_a_cubic_spring_has_not_is_refused(asked):
    with pytest.raises(ParameterError) as error:
        asked(pair(cubic=0.1))
    assert error.value.name == "cubic"
