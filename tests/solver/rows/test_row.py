"""Rows: the raster of one line of a plane, where its solutions appear and end, and that none is missing."""

import numpy as np
import pytest

from solver import ImpactState, domain_label, impact_state, sweep_row
from solver.harmonic.describing_function import evaluate
from tests.conftest import MODELS, antiphase, published, slow_but
from tests.solver.curves import HIGH, LOW
from tests.solver.exhaustive import all_solutions
from tests.solver.reference_rows import VARIANTS, assert_same_columns, fold_places, grid, solutions

# Raster --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("changes", VARIANTS)
def test_the_number_of_columns_does_not_matter(gear, changes):
    _, model = gear
    model = model.replace(**changes)
    coarse, middle, fine = (sweep_row(model, "omega", grid(columns)) for columns in (81, 161, 321))
    np.testing.assert_allclose(fine.grid[::4], coarse.grid, rtol=0, atol=1e-15)
    assert_same_columns(coarse, slice(None), middle, slice(None, None, 2))
    assert_same_columns(coarse, slice(None), fine, slice(None, None, 4))


@pytest.mark.parametrize("changes", VARIANTS)
def test_the_number_of_solutions_changes_across_folds_only(gear, changes):
    _, model = gear
    row = sweep_row(model.replace(**changes), "omega", grid(321))
    assert not np.any(row.open)
    expected = np.full(321, row.n_solutions[0])
    for place, change in fold_places(row):
        expected[row.grid > place] += change
    np.testing.assert_array_equal(row.n_solutions, expected)
    np.testing.assert_array_equal(row.n_stable, (row.n_solutions + 1) // 2)


@pytest.mark.parametrize("changes", VARIANTS)
def test_every_solution_is_one_and_is_described_truly(gear, changes):
    _, model = gear
    model = model.replace(**changes)
    row = sweep_row(model, "omega", grid(157))
    for i, omega in enumerate(row.grid):
        found = solutions(row, i)
        assert len(found) == row.n_solutions[i] == np.sum(np.isfinite(row.mean[i]))
        amplitudes = np.hypot(found[:, 1], found[:, 2])
        assert np.all(np.diff(amplitudes) > 0.0)
        for s, (solution, amplitude) in enumerate(zip(found, amplitudes, strict=True)):
            residual, jacobian = evaluate(model, omega, solution)
            assert np.max(np.abs(residual)) < 1e-12 * max(1.0, np.max(np.abs(solution)))
            assert row.stable[i, s] == (np.linalg.det(jacobian) > 0.0)
            assert row.impact[i, s] == impact_state(solution[0] - amplitude, solution[0] + amplitude, model.b)
            assert row.amplitude[i, s] == amplitude
            motion = row.amplitude[i, s] * np.exp(1j * row.phase[i, s])
            assert motion == pytest.approx(complex(solution[1], -solution[2]), abs=1e-14)
        states = sorted({int(row.impact[i, s]) for s in range(len(found)) if row.stable[i, s] == 1})
        label = f"{np.sum(row.stable[i] == 1)}/{'-'.join(ImpactState(k).symbol for k in states)}"
        assert domain_label(row.domain[i]) == label
        assert np.all(row.stable[i, len(found) :] == -1) and np.all(row.impact[i, len(found) :] == -1)


@pytest.mark.parametrize("name", MODELS)
def test_a_column_exactly_on_an_event_is_computed(name):
    model = MODELS[name]()
    curve = sweep_row(model, "omega", grid(3)).curves[0]
    events = np.unique(curve.points[(curve.event > 0), 3])
    near = np.unique(np.concatenate([[LOW, HIGH], events, events - 1e-7, events + 1e-7]))
    row = sweep_row(model, "omega", near)
    for i, omega in enumerate(near):
        for solution in solutions(row, i):
            assert np.max(np.abs(evaluate(model, omega, solution)[0])) < 1e-11
        if omega not in events:
            assert row.n_solutions[i] % 2 == 1 and not row.open[i]


def test_columns_that_are_points_of_the_curve_are_met_once():
    """A column may coincide with a computed point, an end of the curve included."""
    curve = sweep_row(published(), "omega", grid(3)).curves[0]
    places = np.unique(curve.points[curve.event == 0, 3])
    row = sweep_row(published(), "omega", places)
    expected = np.full(len(places), 1)
    for place, change in fold_places(row):
        expected[places > place] += change
    np.testing.assert_array_equal(row.n_solutions, expected)


@pytest.mark.parametrize("name, omega", [("published", 0.6), ("published", 1.2265), ("antiphase", 1.2934)])
def test_solutions_do_not_depend_on_the_other_columns(name, omega):
    full = sweep_row(MODELS[name](), "omega", np.union1d(grid(81), omega))
    alone = sweep_row(MODELS[name](), "omega", [LOW, omega, HIGH])
    assert_same_columns(full, [int(np.searchsorted(full.grid, omega))], alone, [1], atol=1e-11)
    assert alone.n_solutions[1] >= 3


def test_equal_rows_are_bitwise_equal():
    first, again = (sweep_row(antiphase(), "omega", grid(157)) for _ in range(2))
    for field in ("mean", "cos", "sin", "stable", "impact", "open"):
        np.testing.assert_array_equal(getattr(first, field), getattr(again, field))
    for curve, other in zip(first.curves, again.curves, strict=True):
        np.testing.assert_array_equal(curve.points, other.points)


# Completeness --------------------------------------------------------------------------------------------------------

PLANES = {"b": (0.02, 1.5), "alpha": (0.0, 0.8), "f_e": (0.0, 0.5), "f_pm": (0.3, 1.2)}


@pytest.mark.parametrize(
    ("name", "parameter"),
    slow_but(
        [("published", "b"), ("consistent", "alpha"), ("antiphase", "f_e"), ("published", "f_pm")],
        [(name, parameter) for name in MODELS for parameter in PLANES],
    ),
)
def test_no_solution_is_missing_anywhere_in_the_reference_planes(name, parameter):
    """Against Newton's method from very many starts, which knows nothing of branches."""
    model = MODELS[name]()
    columns, missing = np.linspace(LOW, HIGH, 53), []
    for value in np.linspace(*PLANES[parameter], 17):
        changed = model.replace(**{parameter: value})
        row = sweep_row(changed, "omega", columns)
        for i, omega in enumerate(columns):
            known = solutions(row, i)
            for found in all_solutions(changed, omega, 100):
                if not row.open[i] and np.min(np.max(np.abs(known - found), axis=1), initial=np.inf) > 1e-6:
                    missing.append((round(float(value), 4), round(float(omega), 4), float(np.hypot(*found[1:]))))
    assert missing == []


@pytest.mark.parametrize("low, high", [(0.57, 0.62), (0.05, 0.6), (0.6, 2.0), (1.225, 1.229), (0.62, 1.225)])
def test_the_range_of_the_sweep_does_not_matter(low, high):
    """A user who looks at a resonance closely sees the same solutions as one who sweeps everything."""
    columns = np.linspace(low, high, 11)
    close = sweep_row(published(), "omega", columns)
    whole = sweep_row(published(), "omega", np.union1d(columns, [LOW, HIGH]))
    places = np.searchsorted(whole.grid, columns)
    assert_same_columns(close, slice(None), whole, places, atol=1e-9)
