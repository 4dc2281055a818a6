"""Where branches come from: proven seeds, isolas, certified rows."""

import numpy as np
import pytest

from solver import LinearSeeds, ProvenSeeds, RowError, all_solutions, sweep_row
from solver.boundaries import SpecialPoint, boundary_curves, row_events
from tests.conftest import consistent, published
from tests.solver.reference_rows import grid


@pytest.mark.parametrize("alpha", [0.41, 0.42, 0.43, 0.44, 0.45])
def test_default_seeds_find_the_isola(alpha):
    """docs/physics.md, section 7: apart from the main branch from somewhere above 0.40 to somewhere above 0.45."""
    model = consistent(rotation_coupling=0.93969262, alpha=alpha)
    assert [curve.closed for curve in sweep_row(model, "omega", grid(79)).curves] == [False, True]
    assert [curve.closed for curve in sweep_row(model, "omega", grid(79), seeds=LinearSeeds()).curves] == [False]


def test_a_range_inside_a_jump_has_all_its_branches():
    row = sweep_row(published(), "omega", np.linspace(0.57, 0.62, 26))
    assert np.all(row.n_solutions == 3) and len(row.curves) == 3


@pytest.mark.parametrize("alpha", [0.2, 0.5, 0.75])
def test_every_column_certified(gear, alpha):
    row = sweep_row(gear[1].replace(alpha=alpha), "omega", grid(200), seeds=ProvenSeeds(every_column=True))
    assert np.all(row.certified == 1) and row.n_gained == 0
    same = sweep_row(gear[1].replace(alpha=alpha), "omega", grid(200))
    np.testing.assert_array_equal(row.domain, same.domain)
    assert np.all(same.certified == -1) and same.n_gained == -1 and same.n_folds == row.n_folds


def test_columns_find_what_few_seeds_miss():
    model = consistent(rotation_coupling=0.93969262, alpha=0.44)
    few, all_columns = ProvenSeeds(columns=2), ProvenSeeds(columns=2, every_column=True)
    row, whole = (sweep_row(model, "omega", grid(200), seeds=seeds) for seeds in (few, all_columns))
    assert len(row.curves) == 1 and len(whole.curves) == 2 and whole.n_gained == 1 and whole.n_folds == row.n_folds


def test_enumeration_and_continuation_must_agree(monkeypatch):
    """A branch is lost on its way to the raster: the row fails instead of showing the wrong number."""
    import solver.rows.row

    honest = solver.rows.row.curve_crossings

    def loses_one(problem, curve, columns, continuation):
        column, unknowns, stable = honest(problem, curve, columns, continuation)
        return column[:-1], unknowns[:-1], stable[:-1]

    monkeypatch.setattr(solver.rows.row, "curve_crossings", loses_one)
    with pytest.raises(RowError, match="disagree at 1 columns, first at omega = 2: 1 solutions against 0"):
        sweep_row(published(), "omega", grid(40), seeds=ProvenSeeds(every_column=True))


def test_free_play_without_load_is_no_number():
    with pytest.raises(RowError, match="continuum"):
        sweep_row(published(f_pm=0.0, f_e=0.05), "omega", grid(40))


@pytest.mark.parametrize("columns", [61, 150, 397])
def test_the_solutions_do_not_depend_on_where_seeds_are_taken(columns):
    model = consistent(rotation_coupling=0.93969262, alpha=0.44)
    usual, other = (sweep_row(model, "omega", grid(200), seeds=ProvenSeeds(n)) for n in (197, columns))
    np.testing.assert_array_equal(usual.stable, other.stable)
    np.testing.assert_array_equal(usual.domain, other.domain)
    for name in ("mean", "cos", "sin"):
        np.testing.assert_allclose(getattr(usual, name), getattr(other, name), rtol=0, atol=1e-11)


def test_an_isola_is_born_where_enumeration_first_finds_it():
    """The fold curve's turning point, from rows on one side of it only, against counts of proven solutions."""
    model = consistent(rotation_coupling=0.93969262)
    rows = [(alpha, sweep_row(model.replace(alpha=alpha), "omega", grid(200))) for alpha in (0.41, 0.42)]
    starts = [event for alpha, row in rows for event in row_events(row, alpha)]
    curves = boundary_curves(model, "omega", "alpha", (0.05, 2.0), (0.3, 0.43), starts)
    (birth,) = [c.points[i] for c in curves for i in np.flatnonzero(c.special == SpecialPoint.ISOLA)]
    omega, alpha = birth[3:]
    counts = [len(all_solutions(model.replace(alpha=alpha + d), omega).mean) for d in (-1e-6, -1e-9, 1e-9, 1e-6)]
    assert counts == [1, 1, 3, 3] and 0.40 < alpha < 0.41
