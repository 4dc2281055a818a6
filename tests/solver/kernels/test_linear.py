"""Gaussian elimination of small systems against LAPACK."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.kernels.linear import dot, eliminate


@given(st.integers(1, 8), st.integers(0, 2**32 - 1))
def test_solution_and_determinant(n, seed):
    draw = np.random.default_rng(seed)
    matrix, right = draw.normal(size=(n, n)), draw.normal(size=n)
    x = right.copy()
    determinant = eliminate(matrix.copy(), x)
    assert determinant == pytest.approx(np.linalg.det(matrix), rel=1e-9)
    np.testing.assert_allclose(matrix @ x, right, rtol=0, atol=1e-12 * np.linalg.cond(matrix))


def test_rows_are_exchanged_and_the_sign_follows():
    x = np.array([2.0, 3.0, 5.0])
    assert eliminate(np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]), x) == 1.0
    np.testing.assert_array_equal(x, [5.0, 2.0, 3.0])
    assert eliminate(np.array([[0.0, 1.0], [1.0, 0.0]]), np.ones(2)) == -1.0
    tiny = np.array([1.0, 2.0])
    eliminate(np.array([[1e-20, 1.0], [1.0, 1.0]]), tiny)
    np.testing.assert_allclose(tiny, [1.0, 1.0], rtol=0, atol=1e-15)


def test_a_singular_matrix_has_determinant_zero_and_nan_stays_nan():
    assert eliminate(np.array([[1.0, 2.0], [2.0, 4.0]]), np.ones(2)) == 0.0
    assert eliminate(np.zeros((3, 3)), np.ones(3)) == 0.0
    assert np.isnan(eliminate(np.array([[np.nan, 2.0], [2.0, 4.0]]), np.ones(2)))


def test_dot():
    assert dot(np.array([1.0, 2.0, 3.0]), np.array([4.0, -5.0, 6.0])) == 12.0
