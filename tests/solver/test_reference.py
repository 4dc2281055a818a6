"""Reference digits of docs/physics.md, section 7: folds to 1e-6, solutions to 1e-8."""

import numpy as np
import pytest

from solver import Event, sweep_row

GRID = np.round(np.linspace(0.05, 2.0, 196), 10)


@pytest.fixture(scope="module", params=["published", "consistent", "antiphase"])
def row(request):
    from tests.conftest import MODELS

    return request.param, sweep_row(MODELS[request.param](), "omega", GRID)


def test_folds(row, reference):
    name, result = row
    found = [
        (*curve.points[i, [3, 0]], curve.amplitude[i])
        for curve in result.curves
        for i in np.flatnonzero(curve.event == Event.FOLD)
    ]
    expected = reference[name]["folds"]
    assert len(found) == len(expected)
    if expected:
        np.testing.assert_allclose(sorted(found), sorted(map(tuple, expected)), rtol=0, atol=1e-6)


def test_solutions(row, reference):
    name, result = row
    for omega, expected in reference[name]["solutions"].items():
        column = int(np.argmin(np.abs(GRID - omega)))
        assert GRID[column] == pytest.approx(omega, abs=1e-12)
        count = int(result.n_solutions[column])
        found = np.column_stack([result.mean[column], result.amplitude[column]])[:count]
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8)
