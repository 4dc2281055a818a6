"""What happens in planes of a spur pair and of a stop: attractors, runs along a row, and margins."""

from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.analysis.attractors.places import states_at_rest
from pipeline.analysis.diagram.following import follow
from pipeline.analysis.diagram.options import Way
from pipeline.analysis.margins.distances import margins_of_further
from pipeline.analysis.margins.options import Design
from pipeline.analysis.margins.resonances import resonances_in
from pipeline.analysis.motion.motions import motions_at
from pipeline.config.compose import compose
from pipeline.errors import ConfigurationError
from pipeline.plan.numerics import model_at, point_of
from pipeline.plan.traits import contact_force, contact_system
from pipeline.study.tables.stage import _check as check_tables
from solver import Event, all_solutions
from tests.pipeline.planes import small_plan

SPUR = ("gear=spur", "plane=omega_load")


@pytest.fixture(scope="module")
def spur():
    return small_plan(*SPUR)


def searched(*overrides):
    return compose([*SPUR, "attractors.starts=4", "attractors.slice=0", *overrides]).config.attractors


def test_motions_of_the_spur_pair_are_those_of_the_reference(spur):
    """Physics, section 9: at 0.5 the teeth part, which order 1 does not see; at 1.8 there is 2T beside 1T.

    The highest displacement at 0.5 is 1.242393 by three methods: tests/solver/stability/test_spur_pair.py.
    """
    (motion,) = motions_at(spur, 0.5, 0.1, searched()).attractors
    told = motion.quantities
    assert (motion.label, motion.of_map.label) == ("1T/1", "1T/0")
    assert (told.lowest, told.highest, told.mean) == pytest.approx((0.95104, 1.24239, 1.09286), abs=6e-6)
    assert np.isnan(told.error_rms) and np.isnan(told.support_force) and told.dynamic_factor > 1.0
    # The force that is drawn is that of the motion: 0 where teeth part.
    curves = motion.curves
    model, _ = point_of(spur, 0.1, 0.5)
    wanted = contact_force(model, curves.displacement, 2.0 * np.pi * curves.periods)
    np.testing.assert_allclose(curves.force, wanted, atol=1e-12)
    found = {one.label: one for one in motions_at(spur, 1.8, 0.1, searched("attractors.starts=12")).attractors}
    assert set(found) == {"1T/0", "2T/1"}
    double, single = (found[label].quantities for label in ("2T/1", "1T/0"))
    assert (double.lowest, double.highest) == pytest.approx((0.90521, 1.28247), abs=1e-5)
    assert (single.lowest, single.highest) == pytest.approx((1.06818, 1.11706), abs=1e-5)


def test_a_run_jumps_at_the_folds_of_the_reference(spur):
    """Physics, section 9: folds 0.598153, 0.835838, 0.437007, 0.455324 at orders up to 63; jumps lie within a step."""
    step = 0.01
    run = follow(spur, Way(0.1, tuple(np.arange(0.42, 0.86, step).tolist()), 800)).runs
    jumps = {name: np.sort(one.jumps[np.isfinite(one.jumps)]) for name, one in run.items()}
    np.testing.assert_allclose(jumps["up"], [0.455324, 0.835838], atol=step)
    np.testing.assert_allclose(jumps["down"], [0.437007, 0.598153], atol=step)


def test_margins_in_a_parameter_that_is_no_axis_end_where_solutions_do(spur):
    """Of the spur pair with less damping: the number of solutions changes at the damping that is told."""
    design = Design(0.52, 0.1, 0.52, 0.52)
    found = margins_of_further(spur, design, "damping_ratio")
    (margin,) = [one for one in found if one.place is not None]
    assert margin.kind is Event.FOLD and 0.0 < margin.place < margin.value == 0.05
    counts = []
    for damping in (margin.place - 1e-7, margin.place + 1e-7):
        changed = small_plan(*SPUR, f"gear.spur.damping_ratio={damping!r}")
        counts.append(all_solutions(model_at(changed, 0.1, 0.52), 0.52).mean.size)
    assert counts == [3, 1]


def test_resonances_of_the_spur_pair_are_fractions_of_its_one_mode(spur):
    found = resonances_in(model_at(spur, 0.1, 1.0), 0.3, 2.1)
    np.testing.assert_allclose([one.omega for one in found], [1.0 / 3.0, 0.5, 1.0, 2.0], rtol=1e-12)


def test_a_start_in_a_box_has_the_displacement_and_the_speed_that_were_asked():
    """Of a contact that sees several coordinates, all that it does not see is at rest."""
    planned = small_plan("gear=rotor", "plane=omega_load")
    model, omega = point_of(planned, 0.1, 0.9)
    system, asked = contact_system(model), np.array([[0.3, -0.2], [1.5, 0.7]])
    states, n = states_at_rest(model, omega, asked), system.degrees
    np.testing.assert_allclose(states[:, :n] @ system.contact, asked[:, 0], rtol=1e-13)
    np.testing.assert_allclose(states[:, n:] @ system.contact, asked[:, 1], rtol=1e-13)
    across = np.array([1.0, 1.0, 0.0])
    assert np.ptp(states[:, :n] @ across) < 1e-14 and np.all(np.abs(states[:, n:] @ across) < 1e-14)


def test_tables_of_the_study_are_refused():
    with pytest.raises(ConfigurationError, match="'spur'.*tables"):
        check_tables(SimpleNamespace(settings=compose([*SPUR, "stages=[tables]"])))
