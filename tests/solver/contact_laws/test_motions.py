"""Motions of contact laws beside the plain dead zone by integration, their stability and their forces."""

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from solver import ContactSystem, solve
from solver.harmonic.galerkin import Galerkin
from solver.harmonic.quantities import fill_system_quantities
from solver.model.packing import packed
from solver.stability import motion_multipliers
from solver.timedomain import AttractorKind, advance, find_attractors, integrate, monodromy, orbit_state, shoot
from tests.solver.contact_laws.laws import OMEGA, all_laws, laws, pair, random_motion, sampled
from tests.solver.harmonic.projection import evaluated
from tests.solver.timedomain.systems import scipy_motion


@all_laws
def test_motions_are_those_of_an_independent_integrator(law):
    system, start, stop = pair(**law), np.array([0.9, -0.4, 0.1, 0.6]), 25.0
    expected, switches = scipy_motion(system, OMEGA, start, stop)
    found = integrate(system, OMEGA, start, 0.0, stop, tolerance=1e-13)
    assert set(found.zones) == {-1, 0, 1}
    np.testing.assert_allclose(found.states[-1], expected, rtol=0, atol=1e-9)
    np.testing.assert_allclose(found.switch_times, switches, rtol=0, atol=1e-9)


@all_laws
def test_orbits_of_high_order_are_those_of_shooting(law):
    system, balance = pair(**law), Galerkin(31)
    found = solve(system, np.append([0.0, 0.8, 0.3], np.zeros(60)), OMEGA, balance=balance)
    assert found.status.name == "CONVERGED"
    orbit = shoot(system, OMEGA, orbit_state(system, OMEGA, found.motion), order=8)
    assert orbit.status.name == "CONVERGED"
    assert orbit.switches == 4
    harmonics = np.append(found.motion[0], found.motion[1:17:2] - 1j * found.motion[2:18:2])
    np.testing.assert_allclose(harmonics, orbit.harmonics, rtol=0, atol=3e-4)
    multipliers = motion_multipliers(system, OMEGA, found.motion)
    np.testing.assert_allclose(
        np.poly(multipliers), np.poly(orbit.multipliers), rtol=0, atol=1e-2 * np.max(np.abs(np.poly(multipliers)))
    )
    # The jump of the damper's force leaves harmonics like 1/k^3 in lambda; without it like 1/k^4.
    assert found.stable == (np.prod(1.0 - orbit.multipliers).real > 0.0)


@all_laws
def test_the_monodromy_matrix_is_the_slope_of_the_map(law):
    system, start = pair(**law), np.array([0.9, -0.4, 0.1, 0.6])
    _, matrix, _ = monodromy(system, OMEGA, start, 2)
    step = 1e-6
    ends = [
        advance(system, OMEGA, start + sign * step * np.eye(4), 2, tolerance=1e-13).states[:, -1] for sign in (1, -1)
    ]
    np.testing.assert_allclose(matrix, (ends[0] - ends[1]).T / (2.0 * step), rtol=0, atol=1e-6)


@settings(max_examples=10)
@given(st.floats(0.2, 4.0), st.floats(0.0, 0.4), st.integers(0, 1000))
def test_a_mirrored_system_has_mirrored_motions(ratio, dashpot, seed):
    """Seen from behind, the back flank is in front, and the front one has 1/r of its stiffness."""
    system = pair(back_stiffness=ratio, contact_dashpot=dashpot)
    mirrored = replace(
        system,
        front_gap=system.back_gap,
        back_gap=system.front_gap,
        force=ratio * system.force,
        varying_force=ratio * system.varying_force,
        back_stiffness=1.0 / ratio,
        load=-system.load,
    )
    start = np.random.default_rng(seed).normal(size=4)
    ends = [integrate(one, OMEGA, sign * start, 0.0, 20.0) for one, sign in ((system, 1.0), (mirrored, -1.0))]
    np.testing.assert_allclose(ends[0].states[-1], -ends[1].states[-1], rtol=0, atol=1e-7)
    u = random_motion(3, seed)
    steps = []
    for one, sign in ((system, 1.0), (mirrored, -1.0)):
        residual, jacobian = evaluated(Galerkin(3).problem(one, "omega", 0.1, 2.0), np.append(sign * u, OMEGA))
        steps.append(sign * np.linalg.solve(jacobian[:, :-1], residual))
    np.testing.assert_allclose(*steps, rtol=0, atol=1e-8 * max(1.0, np.max(np.abs(steps[0]))))


def test_flanks_that_meet_without_a_gap():
    """f is bilinear: x'' + 2 zeta x' + x for x > 0 and + r x below, whose free period is pi (1 + 1/sqrt(r))."""
    ratio = 0.25
    spring = ContactSystem([[1.0]], [[0.0]], [[0.0]], [1.0], [1.0], 0.0, 0.0, back_stiffness=ratio)
    period = np.pi * (1.0 + 1.0 / np.sqrt(ratio))
    found = integrate(spring, 1.0, [1.0, 0.0], 0.0, period, tolerance=1e-13)
    np.testing.assert_allclose(found.states[-1], [1.0, 0.0], rtol=0, atol=1e-10)
    assert abs(found.displacement(np.array([0.5 * period]))[0] + 1.0 / np.sqrt(ratio)) < 1e-10
    loaded = replace(spring, damping=[[0.1]], load=[[0.3], [0.5]])
    orbit = shoot(loaded, 1.3, [0.0, 0.0])
    expected, _ = scipy_motion(loaded, 1.3, orbit.state, 2.0 * np.pi / 1.3)
    np.testing.assert_allclose(expected, orbit.state, rtol=0, atol=1e-9)
    found = solve(
        loaded,
        np.append([orbit.harmonics[0].real, orbit.harmonics[1].real, -orbit.harmonics[1].imag], np.zeros(28)),
        1.3,
    )
    np.testing.assert_allclose(found.motion[:2], [orbit.harmonics[0].real, orbit.harmonics[1].real], atol=1e-5)
    np.testing.assert_allclose(
        np.poly(motion_multipliers(loaded, 1.3, found.motion)), np.poly(orbit.multipliers), rtol=0, atol=1e-3
    )


PRESSED = dict(load=[[0.35, 0.0], [0.9, 0.3j]])


def largest_force(system: ContactSystem, times, place, speed) -> float:
    """Over the force at rest, of samples; the stiffness varies in it by half."""
    touching = place > system.front_gap
    variation = sum(
        size * np.cos(l * OMEGA * times + phase) for l, (size, phase) in enumerate(system.stiffness_harmonics, 1)
    )
    force = (1.0 + 0.5 * variation) * system.contact_force(place) + system.contact_dashpot * speed
    closed = system.stiffness + np.outer(system.force, system.contact)
    rest = np.linalg.solve(closed, system.load[0].real + system.force * system.front_gap)
    return np.max(force[touching]) / (system.contact @ rest - system.front_gap)


@laws
def test_attractors_and_their_largest_force(law):
    system = pair(**law, **PRESSED)
    found, period = find_attractors(system, "omega", [OMEGA]), 2.0 * np.pi / OMEGA
    assert found.kind[0, 0] == AttractorKind.PERIOD_1
    orbit = shoot(system, OMEGA, found.state[0, 0])
    assert orbit.stable
    assert orbit.switches == 4
    np.testing.assert_allclose(found.lowest[0, 0], orbit.lowest, rtol=0, atol=1e-7)
    times = np.linspace(0.0, period, 100_001)
    place = integrate(system, OMEGA, orbit.state, 0.0, period).displacement(times)
    speed = np.gradient(place, times, edge_order=2)
    np.testing.assert_allclose(found.force[0, 0], largest_force(system, times, place, speed), rtol=1e-3)


@laws
def test_the_largest_force_of_a_balance(law):
    """The damper's force is largest where contact begins, or between."""
    system, balance, values = pair(**law, **PRESSED), Galerkin(3), np.empty((1, 13))
    for seed in range(4):
        u = random_motion(3, seed)
        fill_system_quantities(*packed(system, "omega", None, 3, 1), np.array([OMEGA]), u[None], values)
        theta, place, speed, _, _ = sampled(system, balance, u, 2**17)
        np.testing.assert_allclose(values[0, 9], largest_force(system, theta / OMEGA, place, OMEGA * speed), rtol=1e-3)
