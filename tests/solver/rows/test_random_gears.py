"""Rows of random gears, and of gears that once broke a row: none fails, hangs or loses a solution."""

import time

import numpy as np
import pytest

from solver import Continuation, Model, sweep_row
from tests.conftest import consistent, published
from tests.solver.reference_rows import grid
from tests.solver.rows.random_gears import COLUMNS, assert_row_is_right, random_row

#: Random gears of the study, and how many of them the ordinary suite looks at.
STUDY, ORDINARY, BATCH = 2000, 40, 100


#: Points and refused steps of a row at most: ten times what the study needs.
STEPS = 20_000


def check(seed: int) -> tuple[int, float]:
    """Compute and check one row; the number of its cells that are proven, and the CPU seconds that it took."""
    model, axis, values, omega = random_row(seed)
    begin = time.process_time()
    row = sweep_row(model, axis, values, omega=omega)
    seconds = time.process_time() - begin
    assert_row_is_right(model, row, omega)
    assert sum(len(curve.points) + curve.refused for curve in row.curves) < STEPS
    return int(np.sum(row.certified == 1)), seconds


@pytest.mark.parametrize("seed", range(ORDINARY))
def test_random_gears(seed):
    check(seed)


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, STUDY, BATCH))
def test_study_of_random_gears(first):
    rows = [check(seed) for seed in range(first, first + BATCH)]
    # What is excluded are loops without end, which take the processor whatever else runs on the machine.
    assert max(seconds for _, seconds in rows) < 5.0
    # What stays undecided are gears without excitation, and folds at a column.
    assert sum(proven for proven, _ in rows) > 0.97 * BATCH * COLUMNS


# Of two gears with different damping at every support.
DAMPINGS = [0.004, 0.005, 0.034, 0.035, 0.012, 0.02], [0.01, 0.012, 0.015, 0.02, 0.022, 0.03]


@pytest.mark.parametrize("make", [published, consistent])
@pytest.mark.parametrize("damping", DAMPINGS)
def test_damping_that_differs_by_support(make, damping):
    for f_e in (0.0, 0.2, 0.5):
        model = make(xi_support=damping, f_e=f_e)
        row = sweep_row(model, "omega", grid(101))
        assert_row_is_right(model, row, None)
        assert np.all(row.certified == 1)


@pytest.mark.parametrize("variation", [0.0, 1.0])
def test_a_gear_without_mesh_damping_returns(variation):
    model = Model(
        b=0.9283,
        alpha=0.0,
        alpha_harmonics=[[0.1225, 1.9314]],
        f_e=0.01224,
        f_e_phase=1.5032,
        f_pm=0.23192,
        kappa=0.43063,
        xi_mesh=0.0,
        xi_translation=0.0,
        xi_support=[0.0415, 0.0095, 0.0284, 0.0792, 0.0661, 0.0420],
        k_support=[0.437, 7.30, 0.177, 9.16, 5.27, 3.54],
        pitch_cone_angle=5.91,
        pressure_angle=35.2,
        translation_coupling=0.0,
        rotation_coupling="geometric",
        variation_translation=1.0 - variation,
        variation_rotation=variation,
    )
    row = sweep_row(model, "omega", np.linspace(0.05, 2.5, COLUMNS))
    assert_row_is_right(model, row, None)
    assert np.all(row.certified == 1)


@pytest.mark.parametrize(
    "changes", [{"xi_mesh": 0.0}, {"xi_support": 0.0}, {"translation_coupling": 0.0}, {"alpha": 0.0}]
)
def test_gears_without_one_kind_of_damping_or_coupling(gear, changes):
    model = gear[1].replace(**changes)
    assert_row_is_right(model, sweep_row(model, "omega", np.linspace(0.06, 2.01, COLUMNS)), None)


def test_gears_without_any_damping(gear):
    model = gear[1].replace(xi_mesh=0.0, xi_translation=0.0, xi_support=0.0)
    assert_row_is_right(model, sweep_row(model, "omega", np.linspace(0.06, 2.01, COLUMNS)), None)


def test_a_row_may_be_empty():
    """Every solution lies above a ceiling that is this low."""
    row = sweep_row(
        published(), "kappa", np.linspace(0.1, 1.0, 9), omega=0.6, continuation=Continuation(amplitude_max=1e-6)
    )
    assert not np.any(row.n_solutions) and np.all(row.open == 1) and row.curves == ()
    assert row.mean.shape == row.instability.shape == (9, 1) and np.all(np.isnan(row.mean))
