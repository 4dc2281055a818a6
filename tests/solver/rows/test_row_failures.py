"""Rows that are refused or cannot be finished, and what is said of them."""

import dataclasses

import numpy as np
import pytest

from solver import Continuation, EndReason, ParameterError, RowError, sweep_row
from tests.conftest import antiphase, published
from tests.solver.reference_rows import grid


@pytest.mark.parametrize("bad", [[], [0.5], [0.5, 0.5], [0.6, 0.5], [0.5, np.nan], [0.5, np.inf], [[0.5, 0.6]]])
def test_a_grid_that_is_not_ascending_is_refused(bad):
    with pytest.raises(ParameterError, match="grid = .* must be at least two finite ascending values"):
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


def test_a_row_that_lacks_room_says_so_and_where():
    with pytest.raises(RowError) as caught:
        sweep_row(published(), "omega", grid(81), continuation=Continuation(max_points=120))
    assert EndReason.ITERATION_LIMIT.sentence in str(caught.value)
    assert "It happened at omega = " in str(caught.value) and "with mean " in str(caught.value)


def test_a_row_whose_steps_become_too_small_says_so():
    stiff = dataclasses.replace(Continuation(), smallest_step=0.02, first_step=0.05)
    with pytest.raises(RowError, match="refused every step down to the smallest one") as caught:
        sweep_row(antiphase(), "omega", grid(81), continuation=stiff)
    assert isinstance(caught.value, ArithmeticError)
