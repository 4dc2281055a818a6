"""Periodic orbits: linear ones, and those of docs/physics.md, section 8, that one harmonic misjudges."""

import numpy as np
import pytest

from solver import ParameterError
from solver.model.contact_system import gear_system
from solver.timedomain import ShootingStatus, advance, monodromy, orbit_state, shoot
from tests.conftest import antiphase, consistent, published
from tests.solver.timedomain.systems import (
    first_order_state,
    flying_mass,
    full_gear_system,
    mathieu,
    oscillator,
    scipy_motion,
)

COS_20 = 0.93969262


def test_linear_orbit_and_multipliers_are_exact():
    damping, omega = 0.05, 0.7
    orbit = shoot(oscillator(damping), omega, [3.0, -1.0])
    amplitude = 1.0 / (1.0 - omega**2 + 2j * damping * omega)
    assert orbit.status is ShootingStatus.CONVERGED and orbit.iterations <= 2 and orbit.minimal_period == 1
    np.testing.assert_allclose(orbit.state, [0.5 + amplitude.real, -omega * amplitude.imag], atol=1e-11)
    np.testing.assert_allclose(orbit.harmonics, [0.5, amplitude, 0.0, 0.0, 0.0], atol=1e-11)
    exponent = (-damping + 1j * np.sqrt(1.0 - damping**2)) * 2.0 * np.pi / omega
    expected = sorted([np.exp(exponent), np.exp(exponent.conjugate())], key=lambda value: -value.imag)
    np.testing.assert_allclose(orbit.multipliers, expected, atol=1e-11)
    assert orbit.lowest == pytest.approx(0.5 - abs(amplitude)) and orbit.highest == pytest.approx(0.5 + abs(amplitude))


def test_a_period_taken_too_long_is_recognised():
    orbit = shoot(oscillator(0.05), 0.7, [0.0, 0.0], period=6, order=12)
    assert orbit.minimal_period == 1
    assert abs(orbit.harmonics[6]) == pytest.approx(1.0 / abs(1.0 - 0.49 + 0.07j))
    np.testing.assert_allclose(np.delete(orbit.harmonics, [0, 6]), 0.0, atol=1e-10)


@pytest.mark.parametrize(
    "omega, first, second, largest", [(0.58, 0.8888, 0.7953, 1.00981), (0.60, 0.7262, 0.6875, 1.02675)]
)
def test_true_orbits_of_the_lower_resonance(omega, first, second, largest):
    # The order-1 start is too far away at 0.58; the orbit is followed from 0.60.
    system, state = first_order_state(published(), 0.60, which=1)
    for value in np.arange(0.60, omega - 1e-9, -0.005):
        orbit = shoot(gear_system(published()), value, state)
        assert orbit.status is ShootingStatus.CONVERGED
        state = orbit.state
    orbit = shoot(system, omega, state)
    assert abs(orbit.harmonics[1]) == pytest.approx(first, abs=6e-5)
    assert abs(orbit.harmonics[2]) == pytest.approx(second, abs=6e-5)
    assert orbit.largest_multiplier == pytest.approx(largest, abs=1e-5)
    # Finite differences of SciPy's flow give the same modulus (docs/physics.md, section 8, has 1.011 and 1.026).
    matrix = np.empty((4, 4))
    for j in range(4):
        shift = 1e-5 * np.eye(4)[j]
        ends = [scipy_motion(system, omega, orbit.state + sign * shift, 2.0 * np.pi / omega)[0] for sign in (1, -1)]
        matrix[:, j] = (ends[0] - ends[1]) / 2e-5
    assert np.max(np.abs(np.linalg.eigvals(matrix))) == pytest.approx(largest, abs=1e-4)
    # A complex pair outside the circle: a torus surrounds the orbit.
    assert abs(orbit.multipliers[0].imag) > 0.1 and not orbit.stable


def test_the_lower_resonance_is_a_period_1_attractor_outside_two_neimark_sacker_points():
    system, state = first_order_state(published(), 0.60, which=1)
    found = {}
    for path in (np.arange(240, 227, -1) / 400.0, np.arange(240, 253) / 400.0):
        following = state
        for omega in path:
            orbit = shoot(system, omega, following)
            following, found[omega] = orbit.state, orbit
    assert [found[omega].stable for omega in (0.57, 0.5725, 0.575, 0.6225, 0.625, 0.63)] == [
        True,
        True,
        False,
        False,
        True,
        True,
    ]
    assert all(orbit.multipliers[0].imag > 0.4 for omega, orbit in found.items() if 0.57 <= omega <= 0.625)


@pytest.mark.parametrize(
    "model, omega, which, multiplier",
    [
        (published(), 0.62, 1, 1.010),
        (published(), 1.2265, -1, -1.177),
        (consistent(rotation_coupling=COS_20, variation_translation=0.0), 1.2, 0, -1.047),
    ],
)
def test_orbits_that_one_harmonic_calls_stable_are_not(model, omega, which, multiplier):
    orbit = shoot(*_with_omega(first_order_state(model, omega, which), omega))
    largest = orbit.multipliers[0]
    assert (abs(largest) if largest.imag else largest.real) == pytest.approx(multiplier, abs=1e-3)


def _with_omega(pair, omega):
    return pair[0], omega, pair[1]


def test_period_doubled_orbit_of_the_consistent_pair():
    system = gear_system(consistent(rotation_coupling=COS_20, variation_translation=0.0))
    near = advance(system, 1.2, [1.0, 2.0, 0.5, 0.5], 300).states[0, -1]
    orbit = shoot(system, 1.2, near, period=2)
    assert orbit.stable and orbit.minimal_period == 2
    assert abs(orbit.harmonics[1]) == pytest.approx(0.7888, abs=1e-4)
    assert abs(orbit.harmonics[2]) == pytest.approx(0.106, abs=5e-4)


def test_a_pair_of_multipliers_leaves_the_circle_near_1_904():
    modulus = {}
    for omega in (1.90, 1.904, 1.908):
        system, state = first_order_state(antiphase(rotation_coupling=COS_20), omega)
        orbit = shoot(system, omega, state)
        assert abs(orbit.multipliers[0].imag) > 0.9
        modulus[omega] = orbit.largest_multiplier
    assert modulus[1.90] < 1.0 < modulus[1.908] and modulus[1.904] == pytest.approx(1.0, abs=1e-4)


def test_merging_supports_adds_only_multipliers_of_the_supports():
    model = published()
    system, state = first_order_state(model, 1.2265)
    merged = shoot(system, 1.2265, state)
    start = np.zeros(14)
    # lambda from the merged orbit; the supports move along d, and d . x = u.
    for half in range(2):
        start[7 * half : 7 * half + 6] = model.direction * merged.state[2 * half] / np.sum(model.direction**2)
        start[7 * half + 6] = merged.state[2 * half + 1]
    full = shoot(full_gear_system(model), 1.2265, start)
    assert full.residual < 1e-10 and full.lowest == pytest.approx(merged.lowest, abs=1e-9)
    own = np.exp((-0.01 + 1j * np.sqrt(1.0 - 1e-4)) * 2.0 * np.pi / 1.2265)
    for value in [*merged.multipliers, own, own.conjugate()]:
        assert np.min(np.abs(full.multipliers - value)) < 1e-7


def test_multipliers_of_a_damped_mathieu_equation():
    # y = exp(-zeta t) u turns the damping into a shift of a, and scales the multipliers.
    a, q, damping = 1.4, 0.5, 0.1
    _, undamped, _ = monodromy(mathieu(a - damping**2, q), 2.0, [0.0, 0.0])
    orbit = shoot(mathieu(a, q, 2.0 * damping), 2.0, [0.01, 0.0])
    expected = np.exp(-damping * np.pi) * np.linalg.eigvals(undamped).astype(complex)
    expected = expected[np.lexsort((-expected.imag, -np.round(np.abs(expected), 12)))]
    np.testing.assert_allclose(orbit.multipliers, expected, atol=1e-10)


def test_orbit_state_is_exact_in_permanent_contact():
    damping, omega = 0.05, 0.7
    amplitude = 1.0 / (1.0 - omega**2 + 2j * damping * omega)
    state = orbit_state(oscillator(damping), omega, [0.5, amplitude.real, -amplitude.imag])
    np.testing.assert_allclose(state, [0.5 + amplitude.real, -omega * amplitude.imag], atol=1e-12)
    doubled = orbit_state(oscillator(damping), omega, [0.5, 0.0, 0.0, amplitude.real, -amplitude.imag], period=2)
    np.testing.assert_allclose(doubled, state, atol=1e-12)


def test_search_that_finds_nothing_says_so():
    # A free mass under a mean load alone never comes back.
    drifting = type(flying_mass())([[1.0]], [[0.0]], [[0.0]], [1.0], [1.0], 1.0, load=[[-1.0]])
    orbit = shoot(drifting, 1.0, [0.0, 0.0], max_iterations=5)
    assert orbit.status is ShootingStatus.NOT_CONVERGED and np.isnan(orbit.multipliers).all() and not orbit.stable
    assert all(status.sentence for status in ShootingStatus)


@pytest.mark.parametrize(
    "call, name",
    [
        (lambda s: shoot(s, 1.0, [0.0, 0.0], period=0), "period"),
        (lambda s: shoot(s, 1.0, [0.0]), "state"),
        (lambda s: shoot(s, 1.0, [0.0, 0.0], tolerance=2.0), "tolerance"),
        (lambda s: orbit_state(s, 1.0, [1.0, 2.0]), "coefficients"),
        (lambda s: orbit_state(s, 1.0, [1.0], samples=1), "samples"),
    ],
)
def test_bad_input_is_named(call, name):
    with pytest.raises(ParameterError, match=f"^{name} ="):
        call(oscillator(0.05))
