"""Rows over other axes than the frequency: their solutions, their first column, their impact states."""

import numpy as np
import pytest

from solver import impact_state, sweep_row
from solver.model.packing import AXES
from tests.conftest import MODELS, published, slow_but
from tests.solver.curves import HIGH, LOW
from tests.solver.exhaustive import all_solutions
from tests.solver.reference_rows import assert_same_columns, grid, solutions

RANGES = {
    "b": (0.0, 1.5),
    "alpha": (0.0, 0.6),
    "alpha_phase": (-3.0, 3.0),
    "f_e": (0.0, 0.5),
    "f_e_phase": (-3.0, 3.0),
    "f_pm": (0.3, 1.2),
    "f_pv": (-0.3, 0.3),
    "kappa": (0.2, 1.0),
    "xi_mesh": (0.01, 0.2),
    "xi_translation": (0.0, 0.1),
    "xi_support": (0.01, 0.1),
    "k_support": (0.5, 2.0),
    "pitch_cone_angle": (10.0, 80.0),
    "pressure_angle": (14.5, 28.0),
    "translation_coupling": (0.1, 1.0),
    "rotation_coupling": (0.5, 1.2),
    "variation_translation": (0.0, 1.5),
    "variation_rotation": (0.0, 1.0),
}


@pytest.mark.costly
@pytest.mark.parametrize(
    ("name", "omega"),
    slow_but([("published", 0.6), ("antiphase", 1.3)], [(name, omega) for name in MODELS for omega in (0.6, 1.3)]),
)
def test_a_row_over_another_axis_has_the_solutions_of_the_frequency_sweeps(name, omega):
    model = MODELS[name]()
    wrong = []
    for axis, ends in RANGES.items():
        row = sweep_row(model, axis, np.linspace(*ends, 9), omega=omega)
        for i, value in enumerate(row.grid):
            other = sweep_row(model.replace(**{axis: value}), "omega", [LOW, omega, HIGH])
            if row.n_solutions[i] != other.n_solutions[1]:
                wrong.append((axis, round(float(value), 4), int(row.n_solutions[i]), int(other.n_solutions[1])))
            else:
                assert_same_columns(row, [i], other, [1], atol=1e-9, same_axis=False)
    assert wrong == []


@pytest.mark.parametrize("axis, omega", [("f_e", 0.6), ("b", 1.3), ("f_pm", 1.3), ("f_e", 0.8), ("alpha", 1.2265)])
def test_a_row_over_another_axis_starts_at_its_first_column(axis, omega):
    """Axes that begin at 0, where a rounding error is as good as a miss."""
    columns = np.linspace(0.5 if axis == "f_pm" else 0.0, RANGES[axis][1], 9)
    row = sweep_row(published(), axis, columns, omega=omega)
    assert row.n_solutions[0] == 1 and not np.any(row.open)
    assert len(row.curves) == 1 and row.curves[0].points[0, 3] == columns[0]
    for i, value in enumerate(columns):
        assert len(solutions(row, i)) == len(all_solutions(published(**{axis: value}), omega))


def test_every_axis_is_covered():
    assert {"omega", *RANGES} == set(AXES)


def test_the_gap_as_axis_gives_states_of_its_own_values():
    row = sweep_row(published(), "b", np.linspace(0.0, 1.5, 31), omega=0.6)
    for curve in row.curves:
        extremes = curve.points[:, 0] - curve.amplitude, curve.points[:, 0] + curve.amplitude
        np.testing.assert_array_equal(row.branch_impact(curve), impact_state(*extremes, curve.points[:, 3]))
    for i, b in enumerate(row.grid):
        for s in range(row.n_solutions[i]):
            mean, amplitude = row.mean[i, s], row.amplitude[i, s]
            assert row.impact[i, s] == impact_state(mean - amplitude, mean + amplitude, b)


def test_states_along_a_branch_over_frequency():
    row = sweep_row(published(), "omega", grid(5))
    (curve,) = row.curves
    extremes = curve.points[:, 0] - curve.amplitude, curve.points[:, 0] + curve.amplitude
    np.testing.assert_array_equal(row.branch_impact(curve), impact_state(*extremes, 1.0))
    assert set(row.branch_impact(curve)) == {0, 1, 2}
