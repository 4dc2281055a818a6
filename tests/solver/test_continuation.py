"""Curves of the gear pair: where they go, what is found on them, why they end, and that they never jump."""

import dataclasses
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq, fsolve, root

from solver import (
    Broyden, Continuation, EndReason, Event, Newton, ParameterError, first_order_problem, impact_state, sweep_row,
)  # fmt: skip
from solver.harmonic.first_order import evaluate
from tests.conftest import antiphase, consistent, published
from tests.solver.exhaustive import all_solutions
from tests.solver.independent import linear_response
from tests.solver.strategies import random_model
from tests.solver.toy import s_curve, toy

LOW, HIGH = 0.05, 2.0
COS_20 = 0.93969262

#: Extremes and flanks that an event of each kind says are equal: (min or max, +b or -b).
GRAZINGS = {
    Event.MIN_AT_DRIVE: (-1.0, -1.0), Event.MIN_AT_BACK: (-1.0, 1.0), Event.MAX_AT_DRIVE: (1.0, -1.0),
    Event.MAX_AT_BACK: (1.0, 1.0),
}  # fmt: skip


def swept(model, **settings_):
    """The curve over frequency that starts from the (single) solution at its low end."""
    problem = first_order_problem(model, "omega", LOW, HIGH)
    start = all_solutions(model, LOW)
    assert len(start) == 1
    return Continuation(**settings_).trace(problem, np.append(start[0], LOW), LOW, HIGH)


def folds(curve):
    """(Omega, lambda_m, lambda_a) of all folds, ascending."""
    at = np.flatnonzero(curve.event == Event.FOLD)
    return sorted((p[3], p[0], a) for p, a in zip(curve.points[at], curve.amplitude[at], strict=True))


def margins(curve, model):
    """(points, 4) values that vanish at the four kinds of grazing."""
    mean, amplitude = curve.points[:, 0], curve.amplitude
    return np.column_stack([mean + e * amplitude + f * model.b for e, f in GRAZINGS.values()])


def check_invariants(curve, model):
    """Everything that holds along every curve over frequency."""
    omega, event, size = curve.points[:, 3], curve.event, max(1.0, np.max(np.abs(curve.points[:, :3])))
    assert set(event) <= {0, *Event}
    # Every point is a solution, and stable where its determinant is positive.
    evaluated = [evaluate(model, y[3], y[:3]) for y in curve.points]
    assert max(np.max(np.abs(residual)) for residual, _ in evaluated) < 1e-8 * size
    determinants = np.array([np.linalg.det(jacobian) for _, jacobian in evaluated])
    clear = (np.abs(determinants) > 1e-8) & (event != Event.FOLD)
    np.testing.assert_array_equal(curve.stable[clear] == 1, determinants[clear] > 0.0)
    # Folds turn p round and stability over, nothing else does.
    at = [0, *np.flatnonzero(event == Event.FOLD), len(omega) - 1]
    senses, states = [], []
    for first, last in zip(at, at[1:], strict=False):
        steps = np.diff(omega[first : last + 1])
        assert np.all(steps >= 0.0) or np.all(steps <= 0.0)
        senses.append(np.sign(omega[last] - omega[first]))
        inside = {*curve.stable[first + 1 : last]} or {1 - states[-1]}
        assert len(inside) == 1
        states.append(inside.pop())
    assert all(a == -b for a, b in zip(senses, senses[1:], strict=False))
    assert all(a == 1 - b for a, b in zip(states, states[1:], strict=False))
    assert np.all(curve.stable[event == Event.FOLD] == 0)
    # A grazing is where its margin vanishes; it changes sign there and nowhere else.
    for kind, values in zip(GRAZINGS, margins(curve, model).T, strict=True):
        at = np.flatnonzero(event == kind)
        assert np.max(np.abs(values[at]), initial=0.0) < 1e-9 * size
        pieces = [np.sign(piece[1 if i else 0 :]) for i, piece in enumerate(np.split(values, at))]
        pieces = [set(piece) for piece in pieces if len(piece)]
        assert all(len(piece) == 1 for piece in pieces)
        signs = [piece.pop() for piece in pieces]
        assert all(a == -b for a, b in zip(signs, signs[1:], strict=False))
    # So the kind of motion is the same between two neighbouring events.
    impact = impact_state(curve.points[:, 0] - curve.amplitude, curve.points[:, 0] + curve.amplitude, model.b)
    for piece in np.split(np.arange(len(omega)), np.flatnonzero(event > Event.FOLD)):
        assert len({*impact[piece[1 if event[piece[0]] > Event.FOLD else 0 :]]}) <= 1
    # Orientation is kept: tangents are unit vectors and follow the chords.
    assert np.all(np.diff(curve.arclength) > 0.0) and curve.arclength[0] == 0.0
    np.testing.assert_allclose(np.linalg.norm(curve.tangents, axis=1), 1.0, rtol=0, atol=1e-12)


def check_steps(curve, problem, continuation):
    """No accepted step is longer or turns further than allowed, and tangents point along the curve."""
    # Located events lie inside of a step, where the curve may turn there and back again.
    whole = (curve.event[1:] == 0) & (curve.event[:-1] == 0)
    turns = np.sum(curve.tangents[1:] * curve.tangents[:-1], axis=1)
    assert np.min(turns[whole]) > np.cos(continuation.largest_angle) - 1e-12
    assert np.min(turns) > 0.5
    chords = np.diff(curve.points / problem.scale, axis=0)
    lengths = np.linalg.norm(chords, axis=1)
    along = np.sum(chords * curve.tangents[:-1], axis=1) / lengths
    assert np.min(along[whole]) > np.cos(continuation.largest_angle)
    sizes = np.max(np.abs(curve.points[:-1, :-1] / problem.scale[:-1]), axis=1)
    limit = np.maximum(continuation.largest_step, continuation.growth * sizes)
    assert np.all(np.diff(curve.arclength) <= 1.2 * limit)
    reach = continuation.parameter_step * (HIGH - LOW)
    assert np.max(np.abs(np.diff(curve.points[:, -1]))) < 1.2 * reach


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


@pytest.mark.parametrize("corrector", [Newton(), Broyden()])
def test_loss_of_contact_begins_where_the_linear_motion_says(gear, corrector):
    """lambda_min = b on a branch in permanent contact: mean and amplitude of the linear response are equal."""
    _, model = gear

    def margin(omega):
        (mean, cosine, sine), _ = linear_response(model, omega)
        return mean - np.hypot(cosine, sine)

    grid = np.linspace(LOW, HIGH, 391)
    values = np.array([margin(omega) for omega in grid])
    exact = [
        brentq(margin, grid[i], grid[i + 1], xtol=1e-13) for i in np.flatnonzero(np.diff(np.sign(values)))
    ]  # fmt: skip
    curve = swept(model, corrector=corrector)
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


def solutions_on(curve, omega):
    """How many points the curve has at a frequency."""
    return int(np.sum(np.diff(np.sign(curve.points[:, 3] - omega)) != 0))


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


# End reasons -----------------------------------------------------------------------------------------------------------


def isola(**settings_):
    """The closed curve of PHYSICS, section 7, from its unstable solution at Omega = 0.55."""
    model = consistent(rotation_coupling=COS_20, alpha=0.44)
    solutions = all_solutions(model, 0.55)
    pairs = [(s[0], np.hypot(s[1], s[2])) for s in solutions]
    np.testing.assert_allclose(
        pairs, [(1.609920, 0.361035), (1.206839, 1.343213), (1.445556, 1.420666)], rtol=0, atol=1e-6
    )
    problem = first_order_problem(model, "omega", LOW, HIGH)
    return model, solutions, Continuation(**settings_).trace_both_ways(problem, np.append(solutions[2], 0.55), LOW, HIGH)


@pytest.mark.parametrize("corrector", [Newton(), Broyden()])
def test_the_isola_closes_and_has_the_published_folds(corrector):
    model, solutions, curve = isola(corrector=corrector)
    assert curve.ends == (EndReason.CLOSED, EndReason.CLOSED) and curve.closed
    # PHYSICS prints 2.122699 for the first amplitude; quadrature of the seven degrees of freedom gives 2.1229868, too.
    expected = [
        (0.511643, 1.084987, 2.122987), (0.513399, 0.826381, 1.879884), (0.521717, 0.921135, 2.289807),
        (0.580161, 1.548228, 0.955863),
    ]  # fmt: skip
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
    assert curve.ends[1] is EndReason.STEP_TOO_SMALL and len(curve.points) == 0


def test_steps_that_may_not_be_small_end_the_curve():
    curve = swept(published(), smallest_step=0.05, first_step=0.2)
    assert curve.ends[1] is EndReason.STEP_TOO_SMALL and 0 < len(curve.points)
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
    for kind, count in ((EndReason, 6), (Event, 9)):
        sentences = {member.sentence for member in kind}
        assert len(sentences) == len(kind) == count
        assert all(sentence.endswith(".") and sentence[0].isupper() or "=" in sentence for sentence in sentences)
    assert [r.name for r in EndReason] == [
        "RANGE_LEFT", "CLOSED", "AMPLITUDE_CEILING", "STEP_TOO_SMALL", "ITERATION_LIMIT", "JOINED",
    ]  # fmt: skip


# Pairs of events close together, and crossings ------------------------------------------------------------------------

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
    """Where the other flank is reached, the curve may bend so sharply that it folds there and back between two points."""
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


def test_the_last_point_lies_on_the_border_exactly():
    for high in (0.3, 0.6, 0.7654321, 1.2265):
        problem = first_order_problem(published(), "omega", LOW, high)
        start = np.append(all_solutions(published(), LOW)[0], LOW)
        curve = Continuation().trace(problem, start, LOW, high)
        assert curve.points[-1, 3] == high and np.all(curve.points[:, 3] <= high)
        residual, _ = evaluate(published(), high, curve.points[-1, :3])
        assert np.max(np.abs(residual)) < 1e-12


# Settings --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name, value, allowed",
    [
        *((name, bad, "a finite number above 0")
          for name in ("first_step", "largest_step", "smallest_step", "growth", "amplitude_max")
          for bad in (0.0, -1.0, np.inf, np.nan)),
        *(("largest_angle", bad, "above 0 and at most 3.14159") for bad in (0.0, 3.2, np.nan)),
        *(("largest_distance", bad, "above 0 and at most 10") for bad in (0.0, 11.0, np.nan)),
        *(("parameter_step", bad, "above 0 and at most 1") for bad in (0.0, 1.5, np.nan)),
        *(("max_points", bad, "from 2 to 10000000") for bad in (1, 10**8)),
    ],
)  # fmt: skip
def test_settings_out_of_range_are_refused(name, value, allowed):
    with pytest.raises(ParameterError) as caught:
        Continuation(**{name: value})
    assert str(caught.value) == f"{name} = {value!r} is not allowed: it must be {allowed}"


def test_settings_are_frozen_and_comparable():
    assert Continuation() == Continuation() != Continuation(corrector=Broyden())
    with pytest.raises(dataclasses.FrozenInstanceError):
        Continuation().first_step = 1.0
    # Workers get them by pickle.
    changed = Continuation(corrector=Broyden(tolerance=1e-7), largest_step=0.3)
    assert pickle.loads(pickle.dumps(changed)) == changed
