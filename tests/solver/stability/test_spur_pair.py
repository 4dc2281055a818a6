"""A spur pair as a gear without translations: motions of one and of two forcing periods side by side.

Reference digits and share: two integrators, docs/physics.md, section 9 (the pair of Kahraman and Singh, Journal of
Sound and Vibration 146 (1991) 135-156, with three harmonics).
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from solver import Model, gear_system, solve
from solver.harmonic.galerkin import Galerkin
from solver.stability import Instability, assess
from solver.timedomain import orbit_state, shoot

SPUR = Model(
    b=1.0,
    alpha=0.2,
    alpha_phase=np.pi,
    alpha_harmonics=[(0.1, np.pi), (0.05, np.pi)],
    f_e=0.01,
    f_e_harmonics=[(0.004, 0.0), (0.002, 0.0)],
    f_pm=0.1,
    kappa=0.5,
    xi_mesh=0.05,
    xi_translation=0.0125,
    xi_support=0.01,
    k_support=1.0,
    pitch_cone_angle=45.0,
    pressure_angle=20.0,
    translation_coupling=0.0,
    rotation_coupling=1.0,
    variation_translation=0.0,
    variation_rotation=1.0,
)
ONCE, TWICE = Galerkin(21), Galerkin(21, 2)


def kind(omega, found, balance):
    stability = assess(SPUR, "omega", [omega], found.motion[None], balance=balance, static=[found.stable])
    return Instability(stability.kind[0])


def test_the_motion_that_parts_at_half_the_resonance():
    found = solve(SPUR, [1.09, 0.03, 0.0], 0.5, balance=ONCE)
    sizes = np.hypot(found.motion[1::2], found.motion[2::2])
    np.testing.assert_allclose([found.motion[0], *sizes[:3]], [1.09286, 0.03002, 0.12401, 0.00442], atol=6e-6)
    np.testing.assert_allclose(np.ravel(ONCE.extremes(found.motion[None])), [0.95104, 1.24239], atol=2e-5)
    assert kind(0.5, found, ONCE) is Instability.NONE


def plain_extremes(omega, periods=30):
    """Lowest and highest x of the motion from rest, by an integrator that shares nothing with the solver.

    Flanks' places and turning points are located as events; both are looked for in the last of the periods.
    """
    harmonics = np.arange(1, 4)
    sizes, errors = np.array([0.2, 0.1, 0.05]), np.array([0.01, 0.004, 0.002])

    def rate(tau, state):
        x, speed = state
        force = x - 1.0 if x > 1.0 else x + 1.0 if x < -1.0 else 0.0
        turns = np.cos(harmonics * omega * tau)
        load = 0.1 + errors @ ((harmonics * omega) ** 2 * turns)
        return speed, load - 0.1 * speed - (1.0 - sizes @ turns) * force

    def turning(tau, state):
        return state[1]

    end = 2.0 * np.pi * periods / omega
    settings = dict(method="DOP853", rtol=1e-12, atol=1e-12, max_step=0.05)
    before = solve_ivp(rate, (0.0, end), (1.1, 0.0), **{**settings, "max_step": 0.5})
    last = solve_ivp(rate, (0.0, 2.0 * np.pi / omega), before.y[:, -1], events=turning, **settings)
    places = last.y_events[0][:, 0]
    return min(places), max(places)


def test_the_largest_displacement_by_three_methods():
    """1.242393 by harmonic balance, by shooting and by plain integration; it ends with 39, not with 38."""
    balance = Galerkin(33)
    found = solve(SPUR, [1.09, 0.03, 0.0], 0.5, balance=balance)
    system = gear_system(SPUR)
    orbit = shoot(system, 0.5, orbit_state(system, 0.5, found.motion))
    by_balance, by_shooting = np.ravel(balance.extremes(found.motion[None])), (orbit.lowest, orbit.highest)
    for lowest, highest in (by_balance, by_shooting, plain_extremes(0.5)):
        assert lowest == pytest.approx(0.951038, abs=1e-6)
        assert highest == pytest.approx(1.242393, abs=1e-6)


def test_two_periods_beside_one():
    once = solve(SPUR, [1.09, 0.03, 0.0], 1.8, balance=ONCE)
    np.testing.assert_allclose(np.ravel(ONCE.extremes(once.motion[None])), [1.06818, 1.11706], atol=6e-6)
    assert kind(1.8, once, ONCE) is Instability.NONE
    guess = TWICE.lifted(np.array([1.09, 0.0, 0.0]))
    guess[1] = 0.19
    twice = solve(SPUR, guess, 1.8, balance=TWICE)
    assert np.hypot(*twice.motion[1:3]) == pytest.approx(0.18730, abs=6e-6)
    assert np.hypot(*twice.motion[3:5]) == pytest.approx(0.02828, abs=6e-6)
    np.testing.assert_allclose(np.ravel(TWICE.extremes(twice.motion[None])), [0.90521, 1.28247], atol=2e-5)
    assert kind(1.8, twice, TWICE) is Instability.NONE
