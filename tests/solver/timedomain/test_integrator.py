"""The integrator against analytic motions, conservation of energy and SciPy."""

import numpy as np
import pytest

from solver import ParameterError
from solver.model.contact_system import ContactSystem, gear_system
from solver.timedomain import Status, Zone, integrate
from tests.conftest import antiphase, consistent, published
from tests.solver.timedomain.systems import flying_mass, full_gear_system, oscillator, scipy_motion


def _forced_response(damping, omega, time):
    """y'' + 2 zeta y' + y = 0.5 + cos Omega tau from rest at y = 0."""
    amplitude = 1.0 / (1.0 - omega**2 + 2j * damping * omega)
    root = np.sqrt(1.0 - damping**2)
    start = -0.5 - amplitude.real
    speed = -(1j * omega * amplitude).real
    free = np.exp(-damping * time) * (
        start * np.cos(root * time) + (speed + damping * start) / root * np.sin(root * time)
    )
    return 0.5 + (amplitude * np.exp(1j * omega * time)).real + free


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8, 1e-10, 1e-12])
def test_error_is_of_the_order_of_the_tolerance(tolerance):
    trajectory = integrate(oscillator(0.02), 0.7, [0.0, 0.0], 0.0, 60.0, tolerance=tolerance)
    error = np.abs(trajectory.states[:, 0] - _forced_response(0.02, 0.7, trajectory.times))
    assert trajectory.status is Status.COMPLETE
    assert 1e-4 * tolerance < np.max(error) < 10.0 * tolerance


def test_error_follows_the_step_with_the_order_of_the_series():
    ends, steps = [], []
    for tolerance in (1e-4, 1e-8):
        trajectory = integrate(oscillator(0.02), 0.7, [0.0, 0.0], 0.0, 200.0, tolerance=tolerance)
        ends.append(np.max(np.abs(trajectory.states[:, 0] - _forced_response(0.02, 0.7, trajectory.times))))
        steps.append(trajectory.zones.size)
    # Order 20 in the step; rounding of the number of steps and the mixture of frequencies leave some room.
    assert np.log(ends[0] / ends[1]) / np.log(steps[1] / steps[0]) == pytest.approx(20.0, abs=3.0)


def test_displacement_between_steps_is_as_accurate():
    trajectory = integrate(oscillator(0.02), 0.7, [0.0, 0.0], 0.0, 60.0, tolerance=1e-12)
    at = np.linspace(0.0, 60.0, 501)
    np.testing.assert_allclose(trajectory.displacement(at), _forced_response(0.02, 0.7, at), atol=1e-11)
    with pytest.raises(ParameterError, match="at ="):
        trajectory.displacement([61.0])


def test_switches_of_a_flying_mass_are_where_they_must_be():
    # 1 / 0.5 to the stop, half a period of the spring, back 2 gaps further, half a period, ...
    trajectory = integrate(flying_mass(1.0, 3.0), 1.0, [0.0, 0.5], 0.0, 31.0, tolerance=1e-15)
    expected = np.cumsum([2.0, np.pi, 8.0, np.pi, 8.0, np.pi])
    np.testing.assert_allclose(trajectory.switch_times, expected, rtol=0.0, atol=1e-12)
    assert trajectory.switch_zones.tolist() == [Zone.FRONT, Zone.FREE, Zone.BACK, Zone.FREE, Zone.FRONT, Zone.FREE]
    assert trajectory.displacement(2.0 + np.pi / 2) == pytest.approx(1.5, abs=1e-12)


def test_a_visit_within_one_step_is_found():
    # y = 1e-9 - (t - 1)^2 / 2 under a constant load: in contact for 9e-5 only, within one step of a polynomial.
    depth = 1e-9
    system = ContactSystem([[1.0]], [[0.0]], [[0.0]], [1.0], [1.0], 0.0, load=[[-1.0]])
    trajectory = integrate(system, 1.0, [depth - 0.5, 1.0], 0.0, 3.0)
    half = np.sqrt(2.0 * depth)
    np.testing.assert_allclose(trajectory.switch_times, [1.0 - half, 1.0 + half], rtol=0.0, atol=1e-10)
    missed = integrate(system, 1.0, [-depth - 0.5, 1.0], 0.0, 3.0)
    assert missed.switch_times.size == 0


def test_energy_is_conserved_over_many_switches():
    mass, stiffness = np.diag([1.0, 0.4]), np.array([[1.5, -0.5], [-0.5, 0.5]])
    contact = np.array([0.3, 1.0])
    system = ContactSystem(mass, np.zeros((2, 2)), stiffness, contact, 4.0 * contact, 0.2, 0.5)
    trajectory = integrate(system, 1.0, [1.0, -0.5, 0.2, 0.7], 0.0, 300.0, tolerance=1e-13)
    y, v = trajectory.states[:, :2], trajectory.states[:, 2:]
    energy = 0.5 * np.einsum("ti,ij,tj->t", v, mass, v) + 0.5 * np.einsum("ti,ij,tj->t", y, stiffness, y)
    energy += 2.0 * system.contact_force(y @ contact) ** 2
    assert trajectory.switch_times.size > 200
    np.testing.assert_allclose(energy, energy[0], rtol=1e-11)


@pytest.mark.parametrize("model, omega", [(published(), 0.6), (antiphase(), 1.3), (consistent(b=0.1), 0.55)])
def test_bevel_pair_agrees_with_scipy(model, omega):
    system, state, stop = gear_system(model), np.array([-0.5, 0.2, 0.0, 1.3]), 10.0 * np.pi / omega
    trajectory = integrate(system, omega, state, 0.0, stop, tolerance=1e-13)
    end, switches = scipy_motion(system, omega, state, stop)
    assert switches.size >= 5
    np.testing.assert_allclose(trajectory.switch_times, switches, rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(trajectory.states[-1], end, rtol=0.0, atol=1e-8)


@pytest.mark.parametrize(
    "model",
    [
        published(),
        consistent(alpha_harmonics=((0.1, 0.4),), f_e_harmonics=((0.05, 1.0),), xi_support=(0.01, 0.02, 0.01) * 2),
    ],
)
def test_merged_supports_move_lambda_as_seven_degrees_of_freedom(model):
    omega, rng = 0.6, np.random.default_rng(3)
    merged, full = gear_system(model), full_gear_system(model)
    position, speed = rng.uniform(-1, 1, 7), rng.uniform(-1, 1, 7)
    kinds = list(dict.fromkeys(zip(model.xi_support, model.k_support, strict=True)))

    def condense(vector):
        member = [kinds.index(pair) for pair in zip(model.xi_support, model.k_support, strict=True)]
        sums = [sum(model.direction[j] * vector[j] for j in range(6) if member[j] == g) for g in range(len(kinds))]
        return [*sums, vector[6]]

    one = integrate(merged, omega, [*condense(position), *condense(speed)], 0.0, 40.0, tolerance=1e-13)
    other = integrate(full, omega, [*position, *speed], 0.0, 40.0, tolerance=1e-13)
    at = np.linspace(0.0, 40.0, 300)
    assert one.switch_times.size > 4
    np.testing.assert_allclose(one.displacement(at), other.displacement(at), rtol=0.0, atol=1e-9)


def test_no_gap_is_a_linear_system():
    trajectory = integrate(gear_system(published(b=0.0)), 0.6, [0.0, -1.0, 0.0, 0.0], 0.0, 30.0)
    assert trajectory.status is Status.COMPLETE and trajectory.switch_times.size == 0
    tiny = integrate(gear_system(published(b=1e-12)), 0.6, [0.0, -1.0, 0.0, 0.0], 0.0, 30.0)
    np.testing.assert_allclose(trajectory.states[-1], tiny.states[-1], atol=1e-9)


def test_rest_on_a_border_is_rest():
    trajectory = integrate(flying_mass(1.0, 3.0), 1.0, [1.0, 0.0], 0.0, 10.0)
    np.testing.assert_allclose(trajectory.states, [[1.0, 0.0]] * len(trajectory.states))
    # Two masses, one resting on the border while the other swings: neither feels the other.
    pair = ContactSystem(np.eye(2), np.zeros((2, 2)), np.diag([0.0, 4.0]), [1.0, 0.0], [1.0, 0.0], 0.3)
    trajectory = integrate(pair, 1.0, [0.3, 1.0, 0.0, 0.0], 0.0, 10.0)
    assert trajectory.states[-1, 1] == pytest.approx(np.cos(20.0), abs=1e-9) and trajectory.zones.size < 50


def test_touching_a_border_from_inside_goes_on():
    # y = cos t + 1e-13 k touches y = 1 from both sides within rounding.
    for shift in (-1e-13, -1e-16, 0.0, 1e-16, 1e-13):
        system = ContactSystem([[1.0]], [[0.0]], [[1.0]], [1.0], [0.5], 1.0)
        trajectory = integrate(system, 1.0, [1.0 + shift, 0.0], 0.0, 100.0, tolerance=1e-13)
        assert trajectory.status is Status.COMPLETE and trajectory.zones.size < 400
        assert trajectory.states[-1, 0] == pytest.approx(np.cos(100.0), abs=1e-9)


def test_what_cannot_go_on_is_told_by_the_status():
    system = gear_system(published())
    assert integrate(system, 0.6, np.ones(4), 0.0, 1e3, max_steps=5).status is Status.TOO_MANY_STEPS
    runaway = ContactSystem([[1.0]], [[-50.0]], [[0.0]], [1.0], [1.0], 0.0, 0.0)
    ended = integrate(runaway, 1.0, [1.0, 1.0], 0.0, 100.0)
    assert ended.status is Status.NOT_FINITE and ended.status.sentence
    stiff = ContactSystem([[1.0]], [[0.0]], [[1e40]], [1.0], [1.0], 0.0, 0.0)
    assert integrate(stiff, 1.0, [1.0, 0.0], 1.0, 2.0).status in (Status.STEP_TOO_SMALL, Status.NOT_FINITE)
    assert all(status.sentence for status in Status)


@pytest.mark.parametrize(
    "arguments, name",
    [
        ((-1.0, np.ones(4), 0.0, 1.0), "omega"),
        ((0.6, np.ones(3), 0.0, 1.0), "state"),
        ((0.6, np.full(4, np.nan), 0.0, 1.0), "state"),
        ((0.6, "abcd", 0.0, 1.0), "state"),
        ((0.6, np.ones((2, 4)), 0.0, 1.0), "state"),
        ((0.6, np.ones(4), 1.0, 0.0), "stop"),
    ],
)
def test_bad_input_is_named(arguments, name):
    with pytest.raises(ParameterError, match=f"^{name} ="):
        integrate(gear_system(published()), *arguments)
    with pytest.raises(ParameterError, match="^tolerance ="):
        integrate(gear_system(published()), 0.6, np.ones(4), 0.0, 1.0, tolerance=0.0)
