"""Rows over the mesh frequency: their columns, what is found there, and how it is compared."""

import numpy as np

from solver import Event
from tests.solver.curves import HIGH, LOW
from tests.solver.independent import linear_response

#: Changes of a gear after which its rows look different.
VARIANTS = [dict(), dict(f_e=0.4), dict(b=0.3), dict(alpha=0.5), dict(f_pm=0.35)]


def grid(columns):
    """Evenly spaced frequencies."""
    return np.linspace(LOW, HIGH, columns)


def solutions(row, column):
    """(k, 3) solutions of one column."""
    count = row.n_solutions[column]
    return np.column_stack([row.mean[column], row.cos[column], row.sin[column]])[:count]


def assert_same_columns(row, columns, other, others, atol=1e-10, same_axis=True):
    """Counts, stability, states and values agree at two sets of columns; what is open beside them on one axis only."""
    np.testing.assert_array_equal(row.n_solutions[columns], other.n_solutions[others])
    np.testing.assert_array_equal(row.domain[columns], other.domain[others])
    if same_axis:
        np.testing.assert_array_equal(row.open[columns], other.open[others])
    for i, j in zip(np.arange(len(row.grid))[columns], np.arange(len(other.grid))[others], strict=True):
        count = row.n_solutions[i]
        np.testing.assert_allclose(solutions(row, i), solutions(other, j), rtol=0, atol=atol)
        np.testing.assert_array_equal(row.stable[i, :count], other.stable[j, :count])
        np.testing.assert_array_equal(row.impact[i, :count], other.impact[j, :count])


def fold_places(row):
    """p of every fold, and by how much the number of solutions grows there with growing p."""
    places = []
    for curve in row.curves:
        for i in np.flatnonzero(curve.event == Event.FOLD):
            # Both sides of a fold lie below it (two solutions end there) or above it.
            places.append((curve.points[i, 3], 2 if curve.points[i - 1, 3] > curve.points[i, 3] else -2))
    return places


def assert_linear(row, model, shift):
    """One solution everywhere: the linear response, with its mean moved by a shift."""
    np.testing.assert_array_equal(row.n_solutions, 1)
    for i, omega in enumerate(row.grid):
        expected, _ = linear_response(model, omega)
        size = max(1.0, np.max(np.abs(expected)))
        np.testing.assert_allclose(solutions(row, i)[0], expected + [shift, 0, 0], rtol=0, atol=1e-10 * size)
