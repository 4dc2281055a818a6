"""The Poincare map by tables against the step-by-step integrator and SciPy; independence; bounds and roots."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import polynomial

from solver.flow.switched_system import SWITCHED_SYSTEM, loaded_system
from solver.flow.tabulation import zone_flows
from solver.flow.zone_flows import COEFFICIENTS, new_flows
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.model.contact_system import ContactSystem, gear_system
from solver.timedomain import Status, advance, integrate, measure
from solver.timedomain.bernstein import first_exit_of_hull, restrict, widen_by_hull
from solver.timedomain.section_map import carry_period, new_room
from tests.conftest import antiphase, consistent, published
from tests.solver.timedomain.systems import flying_mass, full_gear_system, scipy_motion

_F, _I = types.float64, types.int64


@kernel(types.void(SWITCHED_SYSTEM, _F, MATRIX, types.int64[::1], _I))
def carried(system, tolerance, states, order, periods):
    """Motions carried period by period, in a given order."""
    flows = zone_flows(system, tolerance, new_flows(system, 1))
    room, none = new_room(flows), states[:0]
    for _ in range(periods):
        for row in order:
            carry_period(flows, states[row], none, none, np.inf, room)


@kernel(types.Tuple((_F, _I))(ARRAY, ARRAY, _F, ARRAY, _F))
def exit_of(hull, powers, begin, limits, slack):
    """`first_exit_of_hull`."""
    return first_exit_of_hull(hull, powers, begin, limits, slack, np.empty(COEFFICIENTS))


@kernel(types.void(ARRAY, ARRAY, _F, _F, ARRAY))
def widened(hull, powers, begin, end, extremes):
    """`widen_by_hull`."""
    widen_by_hull(hull, powers, begin, end, 1e-15, extremes, np.empty(COEFFICIENTS))


@kernel(types.void(ARRAY, _F, _F, ARRAY))
def part_of(hull, left, right, part):
    """`restrict` of a polynomial over [-1, 1]."""
    restrict(hull, -1.0, 1.0, left, right, part)


SYSTEMS = [
    (gear_system(published()), 0.6),
    (gear_system(antiphase()), 1.3),
    (gear_system(consistent(b=0.1)), 0.55),
    (gear_system(published(xi_support=(0.01, 0.02, 0.03) * 2)), 0.9),
    (full_gear_system(published()), 0.6),
    (flying_mass(1.0, 3.0, 0.02), 0.2),
    (ContactSystem([[1.0]], [[0.1]], [[0.2]], [1.0], [3.0], 0.3, load=[[0.1], [1.0]]), 0.7),
]


@pytest.mark.parametrize("system, omega", SYSTEMS)
def test_sections_of_random_motions_are_those_of_the_stepwise_integrator(system, omega):
    states = np.random.default_rng(7).uniform(-2.0, 2.0, (8, 2 * system.degrees))
    sections = advance(system, omega, states, 2, tolerance=1e-13)
    switches = 0
    for state, ends in zip(states, sections.states, strict=True):
        motion = integrate(system, omega, state, 0.0, 4.0 * np.pi / omega, tolerance=1e-13)
        switches += motion.switch_times.size
        np.testing.assert_allclose(ends[-1], motion.states[-1], rtol=0.0, atol=1e-9)
    assert switches > 8


def test_one_motion_is_that_of_scipy():
    system, omega, state = gear_system(antiphase()), 1.3, np.array([-0.5, 0.2, 0.0, 1.3])
    end, switches = scipy_motion(system, omega, state, 10.0 * np.pi / omega)
    found = advance(system, omega, state, 5, tolerance=1e-13)
    assert switches.size >= 5
    np.testing.assert_allclose(found.states[0, -1], end, rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("system, omega", SYSTEMS[:4])
def test_errors_follow_the_tolerance(system, omega):
    states = np.random.default_rng(3).uniform(-1.5, 1.5, (12, 2 * system.degrees))
    exact = advance(system, omega, states, 1, tolerance=1e-14).states
    errors = [np.abs(advance(system, omega, states, 1, tolerance=t).states - exact).max() for t in (1e-5, 1e-7, 1e-9)]
    assert all(error < 300.0 * t for error, t in zip(errors, (1e-5, 1e-7, 1e-9), strict=True))
    assert errors[0] > 10.0 * errors[2]


def test_a_motion_depends_on_no_other():
    system = loaded_system(gear_system(antiphase()), 1.3)
    states = np.random.default_rng(1).uniform(-2.0, 2.0, (9, 4))
    forwards, backwards, alone = states.copy(), states.copy(), states[4:5].copy()
    carried(system, 1e-10, forwards, np.arange(9), 30)
    carried(system, 1e-10, backwards, np.arange(9)[::-1].copy(), 30)
    carried(system, 1e-10, alone, np.arange(1), 30)
    np.testing.assert_array_equal(forwards, backwards)
    np.testing.assert_array_equal(alone[0], forwards[4])


def test_a_visit_within_one_interval_is_found():
    # lambda = 1e-5 - (t - 1)^2 / 2 under a constant load: in contact for 9e-3 of a period of 6.3.
    system = ContactSystem([[1.0]], [[0.0]], [[0.0]], [1.0], [1.0], 0.0, load=[[-1.0]])
    for depth, switches in ((1e-5, 2), (1e-9, 2), (-1e-9, 0)):
        found = measure(system, 1.0, [depth - 0.5, 1.0], 1)
        # The contact's force takes a share of the depth that is as small as the depth.
        assert found.switches == switches and found.highest == pytest.approx(depth, abs=1e-11 + 1e-5 * abs(depth))


def test_rest_on_a_border_is_rest():
    system = flying_mass(1.0, 3.0)
    for start in ([1.0, 0.0], [-3.0, 0.0]):
        np.testing.assert_array_equal(advance(system, 1.0, start, 50).states[0], [start] * 50)
    # Two masses, one resting on the border while the other swings: neither feels the other.
    pair = ContactSystem(np.eye(2), np.zeros((2, 2)), np.diag([0.0, 4.0]), [1.0, 0.0], [1.0, 0.0], 0.3)
    found = advance(pair, 1.0, [0.3, 1.0, 0.0, 0.0], 50, tolerance=1e-14)
    np.testing.assert_allclose(found.states[0, -1], [0.3, 1.0, 0.0, 0.0], atol=1e-9)


def test_touching_a_border_from_inside_goes_on():
    # y = cos t touches y = 1 from both sides within rounding.
    system = ContactSystem([[1.0]], [[0.0]], [[1.0]], [1.0], [0.5], 1.0)
    for shift in (-1e-13, -1e-16, 0.0, 1e-16, 1e-13):
        found = measure(system, 1.0, [1.0 + shift, 0.0], 16, tolerance=1e-13)
        assert found.status is Status.COMPLETE and found.switches < 100
        np.testing.assert_allclose(found.state, [1.0, 0.0], atol=1e-9)


def test_without_a_gap_there_is_no_switch_and_a_tiny_gap_is_near():
    none, tiny = (
        advance(gear_system(published(b=b)), 0.6, [0.0, -1.0, 0.0, 0.0], 3).states[0, -1] for b in (0.0, 1e-12)
    )
    np.testing.assert_allclose(none, tiny, atol=1e-9)


def _in_both_bases(roots):
    """The polynomial with such roots within [-1, 1], made up to degree 15, in powers and in Bernstein's basis."""
    powers = np.zeros(COEFFICIENTS)
    made = polynomial.polyfromroots(roots)
    powers[: made.size] = made
    nodes = np.cos(np.pi * (np.arange(COEFFICIENTS) + 0.5) / COEFFICIENTS)
    x, degree = 0.5 * (nodes + 1.0), COEFFICIENTS - 1
    basis = np.array([[math.comb(degree, i) * a**i * (1.0 - a) ** (degree - i) for i in range(degree + 1)] for a in x])
    return powers, np.linalg.solve(basis, polynomial.polyval(nodes, powers))


_PLACES = st.lists(st.floats(-1.3, 1.3), min_size=1, max_size=6)


@given(_PLACES, st.floats(-1.0, 0.9))
@settings(deadline=None, max_examples=200)
def test_the_first_exit_is_the_first_crossing(places, begin):
    places = sorted(places)
    if min(np.diff(places), default=1.0) < 1e-3 or min(abs(begin - place) for place in places) < 1e-3:
        return
    powers, hull = _in_both_bases(places)
    start = polynomial.polyval(begin, powers)
    limits = np.array([0.0, np.inf] if start > 0.0 else [-np.inf, 0.0])
    part = np.empty(COEFFICIENTS)
    part_of(hull, begin, 1.0, part)
    time, side = exit_of(part, powers, begin, limits, 1e-12)
    crossings = [place for place in places if begin < place < 1.0]
    if min((abs(1.0 - place) for place in places), default=1.0) < 1e-3:
        return
    if crossings:
        assert side == (-1 if start > 0.0 else 1) and time == pytest.approx(crossings[0], abs=1e-8)
    else:
        assert (time, side) == (1.0, 0)


@given(_PLACES, st.floats(-1.0, 0.5), st.floats(0.05, 0.5))
@settings(deadline=None, max_examples=200)
def test_extremes_are_those_of_the_polynomial(places, begin, length):
    powers, hull = _in_both_bases(places)
    end, part, extremes = begin + length, np.empty(COEFFICIENTS), np.array([np.inf, -np.inf])
    part_of(hull, begin, end, part)
    widened(part, powers, begin, end, extremes)
    turns = polynomial.polyroots(np.trim_zeros(polynomial.polyder(powers), "b"))
    inside = [z.real for z in turns if abs(z.imag) < 1e-6 and begin < z.real < end]
    values = polynomial.polyval(np.array([begin, end, *inside]), powers)
    np.testing.assert_allclose(extremes, [values.min(), values.max()], rtol=1e-9, atol=1e-12)
