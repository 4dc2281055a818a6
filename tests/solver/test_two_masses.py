"""Systems that are no bevel pair, each in a few lines: NLvib's two masses with a stop, a spur pair, a geared rotor.

Numbers of the two masses are in `tests.cases.two_masses`; here is how their motions lose stability.
"""

import numpy as np
import pytest

from solver import ContactSystem, Continuation, Event
from solver.harmonic.galerkin import Galerkin
from solver.stability import Instability, assess
from solver.timedomain import AttractorKind, orbit_state, settle, shoot
from tests.cases.two_masses import TWO_MASSES, second_mass, traced


def test_period_doubling_around_the_peak_and_neimark_sacker_below():
    # A stop this stiff asks for many harmonics: the lower doubling is at 0.6988, 0.7302, 0.7368 for order 31, 41, 61.
    balance, curve = traced(61)
    doublings = curve.points[curve.event == Event.PERIOD_DOUBLING][:, -1]
    tori = curve.points[curve.event == Event.NEIMARK_SACKER][:, -1]
    # Of the balance linearised about itself they are at 0.75558, 0.73879 and 0.61861, 0.58190.
    np.testing.assert_allclose(np.sort(doublings), [0.7388, 0.7556], rtol=0, atol=0.003)
    np.testing.assert_allclose(np.sort(tori), [0.58190, 0.61861], rtol=0, atol=1e-4)
    chosen = {
        Instability.PERIOD_DOUBLING: int(np.argmax(second_mass(curve.points))),
        Instability.NEIMARK_SACKER: _upper(curve, 0.6),
        Instability.NONE: _upper(curve, 0.635),
    }
    places = np.array(list(chosen.values()))
    found = assess(TWO_MASSES, "omega", curve.points[places, -1], curve.points[places, :-1], balance=balance)
    np.testing.assert_array_equal(found.kind, list(chosen))
    # Shooting with the exact monodromy matrix says the same, and so does what direct integration settles on.
    for kind, place in chosen.items():
        omega = curve.points[place, -1]
        orbit = shoot(TWO_MASSES, omega, orbit_state(TWO_MASSES, omega, curve.points[place, :-1]), order=1)
        assert np.abs(orbit.harmonics[1]) == pytest.approx(np.hypot(*curve.points[place, 1:3]), abs=3e-3)
        assert orbit.stable == (kind is Instability.NONE)
        leading = orbit.multipliers[np.argmax(np.abs(orbit.multipliers))]
        if kind is not Instability.NONE:
            assert (abs(leading.imag) > 0.01) == (kind is Instability.NEIMARK_SACKER)
    omega = curve.points[chosen[Instability.NONE], -1]
    state = orbit_state(TWO_MASSES, omega, curve.points[chosen[Instability.NONE], :-1])
    found, slots = settle(TWO_MASSES, omega, [state])
    assert found.kind[0, slots[0]] == AttractorKind.PERIOD_1


def test_the_peak_at_order_21_is_a_period_doubling():
    balance, curve = traced(21)
    place = int(np.argmax(second_mass(curve.points)))
    found = assess(TWO_MASSES, "omega", curve.points[[place], -1], curve.points[[place], :-1], balance=balance)
    assert found.kind[0] == Instability.PERIOD_DOUBLING


def _upper(curve, omega):
    """Index of the point of largest amplitude near a frequency."""
    near = np.abs(curve.points[:, -1] - omega) < 0.005
    return int(np.argmax(np.where(near, np.hypot(curve.points[:, 1], curve.points[:, 2]), -1.0)))


def spur_pair(b=1.0):
    """Single degree of freedom: lambda'' + 2 xi lambda' + (1 + alpha cos) f = mean + error."""
    return ContactSystem(
        mass=[[1.0]],
        damping=[[0.1]],
        stiffness=[[0.0]],
        contact=[1.0],
        force=[1.0],
        varying_force=[1.0],
        front_gap=b,
        back_gap=b,
        stiffness_harmonics=[(0.1, 0.3)],
        load=[[0.3], [0.0]],
        inertial_load=[[0.0], [0.2]],
    )


def geared_rotor():
    """Two shafts on springs and their mesh (x1, x2, lambda), as a pair with two unlike supports."""
    return ContactSystem(
        mass=[[1, 0, 0], [0, 1, 0], [-1, -1, 1]],
        damping=[[0.02, 0, 0], [0, 0.04, 0], [0, 0, 0.1]],
        stiffness=[[0.8, 0, 0], [0, 1.5, 0], [0, 0, 0]],
        contact=[0, 0, 1],
        force=[0.2, 0.3, 0.9],
        varying_force=[0.2, 0.3, 0.9],
        front_gap=1.0,
        back_gap=1.0,
        stiffness_harmonics=[(0.2, 0.0)],
        load=[[0, 0, 0.5]],
        inertial_load=[[0, 0, 0], [0, 0, 0.1]],
    )


@pytest.mark.parametrize("system, omega", [(spur_pair(), 0.7), (spur_pair(), 1.3), (geared_rotor(), 1.1)])
def test_other_gear_pairs_are_a_few_lines(system, omega):
    balance = Galerkin(15)
    problem = balance.problem(system, "omega", 0.3, 2.0)
    _, unknowns = balance.linear_solution(problem, 2.0)
    unknowns[0] += 1.0
    curve = Continuation().trace(problem, np.append(unknowns, 2.0), 0.3, 2.0, heading=-1)
    assert curve.points[-1, -1] == 0.3
    place = int(np.argmin(np.where(curve.stable == 1, np.abs(curve.points[:, -1] - omega), np.inf)))
    at, motion = curve.points[place, -1], curve.points[place, :-1]
    orbit = shoot(system, at, orbit_state(system, at, motion), order=2)
    found = np.concatenate([[motion[0]], motion[1:5:2] - 1j * motion[2:5:2]])
    np.testing.assert_allclose(found, orbit.harmonics[:3], rtol=0, atol=1e-4)
