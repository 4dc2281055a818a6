"""Samples of motions against the step-by-step integrator, quantities that are never sampled, and shooting."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solver import ParameterError
from solver.model.contact_system import ContactSystem, gear_system
from solver.timedomain import Status, advance, integrate, measure, motion_quantities, shoot, trajectory
from tests.conftest import antiphase, consistent, published
from tests.solver.timedomain.systems import first_order_state, flying_mass, full_gear_system
from tests.solver.timedomain.test_quantities import SPUR, UNEQUAL, settled

SYSTEMS = [
    (gear_system(published()), 0.6),
    (gear_system(antiphase()), 1.3),
    (gear_system(consistent(b=0.1)), 0.55),
    (full_gear_system(published()), 0.6),
    (flying_mass(1.0, 3.0, 0.02), 0.2),
    (gear_system(published(b=0.0)), 0.9),
]


@pytest.mark.parametrize("system, omega", SYSTEMS)
def test_samples_are_on_the_motion_of_the_stepwise_integrator(system, omega):
    state = np.random.default_rng(5).uniform(-2.0, 2.0, 2 * system.degrees)
    found = trajectory(system, omega, state, 3, 37, tolerance=1e-13)
    whole = integrate(system, omega, state, 0.0, 6.0 * np.pi / omega, tolerance=1e-13)
    assert found.status is Status.COMPLETE and found.displacement.shape == (111,)
    np.testing.assert_allclose(found.displacement, whole.displacement(found.times), rtol=0.0, atol=1e-9)
    for i in (0, 1, 36, 37, 60, 110):
        there = integrate(system, omega, state, 0.0, found.times[i], tolerance=1e-13).states[-1]
        np.testing.assert_allclose(found.states[i], there, rtol=0.0, atol=1e-9)
        assert found.speed[i] == pytest.approx(system.contact @ there[system.degrees :], abs=1e-9)
    np.testing.assert_allclose(found.end, whole.states[-1], rtol=0.0, atol=1e-9)


@given(st.integers(1, 5), st.integers(1, 70), st.integers(0, 2**32 - 1))
@settings(deadline=None, max_examples=40)
def test_poincare_points_are_the_sections_for_any_number_of_samples(periods, samples, seed):
    system, omega = SYSTEMS[1]
    state = np.random.default_rng(seed).uniform(-2.0, 2.0, 2 * system.degrees)
    found = trajectory(system, omega, state, periods, samples, tolerance=1e-10)
    sections = advance(system, omega, state, periods, tolerance=1e-10).states[0]
    np.testing.assert_allclose(found.states[::samples], np.vstack([state, sections[:-1]]), rtol=0.0, atol=1e-8)
    np.testing.assert_array_equal(found.end, sections[-1])
    np.testing.assert_allclose(found.periods[::samples], np.arange(periods), atol=1e-12)


def test_samples_of_samples_are_the_same():
    system, state = first_order_state(published(), 0.6)
    fine, coarse = (trajectory(system, 0.6, state, 2, samples) for samples in (240, 48))
    np.testing.assert_allclose(fine.states[::5], coarse.states, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("model, omega", [(published(), 0.9), (UNEQUAL, 0.55), (SPUR, 0.5), (antiphase(f_e=0.35), 0.5)])
def test_what_is_read_of_the_samples_are_the_quantities(model, omega):
    state = settled(model, omega, separate=True)
    quantities, _ = motion_quantities(model, omega, state)
    found = trajectory(model, omega, state, 1, 20_000)
    psi, force = found.transmission_error, found.force / found.static_force
    # A grid of N samples misses an extreme by its curvature / (8 N^2), and means of smooth waves by less.
    close = {"abs": 2e-6}
    assert (found.displacement.min(), found.displacement.max()) == pytest.approx(
        (quantities.lowest, quantities.highest), **close
    )
    assert (found.displacement.mean(), found.displacement.std()) == pytest.approx(
        (quantities.mean, quantities.rms), **close
    )
    assert (psi.min(), psi.max(), psi.std()) == pytest.approx(
        (quantities.error_lowest, quantities.error_highest, quantities.error_rms), **close
    )
    assert force.max() == pytest.approx(quantities.dynamic_factor, **close)
    assert np.mean(np.abs(found.displacement) <= model.b) == pytest.approx(quantities.contact_loss, abs=2e-4)
    assert np.max(np.abs(found.support_forces), initial=0.0) == pytest.approx(quantities.support_force, **close)


def test_supports_that_coordinates_do_not_tell_are_left_out():
    merged, apart = settled(UNEQUAL, 0.55), settled(UNEQUAL, 0.55, separate=True)
    one, other = (trajectory(UNEQUAL, 0.55, state, 1, 50) for state in (merged, apart))
    assert one.support_forces.shape == (50, 0) and other.support_forces.shape[1] > 0
    np.testing.assert_allclose(one.transmission_error, other.transmission_error, atol=1e-8)


def test_a_motion_of_two_periods_closes_after_two():
    # docs/physics.md, section 9: the spur pair's 2T motion at 1.8.
    state = settled(SPUR, 1.8, 2, [1.2, 0.1])
    found = trajectory(SPUR, 1.8, state, 4, 64)
    np.testing.assert_allclose(found.displacement[:128], found.displacement[128:], atol=1e-8)
    assert np.max(np.abs(found.displacement[:64] - found.displacement[64:128])) > 0.2
    lines = np.abs(np.fft.rfft(found.displacement[:128])) * 2.0 / 128
    assert (lines[1], lines[2]) == pytest.approx((0.18730, 0.02828), abs=2e-5)


def test_fourier_lines_are_those_of_the_exact_integrals():
    system, state = first_order_state(antiphase(), 1.3)
    orbit = shoot(system, 1.3, state)
    exact = measure(system, 1.3, orbit.state, 1, order=8).harmonics
    lines = np.fft.rfft(trajectory(system, 1.3, orbit.state, 1, 4096).displacement) * 2.0 / 4096
    np.testing.assert_allclose(lines[1:9], exact[1:], atol=1e-7)


def test_a_motion_that_overflows_says_so():
    # y'' = 1e4 y: e^100 a period.
    system = ContactSystem([[1.0]], [[0.0]], [[-1e4]], [1.0], [1.0], 1.0)
    found = trajectory(system, 2.0 * np.pi, [1e-3, 0.1], 20, 4)
    assert found.status is Status.NOT_FINITE
    assert np.isfinite(found.displacement[:4]).all() and np.isnan(found.displacement[-1])


def test_force_of_a_system_whose_stiffness_varies_elsewhere_is_not_told():
    pair = dict(mass=np.eye(2), damping=0.1 * np.eye(2), stiffness=np.eye(2), contact=[1.0, 0.0], force=[1.0, 0.5])
    along = ContactSystem(**pair, front_gap=0.3, varying_force=[0.4, 0.2], stiffness_harmonics=[(0.5, 0.0)])
    other = ContactSystem(**pair, front_gap=0.3, varying_force=[0.4, 0.0], stiffness_harmonics=[(0.5, 0.0)])
    found = trajectory(along, 1.0, [1.0, 0.0, 0.0, 0.0], 1, 8)
    expected = np.maximum(found.displacement - 0.3, 0.0) * (1.0 + 0.4 * 0.5 * np.cos(found.times))
    np.testing.assert_allclose(found.force, expected, atol=1e-14)
    assert np.isnan(trajectory(other, 1.0, [1.0, 0.0, 0.0, 0.0], 1, 8).force).all()
    assert np.isnan(found.transmission_error).all()


@pytest.mark.parametrize(
    "change, name",
    [
        ({"system": "gear"}, "system"),
        ({"omega": 0.0}, "omega"),
        ({"state": np.zeros(3)}, "state"),
        ({"periods": 0}, "periods"),
        ({"samples": 1.5}, "samples"),
        ({"tolerance": 1.0}, "tolerance"),
    ],
)
def test_bad_input_is_named(change, name):
    arguments = {"system": published(), "omega": 0.6, "state": np.zeros(4), "periods": 1, "samples": 8} | change
    with pytest.raises(ParameterError, match=f"^{name} ="):
        trajectory(**arguments)
