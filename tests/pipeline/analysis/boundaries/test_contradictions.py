"""Where boundaries of contradictory cells are sought."""

import numpy as np
import pytest

from pipeline.analysis.boundaries import contradictions
from pipeline.analysis.boundaries.contradictions import contradiction_starts, contradictory_cells
from pipeline.analysis.boundaries.events import read_events
from pipeline.analysis.boundaries.tracing import curves_through
from pipeline.plane.stored import StoredPlane
from solver.stability import Instability
from tests.pipeline.planes import small_plan, small_store

_PLAN = small_plan("plane=omega_fe", columns=60, rows=40)


def _cells(columns, rows, mean: float = 0.4) -> np.ndarray:
    """Cells (k, 5) at columns and rows of the plane, by number."""
    x, p = _PLAN.sweep.values, _PLAN.parameter.values
    between = np.interp(columns, np.arange(x.size), x)
    return np.column_stack([np.tile([mean, 0.3, 0.1], (len(rows), 1)), between, p[rows]])


def test_cells_lie_between_motions_of_which_one_contradicts_itself(tmp_path):
    """Against the same in so many words, of motions in any order, some of them unstable or missing."""
    rng, shape = np.random.default_rng(4), (40, 60, 5)
    kinds = rng.choice([Instability.NONE, Instability.PERIOD_DOUBLING, Instability.CONTRADICTORY], shape)
    stable, mean = rng.integers(-1, 2, shape), rng.normal(size=shape)
    mean[stable < 0] = np.nan
    part = StoredPlane(tmp_path, _PLAN)
    arrays = {"stable": stable, "instability": kinds, "mean": mean, "amplitude": np.ones(shape), "phase": 0.0 * mean}
    vars(part).update(arrays)
    x, p, wanted = _PLAN.sweep.values, _PLAN.parameter.values, []
    for row, column in np.ndindex(40, 59):
        others = np.flatnonzero(stable[row, column + 1] == 1)
        for one in np.flatnonzero(stable[row, column] == 1) if others.size else ():
            other = min(others, key=lambda k: abs(mean[row, column, one] - mean[row, column + 1, k]))
            here, there = kinds[row, column, one], kinds[row, column + 1, other]
            if (here == Instability.CONTRADICTORY) != (there == Instability.CONTRADICTORY):
                middle = 0.5 * (mean[row, column, one] + mean[row, column + 1, other])
                wanted.append([middle, 1.0, 0.0, 0.5 * (x[column] + x[column + 1]), p[row]])
    assert len(wanted) > 100
    np.testing.assert_allclose(contradictory_cells(part), wanted, rtol=1e-15, atol=1e-300)
    vars(part).update(instability=np.full(shape, Instability.NONE))
    assert contradictory_cells(part).shape == (0, 5)


def test_of_cells_in_a_row_some_are_enough_and_of_others_all_are_needed():
    rows = np.arange(31)
    leaning, upright = _cells(10.5 + 0.9 * rows, rows), _cells(np.full(31, 50.5), rows, mean=0.1)
    steep, single = _cells(3.5 + 5.0 * rows[:3], rows[:3], mean=0.9), _cells([20.5], [35])
    together = np.concatenate([leaning, upright, steep, single])
    order = np.lexsort((together[:, 3], together[:, 4]))
    kept = contradictions._sparse(_PLAN, together[order])
    followed = [0, 1, 10, 20, 30]
    wanted = np.concatenate([leaning[followed], upright[followed], steep, single])
    assert sorted(map(tuple, kept)) == sorted(map(tuple, wanted))
    assert contradictions._sparse(_PLAN, together[:0]).shape == (0, 5)


def test_two_motions_that_follow_the_same_place_are_two_boundaries():
    rows = np.arange(4)
    both = np.concatenate([_cells(np.full(4, 30.5), rows), _cells(np.full(4, 30.5), rows, mean=0.8)])
    kept = contradictions._sparse(_PLAN, both[np.argsort(both[:, 4], kind="stable")])
    assert sorted(kept[:, 0].tolist()) == [0.4, 0.4, 0.8, 0.8]


@pytest.mark.costly
def test_all_cells_lead_to_the_same_curves(tmp_path, monkeypatch):
    cells = read_events(small_store(tmp_path / "plane.zarr", _PLAN), _PLAN).contradictory
    few = contradiction_starts(_PLAN, cells, ())
    monkeypatch.setattr(contradictions, "_sparse", lambda plan, cells: cells)
    every = contradiction_starts(_PLAN, cells, ())
    assert 0 < len(few) < len(every)
    found, wanted = (curves_through(_PLAN, starts) for starts in (few, every))
    assert len(found) == len(wanted)
    for one, other in zip(found, wanted, strict=True):
        # Steps depend on where a curve was started.
        assert one.distances(other.points[:, :5]).max() < 1e-6
