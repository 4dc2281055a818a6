"""Floquet multipliers against what is known in closed form or computed with none of the solver's kernels."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.special import mathieu_a, mathieu_b

from solver.model.contact_system import gear_system
from solver.stability import Instability, classify, monodromies, motion_multipliers, multipliers
from tests.conftest import antiphase, consistent, published
from tests.solver.stability.orbits import first_order, matched, oscillator, unmerged
from tests.solver.strategies import frequencies, models


def first_order_form(system, closed, s=0.0):
    """Matrix of the linear system in or out of contact, for a stiffness variation s, from M, C, K alone."""
    n = system.degrees
    stiffness = system.stiffness + closed * np.outer(system.force + s * system.varying_force, system.contact)
    top = np.hstack([np.zeros((n, n)), np.eye(n)])
    return np.vstack([top, -np.linalg.solve(system.mass, np.hstack([stiffness, system.damping]))])


def variation(system, angle):
    return sum(a * np.cos(l * angle + phase) for l, (a, phase) in enumerate(system.stiffness_harmonics, start=1))


def integrated(system, omega, motion):
    """The monodromy matrix by an integrator of SciPy, restarted at sign changes found on a fine grid and polished."""
    order = len(motion) // 2
    k = np.arange(1, order + 1)

    def displacement(angle):
        turns = np.multiply.outer(angle, k)
        return motion[0] + np.cos(turns) @ motion[1::2] + np.sin(turns) @ motion[2::2]

    def closed(angle):
        return (displacement(angle) > system.front_gap) | (displacement(angle) < -system.back_gap)

    grid = np.linspace(0.0, 2.0 * np.pi, 20_001)
    cuts = [0.0]
    for i in np.flatnonzero(np.diff(closed(grid).astype(int))):
        low, high = grid[i], grid[i + 1]
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if closed(middle) == closed(grid[i]) else (low, middle)
        cuts.append(high)
    state, n = np.eye(2 * system.degrees), 2 * system.degrees
    for begin, end in zip(cuts, [*cuts[1:], 2.0 * np.pi], strict=True):
        inside = bool(closed(0.5 * (begin + end)))
        constant, varying = first_order_form(system, inside), first_order_form(system, inside, 1.0)
        varying -= constant
        result = solve_ivp(
            lambda t, x, c=constant, v=varying: ((c + variation(system, omega * t) * v) @ x.reshape(n, n)).ravel(),
            (begin / omega, end / omega),
            state.ravel(),
            method="DOP853",
            rtol=1e-11,
            atol=1e-13,
        )
        state = result.y[:, -1].reshape(n, n)
    return state


@pytest.mark.parametrize("omega", [0.07, 0.66, 1.9])
@pytest.mark.parametrize("make", [published, consistent, antiphase])
def test_permanent_contact_with_variation_against_an_integrator(make, omega):
    model = make(alpha=0.35, alpha_harmonics=[[0.2, 0.4], [0.1, -1.0]], b=0.0)
    motion = np.array([[5.0, 0.3, 0.2]])
    found = monodromies(model, "omega", [omega], motion)[0]
    np.testing.assert_allclose(found, integrated(gear_system(model), omega, motion[0]), rtol=0, atol=2e-9)


def test_motions_that_hit_both_flanks_against_an_integrator():
    model = antiphase(alpha=0.4, kappa=[0.4, 0.7], k_support=[1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
    motion = np.array([0.3, 1.4, -0.8, 0.3, 0.5, -0.2, 0.4])
    found = monodromies(model, "omega", [0.47], motion[None])[0]
    np.testing.assert_allclose(found, integrated(gear_system(model), 0.47, motion), rtol=0, atol=2e-9)


@pytest.mark.parametrize("q", [0.05, 0.7, 3.0])
@pytest.mark.parametrize("characteristic, sign", [(1, -1), (2, 1), (3, -1)])
def test_transition_curves_of_mathieu(q, characteristic, sign):
    """y'' + (a - 2 q cos 2x) y = 0 has the multiplier 1 or -1 over pi on them, and is unstable between a_m and b_m."""
    edges = [float(mathieu_b(characteristic, q)), float(mathieu_a(characteristic, q))]
    for a, inside in [(edges[0], False), (edges[1], False), (0.5 * sum(edges), True)]:
        system = oscillator(a - 1.0, force=1.0, varying=2.0 * q, harmonics=[[1.0, np.pi]])
        found = monodromies(system, "omega", [2.0], np.array([[9.0, 0.0, 0.0]]))
        trace = np.trace(found[0])
        if not inside:
            assert abs(trace - 2.0 * sign) < 1e-9
        elif edges[1] - edges[0] > 1e-3:
            kind = classify(np.linalg.eigvals(found))
            assert kind[0] == (Instability.FOLD if sign > 0 else Instability.PERIOD_DOUBLING)


@pytest.mark.parametrize("damping", [0.0, 0.1, 2.0, 3.0])
def test_damped_oscillator_in_closed_form(damping):
    system, omega = oscillator(0.5, damping, force=0.5), 0.9
    period = 2.0 * np.pi / omega
    roots = np.roots([1.0, damping, 1.0])
    for motion, exponents in [([3.0, 0.1, 0.2], roots), ([0.0, 0.1, 0.2], np.roots([1.0, damping, 0.5]))]:
        # A double root is known to the square root of rounding only.
        assert matched(motion_multipliers(system, omega, motion), np.exp(exponents * period)) < 1e-7
        twice = motion_multipliers(system, omega, [motion[0], *[0.0] * 2, *motion[1:]], period=2)
        assert matched(twice, np.exp(exponents * 2.0 * period)) < 1e-7


def test_constant_pieces_are_exponentials():
    """Half a period in contact: lambda = sin theta with a gap of 0 in front and none behind."""
    model, omega = published(alpha=0.0), 0.37
    system = dataclasses.replace(gear_system(model), front_gap=0.0, back_gap=np.inf)
    half = np.pi / omega
    found = monodromies(system, "omega", [omega], np.array([[0.0, 0.0, 1.0]]))[0]
    expected = expm(first_order_form(system, 0.0) * half) @ expm(first_order_form(system, 1.0) * half)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10)


@given(models(), frequencies, st.lists(st.integers(-2000, 2000), min_size=7, max_size=7), st.integers(1, 3))
@settings(max_examples=40)
def test_liouville(model, omega, numbers, period):
    motion = np.array(numbers)[None] / 1000.0
    system = gear_system(model)
    decay = np.trace(np.linalg.solve(system.mass, system.damping))
    determinant = np.linalg.det(monodromies(model, "omega", [omega], motion, period=period))[0]
    expected = np.exp(-decay * 2.0 * np.pi * period / omega)
    largest = np.max(np.abs(multipliers(model, "omega", [omega], motion, period=period)))
    assert abs(determinant - expected) < 1e-8 * max(1.0, largest**2)


@pytest.mark.parametrize("unlike", [{}, {"kappa": [0.3, 0.6], "xi_support": [0.02] * 3 + [0.05] * 3}])
@pytest.mark.parametrize("make", [published, antiphase])
def test_merged_supports_leave_out_their_own_multipliers(make, unlike):
    model, omega = make(**unlike), 0.58
    motions, _ = first_order(model, omega)
    merged = motion_multipliers(model, omega, motions)
    full = motion_multipliers(unmerged(model), omega, motions)
    kinds = list(zip(model.xi_support, model.k_support, strict=True))
    spare = [kind for kind in set(kinds) for _ in range(kinds.count(kind) - 1)]
    exponents = np.array([-xi + sign * 1j * np.sqrt(k - xi**2) for xi, k in spare for sign in (1, -1)])
    alone = np.exp(exponents * 2.0 * np.pi / omega)
    for few, many in zip(merged, full, strict=True):
        assert few.size + alone.size == many.size == 14
        # The spare ones are several times the same, which rounding spreads.
        assert matched(many, np.concatenate([few, alone])) < 1e-7


def flow(system, omega, load, state):
    """State after one period of the nonlinear system, in pieces too short to matter where contact switches."""
    n = system.degrees
    inverse = np.linalg.inv(system.mass)

    def slope(t, x):
        y, v = x[:n], x[n:]
        force = system.contact_force(system.contact @ y)
        drive = (system.force + system.varying_force * variation(system, omega * t)) * force
        return np.concatenate([v, inverse @ (load(t) - system.damping @ v - system.stiffness @ y - drive)])

    return solve_ivp(
        slope,
        (0.0, 2.0 * np.pi / omega),
        state,
        method="DOP853",
        rtol=1e-11,
        atol=1e-12,
        max_step=0.05,
        dense_output=True,
    )


@pytest.mark.costly
def test_derivative_of_the_flow():
    """About a periodic orbit found by shooting, which loses contact; its harmonics are all that the solver is told."""
    model, omega = published(), 1.3
    system = gear_system(model)

    def load(t):
        return np.array([0.0, model.f_pm + model.f_e * omega**2 * np.cos(omega * t)])

    def jacobian(state, h=2e-6):
        near = [[flow(system, omega, load, state + h * sign * unit).y[:, -1] for sign in (1, -1)] for unit in np.eye(4)]
        return np.array([(after - before) / (2.0 * h) for after, before in near]).T

    motion = first_order(model, omega)[0][0]
    state = np.array([-0.5, motion[0] + motion[1], 0.0, omega * motion[2]])
    for _ in range(8):
        result = flow(system, omega, load, state)
        gap = result.y[:, -1] - state
        if np.max(np.abs(gap)) < 1e-9:
            break
        state = state - np.linalg.solve(jacobian(state) - np.eye(4), gap)
    assert np.max(np.abs(gap)) < 1e-9
    samples = result.sol(np.arange(512) * 2.0 * np.pi / omega / 512)[1]
    assert samples.min() < model.b < samples.max()
    harmonics = np.fft.rfft(samples)[:65] / 512
    waves = 2.0 * np.column_stack([harmonics[1:].real, -harmonics[1:].imag])
    exact = np.concatenate([[harmonics[0].real], waves.ravel()])
    found = monodromies(model, "omega", [omega], exact[None])[0]
    np.testing.assert_allclose(found, jacobian(state), rtol=0, atol=2e-5)


def test_one_motion_and_many():
    motions, _ = first_order(published(), 0.6)
    many = motion_multipliers(published(), 0.6, motions)
    assert many.shape == (3, 4)
    for i in range(3):
        np.testing.assert_array_equal(motion_multipliers(published(), 0.6, motions[i]), many[i])
    assert np.all(motion_multipliers(published(), [0.6, 0.7, 0.8], motions)[0] == many[0])


def test_without_backlash_there_is_always_contact():
    """A motion through both flanks at once, which touch each other."""
    model, omega = antiphase(b=0.0), 0.7
    through, beside = motion_multipliers(model, omega, [[0.1, 1.0, 0.3], [5.0, 1.0, 0.3]])
    assert matched(through, beside) < 1e-11


def test_motions_that_never_touch():
    """Free of contact lambda may rest anywhere: one multiplier is 1."""
    model, omega = published(), 0.7
    free = motion_multipliers(model, omega, [0.2, 0.3, 0.1])
    expected = np.linalg.eigvals(expm(first_order_form(gear_system(model), 0.0) * 2.0 * np.pi / omega))
    assert matched(free, expected) < 1e-7 and np.min(np.abs(free - 1.0)) < 1e-9


@pytest.mark.parametrize("gap, motion", [(0.0, [0.0, 0.0, 0.0]), (1.0, [1.0, 0.0, 0.0]), (1.0, [1.0, 1e-17, 0.0])])
def test_a_motion_that_rests_on_a_flank_is_free(gap, motion):
    """Nothing is pressed together; the search for crossings must not look for them for ever."""
    model, omega = published(b=gap), 0.7
    resting = motion_multipliers(model, omega, motion)
    closed, free = motion_multipliers(published(), omega, [[5.0, 0.0, 0.0], [0.2, 0.0, 0.0]])
    assert min(matched(resting, free), matched(resting, closed)) < 1e-9
