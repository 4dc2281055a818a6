"""The diary of continuation: complete, and of the very curve that is traced without it."""

import numpy as np
import pytest

from solver import Broyden, Continuation, EndReason, Event, LinearSeeds, Newton, sweep_row
from solver.boundaries.problem import curve_tangent
from solver.continuation.curve_point import extrapolate, orient_near
from solver.continuation.trace_log import LoggedContinuation, Outcome
from solver.harmonic.describing_function import DescribingFunction
from solver.harmonic.galerkin import Galerkin
from solver.rows.seeds import LiftedSeeds
from tests.conftest import MODELS, antiphase, published
from tests.solver.toy import s_curve

GRID = np.linspace(0.05, 2.0, 41)


def check(trace, continuation):
    """What holds between the steps of a trace and its curve."""
    steps, curve = trace.steps, trace.curve
    accepted = steps.outcome == Outcome.ACCEPTED
    assert np.sum(~accepted) == curve.refused
    np.testing.assert_array_equal(steps.places[accepted], curve.points[steps.points[accepted] - 1])
    # What a step adds is its last point, and before it the events that were located on the way.
    added = np.diff(steps.points[accepted], prepend=1)
    assert steps.points[-1] == len(curve.points) and np.all(added >= 1)
    assert np.sum(added - 1) + np.sum(curve.event == Event.BRANCH_POINT) == np.sum(curve.event != Event.NONE)
    # A refused step is tried again at half the length.
    again = np.flatnonzero(~accepted[:-1])
    assert np.all(steps.length[again + 1] <= 0.5 * steps.length[again] * (1.0 + 1e-12))
    assert np.array_equal(steps.iterations == -1, steps.outcome == Outcome.NOT_CORRECTED)
    assert np.array_equal(np.isnan(steps.turn), steps.outcome == Outcome.NOT_CORRECTED)
    assert np.all(steps.turn[accepted] <= continuation.largest_angle)
    assert np.all(steps.turn[steps.outcome == Outcome.TURNED] > continuation.largest_angle)
    strayed = steps.outcome == Outcome.STRAYED
    assert np.all(steps.stray[strayed] > continuation.largest_distance * steps.length[strayed])
    # The angle again, from the tangents of the curve where no event lies between.
    plain = np.flatnonzero(accepted)[(added == 1) & (np.arange(added.size) < added.size - 1)]
    tangents = curve.tangents
    cosines = np.sum(tangents[steps.points[plain] - 1] * tangents[steps.points[plain] - 2], axis=1)
    np.testing.assert_allclose(np.cos(steps.turn[plain]), cosines, rtol=0, atol=1e-12)


def same_rows(one, other):
    """Two rows to the bit."""
    np.testing.assert_array_equal(one.motions, other.motions)
    assert len(one.curves) == len(other.curves)
    for left, right in zip(one.curves, other.curves, strict=True):
        for name in ("points", "tangents", "arclength", "event", "refused", "ends"):
            np.testing.assert_array_equal(getattr(left, name), getattr(right, name))


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("seeds", [None, LinearSeeds()], ids=["proven", "linear"])
def test_a_row_with_a_diary_is_the_row_without(name, seeds):
    diary = LoggedContinuation()
    same_rows(
        sweep_row(MODELS[name](), "omega", GRID, seeds=seeds, continuation=diary),
        sweep_row(MODELS[name](), "omega", GRID, seeds=seeds, continuation=Continuation()),
    )
    assert diary.traces
    for trace in diary.traces:
        # Linear seeds grow the backlash with longer strides, the bounds on angle and distance being the same.
        check(trace, diary)


def test_order_h_and_broyden_keep_a_diary_too():
    seeds = LiftedSeeds(11)
    diary = LoggedContinuation(corrector=Broyden())
    row = sweep_row(antiphase(), "omega", GRID, balance=Galerkin(3), seeds=seeds, continuation=diary)
    same_rows(
        row,
        sweep_row(
            antiphase(), "omega", GRID, balance=Galerkin(3), seeds=seeds, continuation=Continuation(corrector=Broyden())
        ),
    )
    for trace in diary.traces:
        assert trace.steps.places.shape[1] == 8
        check(trace, diary)


def test_every_reason_has_a_sentence_and_most_are_met():
    # Long steps meet all objections but the rare ones.
    diary = LoggedContinuation(
        first_step=2.0, largest_step=5.0, parameter_step=1.0, largest_angle=0.8, largest_distance=0.1
    )
    for f_e in (0.2, 0.6, 1.2):
        sweep_row(published(f_e=f_e), "omega", GRID, continuation=diary)
    usual = LoggedContinuation(traces=diary.traces)
    sweep_row(antiphase(f_e=0.12), "omega", GRID, continuation=usual, seeds=LinearSeeds())
    met = {Outcome(int(one)) for trace in diary.traces for one in np.unique(trace.steps.outcome)}
    assert {Outcome.ACCEPTED, Outcome.NOT_CORRECTED, Outcome.TURNED, Outcome.STRAYED} <= met
    assert all(outcome.sentence.endswith(".") for outcome in Outcome)


def test_a_diary_that_is_full_is_made_larger():
    finder = LoggedContinuation()
    sweep_row(published(), "omega", GRID, continuation=finder)
    first = finder.traces[0]
    start = first.curve.points[np.argmax(first.curve.event == Event.FOLD) + 3]
    # So sharp a bend refuses more steps than points fit.
    diary = LoggedContinuation(first_step=0.2, largest_angle=1e-4, max_points=4)
    curve = diary.trace(first.problem, start, GRID[0], GRID[-1], 1)
    (trace,) = diary.traces
    assert curve.ends[1] is EndReason.ITERATION_LIMIT and curve.refused > 4
    steps = trace.steps
    assert steps.outcome.size == curve.refused + 4 and steps.points[-1] == len(curve.points) == 4
    np.testing.assert_array_equal(steps.places[steps.outcome == Outcome.ACCEPTED][:-1], curve.points[1:])


@pytest.mark.parametrize("balance", [DescribingFunction(), Galerkin(3)], ids=["order 1", "order 3"])
def test_short_steps_seldom_need_a_corrector_and_lie_on_the_curve_all_the_same(balance):
    seeds = None if balance.truncated else LiftedSeeds(5)
    row = sweep_row(published(), "omega", GRID, balance=balance, seeds=seeds)
    middle = row.curves[0].points[len(row.curves[0].points) // 2]
    diary = LoggedContinuation(largest_angle=0.005, largest_step=0.05, max_points=300)
    curve = diary.trace(balance.problem(published(), "omega", GRID[0], GRID[-1]), middle, GRID[0], GRID[-1])
    (trace,) = diary.traces
    steps, problem, scale = trace.steps, trace.problem, trace.problem.scale
    assert np.mean(steps.iterations[steps.accepted] == 1) > 0.3
    for y, tangent, normal in zip(curve.points[1:], curve.tangents[1:], curve.tangents[:-1], strict=True):
        again = problem.corrected(y, Newton(tolerance=1e-12), normal)
        assert np.max(np.abs(again - y) / scale) < 1e-12
        expected = curve_tangent(problem, y)
        assert np.max(np.abs(tangent - np.sign(tangent @ expected) * expected)) < 1e-8


def test_a_cubic_is_continued_exactly_to_a_plane_across_its_end():
    problem = s_curve(3.0)
    setup = problem.setup(Newton())
    size = 2 * 2 + 2 * problem.test_count + 1

    def place(t):
        """A cubic's point and derivative by t, as a point array whose tangent is not normed."""
        y, slope = np.array([t**3 - t, 0.5 * t**2 + 2.0 * t]), np.array([3.0 * t**2 - 1.0, t + 2.0])
        return np.concatenate([y, slope / problem.scale, np.zeros(size - 4)])

    before, here, guess = place(0.0), place(0.5), np.zeros(size)
    tangent = here[2:4] / np.linalg.norm(here[2:4])
    for step in (0.1, 0.5, 1.0):
        extrapolate(setup, before, here, 0.5, step, guess)
        # On the hyperplane where the arrays' tangent says, moved there along it from the cubic's own place.
        reached = (guess[:2] - here[:2]) / problem.scale
        expected = (place(0.5 + step)[:2] - here[:2]) / problem.scale
        moved = reached - expected
        np.testing.assert_allclose(moved - (moved @ tangent) * tangent, 0.0, atol=1e-13)


def test_what_is_far_from_the_curve_is_left_to_the_corrector():
    problem = s_curve(3.0)
    setup, size = problem.setup(Newton()), 2 * 2 + 2 * problem.test_count + 1
    u, border = 1.5, np.array([0.0, 1.0])
    for away, takes in ((1e-11, 1), (1e-6, 2), (0.3, -1)):
        point = np.zeros(size)
        point[:2] = u + away, u**3 - 3.0 * u
        assert orient_near(setup, point, border) == takes
        if takes > 0:
            assert abs(point[0] - u) < 1e-11
