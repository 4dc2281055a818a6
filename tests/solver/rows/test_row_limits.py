"""Rows where the motion is known: without a gap, without contact loss, without load, without excitation."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solver import ImpactState, domain_label, sweep_row
from solver.harmonic.describing_function import evaluate
from tests.conftest import MODELS
from tests.solver.independent import linear_response
from tests.solver.reference_rows import assert_linear, grid, solutions
from tests.solver.strategies import numbers, random_model


def test_without_gap_the_solution_is_linear(gear):
    _, model = gear
    row = sweep_row(model.replace(b=0.0), "omega", grid(79))
    assert_linear(row, model, 0.0)
    assert np.all(row.stable == 1) and not np.any(row.open)


@settings(max_examples=25)
@given(st.integers(0, 10**9), numbers(0.1, 1.0))
def test_without_gap_every_gear_is_linear(seed, f_pm):
    model = random_model(seed, b=0.0, f_pm=f_pm)
    row = sweep_row(model, "omega", grid(9))
    for i, omega in enumerate(row.grid):
        if row.n_solutions[i]:
            assert row.n_solutions[i] == 1
            expected, determinant = linear_response(model, omega)
            size = max(1.0, np.max(np.abs(expected)))
            np.testing.assert_allclose(solutions(row, i)[0], expected, rtol=0, atol=1e-9 * size)
            assert row.stable[i, 0] == (determinant > 0.0)
        else:
            assert row.open[i]


@pytest.mark.parametrize("f_pm", [10.0, -10.0])
def test_without_contact_loss_the_solution_is_linear_and_shifted_by_the_gap(gear, f_pm):
    """A large load alone is not enough: varying stiffness makes vibration of load, in proportion to it."""
    _, model = gear
    model = model.replace(f_pm=f_pm, alpha=0.02)
    row = sweep_row(model, "omega", grid(79))
    assert_linear(row, model, np.sign(f_pm) * model.b)
    state = ImpactState.PERMANENT if f_pm > 0 else ImpactState.MIRRORED_PERMANENT
    assert np.all(row.impact == state) and {domain_label(code) for code in row.domain} == {f"1/{state.symbol}"}


def test_permanent_contact_at_default_load_is_linear_too(gear):
    _, model = gear
    row = sweep_row(model, "omega", grid(79))
    counted = 0
    for i, omega in enumerate(row.grid):
        for s in np.flatnonzero(row.impact[i] == ImpactState.PERMANENT):
            expected, _ = linear_response(model, omega)
            np.testing.assert_allclose(solutions(row, i)[s], expected + [model.b, 0, 0], rtol=0, atol=1e-10)
            counted += 1
    assert counted > 40


# Without load --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name, b", [(name, b) for name in MODELS for b in (0.02, 0.05)] + [("published", 0.1)])
def test_without_load_motions_that_reach_both_flanks_are_found(name, b):
    """The free pair would move by f_e = 0.2, more than the gap."""
    model = MODELS[name](f_pm=0.0, b=b)
    row = sweep_row(model, "omega", grid(79))
    np.testing.assert_array_equal(row.n_solutions, 1)
    assert {domain_label(code) for code in row.domain} == {"1/2"} and not np.any(row.open)
    for i, omega in enumerate(row.grid):
        assert np.max(np.abs(evaluate(model, omega, solutions(row, i)[0])[0])) < 1e-12


def test_without_load_and_gap_the_pair_is_linear(gear):
    _, model = gear
    assert_linear(sweep_row(model.replace(f_pm=0.0, b=0.0), "omega", grid(79)), model.replace(f_pm=0.0), 0.0)


def test_without_excitation_the_pair_rests_on_the_drive_flank(gear):
    _, model = gear
    row = sweep_row(model.replace(f_e=0.0, alpha=0.0), "omega", grid(79))
    np.testing.assert_array_equal(row.n_solutions, 1)
    np.testing.assert_allclose(row.mean[:, 0], 1.0 + 0.5 / model.rotation, rtol=0, atol=1e-12)
    np.testing.assert_allclose(row.amplitude[:, 0], 0.0, rtol=0, atol=1e-12)
