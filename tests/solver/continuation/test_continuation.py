"""Curves of the gear pair: what holds along them, where their events are, and that they never jump."""

import functools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq, fsolve, root

from solver import Broyden, Continuation, EndReason, Event, Newton, first_order_problem, sweep_row
from solver.harmonic.describing_function import evaluate
from tests.conftest import MODELS, antiphase, published
from tests.solver.curves import HIGH, LOW, check_invariants, check_steps, folds, solutions_on, swept
from tests.solver.exhaustive import all_solutions
from tests.solver.independent import linear_response
from tests.solver.strategies import random_model
from tests.solver.toy import s_curve


def test_invariants_on_the_three_sets(gear):
    _, model = gear
    curve = swept(model)
    check_invariants(curve, model)
    check_steps(curve, first_order_problem(model, "omega", LOW, HIGH), Continuation())
    assert curve.ends == (EndReason.RANGE_LEFT, EndReason.RANGE_LEFT)
    assert curve.points[0, 3] == LOW and curve.points[-1, 3] == HIGH


@settings(max_examples=40)
@given(st.integers(0, 10**9), st.floats(0.1, 1.0), st.floats(0.05, 2.0), st.sampled_from([Newton(), Broyden()]))
def test_invariants_on_gears_of_all_kinds(seed, f_pm, b, corrector):
    model = random_model(seed, f_pm=f_pm, b=b)
    continuation = Continuation(corrector=corrector)
    for curve in sweep_row(model, "omega", [LOW, 1.0, HIGH], continuation=continuation).curves:
        check_invariants(curve, model)
        check_steps(curve, first_order_problem(model, "omega", LOW, HIGH), continuation)


@functools.cache
def linear_grazings(name):
    """Where lambda_min = b on a branch in permanent contact: mean and amplitude of the linear response are equal."""
    model = MODELS[name]()

    def margin(omega):
        (mean, cosine, sine), _ = linear_response(model, omega)
        return mean - np.hypot(cosine, sine)

    grid = np.linspace(LOW, HIGH, 391)
    values = np.array([margin(omega) for omega in grid])
    return [brentq(margin, grid[i], grid[i + 1], xtol=1e-13) for i in np.flatnonzero(np.diff(np.sign(values)))]


@pytest.mark.parametrize("corrector", [Newton(), Broyden()])
def test_loss_of_contact_begins_where_the_linear_motion_says(gear, corrector):
    name, model = gear
    exact, curve = linear_grazings(name), swept(model, corrector=corrector)
    found = np.sort(curve.points[curve.event == Event.MIN_AT_DRIVE, 3])
    assert len(exact) >= 3
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-9)


@pytest.mark.parametrize("corrector", [Newton(), Broyden()])
@pytest.mark.parametrize("make", [published, antiphase])
def test_grazings_of_the_back_flank_solve_the_augmented_system(make, corrector):
    model = make(f_e=0.4)
    curve = swept(model, corrector=corrector)
    at = np.flatnonzero(curve.event == Event.MIN_AT_BACK)
    assert len(at) >= 2

    def system(y):
        return np.append(evaluate(model, y[3], y[:3])[0], y[0] - np.hypot(y[1], y[2]) + model.b)

    for point in curve.points[at]:
        exact = root(system, point + [1e-5, -1e-5, 1e-5, 1e-6], tol=1e-14).x
        assert np.max(np.abs(system(exact))) < 1e-12
        assert point[3] == pytest.approx(exact[3], abs=1e-9)


@pytest.mark.parametrize("corrector", [Newton(), Broyden()])
@pytest.mark.parametrize("make", [published, antiphase])
def test_folds_solve_the_augmented_system(make, corrector):
    """E = 0, det J = 0, solved by SciPy from a start that is moved away."""
    model = make()
    curve = swept(model, corrector=corrector)
    assert len(folds(curve)) == {published: 4, antiphase: 8}[make]

    def system(y):
        residual, jacobian = evaluate(model, y[3], y[:3])
        return np.append(residual, np.linalg.det(jacobian))

    for point in curve.points[curve.event == Event.FOLD]:
        exact, *_, message = fsolve(system, point + [1e-5, 1e-5, -1e-5, 1e-5], xtol=1e-13, full_output=True)
        assert np.max(np.abs(system(exact))) < 1e-11, message
        assert point[3] == pytest.approx(exact[3], abs=1e-9)
        np.testing.assert_allclose(point, exact, rtol=0, atol=1e-6)


RELAXED = dict(largest_step=10.0, parameter_step=1.0)


def test_no_jump_where_steps_are_huge_but_guards_are_kept(gear, reference):
    """Steps may be as long as the whole range: what holds them back are angle and distance alone."""
    name, model = gear
    curve = swept(model, **RELAXED)
    expected = reference[name]["folds"]
    assert len(folds(curve)) == len(expected)
    if expected:
        np.testing.assert_allclose(folds(curve), sorted(map(tuple, expected)), rtol=0, atol=1e-6)


def test_without_the_guards_the_curve_jumps_and_loses_solutions():
    """The same steps with angle and distance let go: two of the resonance's branches are cut off."""
    model = antiphase()
    jumping = swept(model, largest_angle=np.pi, largest_distance=10.0, **RELAXED)
    guarded = swept(model, **RELAXED)
    assert len(folds(jumping)) < len(folds(guarded)) == 8
    for omega, count in ((0.525, 5), (1.3, 3)):
        assert len(all_solutions(model, omega)) == solutions_on(guarded, omega) == count
    assert solutions_on(jumping, 0.525) + solutions_on(jumping, 1.3) < 8


def test_without_the_angle_guard_the_curve_jumps_too():
    jumping = swept(published(), largest_angle=np.pi, **RELAXED)
    assert len(folds(jumping)) < len(folds(swept(published(), **RELAXED))) == 4
    assert solutions_on(jumping, 0.6) + solutions_on(jumping, 1.2265) < 6


def test_the_distance_guard_alone_keeps_the_branch():
    """However far the tangent may turn, a correction that is long against its step gives the jump away."""
    kept = swept(antiphase(), largest_angle=np.pi, **RELAXED)
    np.testing.assert_allclose(folds(kept), folds(swept(antiphase())), rtol=0, atol=1e-7)


def test_a_curve_that_passes_close_to_its_start_is_not_closed():
    """The upper branch runs past the start on the lower one in the same sense, nearer than a step."""
    for gap in (0.3, 0.1, 0.03, 0.01):
        for angle in (0.35, 1.0, 2.0):
            continuation = Continuation(largest_step=1.0, first_step=0.05, parameter_step=1.0, largest_angle=angle)
            curve = continuation.trace(s_curve(gap), np.array([-np.sqrt(gap), 0.0]), -1.0, 1.0)
            assert curve.ends[1] is EndReason.RANGE_LEFT and curve.points[-1, 1] == 1.0
            assert np.sum(curve.event == Event.FOLD) == 2


@pytest.mark.parametrize("first_step", [1e-6, 1e-3, 0.1])
@pytest.mark.parametrize("largest_step", [0.02, 0.2, 2.0])
def test_folds_do_not_depend_on_the_steps(first_step, largest_step):
    expected = folds(swept(antiphase()))
    found = folds(swept(antiphase(), first_step=first_step, largest_step=largest_step))
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-7)
    np.testing.assert_allclose([f[0] for f in found], [f[0] for f in expected], rtol=0, atol=1e-9)
