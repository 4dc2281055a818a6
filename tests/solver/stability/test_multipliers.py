"""Eigenvalues of small matrices against LAPACK, test functions against their definitions."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.stability.assessment import _eigenvalues
from solver.stability.multipliers import DOUBLING, GAP, LARGEST, OUTSIDE, RIVAL, TESTS, UNIT, spectral_tests
from tests.solver.stability.orbits import matched


def eigenvalues(matrices):
    matrices = np.array(matrices, dtype=float)
    real, imaginary = np.empty(matrices.shape[:2]), np.empty(matrices.shape[:2])
    _eigenvalues(matrices, real, imaginary)
    return real + 1j * imaginary


@given(st.integers(1, 14), st.integers(0, 2**32 - 1))
def test_random_matrices(size, seed):
    random = np.random.default_rng(seed)
    matrix = random.normal(size=(size, size)) * 10.0 ** random.uniform(-3, 3)
    scale = np.linalg.norm(matrix)
    assert matched(eigenvalues(matrix[None])[0], np.linalg.eigvals(matrix)) < 1e-8 * scale


@pytest.mark.parametrize(
    "matrix",
    [
        np.zeros((4, 4)),
        np.eye(4),
        np.diag([2.0, -3.0, 0.5, 0.0]),
        np.roll(np.eye(4), 1, axis=0),
        np.roll(np.eye(6), 1, axis=0),
        np.triu(np.ones((4, 4))),
        [[0.0, 1.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 2.0], [0.0, 0.0, -2.0, 0.0]],
    ],
)
def test_matrices_that_defeat_a_plain_iteration(matrix):
    matrix = np.asarray(matrix, dtype=float)
    assert matched(eigenvalues(matrix[None])[0], np.linalg.eigvals(matrix)) < 1e-7


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_not_finite_has_none(bad):
    matrix = np.eye(4)
    matrix[1, 2] = bad
    assert np.all(np.isnan(eigenvalues(matrix[None])))


def functions_of(values):
    values = np.asarray(values, dtype=complex)
    found = np.empty(TESTS)
    spectral_tests(np.ascontiguousarray(values.real), np.ascontiguousarray(values.imag), found)
    return found


def test_functions_of_given_multipliers():
    pair, inside = [0.8 + 0.7j, 0.8 - 0.7j], [0.3 + 0.4j, 0.3 - 0.4j]
    found = functions_of([-1.2, 0.5, *pair])
    assert found[DOUBLING] == pytest.approx(np.prod([1 - 1.2, 1.5, *(1 + z for z in pair)]).real)
    assert found[LARGEST] == pytest.approx(1.2) and found[GAP] == pytest.approx(abs(pair[0]) - 1.0)
    # One beyond -1 is left out of the count; so is one beyond +1, and two beyond one of them are as good as a pair.
    for values in ([-1.2, 0.5, *pair], [1.2, -1.3, *pair], [-1.1, -1.3, *inside]):
        assert functions_of(values)[OUTSIDE] == 2
    assert functions_of(inside)[OUTSIDE] == functions_of([-1.2, *inside])[OUTSIDE] == 0
    # How far beyond +1 the nearest is, over how far inside the nearest of the others is.
    found = functions_of([1.2, 0.9, *pair])
    assert found[UNIT] == pytest.approx(np.prod([1.2 - 1, 0.9 - 1, *(z - 1 for z in pair)]).real)
    assert found[RIVAL] == pytest.approx(0.2 / 0.1)
    assert functions_of([1.2, -0.9])[RIVAL] == functions_of([0.2, 0.9])[RIVAL] == 0.0
    assert np.all(np.isnan(functions_of([np.nan, 0.1])[[LARGEST, DOUBLING, OUTSIDE, UNIT]]))
