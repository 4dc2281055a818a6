"""Where boundaries of contradictory cells are sought."""

import numpy as np
import pytest

from pipeline.analysis.boundaries import contradictions
from pipeline.analysis.boundaries.contradictions import contradiction_starts
from pipeline.analysis.boundaries.events import read_events
from pipeline.analysis.boundaries.tracing import curves_through
from tests.pipeline.planes import small_plan, small_store

_PLAN = small_plan("plane=omega_fe", columns=60, rows=40)


def _cells(columns, rows, mean: float = 0.4) -> np.ndarray:
    """Cells (k, 5) at columns and rows of the plane, by number."""
    x, p = _PLAN.sweep.values, _PLAN.parameter.values
    between = np.interp(columns, np.arange(x.size), x)
    return np.column_stack([np.tile([mean, 0.3, 0.1], (len(rows), 1)), between, p[rows]])


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
