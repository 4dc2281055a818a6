"""The diary of continuation: complete, and of the very curve that is traced without it."""

import numpy as np
import pytest

from solver import Broyden, Continuation, EndReason, Event, LinearSeeds, sweep_row
from solver.continuation.trace_log import LoggedContinuation, Outcome
from solver.harmonic.galerkin import Galerkin
from solver.rows.seeds import LiftedSeeds
from tests.conftest import MODELS, antiphase, published

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
