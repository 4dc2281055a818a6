"""Where a multiplier passes +1 and no branch folds: curves against multipliers on both sides."""

import numpy as np
import pytest

from solver import Continuation, Event, enumerate_row
from solver.boundaries import SpecialPoint, boundary_curves
from solver.boundaries.tracer import events_near
from solver.stability import multipliers
from tests.conftest import MODELS

PLANE = (MODELS["published"](), "omega", "f_e", (0.5, 0.7), (0.1, 0.4))


def guesses(value=0.3):
    """Half-way between two columns of a row between which the number of multipliers beyond +1 changes."""
    model, grid = MODELS["published"](f_e=value), np.linspace(0.51, 0.69, 91)
    found = enumerate_row(model, "omega", grid)
    places, before = [], None
    for column, x in enumerate(grid):
        stable = np.flatnonzero(found.stable[column] == 1)
        motion = found.motions[column, stable[np.argmax(found.amplitude[column, stable])]]
        beyond = beyond_one(model, x, motion)
        if before is not None and beyond != before[1] and np.max(np.abs(motion - before[0])) < 0.3:
            places.append((Event.UNIT_MULTIPLIER, np.array([*(0.5 * (motion + before[0])), x - 0.001, value])))
        before = motion, beyond
    return places


def beyond_one(model, x, motion) -> int:
    (found,) = multipliers(model, "omega", [x], motion[None])
    return int(np.sum((found.imag == 0.0) & (found.real > 1.0)))


@pytest.fixture(scope="module")
def curves():
    starts = events_near(*PLANE, guesses(), 0.01)
    assert starts
    return boundary_curves(*PLANE, starts)


def test_a_multiplier_is_one_all_along(curves):
    for curve in curves:
        assert curve.kind is Event.UNIT_MULTIPLIER and len(curve.points) > 20
        for point in curve.points[::7]:
            model = MODELS["published"](f_e=point[4])
            (found,) = multipliers(model, "omega", [point[3]], point[None, :3])
            assert np.min(np.abs(found - 1.0)) < 1e-7


def test_the_number_beyond_one_changes_across(curves):
    """By one, whether next to it a pair has met beyond +1 or not."""
    looked = 0
    for curve in curves:
        column, points = curve.crossings([0.22, 0.3, 0.35])
        for point in points:
            model, sides = MODELS["published"](f_e=point[4]), []
            for step in (-2e-4, 2e-4):
                found = enumerate_row(model, "omega", [point[3] + step])
                gaps = np.max(np.abs(found.motions[0] - point[:3]), axis=1)
                if np.nanmin(gaps) < 0.05:
                    sides.append(beyond_one(model, point[3] + step, found.motions[0, np.nanargmin(gaps)]))
            if len(sides) == 2:
                assert abs(sides[0] - sides[1]) == 1
                looked += 1
    assert looked >= 2


def test_where_the_motion_folds_as_well_is_located(curves):
    """det dE/du vanishes there and changes its sign along the curve."""
    crossed = [(c, i) for c in curves for i in np.flatnonzero(c.special == SpecialPoint.FOLD_CROSSING)]
    assert crossed
    for curve, i in crossed:
        assert curve.stable[i] == 0 and {int(curve.stable[i - 1]), int(curve.stable[i + 1])} == {0, 1}
        stretch = curve.stretches[0]
        values = np.abs(stretch.problem.observed_all(stretch.curve.points, 2)[:, 1])
        assert values[3] == abs(stretch.problem.observed(stretch.curve.points[3], 2)[1])
        assert values[i] < 1e-8 < 1e-4 * max(values) if len(curve.stretches) == 1 else True


def test_a_guess_that_leads_too_far_is_left_out():
    (kind, guess), *_ = guesses()
    assert events_near(*PLANE, [(kind, guess)], 0.01, continuation=Continuation())
    assert events_near(*PLANE, [(kind, guess)], 1e-9) == []
