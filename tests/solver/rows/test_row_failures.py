"""Rows that are refused or cannot be finished, and what is said of them."""

import numpy as np
import pytest

from solver import Continuation, EndReason, LinearSeeds, ParameterError, sweep_row
from tests.conftest import antiphase, published
from tests.solver.reference_rows import assert_same_columns, grid


@pytest.mark.parametrize("bad", [[], [0.5], [0.5, 0.5], [0.6, 0.5], [0.5, np.nan], [0.5, np.inf], [[0.5, 0.6]]])
def test_a_grid_that_is_not_ascending_is_refused(bad):
    with pytest.raises(ParameterError, match="grid"):
        sweep_row(published(), "omega", bad)


@pytest.mark.parametrize("low", [0.0, -0.1])
def test_frequencies_must_be_positive(low):
    with pytest.raises(ParameterError, match="omega = .* must be a finite number above 0"):
        sweep_row(published(), "omega", [low, 1.0])


@pytest.mark.parametrize("omega", [None, 0.0, -1.0, np.nan, np.inf])
def test_another_axis_needs_a_frequency(omega):
    with pytest.raises(ParameterError, match="omega = .* must be a finite number above 0"):
        sweep_row(published(), "b", [0.1, 1.0], omega=omega)


def test_an_unknown_axis_is_refused():
    with pytest.raises(ParameterError, match="axis = 'backlash' is not allowed: it must be one of omega, b"):
        sweep_row(published(), "backlash", [0.1, 1.0], omega=0.5)


@pytest.mark.parametrize("axis, low", [("b", -0.5), ("kappa", 0.0), ("k_support", -1.0), ("rotation_coupling", 0.0)])
def test_axis_values_that_the_model_refuses_are_refused(axis, low):
    with pytest.raises(ParameterError, match=axis):
        sweep_row(published(), axis, [low, 0.5, 1.0], omega=0.6)


BROKEN = [
    (published(), Continuation(max_points=60), EndReason.ITERATION_LIMIT),
    (antiphase(), Continuation(smallest_step=0.02, first_step=0.05), EndReason.STEP_TOO_SMALL),
]


@pytest.mark.parametrize(("model", "continuation", "reason"), BROKEN)
def test_a_row_keeps_branches_that_break_off_and_loses_no_solution(model, continuation, reason):
    row, whole = sweep_row(model, "omega", grid(81), continuation=continuation), sweep_row(model, "omega", grid(81))
    assert any(reason in curve.ends for curve in row.curves)
    assert any(reason.sentence in note and "omega = " in note for note in row.notes) and not whole.notes
    assert_same_columns(row, slice(None), whole, slice(None))
    np.testing.assert_array_equal(row.certified, 1)


@pytest.mark.parametrize(("model", "continuation", "reason"), BROKEN)
def test_without_proof_columns_beside_a_place_where_a_branch_breaks_off_are_open(model, continuation, reason):
    row = sweep_row(model, "omega", grid(81), continuation=continuation, seeds=LinearSeeds())
    places = [c.points[k, 3] for c in row.curves for k in (0, -1) if c.ends[k] is reason]
    assert places and all(row.open[np.searchsorted(row.grid, place) + side] for place in places for side in (-1, 0))
    assert np.any(row.open == 0) and np.all(row.certified == -1)
