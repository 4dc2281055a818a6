"""Contact laws beside the plain dead zone: flanks of unlike stiffness, damping of touching teeth, a cubic spring.

Every law goes through the balances, stability, boundaries and integration; each is held against an independent method.
"""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import simpson
from scipy.special import ellipk

from solver import (
    ContactSystem,
    DescribingFunction,
    Event,
    FreeVibrationStatus,
    LiftedSeeds,
    ParameterError,
    ProvenSeeds,
    all_solutions,
    free_vibration,
    solve,
    sweep_row,
)
from solver.boundaries import BIFURCATIONS
from solver.boundaries.first_order import FirstOrderProblem
from solver.boundaries.harmonic import HarmonicProblem
from solver.boundaries.problem import Plane
from solver.harmonic.describing_function import evaluate
from solver.harmonic.galerkin import Galerkin
from solver.harmonic.quantities import fill_system_quantities
from solver.model.packing import packed
from solver.stability import motion_multipliers
from solver.timedomain import (
    AttractorKind,
    advance,
    find_attractors,
    growth,
    integrate,
    measure,
    monodromy,
    orbit_state,
    shoot,
    trajectory,
)
from tests.solver.enumeration.test_systems import by_newton
from tests.solver.harmonic.projection import evaluated
from tests.solver.timedomain.systems import scipy_motion

LAWS = {
    "soft back": dict(back_stiffness=0.3),
    "stiff back": dict(back_stiffness=2.5),
    "dashpot": dict(contact_dashpot=0.2),
    "both": dict(back_stiffness=0.5, contact_dashpot=0.15),
}
CUBIC = {
    "cubic": dict(cubic=0.4),
    "softening": dict(cubic=-0.05, back_stiffness=2.0),
    "cubic and dashpot": dict(cubic=0.3, contact_dashpot=0.1, back_stiffness=0.6),
}
laws = pytest.mark.parametrize("law", list(LAWS.values()), ids=list(LAWS))
all_laws = pytest.mark.parametrize("law", [*LAWS.values(), *CUBIC.values()], ids=[*LAWS, *CUBIC])
OMEGA = 0.9


def pair(**changes) -> ContactSystem:
    """Two masses on springs, gaps that differ, a stiffness that varies; both flanks are struck at OMEGA."""
    given = dict(
        mass=[[1.0, 0.1], [0.1, 0.8]],
        damping=[[0.08, -0.02], [-0.02, 0.06]],
        stiffness=[[0.6, -0.2], [-0.2, 0.4]],
        contact=[1.0, -0.5],
        force=[0.7, -0.35],
        front_gap=0.3,
        back_gap=0.5,
        varying_force=[0.35, -0.175],
        stiffness_harmonics=((0.3, 0.2), (0.1, 1.0)),
        load=[[0.05, 0.0], [0.5, 0.2j]],
    )
    return ContactSystem(**{**given, **changes})


def random_motion(order: int, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=2 * order + 1) / np.maximum(1.0, np.arange(2 * order + 1) / 2.0)


def sampled(system: ContactSystem, balance: Galerkin, motion, samples: int = 2**15):
    """Angles, lambda, d lambda/d theta, f and its slope of a motion."""
    theta = 2.0 * np.pi * (np.arange(samples) + 0.5) / samples
    k = np.arange(1, balance.harmonics + 1)
    turns = np.multiply.outer(theta, k)
    place = motion[0] + np.cos(turns) @ motion[1::2] + np.sin(turns) @ motion[2::2]
    speed = np.cos(turns) @ (k * motion[2::2]) - np.sin(turns) @ (k * motion[1::2])
    slope = np.where(place > system.front_gap, 1.0, np.where(place < -system.back_gap, system.back_stiffness, 0.0))
    return theta, place, speed, system.contact_force(place), slope


# Balances ------------------------------------------------------------------------------------------------------------


@all_laws
@pytest.mark.parametrize("balance", [Galerkin(3), Galerkin(2, 2)], ids=repr)
def test_the_balance_is_the_projection_of_the_law(law, balance):
    """The damper's force is sampled as what it is, c_c lambda' while the teeth touch."""
    system, base = pair(**law), OMEGA / balance.period
    for seed in range(3):
        u = random_motion(balance.harmonics, seed)
        theta, place, speed, force, slope = sampled(system, balance, u)
        plain = force + system.contact_dashpot * slope * speed * base + system.cubic * place**3
        varied = force * sum(
            size * np.cos(l * balance.period * theta + phase)
            for l, (size, phase) in enumerate(system.stiffness_harmonics, 1)
        )
        residual, _ = evaluated(balance.problem(system, "omega", 0.1, 2.0), np.append(u, OMEGA))
        for k in range(balance.harmonics + 1):
            wave = np.exp(-1j * k * theta) * (1.0 if k == 0 else 2.0) / theta.size
            dynamic = system.dynamic_stiffness(k * base)
            load = system.load_harmonics(OMEGA, 1)[k // balance.period] if k in (0, balance.period) else 0.0
            right = load - system.force * (wave @ plain) - system.varying_force * (wave @ varied)
            row = (complex(u[2 * k - 1], -u[2 * k]) if k else u[0]) - system.contact @ np.linalg.solve(dynamic, right)
            row /= 1.0 + system.contact @ np.linalg.solve(dynamic, system.force)
            found = complex(residual[2 * k - 1], -residual[2 * k]) if k else residual[0]
            scale = np.abs(np.array([row.real, 1e-3 if k == 0 else row.imag])).max()
            ratio = found / row
            # Rows carry a factor that is a power of two.
            assert abs(ratio - 2.0 ** np.round(np.log2(abs(ratio)))) < 2e-3 / scale


@all_laws
@pytest.mark.parametrize("axis", ["omega", "gap_scale", "contact_damping"])
def test_jacobians_are_differences(law, axis):
    system = pair(**law)
    for balance in (Galerkin(3), Galerkin(2, 2), *(() if system.cubic else (DescribingFunction(),))):
        problem = balance.problem(system, axis, 0.2, 2.0, OMEGA)
        for seed in range(4):
            y = np.append(random_motion(problem.unknowns // 2, seed), 0.93)
            jacobian = evaluated(problem, y)[1]
            columns = [
                (evaluated(problem, y + 1e-6 * e)[0] - evaluated(problem, y - 1e-6 * e)[0]) / 2e-6
                for e in np.eye(y.size)
            ]
            size = max(1.0, np.max(np.abs(jacobian)))
            np.testing.assert_allclose(jacobian, np.transpose(columns), rtol=0, atol=2e-6 * size)


@laws
def test_first_order_is_galerkin_of_order_one_where_the_stiffness_is_steady(law):
    system = pair(**law, stiffness_harmonics=())
    for seed in range(4):
        u = random_motion(1, seed)
        first, galerkin = evaluate(system, OMEGA, u), Galerkin(1).problem(system, "omega", 0.1, 2.0)
        residual, jacobian = evaluated(galerkin, np.append(u, OMEGA))
        np.testing.assert_allclose(first[0], residual, rtol=0, atol=1e-12)
        np.testing.assert_allclose(first[1], jacobian[:, :3], rtol=0, atol=1e-12)


def test_a_dashpot_without_a_gap_is_a_damper():
    """Where the teeth always touch it is C + c_c h w^T."""
    closed = pair(front_gap=0.0, back_gap=0.0)
    touching, damped = replace(closed, contact_dashpot=0.3), closed.at("contact_damping", 0.3)
    u, balance = random_motion(4, 1), Galerkin(4)
    rows = [evaluated(balance.problem(one, "omega", 0.1, 2.0), np.append(u, OMEGA)) for one in (touching, damped)]
    steps = [np.linalg.solve(jacobian[:, :-1], residual) for residual, jacobian in rows]
    np.testing.assert_allclose(*steps, rtol=0, atol=1e-10)
    orbits = [shoot(one, OMEGA, np.zeros(4)) for one in (touching, damped)]
    np.testing.assert_allclose(orbits[0].state, orbits[1].state, rtol=0, atol=1e-9)
    np.testing.assert_allclose(orbits[0].multipliers, orbits[1].multipliers, rtol=0, atol=1e-9)


# Integration and stability -------------------------------------------------------------------------------------------


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


# A cubic spring ------------------------------------------------------------------------------------------------------


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


# Boundaries ----------------------------------------------------------------------------------------------------------


def rows(problem, y):
    residual, jacobian = np.empty(problem.unknowns), np.empty((problem.unknowns, y.size))
    problem.residual_and_jacobian(problem.parameters, problem.parameter_slope, y, residual, jacobian)
    return residual, jacobian


@laws
@pytest.mark.parametrize("order", [None, 3], ids=["first order", "order 3"])
def test_rows_of_boundaries(law, order):
    """Test functions are those of the multipliers, and the derivatives of all rows are differences."""
    system = pair(**law)
    plane = Plane(system, "omega", "gap_scale", (0.5, 1.5), (0.4, 1.6))
    found = FirstOrderProblem(plane) if order is None else HarmonicProblem(plane, Galerkin(order))
    place, rng = np.array([OMEGA, 1.0]), np.random.default_rng(4)
    for kind in (Event.FOLD, *BIFURCATIONS):
        for seed in range(4):
            u, kappa = random_motion(order or 1, seed), rng.uniform(-1.0, 1.0)
            point, torus = np.concatenate([u, place]), kind is Event.NEIMARK_SACKER
            if order is None:
                starts = [(contact, found.lift(kind, contact, point)) for contact in found.zones(kind, point)]
                starts = [(contact, np.insert(y, 5, kappa) if torus else y) for contact, y in starts]
            else:
                starts = [(None, np.insert(point, -2, kappa) if torus else point)]
            for contact, y in starts:
                problem = found.problem(kind, contact)
                residual, jacobian = rows(problem, y)
                if kind is Event.PERIOD_DOUBLING:
                    multipliers = motion_multipliers(system, OMEGA, u)
                    expected = np.prod(1.0 + multipliers).real
                    assert abs(residual[-1] - expected) < 1e-8 * np.prod(1.0 + np.abs(multipliers))
                slopes = [
                    np.transpose(
                        [
                            (rows(problem, y + h * e)[0] - rows(problem, y - h * e)[0]) / (2.0 * h)
                            for e in np.eye(y.size)
                        ]
                    )
                    for h in (4e-6, 2e-6)
                ]
                size = 1.0 + np.max(np.abs(jacobian), axis=1, keepdims=True)
                close = np.max(np.abs(slopes[1] - slopes[0]) / size) < 1e-6
                error = np.max(np.abs(jacobian - (4.0 * slopes[1] - slopes[0]) / 3.0) / size)
                assert error < (1e-7 if close else 1e-3), (kind, contact)


# Proof ---------------------------------------------------------------------------------------------------------------


@laws
def test_a_row_is_proven(law):
    """And Newton's method finds nothing else in it."""
    load, rng = [[0.05, 0.0], [0.06, 0.02j]], np.random.default_rng(3)
    system = pair(**law, stiffness_harmonics=(), load=load, damping=0.02 * np.eye(2))
    row = sweep_row(system, "omega", np.linspace(1.05, 1.15, 11), seeds=ProvenSeeds(columns=21))
    assert np.all(row.certified == 1)
    assert row.n_solutions.max() == 3
    for column in (0, int(np.argmax(row.n_solutions))):
        motions = row.motions[column, : row.n_solutions[column]]
        for motion in by_newton(system, float(row.grid[column]), rng, 20):
            assert np.min(np.max(np.abs(motions - motion), axis=1)) < 1e-6


# What is refused -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "value"),
    [("back_stiffness", 0.0), ("back_stiffness", -1.0), ("back_stiffness", np.nan), ("back_stiffness", "1")]
    + [
        ("cubic", np.nan),
        ("cubic", "1"),
        ("contact_dashpot", -0.1),
        ("contact_dashpot", np.inf),
        ("contact_dashpot", None),
    ],
)
def test_bad_values_are_refused(name, value):
    with pytest.raises(ParameterError, match=name):
        pair(**{name: value})
