"""Duffing's oscillator through the continuation code: points, folds and grazings against its closed formula."""

import dataclasses

import numpy as np
import pytest

from solver import Broyden, Continuation, EndReason, Event, Newton
from solver.continuation.continuation import Curve
from solver.continuation.on_curve import curve_crossings
from tests.solver import duffing
from tests.solver.independent import difference

LOW, HIGH = 0.05, 2.0


@pytest.fixture(scope="module", params=[Newton(), Broyden()], ids=["newton", "broyden"])
def curve(request) -> Curve:
    problem = duffing.duffing(LOW, HIGH)
    return Continuation(corrector=request.param).trace(problem, duffing.start(LOW), LOW, HIGH)


def size(points):
    return np.hypot(points[:, 0], points[:, 1])


def test_derivatives():
    problem, y = duffing.duffing(), np.array([0.7, -1.3, 1.1])
    residual, jacobian, values, gradient = np.empty(2), np.empty((2, 3)), np.empty(2), np.empty((2, 3))

    def both(x):
        problem.residual_and_jacobian(problem.parameters, problem.parameter_slope, x, residual, jacobian)
        problem.test_functions(problem.parameters, problem.parameter_slope, x, values, gradient)
        return np.concatenate([residual, values])

    expected = np.column_stack([difference(lambda x, c=c: both(y + x * np.eye(3)[c]), 0.0, 1e-3) for c in range(3)])
    both(y)
    np.testing.assert_allclose(np.vstack([jacobian, gradient]), expected, rtol=0, atol=1e-9)


def test_every_point_lies_on_the_closed_curve(curve):
    omega = curve.points[:, 2]
    assert np.max(np.abs(duffing.defect(size(curve.points), omega))) < 1e-12
    assert omega[0] == LOW and omega[-1] == HIGH
    assert curve.ends == (EndReason.RANGE_LEFT, EndReason.RANGE_LEFT)
    squares = np.array(duffing.squared_frequencies(size(curve.points)))
    resolved = size(curve.points) < 2.8
    np.testing.assert_allclose(np.min(np.abs(squares - omega**2), axis=0)[resolved], 0.0, rtol=0, atol=1e-9)


def test_folds_are_the_published_and_the_exact_ones(curve):
    found = curve.points[curve.event == Event.FOLD]
    pairs = sorted(zip(found[:, 2], size(found), strict=True))
    np.testing.assert_allclose(pairs, [(1.11559, 1.08408), (1.26754, 2.83622)], rtol=0, atol=5e-6)
    exact = np.array(duffing.folds())
    np.testing.assert_allclose([p[0] for p in pairs], exact[:, 0], rtol=0, atol=1e-9)
    np.testing.assert_allclose([p[1] for p in pairs], exact[:, 1], rtol=0, atol=1e-7)


def test_grazings_are_exact(curve):
    found = np.sort(curve.points[curve.event == 2][:, 2])
    exact = np.sqrt(duffing.squared_frequencies(duffing.LEVEL))
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-9)
    np.testing.assert_allclose(size(curve.points[curve.event == 2]), duffing.LEVEL, rtol=0, atol=1e-9)


def test_stability_is_that_of_the_slope_of_the_closed_curve(curve):
    """Between the folds and nowhere else; both folds turn Omega round and the tangent never does."""
    folds = np.flatnonzero(curve.event == Event.FOLD)
    expected = np.ones(len(curve.points))
    expected[folds[0] : folds[1] + 1] = 0
    np.testing.assert_array_equal(curve.stable, expected)
    step = np.diff(curve.points[:, 2])
    np.testing.assert_array_equal(step > 0.0, [not folds[0] <= i < folds[1] for i in range(len(step))])
    assert np.all(np.sum(curve.tangents[1:] * curve.tangents[:-1], axis=1) > np.cos(Continuation().largest_angle))
    np.testing.assert_allclose(np.linalg.norm(curve.tangents, axis=1), 1.0, rtol=0, atol=1e-12)
    np.testing.assert_allclose(curve.tangents[folds, 2], 0.0, rtol=0, atol=1e-9)


def test_arc_length_is_that_of_the_closed_curve(curve):
    """Against the length of a polygon through many points of the closed formula."""
    problem = duffing.duffing(LOW, HIGH)
    assert np.all(np.diff(curve.arclength) > 0.0)
    fine = dataclasses.replace(Continuation(), largest_step=1e-3, first_step=1e-3, max_points=100_000)
    dense = fine.trace(problem, duffing.start(LOW), LOW, HIGH).points / problem.scale
    length = np.sum(np.linalg.norm(np.diff(dense, axis=0), axis=1))
    assert curve.arclength[-1] == pytest.approx(length, rel=1e-3)


@pytest.mark.parametrize("heading", [1, -1])
def test_from_either_end_the_curve_is_the_same(heading):
    continuation, problem = Continuation(), duffing.duffing(LOW, HIGH)
    curve = continuation.trace(problem, duffing.start(LOW if heading == 1 else HIGH), LOW, HIGH, heading)
    folds = curve.points[curve.event == Event.FOLD]
    np.testing.assert_allclose(np.sort(folds[:, 2]), [f[0] for f in duffing.folds()], rtol=0, atol=1e-9)
    assert curve.points[-1, 2] == (HIGH if heading == 1 else LOW)


def test_both_ways_from_the_middle_is_one_curve_in_order():
    continuation, problem = Continuation(), duffing.duffing(LOW, HIGH)
    curve = continuation.trace_both_ways(problem, duffing.start(1.15), LOW, HIGH)
    assert curve.points[0, 2] == LOW and curve.points[-1, 2] == HIGH
    assert curve.ends == (EndReason.RANGE_LEFT, EndReason.RANGE_LEFT) and curve.arclength[0] == 0.0
    assert np.all(np.diff(curve.arclength) > 0.0) and not curve.closed
    assert np.all(np.sum(curve.tangents[1:] * curve.tangents[:-1], axis=1) > 0.9)
    chords = np.diff(curve.points / problem.scale, axis=0)
    assert np.all(np.sum(chords * curve.tangents[1:], axis=1) > 0.0)
    assert sorted(curve.event[curve.event > 0]) == [Event.FOLD, Event.FOLD, 2, 2]
    assert np.max(np.abs(duffing.defect(size(curve.points), curve.points[:, 2]))) < 1e-12


def test_crossings_are_all_roots_of_the_cubic(curve):
    grid = np.linspace(LOW, HIGH, 391)
    columns, unknowns, stable, *_ = curve_crossings(duffing.duffing(LOW, HIGH), curve, grid, Continuation())
    for i, omega in enumerate(grid):
        expected = duffing.amplitudes(omega)
        order = np.argsort(np.hypot(*unknowns[columns == i].T))
        found = np.hypot(*unknowns[columns == i].T)[order]
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10)
        assert list(stable[columns == i][order]) == [1, 0, 1][: len(expected)]


@pytest.mark.parametrize("largest_step", [0.01, 0.05, 0.5])
@pytest.mark.parametrize("parameter_step", [0.002, 0.02, 1.0])
def test_events_do_not_depend_on_the_steps(largest_step, parameter_step):
    continuation = Continuation(largest_step=largest_step, parameter_step=parameter_step)
    curve = continuation.trace(duffing.duffing(LOW, HIGH), duffing.start(LOW), LOW, HIGH)
    events = [(int(e), round(float(p), 9)) for e, p in zip(curve.event, curve.points[:, 2], strict=True) if e]
    (low, _), (high, _) = duffing.folds()
    left, right = np.sqrt(duffing.squared_frequencies(duffing.LEVEL))
    assert events == [(2, round(float(left), 9)), (1, round(high, 9)), (2, round(float(right), 9)), (1, round(low, 9))]
