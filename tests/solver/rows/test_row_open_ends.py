"""Rows whose branches leave through the amplitude ceiling: what is marked as open, and what the degree says there."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from solver import Continuation, EndReason, LinearSeeds, ProvenSeeds, sweep_row, uncondensed_balance
from solver.harmonic.describing_function import evaluate
from tests.conftest import consistent, published
from tests.solver.curves import COS_20
from tests.solver.exhaustive import all_solutions
from tests.solver.reference_rows import grid, solutions
from tests.solver.strategies import numbers, random_model


@settings(max_examples=25)
@example(206020430, 0.99964, 1.99922)  # its exponent bends on its way across the axis
@given(st.integers(0, 10**9), numbers(0.1, 1.0), numbers(0.05, 2.0))
def test_signs_of_the_determinant_add_up_to_the_linear_one(seed, f_pm, b):
    """The linear sign is taken from the 21 unknowns, whose determinant has the sign of the condensed one."""
    model = random_model(seed, f_pm=f_pm, b=b)
    row = sweep_row(model, "omega", grid(14))
    for i, omega in enumerate(row.grid):
        signs = sum(int(np.sign(np.linalg.det(evaluate(model, omega, u)[1]))) for u in solutions(row, i))
        linear = np.sign(np.linalg.slogdet(uncondensed_balance(model.replace(b=0.0), omega, np.zeros(21))[1])[0])
        if not row.open[i]:
            assert signs == linear
            assert 2 * row.n_stable[i] - row.n_solutions[i] == linear


@pytest.mark.parametrize("alpha", [0.4595, 0.47, 0.5])
def test_an_unbounded_branch_is_open_and_says_why(alpha):
    model = consistent(rotation_coupling=COS_20, variation_translation=0.0, alpha=alpha)
    row = sweep_row(model, "omega", grid(391))
    ends = {end for curve in row.curves for end in curve.ends}
    assert ends == {EndReason.RANGE_LEFT, EndReason.AMPLITUDE_CEILING}
    assert "amplitude ceiling" in EndReason.AMPLITUDE_CEILING.sentence
    flagged = np.flatnonzero(row.open)
    exits = [c.points[k, 3] for c in row.curves for k in (0, -1) if c.ends[k] is EndReason.AMPLITUDE_CEILING]
    beside = np.unique([np.searchsorted(row.grid, place) + side for place in exits for side in (-1, 0)])
    assert len(exits) and set(beside) <= set(flagged) <= set(range(beside[0], beside[-1] + 1))
    assert np.all(np.abs(row.grid[flagged] - 0.5918) < 0.03)
    assert np.nanmax(row.amplitude) <= 100.0


@pytest.mark.parametrize("columns", [4, 7, 14])
def test_a_coarse_raster_says_too_that_a_branch_left(columns):
    """No column need lie where the solutions are: those beside are marked."""
    model = consistent(rotation_coupling=COS_20, variation_translation=0.0, alpha=0.4595)
    row = sweep_row(model, "omega", grid(columns))
    right = int(np.searchsorted(row.grid, 0.5918))
    assert row.open[right - 1] and row.open[right] and np.sum(row.open) <= 3


@pytest.mark.parametrize("seeds", [ProvenSeeds(), LinearSeeds()], ids=["proven", "linear"])
@pytest.mark.parametrize("seed, f_pm, b", [(1791, -1.103, 0.025), (14, -0.403, 0.722), (87, 0.465, 1.567)])
def test_a_branch_that_touches_neither_end_of_the_range_is_found(seed, f_pm, b, seeds):
    """Between two unbounded branches lies a third that comes down from above the ceiling and leaves through it again.

    Proven seeds know it is there; to linear ones only the degree says that something is missing.
    """
    model = random_model(seed, f_pm=f_pm, b=b)
    row = sweep_row(model, "omega", grid(79), seeds=seeds)
    left, up = EndReason.RANGE_LEFT, EndReason.AMPLITUDE_CEILING
    assert [curve.ends for curve in row.curves] == [(left, up), (left, up), (up, up)]
    for i, omega in enumerate(row.grid):
        expected = [u for u in all_solutions(model, omega, 400) if np.hypot(u[1], u[2]) < 100.0]
        np.testing.assert_allclose(solutions(row, i), expected, rtol=0, atol=1e-7)


def test_below_the_threshold_the_branch_is_bounded_and_nothing_is_open():
    model = consistent(rotation_coupling=COS_20, variation_translation=0.0, alpha=0.45)
    row = sweep_row(model, "omega", grid(391))
    assert not np.any(row.open)
    assert 36.0 < max(np.max(curve.amplitude) for curve in row.curves) <= 37.0


def test_a_low_ceiling_opens_the_columns_between_the_places_where_branches_left():
    full = sweep_row(published(), "omega", grid(391))
    cut = sweep_row(published(), "omega", grid(391), continuation=Continuation(amplitude_max=1.5))
    exits = [
        curve.points[place, 3]
        for curve in cut.curves
        for end, place in zip(curve.ends, (0, -1), strict=True)
        if end is EndReason.AMPLITUDE_CEILING
    ]
    assert len(exits) == 2
    # Proven: exactly the columns where solutions lie above, and those beside the places where a branch left.
    above = np.any(full.amplitude > 1.5, axis=1)
    above[[np.searchsorted(cut.grid, place) + side for place in exits for side in (-1, 0)]] = True
    np.testing.assert_array_equal(cut.open, above)
    # Without proof: all between them.
    between = (cut.grid > min(exits)) & (cut.grid < max(exits))
    traced = sweep_row(
        published(), "omega", grid(391), continuation=Continuation(amplitude_max=1.5), seeds=LinearSeeds()
    )
    np.testing.assert_array_equal(traced.open[between], 1)
    assert 0 < np.sum(traced.open) <= np.sum(between) + 2
    assert np.nanmax(cut.amplitude) < 1.5 < np.nanmax(full.amplitude)
    for i in range(391):
        kept = solutions(full, i)[full.amplitude[i][: full.n_solutions[i]] < 1.5]
        np.testing.assert_allclose(solutions(cut, i), kept, rtol=0, atol=1e-10)
