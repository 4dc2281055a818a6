"""Slow runs: against saddle-nodes by shooting, SciPy's integration, exact linear motions; that they can be cut."""

import functools
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from solver import ImpactState, gear_system
from solver.timedomain import AttractorKind, AttractorSearch, SlowRun, find_attractors, shoot, slow_run
from tests.conftest import consistent, published
from tests.solver.timedomain.systems import field_of, mathieu, oscillator

ONE, TWO, TORUS = AttractorKind.PERIOD_1, AttractorKind.PERIOD_2, AttractorKind.QUASI_PERIODIC


@functools.cache
def up_and_down(low: float = 1.2, high: float = 1.25, count: int = 26) -> tuple[SlowRun, SlowRun]:
    """The published pair around its upper resonance, up from rest and down from there."""
    values = np.linspace(low, high, count)
    up = slow_run(published(), "omega", values)
    return up, slow_run(published(), "omega", values[::-1], state=up.state[-1])


def saddle_node(run: SlowRun, i: int) -> float:
    """Where the periodic orbit that a run had before value i ends, by shooting and bisection."""
    system, period = gear_system(published()), int(run.kind[i - 1])
    there, gone, state = run.values[i - 1], run.values[i], run.state[i - 1]
    for _ in range(20):
        middle = 0.5 * (there + gone)
        orbit = shoot(system, middle, state, period)
        if orbit.status == 0 and orbit.stable and np.max(np.abs(orbit.state - state)) < 0.3:
            there, state, last = middle, orbit.state, orbit
        else:
            gone = middle
    assert last.multipliers[0] == pytest.approx(1.0, abs=1e-3)
    return there


def test_the_hysteresis_of_the_upper_resonance_ends_at_saddle_nodes():
    up, down = up_and_down()
    ends = []
    for run, before in ((up, ONE), (down, TWO)):
        (i,) = np.flatnonzero(np.isfinite(run.jumps))
        assert run.kind[i - 1] == before and run.kind[i] != before
        ends.append(saddle_node(run, i))
        # The small steps are a sixteenth of 0.002.
        assert abs(run.jumps[i] - ends[-1]) <= 0.5 * 0.002 / 16 + 1e-6
    # Both directions have the same motions outside, and others within.
    np.testing.assert_allclose(ends, [1.2301969, 1.2194472], atol=1e-6)
    ways = up.quantities["rms"], down.quantities["rms"][::-1]
    within = (up.values > ends[1]) & (up.values < ends[0])
    assert np.all(np.abs(ways[0] - ways[1])[within] > 0.1)
    below = up.values < ends[1]
    np.testing.assert_allclose(ways[0][below], ways[1][below], rtol=1e-9)


@pytest.mark.costly
def test_large_steps_meet_the_same_jumps():
    """In steps of 0.02, wider than the upper hysteresis, as by shooting: four saddle-nodes, and a subcritical period
    doubling at 0.65016; between them tori and motions of four periods are met."""
    values, search = np.linspace(0.5, 1.3, 41), AttractorSearch(transient=1500, watched=10000)
    up = slow_run(published(), "omega", values, search=search)
    down = slow_run(published(), "omega", values[::-1], state=up.state[-1], search=search)
    for run, places in ((up, (0.6173089, 0.6501561, 1.2301969)), (down, (1.2194472, 0.5259298))):
        for place in places:
            assert np.nanmin(np.abs(run.jumps - place)) <= 0.5 * 0.02 / 16 + 1e-6, place


def test_hysteresis_is_where_attractors_have_it():
    up, down = up_and_down()
    found = find_attractors(published(), "omega", up.values)
    numbers = found.rms
    for i in range(up.values.size):
        # Both runs are on attractors that a search from random states and neighbours finds.
        for run, at in ((up, i), (down, -1 - i)):
            if run.kind[at] <= TWO:
                assert np.nanmin(np.abs(numbers[i] - run.quantities["rms"][at])) < 1e-8
    several = np.sum((found.kind >= ONE) & (found.kind <= AttractorKind.CHAOTIC), axis=1) > 1
    apart = np.abs(up.quantities["rms"] - down.quantities["rms"][::-1]) > 0.1
    assert apart.sum() == 6 and np.all(several[apart])


@pytest.mark.costly
@pytest.mark.parametrize("way, i", [(0, 10), pytest.param(1, 14, marks=pytest.mark.slow), (1, 16)])
def test_motions_are_those_of_another_integration(way, i):
    """From the state before, over 250 periods, SciPy comes to the same extremes, mean and RMS: also over the jump."""
    run = up_and_down()[way]
    assert math.isfinite(run.jumps[i]) == (i == 16)
    system, omega, kind = gear_system(published()), run.values[i], int(run.kind[i])
    span, samples = 2.0 * math.pi / omega, 2000
    times = span * (250 + np.arange(kind * samples) / samples)
    found = solve_ivp(
        field_of(system, omega),
        (0.0, times[-1]),
        run.state[i - 1],
        method="DOP853",
        rtol=1e-9,
        atol=1e-10,
        t_eval=times,
    )
    values = system.contact @ found.y[: system.degrees]
    expected = {"lowest": values.min(), "highest": values.max(), "mean": values.mean(), "rms": values.std()}
    for name, value in expected.items():
        assert run.quantities[name][i] == pytest.approx(value, abs=2e-6), name
    np.testing.assert_allclose(np.sort(values[::samples]), np.sort(run.sections[i, :kind]), atol=2e-6)


def test_a_motion_of_two_periods_has_two_sections_and_its_multiplier():
    _, down = up_and_down()
    (doubled,) = np.nonzero(down.kind == TWO)
    assert doubled.size == 4
    for i in doubled.tolist():
        points = down.sections[i]
        assert np.isfinite(points).sum() == 2 and abs(points[0] - points[1]) > 0.01
        orbit = shoot(gear_system(published()), down.values[i], down.state[i], 2)
        assert orbit.minimal_period == 2
        rate = math.log(orbit.largest_multiplier) / (2.0 * 2.0 * math.pi / down.values[i])
        assert down.lyapunov[i] == pytest.approx(rate, rel=1e-6)
    torus = up_and_down()[0].kind == TORUS
    assert torus.any() and np.all(np.isfinite(up_and_down()[0].sections[torus]))


def test_a_run_can_be_cut_in_two():
    values = np.linspace(0.6, 0.63, 11)
    whole = slow_run(published(), "omega", values)
    first = slow_run(published(), "omega", values[:7])
    second = slow_run(published(), "omega", values[7:], state=first.state[-1])
    assert whole.from_rest.tolist() == [True] + 10 * [False] and not second.from_rest.any()
    for name in ("kind", "impact", "sections", "lyapunov", "state"):
        joined = np.concatenate([getattr(first, name), getattr(second, name)])
        np.testing.assert_array_equal(getattr(whole, name), joined)
    for name, numbers in whole.quantities.items():
        np.testing.assert_array_equal(numbers, np.concatenate([first.quantities[name], second.quantities[name]]))


@pytest.mark.parametrize("damping", [0.05, 0.4])
def test_linear_motions_are_exact_both_ways(damping):
    """y'' + 2 zeta y' + y = 0.5 + cos Omega tau, whatever the direction."""
    values = np.linspace(0.5, 1.5, 9)
    exact = 1.0 / np.hypot(1.0 - values**2, 2.0 * damping * values)
    for order in (slice(None), slice(None, None, -1)):
        run = slow_run(oscillator(damping), "omega", values[order])
        assert np.all(run.kind == ONE) and np.all(np.isnan(run.jumps))
        for name, expected in (
            ("amplitude", exact),
            ("highest", 0.5 + exact),
            ("lowest", 0.5 - exact),
            ("rms", exact / math.sqrt(2.0)),
            ("mean", np.full(9, 0.5)),
        ):
            np.testing.assert_allclose(run.quantities[name], expected[order], rtol=1e-7, err_msg=name)
        np.testing.assert_allclose(run.lyapunov, -damping, rtol=1e-6)


def test_an_unbounded_motion_ends_the_run_which_begins_again_at_rest():
    """Mathieu's equation within its first tongue, a - 1 = q: not outside of it."""
    run = slow_run(mathieu(1.0, 0.3, 0.02), "omega", [1.3, 1.6, 2.0, 2.6, 3.0])
    assert run.kind.tolist() == [ONE, ONE, AttractorKind.UNBOUNDED, ONE, ONE]
    assert run.from_rest.tolist() == [True, False, False, True, False]
    assert np.isfinite(run.jumps).tolist() == [False, False, True, True, False]
    assert run.impact[2] == -1 and np.isnan(run.state[2]).all() and np.isnan(run.sections[2]).all()
    assert all(np.isnan(numbers[2]) for numbers in run.quantities.values())


def test_a_run_along_another_parameter():
    """Over the backlash at one frequency: without any the pair never leaves contact."""
    values = np.linspace(0.0, 1.0, 5)
    run = slow_run(consistent(), "b", values, omega=0.7)
    assert run.impact[0] == ImpactState.PERMANENT
    np.testing.assert_allclose(run.values, values)
    # In contact all along, lambda is that of the linear pair, b further out.
    inside = run.impact == ImpactState.PERMANENT
    assert inside.sum() >= 2
    np.testing.assert_allclose(run.quantities["mean"][inside] - values[inside], run.quantities["mean"][0], rtol=1e-6)
