"""Pairs of events close together, crossings of branches, and what only comes near."""

import numpy as np
import pytest

from solver import Continuation, EndReason, Event, sweep_row
from tests.solver.curves import HIGH, LOW, check_invariants, solutions_on
from tests.solver.exhaustive import all_solutions
from tests.solver.strategies import random_model
from tests.solver.toy import s_curve, toy

WIDE = Continuation(largest_step=1.0, parameter_step=1.0, first_step=0.3)


@pytest.mark.parametrize("gap", [0.3, 1e-2, 1e-3, 1e-4])
def test_two_folds_do_not_hide_inside_one_step(gap):
    """p = u^3 - gap u: the folds lie 4 (gap/3)^1.5 apart in p, far less than a step."""
    curve = WIDE.trace(s_curve(gap), np.array([-1.2, -1.728 + 1.2 * gap]), -1.728 + 1.2 * gap, 2.0)
    at = curve.points[curve.event == Event.FOLD]
    place = np.sqrt(gap / 3.0)
    np.testing.assert_allclose(at[:, 0], [-place, place], rtol=0, atol=1e-6)
    np.testing.assert_allclose(at[:, 1], [2.0 * place**3, -2.0 * place**3], rtol=0, atol=1e-9)
    assert curve.ends[1] is EndReason.RANGE_LEFT


@pytest.mark.parametrize("seed, f_pm, b", [(1012, -0.763, 0.531), (1791, -1.103, 0.025), (2068, 0.62, 0.193)])
def test_two_folds_beside_a_grazing_do_not_hide_inside_one_step(seed, f_pm, b):
    """Where the other flank is reached, the curve may bend so sharply that it folds twice between two points."""
    model = random_model(seed, f_pm=f_pm, b=b)
    curves = sweep_row(model, "omega", [LOW, 1.0, HIGH]).curves
    for curve in curves:
        check_invariants(curve, model)
        for i in np.flatnonzero(curve.event > Event.FOLD):
            middle = 0.5 * (curve.points[i - 1, 3] + curve.points[i, 3])
            count = len(all_solutions(model, middle, 1000))
            assert sum(solutions_on(other, middle) for other in curves) == count


def test_no_folds_where_there_are_none():
    for gap in (0.0, -1e-4, -0.1):
        curve = WIDE.trace(s_curve(gap), np.array([-1.2, -1.728 + 1.2 * gap]), -1.728 + 1.2 * gap, 2.0)
        assert not np.any(curve.event == Event.FOLD) and np.all(curve.stable[curve.points[:, 0] != 0.0] == 1)


@pytest.mark.parametrize("depth", [0.1, 1e-3, 1e-5])
@pytest.mark.parametrize("centre", [-0.5, 0.013, 0.5])
def test_two_grazings_do_not_hide_inside_one_step(centre, depth):
    """(u - centre)^2 = depth, along the straight curve u = p."""
    curve = WIDE.trace(toy(1e-9, 1.0, 0.0, -1.0, centre=centre, depth=depth), np.array([-1.0, -1.0]), -1.0, 1.0)
    at = curve.points[curve.event == 2, 1]
    np.testing.assert_allclose(at, [centre - np.sqrt(depth), centre + np.sqrt(depth)], rtol=0, atol=1e-8)


def test_a_margin_that_only_comes_near_is_no_grazing():
    curve = WIDE.trace(toy(0.0, 1.0, 0.0, -1.0, centre=0.1, depth=-1e-4), np.array([-1.0, -1.0]), -1.0, 1.0)
    assert not np.any(curve.event)


def test_a_crossing_of_branches_is_passed_and_marked():
    """u (u^2 - p) = 0 along u = 0: stable before, unstable after the pitchfork."""
    curve = Continuation().trace(toy(cubic=1.0, mixed=-1.0), np.array([0.0, -1.0]), -1.0, 1.0)
    assert curve.ends[1] is EndReason.RANGE_LEFT
    np.testing.assert_allclose(curve.points[:, 0], 0.0, rtol=0, atol=1e-12)
    at = np.flatnonzero(curve.event == Event.BRANCH_POINT)
    assert len(at) == 1 and curve.points[at[0], 1] == pytest.approx(0.0, abs=1e-3)
    np.testing.assert_array_equal(curve.stable[: at[0] - 1], 1)
    np.testing.assert_array_equal(curve.stable[at[0] + 1 :], 0)
