"""Slabs: what is looked at together is what is looked at one by one."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from solver.regions.slabs import RowCrossings, _may_vanish, _zeros

_FLOOR = 1e-10


class _Wave:
    """A boundary x = sin(p) and one that turns round at p = 2."""

    parameter = np.array([0.0, 3.0])

    def __init__(self, shift: float):
        self.shift = shift

    def crossings(self, values):
        values = np.asarray(values, dtype=float)
        column = np.repeat(np.arange(values.size), 2)
        x = np.column_stack([np.sin(values + self.shift), 2.0 - values]).ravel()
        points = np.zeros((x.size, 5))
        points[:, 3], points[:, 4] = x, values[column]
        return column, points


def _polynomial(coefficients):
    return lambda value: float(np.polyval(coefficients, value))


@given(st.lists(st.tuples(*[st.floats(-2.0, 2.0)] * 3), min_size=1, max_size=8), st.integers(3, 12))
def test_functions_that_are_left_out_have_no_zeros_between_samples(polynomials, count):
    at = np.linspace(-1.0, 1.0, count)
    functions = [_polynomial(coefficients) for coefficients in polynomials]
    gaps = np.array([[function(value) for function in functions] for value in at])
    looked_at = _may_vanish(at, gaps, _FLOOR)
    for function, gap, kept in zip(functions, gaps.T, looked_at, strict=True):
        found = _zeros(at, gap, function, _FLOOR)
        assert kept or found == []
        assert all(abs(function(value)) < 1e-6 for value in found)


def test_two_zeros_between_two_samples_are_found():
    at, function = np.linspace(-1.0, 1.0, 4), _polynomial([1.0, 0.0, -0.01])
    gaps = np.array([function(value) for value in at])
    assert np.all(gaps > 0.0)
    assert _may_vanish(at, gaps[:, None], _FLOOR).all()
    np.testing.assert_allclose(sorted(_zeros(at, gaps, function, _FLOOR)), [-0.1, 0.1], atol=1e-10)


def test_rows_that_were_looked_up_together_are_those_looked_up_alone():
    curves, values = (_Wave(0.0), _Wave(1.0)), np.linspace(0.1, 2.9, 7)
    alone, together = RowCrossings(curves, (-3.0, 3.0)), RowCrossings(curves, (-3.0, 3.0))
    together.look_up(values)
    for part in (values[:3], values[4:], values, np.array([0.1, 0.55])):
        arcs, x = alone.matrix(part)
        others, places = together.matrix(part)
        assert arcs == others
        np.testing.assert_array_equal(x, places)
    together.look_up(np.empty(0))
    assert together.table(np.empty(0)) == []
