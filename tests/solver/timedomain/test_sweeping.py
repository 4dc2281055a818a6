"""Attractors up and down a parameter."""

import numpy as np
import pytest

from solver import ParameterError
from solver.model.contact_system import ContactSystem, gear_system
from solver.timedomain import AttractorKind, resting_state, sweep_attractors
from tests.conftest import consistent, published


def test_run_up_and_run_down_differ_between_the_folds():
    def system_at(omega):
        return gear_system(published()), omega

    # The true 1T of the lower branch touches b, and 2T lives beside it: docs/physics.md, section 8.
    sweep = sweep_attractors(system_at, [1.20, 1.215, 1.2265, 1.25])
    assert sweep.hysteresis.tolist() == [False, False, True, False]
    kinds = {sweep.up[2].kind, sweep.down[2].kind}
    assert kinds == {AttractorKind.PERIOD_1, AttractorKind.PERIOD_2}


def test_period_doubling_of_the_consistent_pair():
    model = consistent(rotation_coupling=0.93969262, variation_translation=0.0)
    sweep = sweep_attractors(lambda omega: (gear_system(model), omega), [1.00, 1.21, 1.30])
    assert [one.kind for one in sweep.up] == [AttractorKind.PERIOD_1, AttractorKind.PERIOD_2, AttractorKind.PERIOD_1]
    assert [one.kind for one in sweep.down] == [one.kind for one in sweep.up]


def test_unbounded_motion_does_not_poison_what_follows():
    def system_at(strength):
        return ContactSystem(
            [[1.0]],
            [[0.1]],
            [[0.0]],
            [1.0],
            [1.0],
            0.0,
            0.0,
            varying_force=[1.0],
            stiffness_harmonics=[(strength, 0.0)],
            load=[[1.0]],
        ), 2.0

    sweep = sweep_attractors(system_at, [0.1, 0.8, 0.05])
    assert [one.kind for one in sweep.up] == [AttractorKind.PERIOD_1, AttractorKind.UNBOUNDED, AttractorKind.PERIOD_1]
    assert sweep.down[0].mean == pytest.approx(sweep.up[0].mean, abs=1e-9)


def test_resting_state_carries_the_mean_load():
    system = gear_system(published())
    y = resting_state(system)[:2]
    force = system.contact_force(system.contact @ y)
    np.testing.assert_allclose(system.stiffness @ y + system.force * force, system.load[0].real, atol=1e-12)


@pytest.mark.parametrize("values", [[], [np.nan], [[1.0]]])
def test_bad_values_are_named(values):
    with pytest.raises(ParameterError, match="^values ="):
        sweep_attractors(lambda omega: (gear_system(published()), omega), values)
