"""Kinds of attractors, each on a case where it is known."""

import numpy as np
import pytest

from solver import ImpactState, ParameterError
from solver.model.contact_system import ContactSystem, gear_system
from solver.timedomain import AttractorKind, Settling, contact_impact, settle, shoot
from tests.conftest import antiphase, consistent, published
from tests.solver.timedomain.systems import first_order_state, flying_mass, mathieu, oscillator

COS_20 = 0.93969262
QUICK = Settling(max_periods=900, lyapunov_periods=1000, tolerance=1e-9)


def _one(system, omega, state, settling=QUICK):
    (attractor,) = settle(system, omega, state, settling=settling)
    return attractor


@pytest.mark.parametrize(
    "omega, kind",
    [
        (0.58, AttractorKind.PERIOD_1),
        (0.60, AttractorKind.PERIOD_1),
        (0.62, AttractorKind.QUASI_PERIODIC),
        (1.2265, AttractorKind.PERIOD_2),
    ],
)
def test_where_the_upper_first_order_solution_leads(omega, kind):
    system, state = first_order_state(published(), omega)
    attractor = _one(system, omega, state)
    assert attractor.kind is kind
    if kind is AttractorKind.PERIOD_1:
        assert attractor.impact == ImpactState.PERMANENT
    elif kind is AttractorKind.PERIOD_2:
        assert attractor.half_order_amplitude == pytest.approx(0.418, abs=5e-4)
        assert attractor.impact == ImpactState.SINGLE_SIDED and attractor.points.shape == (2, 4)
    else:
        # The lower branch, "1/0", is false here: the motion loses contact.
        assert attractor.impact == ImpactState.SINGLE_SIDED and abs(attractor.lyapunov) < 1e-3


def test_consistent_pair_settles_on_twice_the_period():
    system = gear_system(consistent(rotation_coupling=COS_20, variation_translation=0.0))
    starts = np.random.default_rng(0).uniform(-3.0, 3.0, (6, 4))
    for attractor in settle(system, 1.2, starts):
        assert attractor.kind is AttractorKind.PERIOD_2
        assert attractor.half_order_amplitude == pytest.approx(0.7888, abs=1e-4)
        assert attractor.amplitude == pytest.approx(0.106, abs=5e-4)
        assert attractor.largest_multiplier < 1.0 and attractor.lyapunov < 0.0


def test_a_coordinate_that_nothing_drives_is_no_part_of_the_motion():
    """It would swing on for ever and drive lambda, which sees it."""
    small = gear_system(published())
    n = small.degrees
    mass, stiffness, damping = np.eye(n + 1), np.zeros((n + 1, n + 1)), np.zeros((n + 1, n + 1))
    mass[:n, :n], stiffness[:n, :n], damping[:n, :n] = small.mass, small.stiffness, small.damping
    mass[n - 1, n], stiffness[n, n] = -1.0, 0.7
    vectors = (np.append(vector, 0.0) for vector in (small.contact, small.force))
    loads = (np.pad(load, ((0, 0), (0, 1))) for load in (small.load, small.inertial_load))
    varying = np.append(small.varying_force, 0.0)
    large = ContactSystem(mass, damping, stiffness, *vectors, 1.0, 1.0, varying, small.stiffness_harmonics, *loads)
    starts = np.random.default_rng(3).uniform(-3.0, 3.0, (3, 2 * n + 2))
    kept = [*range(n), *range(n + 1, 2 * n + 1)]
    for one, other in zip(settle(large, 1.0, starts), settle(small, 1.0, starts[:, kept]), strict=True):
        assert one.kind is other.kind is AttractorKind.PERIOD_1
        np.testing.assert_allclose(one.state[kept], other.state, rtol=0, atol=1e-9)
        assert one.state[n] == one.state[-1] == 0.0 and one.points.shape == (1, 2 * n + 2)
        assert one.lyapunov == pytest.approx(other.lyapunov) and one.lyapunov < 0.0
        orbit = shoot(large, 1.0, one.state)
        assert orbit.multipliers.size == 2 * n and orbit.state.size == 2 * n + 2 and orbit.stable


def test_torus_beyond_the_neimark_sacker_point():
    model = antiphase(rotation_coupling=COS_20)
    before, beyond = first_order_state(model, 1.88), first_order_state(model, 1.93)
    assert _one(before[0], 1.88, before[1]).kind is AttractorKind.PERIOD_1
    torus = _one(beyond[0], 1.93, beyond[1])
    assert torus.kind is AttractorKind.QUASI_PERIODIC and torus.period == 0
    # It surrounds the orbit that lost its stability.
    assert torus.mean == pytest.approx(1.4558, abs=5e-3) and torus.amplitude == pytest.approx(0.6075, abs=1e-2)


def test_chaos_of_the_antiphase_pair():
    attractor = _one(gear_system(antiphase(rotation_coupling=COS_20)), 1.93, [0.0, -1.0, 2.0, -2.0])
    assert attractor.kind is AttractorKind.CHAOTIC and attractor.impact == ImpactState.DOUBLE_SIDED
    assert attractor.lyapunov == pytest.approx(0.0233, abs=0.008)
    assert attractor.lyapunov > 4.0 * attractor.lyapunov_error


def test_parametric_resonance_is_unbounded():
    attractor = _one(mathieu(1.0, 0.2), 2.0, [1.0, 0.0])
    assert attractor.kind is AttractorKind.UNBOUNDED and np.isnan(attractor.mean) and attractor.impact == -1


def test_slow_convergence_is_certain_when_near_and_told_when_far():
    # Damping 1e-5: 1e4 periods to lose half the deviation.
    system, omega = oscillator(1e-5), 0.7
    amplitude = 1.0 / (1.0 - omega**2)
    near = _one(system, omega, [0.5 + amplitude + 2e-3, 0.0])
    assert near.kind is AttractorKind.PERIOD_1 and near.periods_used < 900
    assert near.largest_multiplier == pytest.approx(np.exp(-2e-5 * np.pi / omega), abs=1e-9)
    assert near.amplitude == pytest.approx(amplitude, abs=1e-7)
    far = _one(system, omega, [0.5 + amplitude + 2.0, 0.0])
    assert far.kind is AttractorKind.UNSETTLED and "still" in far.kind.sentence


def test_failure_is_not_slow_convergence():
    runaway = ContactSystem([[1.0]], [[-200.0]], [[0.0]], [1.0], [1.0], 0.0, 0.0)
    attractor = _one(runaway, 0.5, [1.0, 1.0])
    assert attractor.kind in (AttractorKind.FAILED, AttractorKind.UNBOUNDED) and attractor.status.sentence


def test_results_do_not_depend_on_the_company_of_other_states():
    system = gear_system(published())
    starts = np.random.default_rng(5).uniform(-3.0, 3.0, (4, 4))
    together = settle(system, 1.2265, starts)
    for attractor, start in zip(together, starts, strict=True):
        alone = _one(system, 1.2265, start, Settling())
        assert alone.kind is attractor.kind and alone.amplitude == pytest.approx(attractor.amplitude, abs=1e-9)


def test_impact_state_with_two_different_gaps_or_one():
    two = flying_mass(1.0, 3.0)
    cases = [(1.1, 2.0), (-2.9, 1.1), (-3.1, 1.1), (-2.9, 0.9), (-3.1, 0.9), (-4.0, -3.1)]
    assert [contact_impact(two, *case) for case in cases] == [0, 1, 2, 3, 4, 5]
    assert [contact_impact(flying_mass(1.0), *case) for case in cases] == [0, 1, 1, 3, 3, 3]
    assert contact_impact(two, np.nan, 1.0) == contact_impact(flying_mass(1.0), np.nan, 1.0) == -1


@pytest.mark.parametrize(
    "name, value",
    [
        ("max_periods", 0),
        ("block", 10),
        ("near", 0.0),
        ("ceiling", np.inf),
        ("highest_period", 2),
        ("tolerance", -1.0),
        ("lyapunov_periods", 3),
        ("lyapunov_floor", np.nan),
        ("close", -1.0),
    ],
)
def test_settings_are_checked(name, value):
    with pytest.raises(ParameterError, match=f"^{name} ="):
        Settling(**{name: value})


def test_every_kind_has_its_sentence():
    assert all(kind.sentence for kind in AttractorKind)
    assert [kind for kind in AttractorKind if kind.periodic] == list(AttractorKind)[1:6]
