"""Why curves end: closed, out of the range or of any other box, above the ceiling, stuck, full."""

import numpy as np
import pytest

from solver import Broyden, Continuation, EndReason, Event, LinearSeeds, Newton, first_order_problem, sweep_row
from solver.harmonic.describing_function import evaluate
from tests.conftest import consistent, published
from tests.solver.curves import COS_20, HIGH, LOW, check_invariants, folds, swept
from tests.solver.exhaustive import all_solutions
from tests.solver.reference_rows import grid
from tests.solver.toy import s_curve, toy


def isola(**settings_):
    """The closed curve of docs/physics.md, section 7, from its unstable solution at Omega = 0.55."""
    model = consistent(rotation_coupling=COS_20, alpha=0.44)
    solutions = all_solutions(model, 0.55)
    pairs = [(s[0], np.hypot(s[1], s[2])) for s in solutions]
    np.testing.assert_allclose(
        pairs, [(1.609920, 0.361035), (1.206839, 1.343213), (1.445556, 1.420666)], rtol=0, atol=1e-6
    )
    problem = first_order_problem(model, "omega", LOW, HIGH)
    start = np.append(solutions[2], 0.55)
    return model, solutions, Continuation(**settings_).trace_both_ways(problem, start, LOW, HIGH)


@pytest.mark.parametrize("corrector", [Newton(), Broyden()])
def test_the_isola_closes_and_has_the_published_folds(corrector):
    model, solutions, curve = isola(corrector=corrector)
    assert curve.ends == (EndReason.CLOSED, EndReason.CLOSED) and curve.closed
    # docs/physics.md, section 7.
    expected = [
        (0.511643, 1.084987, 2.122987),
        (0.513399, 0.826381, 1.879884),
        (0.521717, 0.921135, 2.289807),
        (0.580161, 1.548228, 0.955863),
    ]
    np.testing.assert_allclose(folds(curve), expected, rtol=0, atol=1e-6)
    np.testing.assert_allclose(curve.points[0], curve.points[-1], rtol=0, atol=1e-12)
    assert abs(curve.tangents[0] @ curve.tangents[-1]) == pytest.approx(1.0, abs=1e-9)
    check_invariants(curve, model)
    assert curve.stable[0] == 0
    near = np.argmin(np.max(np.abs(curve.points[:, :3] - solutions[1]), axis=1))
    assert curve.stable[near] == 1
    # Apart from the main branch, which has no fold at all.
    assert folds(swept(model)) == []
    assert np.min(curve.points[:, 3]) == pytest.approx(0.511643, abs=1e-6)
    assert np.max(curve.points[:, 3]) == pytest.approx(0.580161, abs=1e-6)


@pytest.mark.parametrize("omega, place", [(0.53, 1), (0.53, 2), (0.57, 1), (0.518, 3)])
def test_the_isola_closes_from_everywhere(omega, place):
    model, _, reference = isola()
    problem = first_order_problem(model, "omega", LOW, HIGH)
    start = np.append(all_solutions(model, omega)[place], omega)
    for heading in (1, -1):
        curve = Continuation().trace(problem, start, LOW, HIGH, heading)
        assert curve.ends[1] is EndReason.CLOSED
        np.testing.assert_allclose(folds(curve), folds(reference), rtol=0, atol=1e-7)
        assert curve.arclength[-1] == pytest.approx(reference.arclength[-1], rel=1e-2)


def test_an_isola_cut_by_the_range_is_followed_to_both_borders():
    model, solutions, _ = isola()
    problem = first_order_problem(model, "omega", 0.54, HIGH)
    curve = Continuation().trace_both_ways(problem, np.append(solutions[2], 0.55), 0.54, HIGH)
    assert curve.ends == (EndReason.RANGE_LEFT, EndReason.RANGE_LEFT) and not curve.closed
    assert curve.points[0, 3] == curve.points[-1, 3] == 0.54
    assert len(folds(curve)) == 1 and np.all(np.diff(curve.arclength) > 0.0)


def test_the_last_point_lies_on_the_border_exactly():
    for high in (0.3, 0.6, 0.7654321, 1.2265):
        problem = first_order_problem(published(), "omega", LOW, high)
        start = np.append(all_solutions(published(), LOW)[0], LOW)
        curve = Continuation().trace(problem, start, LOW, high)
        assert curve.points[-1, 3] == high and np.all(curve.points[:, 3] <= high)
        residual, _ = evaluate(published(), high, curve.points[-1, :3])
        assert np.max(np.abs(residual)) < 1e-12


def test_a_curve_ends_where_any_component_leaves_its_box():
    model = published()
    problem = first_order_problem(model, "omega", LOW, HIGH)
    start = sweep_row(model, "omega", grid(100), seeds=LinearSeeds()).curves[0].points[0]
    low, high = np.array([-np.inf, -np.inf, -np.inf, 0.05]), np.array([np.inf, np.inf, np.inf, 2.0])
    free = Continuation().trace(problem, start, 0.05, 2.0)
    level = 0.5 * np.max(free.points[:, 1])
    high[1] = level
    curve = Continuation().trace(problem, start, low, high)
    assert curve.ends[1] is EndReason.RANGE_LEFT
    assert curve.points[-1, 1] == level and np.all(curve.points[:-1, 1] < level)
    # From that border it heads out at once, or back in.
    outwards = Continuation().trace(problem, curve.points[-1], low, high, heading=curve.tangents[-1])
    assert len(outwards.points) == 1 and outwards.ends[1] is EndReason.RANGE_LEFT
    back = Continuation().trace(problem, curve.points[-1], low, high, heading=-curve.tangents[-1])
    np.testing.assert_allclose(back.points[-1], start, rtol=0, atol=1e-8)


@pytest.mark.parametrize("ceiling", [3.0, 20.0, 100.0])
def test_a_branch_that_rises_above_the_ceiling_ends_on_it(ceiling):
    model = consistent(rotation_coupling=COS_20, variation_translation=0.0, alpha=0.47)
    curve = swept(model, amplitude_max=ceiling)
    assert curve.ends[1] is EndReason.AMPLITUDE_CEILING
    assert curve.amplitude[-1] == pytest.approx(ceiling, abs=1e-9 * ceiling)
    assert np.all(curve.amplitude[:-1] < ceiling)
    check_invariants(curve, model)


def test_the_unbounded_branch_runs_to_its_published_frequency():
    # To infinity near 0.5918 once alpha passes 0.4590; lambda_a <= 37 at 0.45.
    def peak(alpha, ceiling):
        model = consistent(rotation_coupling=COS_20, variation_translation=0.0, alpha=alpha)
        return swept(model, amplitude_max=ceiling)

    bounded = peak(0.45, 1e4)
    assert bounded.ends[1] is EndReason.RANGE_LEFT and 36.0 < np.max(bounded.amplitude) <= 37.0
    assert peak(0.4585, 1e4).ends[1] is EndReason.RANGE_LEFT
    for alpha in (0.4595, 0.47):
        assert peak(alpha, 1e4).ends[1] is EndReason.AMPLITUDE_CEILING
    assert peak(0.4595, 1e4).points[-1, 3] == pytest.approx(0.5918, abs=1e-3)


def test_a_curve_that_cannot_go_on_says_so():
    # u = p, undefined above p = 0.5.
    curve = Continuation().trace(toy(linear=1.0, parameter=-1.0, limit=0.5), np.zeros(2), 0.0, 1.0)
    assert curve.ends[1] is EndReason.STEP_TOO_SMALL
    np.testing.assert_allclose(curve.points[-1], [0.5, 0.5], rtol=0, atol=1e-8)
    assert curve.refused > 10 and np.all(curve.points[:, 1] <= 0.5)


def test_a_start_without_a_tangent_says_so():
    # u (u^2 - p) = 0 at its crossing.
    curve = Continuation().trace(toy(cubic=1.0, mixed=-1.0), np.zeros(2), -1.0, 1.0)
    assert curve.ends[1] is EndReason.NO_TANGENT and len(curve.points) == 0


def test_a_start_that_is_no_solution_is_corrected_at_its_own_axis_value():
    problem = first_order_problem(published(), "omega", LOW, HIGH)
    exact = all_solutions(published(), 0.9)[0]
    moved = exact + [0.05, -0.03, 0.04]
    curve = Continuation().trace(problem, np.append(moved, 0.9), LOW, HIGH)
    assert curve.ends[1] is EndReason.RANGE_LEFT and len(curve.points) > 10
    np.testing.assert_allclose(curve.points[0], np.append(exact, 0.9), rtol=0, atol=1e-10)
    assert np.max(np.abs(evaluate(published(), 0.9, curve.points[0, :3])[0])) < 1e-11


def test_a_start_that_cannot_be_corrected_is_refused_with_its_reason():
    # u = p is undefined above p = 0.5: nothing is to be found there, in neither direction.
    problem = toy(linear=1.0, parameter=-1.0, limit=0.5)
    for trace in (Continuation().trace, Continuation().trace_both_ways):
        curve = trace(problem, np.array([0.3, 0.7]), 0.0, 1.0)
        assert curve.ends[1] is EndReason.NO_SOLUTION and len(curve.points) == 0


def test_a_start_on_a_fold_is_followed_to_both_sides():
    """There p turns round, so that a heading in p tells no side; opposite ones take opposite sides all the same."""
    fold = np.sqrt(1.0 / 3.0)
    start = np.array([fold, fold**3 - fold])
    curves = [Continuation().trace(s_curve(1.0), start, -1.0, 1.0, heading) for heading in (1, -1)]
    for curve in curves:
        assert len(curve.points) > 3 and curve.ends[1] is EndReason.RANGE_LEFT
        np.testing.assert_allclose(curve.points[0], start, rtol=0, atol=1e-7)
        np.testing.assert_allclose(curve.points[:, 0] ** 3 - curve.points[:, 0], curve.points[:, 1], rtol=0, atol=1e-10)
    # One side leads straight to p = 1, the other over the second fold to p = -1.
    assert {curve.points[-1, 1] for curve in curves} == {-1.0, 1.0}


def test_steps_that_may_not_be_small_end_the_curve():
    curve = swept(published(), smallest_step=0.05, first_step=0.2)
    assert curve.ends[1] is EndReason.STEP_TOO_SMALL and len(curve.points) > 0
    assert curve.points[-1, 3] < HIGH


@pytest.mark.parametrize("room", [2, 3, 40, 150])
def test_a_full_curve_says_so_and_is_what_fits(room):
    whole, cut = swept(published()), swept(published(), max_points=room)
    assert cut.ends[1] is EndReason.ITERATION_LIMIT and len(cut.points) == room
    np.testing.assert_array_equal(cut.points, whole.points[:room])
    np.testing.assert_array_equal(cut.event, whole.event[:room])


def test_a_curve_that_just_fits_is_whole():
    whole = swept(published())
    assert swept(published(), max_points=len(whole.points)).ends[1] is EndReason.RANGE_LEFT
    assert swept(published(), max_points=len(whole.points) - 1).ends[1] is EndReason.ITERATION_LIMIT


def test_every_reason_and_event_has_a_sentence_of_its_own():
    for kind, count in ((EndReason, 8), (Event, 10)):
        sentences = {member.sentence for member in kind}
        assert len(sentences) == len(kind) == count
        assert all(sentence.endswith(".") and sentence[0].isupper() or "=" in sentence for sentence in sentences)
    assert [r.name for r in EndReason] == [
        "RANGE_LEFT",
        "CLOSED",
        "AMPLITUDE_CEILING",
        "STEP_TOO_SMALL",
        "ITERATION_LIMIT",
        "JOINED",
        "NO_SOLUTION",
        "NO_TANGENT",
    ]
