"""Curves through the corners where stiff contacts begin and end: folds, truth by integration, and random systems."""

import numpy as np
import pytest
from scipy.linalg import eigh

from solver import ContactSystem, Continuation, EndReason, Event
from solver.continuation.on_curve import curve_crossings
from solver.continuation.trace_log import LoggedContinuation, Outcome
from solver.harmonic.galerkin import Galerkin
from solver.timedomain import ShootingStatus, orbit_state, shoot
from tests.conftest import slow_but

CHAIN = np.array([[1.0, -1.0], [-1.0, 2.0]])
#: Lowest natural frequency of the chain without contact.
NATURAL = 0.6180339887
GRAZINGS = (Event.MIN_AT_DRIVE, Event.MIN_AT_BACK, Event.MAX_AT_DRIVE, Event.MAX_AT_BACK)


def chain(stiffness):
    """Two masses, a one-sided stop on the first, a force on the second."""
    load = [[0.0, 0.0], [0.0, 0.1]]
    return ContactSystem(np.eye(2), 0.06 * CHAIN, CHAIN, [1.0, 0.0], [stiffness, 0.0], 1.0, load=load)


def free_start(system, balance, omega):
    """The motion without contact."""
    start = np.zeros(balance.unknowns + 1)
    mean = np.linalg.solve(system.stiffness, system.load[0].real)
    first = system.contact @ np.linalg.solve(system.dynamic_stiffness(omega), system.load[1])
    start[[0, 1, 2, -1]] = system.contact @ mean, first.real, -first.imag, omega
    return start


def swept(system, order, low, high, heading=1, continuation=None):
    """Problem and curve from the free motion at one end of the range."""
    balance = Galerkin(order)
    problem = balance.problem(system, "omega", low, high)
    start = free_start(system, balance, low if heading > 0 else high)
    continuation = continuation or Continuation(max_points=30000)
    return problem, continuation.trace(problem, start, low, high, heading)


def check(problem, curve):
    """What holds along every curve, however stiff its contacts are."""
    n, p = problem.unknowns, curve.points[:, -1]
    values, gradient = np.empty(problem.test_count), np.empty((problem.test_count, n + 1))
    at_grazing = {kind: np.flatnonzero(curve.event == kind) for kind in GRAZINGS}
    margins = np.empty((len(p), 4))
    for i, y in enumerate(curve.points):
        residual, jacobian = problem.evaluated(y)
        size = np.abs(jacobian) @ problem.scale
        assert np.max(np.abs(residual) / size) < 1e-8, i
        problem.test_functions(problem.parameters, problem.parameter_slope, y, values, gradient)
        margins[i] = values[1:]
    # A grazing is where its margin vanishes; it changes sign there and nowhere else.
    for column, kind in enumerate(GRAZINGS):
        assert np.max(np.abs(margins[at_grazing[kind], column]), initial=0.0) < 1e-10
        clear = np.abs(margins[:, column]) > 1e-9
        signs = np.sign(margins[clear, column])
        changes = np.sum(signs[1:] != signs[:-1])
        assert changes <= at_grazing[kind].size and (changes - at_grazing[kind].size) % 2 == 0
    # Between two folds p is monotone.
    turns = [0, *np.flatnonzero(curve.event == Event.FOLD), len(p) - 1]
    for first, last in zip(turns, turns[1:], strict=False):
        steps = np.diff(p[first : last + 1])
        assert np.all(steps >= -1e-13) or np.all(steps <= 1e-13)
    assert np.all(np.diff(curve.arclength) >= 0.0)
    np.testing.assert_allclose(np.linalg.norm(curve.tangents, axis=1), 1.0, rtol=0, atol=1e-12)


# Folds over the natural frequency. At k = 10 and beyond the lower one coincides with the grazing that ends the contact.
# At k = 200 the upper one is 1.19757 of order 15, and 1.19777 from order 25 on.
FOLDS = {
    10.0: (1.05487, 1.18640),
    200.0: (1.05487, 1.19777),
    1e3: (1.05487, 1.19896),
    1e4: (1.05487, 1.19954),
    1e5: (1.05487, 1.19966),
}


@pytest.mark.parametrize("stiffness", FOLDS)
def test_the_resonance_is_passed_however_stiff_the_stop_is(stiffness):
    order = 25 if stiffness == 200.0 else 15
    problem, curve = swept(chain(stiffness), order, 0.8 * NATURAL, 1.3 * NATURAL)
    assert curve.ends[1] is EndReason.RANGE_LEFT and curve.points[-1, -1] == 1.3 * NATURAL
    folds = np.sort(curve.points[curve.event == Event.FOLD, -1]) / NATURAL
    np.testing.assert_allclose(folds, FOLDS[stiffness], rtol=0, atol=2e-5)
    # Contact begins and ends where the motion without it says.
    grazings = curve.points[curve.event == Event.MAX_AT_DRIVE, -1]
    for omega in grazings:
        free = np.linalg.solve(chain(stiffness).dynamic_stiffness(omega), [0.0, 0.1])[0]
        assert abs(free) == pytest.approx(1.0, abs=1e-9)
    assert grazings.size == 2 and grazings[1] / NATURAL == pytest.approx(1.05487, abs=1e-5)
    check(problem, curve)


@pytest.mark.parametrize("stiffness", [1e3, 1e5])
def test_downwards_it_is_the_same_curve(stiffness):
    _, up = swept(chain(stiffness), 15, 0.8 * NATURAL, 1.3 * NATURAL)
    _, down = swept(chain(stiffness), 15, 0.8 * NATURAL, 1.3 * NATURAL, heading=-1)
    for kind in (Event.FOLD, Event.MAX_AT_DRIVE):
        places = [np.sort(curve.points[curve.event == kind, -1]) for curve in (up, down)]
        np.testing.assert_allclose(*places, rtol=0, atol=1e-9)


@pytest.mark.parametrize(("stiffness", "order"), slow_but([(1e3, 63)], [(200.0, 31), (1e3, 63)]))
def test_the_motions_are_those_of_integration(stiffness, order):
    system = chain(stiffness)
    problem, curve = swept(system, order, 0.8 * NATURAL, 1.3 * NATURAL)
    shown = 0
    for omega in (0.96 * NATURAL, 1.0 * NATURAL, 1.03 * NATURAL):
        _, motions, *_ = curve_crossings(problem, curve, np.array([omega]), Continuation())
        for motion in motions:
            orbit = shoot(system, omega, orbit_state(system, omega, motion), order=2)
            assert orbit.status is ShootingStatus.CONVERGED
            found = np.concatenate([[motion[0]], motion[1:5:2] - 1j * motion[2:5:2]])
            np.testing.assert_allclose(found, orbit.harmonics[:3], rtol=0, atol=3e-3)
            shown += orbit.switches > 0
    assert shown >= 3


@pytest.mark.parametrize("stiffness", [1e4, 1e5])
def test_values_next_to_a_corner_are_met(stiffness):
    """Grid values on both sides of where contact begins, at distances down to rounding."""
    problem, curve = swept(chain(stiffness), 15, 0.8 * NATURAL, 1.3 * NATURAL)
    (begin, *_) = curve.points[curve.event == Event.MAX_AT_DRIVE, -1]
    apart = 10.0 ** np.arange(-13, -2)
    grid = np.sort(np.concatenate([begin - apart, begin + apart]))
    columns, motions, *_ = curve_crossings(problem, curve, grid, Continuation())
    np.testing.assert_array_equal(np.sort(columns), np.arange(grid.size))
    for column, motion in zip(columns, motions, strict=True):
        residual, jacobian = problem.evaluated(np.append(motion, grid[column]))
        assert np.max(np.abs(residual) / (np.abs(jacobian) @ problem.scale)) < 1e-9


def test_points_round_a_corner_are_logged_as_such():
    log = LoggedContinuation(max_points=30000)
    _, curve = swept(chain(1e4), 15, 0.8 * NATURAL, 1.3 * NATURAL, continuation=log)
    (trace,) = log.traces
    steps = trace.steps
    assert np.sum(steps.outcome == Outcome.ROUND_A_CORNER) > 10
    assert np.sum(~steps.accepted) == curve.refused and steps.points[-1] == len(curve.points)
    np.testing.assert_array_equal(steps.places[steps.accepted], curve.points[steps.points[steps.accepted] - 1])


def random_system(seed):
    """A chain of one to three masses with a stop on one or on both sides, ten to a hundred thousand times as stiff."""
    draw = np.random.default_rng(seed)
    n = int(draw.integers(1, 4))
    springs = draw.uniform(0.3, 2.0, n + 1)
    stiffness = np.diag(springs[:-1] + springs[1:]) - np.diag(springs[1:-1], 1) - np.diag(springs[1:-1], -1)
    mass, damping = np.diag(draw.uniform(0.5, 2.0, n)), draw.uniform(0.01, 0.1) * stiffness
    stop, gap, two_sided = 10.0 ** draw.uniform(1.0, 5.0), draw.uniform(0.3, 1.0), draw.random() < 0.5
    # Half of the gaps on both sides are alike, so that a symmetric motion touches both at once.
    back = (gap if draw.random() < 0.5 else gap * draw.uniform(0.5, 1.5)) if two_sided else np.inf
    load = np.zeros((2, n))
    load[1, -1] = 10.0 ** draw.uniform(-1.5, 0.0)
    load[0, 0] = draw.uniform(-0.3, 0.3) if draw.random() < 0.5 else 0.0
    contact = np.eye(n)[0]
    return ContactSystem(mass, damping, stiffness, contact, stop * contact, gap, back, load=load)


@pytest.mark.parametrize(("seed",), slow_but([(seed,) for seed in range(24)], [(seed,) for seed in range(200)]))
def test_random_stiff_contacts_are_passed(seed):
    system = random_system(seed)
    lowest = np.sqrt(eigh(system.stiffness, system.mass, eigvals_only=True)[0])
    low, high = 0.4 * lowest, 1.8 * lowest
    order, heading = (5, 9, 15)[seed % 3], 1 if seed % 2 else -1
    problem, curve = swept(system, order, low, high, heading)
    if not len(curve.points):
        # The free motion that it starts from leaves the gap, and the corrector finds none that does not.
        start = free_start(system, Galerkin(order), low if heading > 0 else high)
        assert curve.ends[1] is EndReason.NO_SOLUTION
        reach = np.hypot(start[1], start[2])
        assert start[0] + reach > system.front_gap or start[0] - reach < -system.back_gap
        return
    assert curve.ends[1] is EndReason.RANGE_LEFT
    check(problem, curve)
