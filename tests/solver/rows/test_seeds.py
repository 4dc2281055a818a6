"""Where branches come from: proven seeds, isolas, certified rows."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver import (
    ContactSystem,
    Continuation,
    Curve,
    DescribingFunction,
    EndReason,
    Event,
    LinearSeeds,
    ProvenSeeds,
    RowError,
    all_solutions,
    sweep_row,
)
from solver.boundaries import SpecialPoint, boundary_curves, row_events
from solver.rows import seeds
from solver.rows.seeds import spread_columns
from solver.rows.span import RowSpan
from tests.conftest import antiphase, consistent, published
from tests.solver.curves import HIGH, LOW
from tests.solver.reference_rows import assert_same_columns, grid


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
def test_every_column_is_proven_unless_asked_otherwise(gear, alpha):
    model = gear[1].replace(alpha=alpha)
    row, few = (sweep_row(model, "omega", grid(200), seeds=seeds) for seeds in (None, ProvenSeeds(every_column=False)))
    assert np.all(row.certified == 1) and np.all(few.certified == -1) and not row.notes and not few.notes
    assert_same_columns(row, slice(None), few, slice(None))
    assert row.n_folds == few.n_folds


def test_columns_find_what_few_seeds_miss():
    model = consistent(rotation_coupling=0.93969262, alpha=0.44)
    few, whole = (sweep_row(model, "omega", grid(200), seeds=ProvenSeeds(2, every)) for every in (False, True))
    assert len(few.curves) == 1 and len(whole.curves) == 2 and whole.n_folds == few.n_folds + 4


@given(st.lists(st.integers(1, 400), min_size=1, max_size=12), st.integers(2, 300))
def test_columns_between_grid_values_close_the_gaps(steps, columns):
    values = np.concatenate([[0.0], np.cumsum(steps)]) / 400.0
    spread, place = spread_columns(values, columns)
    np.testing.assert_array_equal(spread[place], values)
    assert np.all(np.diff(spread) > 0.0) and spread.size >= columns
    assert np.max(np.diff(spread)) <= (values[-1] - values[0]) / (columns - 1) * (1.0 + 1e-9)
    # Evenly between two grid values, and none where these lie close enough.
    for first, last in zip(place[:-1], place[1:], strict=True):
        np.testing.assert_allclose(np.diff(spread[first : last + 1]), (spread[last] - spread[first]) / (last - first))
        assert last - first == 1 or spread[last] - spread[first] > (values[-1] - values[0]) / (columns - 1)


# Where enumeration and continuation disagree --------------------------------------------------------------------------


def cut_off(curve: Curve, first: int, last: int) -> Curve:
    """A part of a curve, as if its steps had become too small at both ends."""
    part = slice(first, last)
    ends = EndReason.STEP_TOO_SMALL, EndReason.STEP_TOO_SMALL
    return Curve(
        *(getattr(curve, name)[part] for name in ("points", "tangents", "arclength", "stable", "event")), ends, 0
    )


def test_what_a_branch_lost_is_traced_from_the_proven_solutions(monkeypatch):
    """Every trace breaks off after some points: what is missing is traced on, and every solution lies on a branch."""
    honest = RowSpan.traced

    def breaks_off(span, start):
        curve = honest(span, start)
        here = int(np.argmin(np.abs(curve.points - start).sum(axis=1)))
        return cut_off(curve, max(here - 25, 0), here + 25)

    whole = sweep_row(antiphase(), "omega", grid(200))
    monkeypatch.setattr(RowSpan, "traced", breaks_off)
    row = sweep_row(antiphase(), "omega", grid(200))
    assert len(row.curves) > len(whole.curves) and any("too small" in note or "refused" in note for note in row.notes)
    np.testing.assert_array_equal(row.certified, 1)
    assert_same_columns(row, slice(None), whole, slice(None))
    met = [span_of(row).crossings(curve, row.grid) for curve in row.curves]
    counts = np.bincount(np.concatenate([part.column for part in met]), minlength=200)
    assert np.all(counts >= row.n_solutions)


def test_a_branch_that_is_traced_again_is_kept_once(monkeypatch):
    """The corrector fails at a column: its solution seems to be missing, and tracing from it gives the same branch."""
    honest, whole = RowSpan.crossings, sweep_row(published(), "omega", grid(100))

    def loses_one(span, curve, probes, known=None):
        met = honest(span, curve, probes, known)
        met.on_curve[70] = False
        return met

    monkeypatch.setattr(RowSpan, "crossings", loses_one)
    row = sweep_row(published(), "omega", grid(100))
    assert len(row.curves) == len(whole.curves) and not row.notes and np.all(row.certified == 1)


def test_solutions_that_no_branch_can_be_traced_through_stay_in_the_raster_and_are_marked(monkeypatch):
    honest, whole = RowSpan.traced, sweep_row(published(), "omega", grid(100))

    def dies(span, start):
        curve = honest(span, start)
        return cut_off(curve, 0, 0) if start[-1] > 1.0 else cut_off(curve, 0, int(np.sum(curve.points[:, -1] < 1.0)))

    monkeypatch.setattr(RowSpan, "traced", dies)
    row = sweep_row(published(), "omega", grid(100))
    assert_same_columns(row, slice(None), whole, slice(None))
    np.testing.assert_array_equal(row.certified[row.grid > 1.0], 0)
    np.testing.assert_array_equal(row.certified[row.grid < 0.95], 1)
    assert any("No branch was traced" in note for note in row.notes)


def test_a_branch_where_nothing_is_proven_to_be_is_marked_and_left_out(monkeypatch):
    """The enumeration claims to be complete without one of three solutions."""
    honest, whole = seeds.proven_solutions, sweep_row(published(), "omega", grid(200))
    column = int(np.argmax(whole.n_solutions == 3))

    def loses_one(span, probes):
        found = honest(span, probes)
        place = int(np.searchsorted(probes, whole.grid[column]))
        found.motions[place, 1:] = np.roll(found.motions[place, 1:], -1, axis=0)
        found.stable[place, 1:] = np.roll(found.stable[place, 1:], -1)
        found.motions[place, 2], found.stable[place, 2], found.n_solutions[place] = np.nan, -1, 2
        return found

    monkeypatch.setattr(seeds, "proven_solutions", loses_one)
    row = sweep_row(published(), "omega", grid(200))
    assert np.flatnonzero(row.certified != 1).tolist() == [column] and row.n_solutions[column] == 2
    assert len(row.notes) == 1 and f"{whole.grid[column]:.9g}" in row.notes[0]


def test_folds_at_a_column_are_undecided_and_keep_what_continuation_knows():
    curve = sweep_row(published(), "omega", grid(3)).curves[0]
    folds = curve.points[curve.event == Event.FOLD, 3]
    row = sweep_row(published(), "omega", np.sort([LOW, *folds, HIGH]))
    np.testing.assert_array_equal(row.certified, [1, 0, 0, 0, 0, 1])
    np.testing.assert_array_equal(row.n_solutions[1:5], 2)
    assert len(row.notes) == 1 and "3 more" in row.notes[0] and "fold" in row.notes[0]


def span_of(row) -> RowSpan:
    model = antiphase()
    return RowSpan(DescribingFunction(), model, "omega", row.grid[0], row.grid[-1], None, Continuation())


def test_free_play_without_load_is_no_number():
    with pytest.raises(RowError, match="continuum"):
        sweep_row(published(f_pm=0.0, f_e=0.05), "omega", grid(40))


@pytest.mark.parametrize("columns", [61, 150, 397])
def test_the_solutions_do_not_depend_on_where_seeds_are_taken(columns):
    model = consistent(rotation_coupling=0.93969262, alpha=0.44)
    usual, other = (sweep_row(model, "omega", grid(200), seeds=ProvenSeeds(n, False)) for n in (197, columns))
    np.testing.assert_array_equal(usual.stable, other.stable)
    np.testing.assert_array_equal(usual.domain, other.domain)
    for name in ("mean", "cos", "sin"):
        np.testing.assert_allclose(getattr(usual, name), getattr(other, name), rtol=0, atol=1e-11)


def test_an_isola_is_born_where_enumeration_first_finds_it():
    """The fold curve's turning point, from rows on one side of it only, against counts of proven solutions."""
    model = consistent(rotation_coupling=0.93969262)
    rows = [(alpha, sweep_row(model.replace(alpha=alpha), "omega", grid(200))) for alpha in (0.41, 0.42)]
    starts = [event for alpha, row in rows for event in row_events(row.curves, alpha)]
    curves = boundary_curves(model, "omega", "alpha", (0.05, 2.0), (0.3, 0.43), starts)
    (birth,) = [c.points[i] for c in curves for i in np.flatnonzero(c.special == SpecialPoint.ISOLA)]
    omega, alpha = birth[3:]
    counts = [len(all_solutions(model.replace(alpha=alpha + d), omega).mean) for d in (-1e-6, -1e-9, 1e-9, 1e-6)]
    assert counts == [1, 1, 3, 3] and 0.40 < alpha < 0.41


def test_guessed_branches_of_one_flank_are_the_proven_ones():
    """Two masses, the first against a stop: nothing grows out of a linear system, and the row says what is open."""
    stop = ContactSystem(
        np.eye(2), 0.1 * np.eye(2), [[1.0, -1.0], [-1.0, 2.0]], [1.0, 0.0], [5.0, 0.0], 0.3, load=[[0, 0], [0, 0.375]]
    )
    values = np.linspace(0.2, 2.0, 9)
    guessed, proven = (sweep_row(stop, "omega", values, seeds=one) for one in (LinearSeeds(), ProvenSeeds(9)))
    np.testing.assert_allclose(guessed.motions, proven.motions, atol=1e-9)
    assert len(guessed.notes) == 1 and proven.notes == () and np.all(proven.certified == 1)
