"""Where curves meet given values: every one once, each a solution, on closed curves and next to folds too."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solver import Continuation, EndReason, Event, first_order_problem, sweep_row
from solver.continuation.on_curve import curve_crossings
from solver.harmonic.describing_function import evaluate
from tests.conftest import antiphase, consistent, published
from tests.solver.exhaustive import all_solutions
from tests.solver.strategies import numbers
from tests.solver.toy import s_curve

LOW, HIGH = 0.05, 2.0


def met(problem, curve, grid):
    """Unknowns and stability at every grid value, in order of the first unknown."""
    columns, unknowns, stable, *_ = curve_crossings(problem, curve, np.asarray(grid), Continuation())
    for k in range(len(grid)):
        order = np.argsort(unknowns[columns == k][:, 0])
        yield unknowns[columns == k][order], stable[columns == k][order]


def test_a_closed_curve_is_met_once_at_its_start_too():
    model = consistent(rotation_coupling=0.93969262, alpha=0.44)
    problem = first_order_problem(model, "omega", LOW, HIGH)
    main, *others = all_solutions(model, 0.55)
    curve = Continuation().trace_both_ways(problem, np.append(others[1], 0.55), LOW, HIGH)
    assert curve.closed
    grid = np.union1d(np.linspace(0.505, 0.585, 81), [0.55])
    for omega, (found, stable) in zip(grid, met(problem, curve, grid), strict=True):
        expected = all_solutions(model, omega)[1:]
        assert len(found) == len(expected) and 2 * np.sum(stable) == len(found)
        np.testing.assert_allclose(found, expected[np.argsort(expected[:, 0])], rtol=0, atol=1e-9)


@pytest.mark.parametrize("distance", [1e-3, 1e-5, 1e-7, 1e-9])
@pytest.mark.parametrize("make", [published, antiphase])
def test_both_sides_of_a_fold_are_met_however_close(make, distance):
    model = make()
    (curve,) = sweep_row(model, "omega", [LOW, HIGH]).curves
    problem = first_order_problem(model, "omega", LOW, HIGH)
    for i in np.flatnonzero(curve.event == Event.FOLD):
        place = curve.points[i, 3]
        inside = -1.0 if curve.points[i - 1, 3] < place else 1.0
        if make is antiphase and abs(place - 1.2934) < 3e-4 and distance > 1e-4:
            continue  # the two folds of the pair are closer to each other than that
        grid = np.sort([place - distance, place + distance])
        counts = {}
        for omega, (found, stable) in zip(grid, met(problem, curve, grid), strict=True):
            counts[omega > place] = len(found)
            assert np.sum(stable) - np.sum(stable == 0) == 1
            for unknowns in found:
                assert np.max(np.abs(evaluate(model, omega, unknowns)[0])) < 1e-11
        assert counts[inside > 0] - counts[inside < 0] == 2


@settings(max_examples=40)
@given(numbers(0.001, 1.0), st.lists(numbers(-1.9, 1.9), min_size=1, max_size=8, unique=True))
def test_an_s_curve_is_met_where_its_cubic_has_roots(gap, grid):
    problem = s_curve(gap)
    start = float(np.roots([1.0, 0.0, -gap, 2.0])[np.argmin(np.abs(np.roots([1.0, 0.0, -gap, 2.0]).imag))].real)
    curve = Continuation(largest_step=0.5, parameter_step=0.2).trace(problem, np.array([start, -2.0]), -2.0, 2.0)
    assert curve.ends[1] is EndReason.RANGE_LEFT
    fold = 2.0 * (gap / 3.0) ** 1.5
    for p, (found, stable) in zip(np.sort(grid), met(problem, curve, np.sort(grid)), strict=True):
        roots = np.roots([1.0, 0.0, -gap, -p])
        if abs(abs(p) - fold) > 1e-9:
            expected = np.sort(roots[np.abs(roots.imag) < 1e-7].real) if abs(p) < fold else None
            if expected is None:
                expected = [roots[np.argmin(np.abs(roots.imag))].real]
            np.testing.assert_allclose(found[:, 0], expected, rtol=0, atol=1e-6)
            assert list(stable) == ([1, 0, 1] if abs(p) < fold else [1])
        np.testing.assert_allclose(found[:, 0] ** 3 - gap * found[:, 0] - p, 0.0, rtol=0, atol=1e-12)


def test_values_outside_of_the_curve_are_not_met():
    problem = first_order_problem(published(), "omega", LOW, 1.0)
    (curve,) = sweep_row(published(), "omega", [LOW, 1.0]).curves
    grid = np.array([0.01, 0.0499999, 0.05, 0.3, 1.0, 1.0000001, 1.5])
    columns, *_ = curve_crossings(problem, curve, grid, Continuation())
    assert list(columns) == [2, 3, 4]
    columns, unknowns, stable, *_ = curve_crossings(problem, curve, np.array([]), Continuation())
    assert len(columns) == len(unknowns) == len(stable) == 0


def test_room_grows_with_the_number_of_crossings():
    """Five solutions at every value, where the first guess has room for four and sixteen more in all."""
    (curve,) = sweep_row(antiphase(), "omega", [LOW, HIGH]).curves
    grid = np.linspace(1.2932, 1.29358, 200)
    columns, *_ = curve_crossings(first_order_problem(antiphase(), "omega", LOW, HIGH), curve, grid, Continuation())
    np.testing.assert_array_equal(np.bincount(columns), 5)


def test_values_are_met_in_the_order_in_which_the_curve_passes_them():
    """Up and down: between two points the curve may pass many values."""
    model = published()
    grid = np.linspace(0.3, 1.9, 800)
    for curve in sweep_row(model, "omega", np.linspace(0.3, 1.9, 20)).curves:
        problem = first_order_problem(model, "omega", 0.3, 1.9)
        columns, *_ = curve_crossings(problem, curve, grid, Continuation())
        # At a fold the last value met is the first one again.
        senses = np.sign(np.diff(columns)[np.diff(columns) != 0])
        assert np.sum(senses[1:] != senses[:-1]) == np.sum(curve.event == Event.FOLD)
