"""The balance of all seven degrees of freedom gives the same solutions as the condensed one."""

import numpy as np
import pytest
from hypothesis import assume, given
from scipy.optimize import root

from solver import sweep_row, translations, uncondensed_balance
from tests.conftest import MODELS, published
from tests.solver.independent import difference, projected_balance
from tests.solver.strategies import frequencies, models, motions

PLACES = np.array([0.3, 0.53, 0.6, 0.9, 1.2265, 1.2934, 1.6])

UNLIKE = dict(
    kappa=[0.4, 0.7],
    xi_translation=[0.01, 0.02],
    xi_support=[0.02, 0.01, 0.03, 0.02, 0.01, 0.02],
    k_support=[1.0, 0.8, 1.2, 2.0, 0.7, 1.5],
    alpha=0.3,
    alpha_phase=0.5,
    alpha_harmonics=[[0.1, -0.7]],
    f_pv=0.1,
    variation_rotation=0.7,
    translation_coupling=0.5,
)

PAIRS = {**{name: make() for name, make in MODELS.items()}, "unlike": published(**UNLIKE)}


def insert(model, omega, mesh):
    """The 21 unknowns that belong to a condensed solution."""
    return np.column_stack([translations(model, omega, mesh), mesh]).ravel()


def solutions(model):
    """(omega, (lambda_m, lambda_c, lambda_s)) of everything `sweep_row` finds at the chosen places."""
    row = sweep_row(model, "omega", PLACES)
    for i, omega in enumerate(PLACES):
        for s in range(row.n_solutions[i]):
            yield omega, np.array([row.mean[i, s], row.cos[i, s], row.sin[i, s]])


@pytest.mark.parametrize("name", PAIRS)
def test_condensed_solutions_solve_the_uncondensed_balance(name):
    count = 0
    for omega, mesh in solutions(PAIRS[name]):
        residual, _ = uncondensed_balance(PAIRS[name], omega, insert(PAIRS[name], omega, mesh))
        assert np.max(np.abs(residual)) < 1e-11
        count += 1
    assert count >= len(PLACES) and (name != "antiphase" or count >= len(PLACES) + 6)


@pytest.mark.parametrize("name", PAIRS)
def test_uncondensed_solutions_are_the_condensed_ones(name):
    """Solved by SciPy from perturbed starts; all solutions at a frequency are known, the one reached must be there."""
    model, draw, reached = PAIRS[name], np.random.default_rng(5), set()
    known = list(solutions(model))
    for number, (omega, mesh) in enumerate(known):
        for _ in range(3):
            start = insert(model, omega, mesh) + draw.uniform(-0.02, 0.02, 21)
            result = root(lambda u, w=omega: uncondensed_balance(model, w, u), start, jac=True, tol=1e-13)
            assert np.max(np.abs(result.fun)) < 1e-10
            found = result.x.reshape(3, 7)[:, 6]
            distances = [np.max(np.abs(found - m)) if w == omega else np.inf for w, m in known]
            assert min(distances) < 1e-9
            if np.argmin(distances) == number:
                reached.add(number)
            expected = translations(model, omega, found)
            np.testing.assert_allclose(result.x.reshape(3, 7)[:, :6], expected, rtol=0, atol=1e-9)
    assert reached == set(range(len(known)))


@given(models(), frequencies, motions)
def test_jacobian_of_the_uncondensed_balance(model, omega, mesh):
    amplitude = np.hypot(mesh[1], mesh[2])
    assume(amplitude > 0.1 and min(abs(abs(s * model.b - mesh[0]) - amplitude) for s in (1, -1)) > 0.02)
    unknowns = insert(model, omega, mesh) + 0.1
    _, jacobian = uncondensed_balance(model, omega, unknowns)
    for column in range(21):
        expected = difference(
            lambda x, c=column: uncondensed_balance(model, omega, unknowns + x * np.eye(21)[c])[0], 0.0, 1e-4
        )
        np.testing.assert_allclose(jacobian[:, column], expected, rtol=0, atol=1e-7, err_msg=f"column {column}")


@given(models(), frequencies, motions)
def test_translations_leave_only_the_mesh_rows(model, omega, mesh):
    residual, _ = uncondensed_balance(model, omega, insert(model, omega, mesh))
    rows = residual.reshape(3, 7)
    size = max(1.0, np.max(np.abs(insert(model, omega, mesh))))
    np.testing.assert_allclose(rows[:, :6], 0.0, rtol=0, atol=1e-12 * size)
    np.testing.assert_allclose(rows[:, 6], projected_balance(model, omega, mesh), rtol=0, atol=5e-7 * size)


def test_the_mesh_at_rest_is_a_regular_point():
    residual, jacobian = uncondensed_balance(published(), 0.7, np.zeros(21))
    assert np.all(np.isfinite(residual)) and np.all(np.isfinite(jacobian))
