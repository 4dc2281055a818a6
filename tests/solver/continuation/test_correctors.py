"""Newton and Broyden, and everything above them that must not depend on which one is used."""

import numpy as np
import pytest
from hypothesis import assume, given

from solver import Broyden, Continuation, Newton, ParameterError, first_order_problem, sweep_row
from solver.continuation.correctors import bordered, workspace_rows
from tests.conftest import MODELS
from tests.solver import duffing
from tests.solver.strategies import numbers

GRID = np.linspace(0.05, 2.0, 157)


class Workshop:
    """Calls a corrector's kernel as continuation does, and keeps its work array to look at."""

    def __init__(self, corrector, problem):
        self.corrector, self.problem = corrector, problem
        n = problem.unknowns
        self.work = np.zeros((workspace_rows(n), n + 1))

    def correct(self, start, normal, tolerance=1e-12, limit=50):
        y, p = np.array(start, dtype=float), self.problem
        iterations = self.corrector.kernel(
            p.residual_and_jacobian,
            p.parameters,
            p.parameter_slope,
            p.scale,
            y,
            np.array(normal, dtype=float),
            tolerance,
            limit,
            self.work,
        )
        return iterations, y

    def system(self, y, normal):
        """Scaled bordered Jacobian and residual."""
        p, n = self.problem, self.problem.unknowns
        jacobian, residual, matrix = np.empty((n, n + 1)), np.empty(n), np.empty((n + 1, n + 1))
        bordered(
            p.residual_and_jacobian,
            p.parameters,
            p.parameter_slope,
            p.scale,
            y,
            np.array(normal, dtype=float),
            jacobian,
            residual,
            matrix,
        )
        return matrix, residual


UPPER = duffing.start(1.2, 2)
TANGENT = (duffing.start(1.2001, 2) - duffing.start(1.1999, 2)) / duffing.duffing().scale
ACROSS = TANGENT / np.linalg.norm(TANGENT)


@given(numbers(-0.05, 0.05), numbers(-0.05, 0.05), numbers(-0.003, 0.003))
def test_both_reach_the_same_point_of_the_hyperplane(c, s, omega):
    problem = duffing.duffing()
    start = UPPER + [c, s, omega]
    (newton, reached), (broyden, other) = (Workshop(k, problem).correct(start, ACROSS) for k in (Newton(), Broyden()))
    assert 0 < newton <= broyden
    np.testing.assert_allclose(reached, other, rtol=0, atol=1e-11)
    assert abs(duffing.defect(np.hypot(*reached[:2]), reached[2])) < 1e-12
    assert ACROSS @ ((reached - start) / problem.scale) == pytest.approx(0.0, abs=1e-13)


def test_newton_converges_quadratically():
    start, errors = UPPER + [0.1, -0.1, 0.0], []
    _, exact = Workshop(Newton(), duffing.duffing()).correct(start, [0, 0, 1])
    for limit in (1, 2, 3, 4):
        iterations, y = Workshop(Newton(), duffing.duffing()).correct(start, [0, 0, 1], limit=limit)
        assert iterations == -1
        errors.append(np.max(np.abs(y - exact)))
    assert exact[2] == start[2]
    for before, after in zip(errors, errors[1:], strict=False):
        assert after < max(5.0 * before**2, 1e-15)
    assert errors[0] > 1e-3


def test_the_limit_and_the_number_of_iterations_are_kept():
    workshop = Workshop(Newton(), duffing.duffing())
    start = UPPER + [0.05, 0.02, 0.0]
    needed, _ = workshop.correct(start, ACROSS, 1e-12, 50)
    assert needed > 2
    assert workshop.correct(start, ACROSS, 1e-12, needed)[0] == needed
    assert workshop.correct(start, ACROSS, 1e-12, needed - 1)[0] == -1


@pytest.mark.parametrize("corrector", [Newton(), Broyden()])
def test_a_singular_or_undefined_system_is_refused(corrector):
    workshop = Workshop(corrector, duffing.duffing())
    # c = s = 0 and no frequency: the border is all that is left of the row of the second unknown.
    assert workshop.correct([0.0, 0.0, 1.0], [0.0, 0.0, 0.0])[0] == -1
    assert workshop.correct([np.nan, 0.0, 1.0], ACROSS)[0] == -1
    assert workshop.correct([1e200, 0.0, 1.0], ACROSS)[0] == -1


def test_broyden_s_update_is_the_article_s_and_meets_the_secant_condition():
    """J <- J + (y - J s) s^T/(s^T s), y = E(new) - E(old), with the border as a row of its own that is linear."""
    problem, normal = duffing.duffing(), ACROSS
    workshop, start = Workshop(Broyden(), problem), UPPER + [0.05, 0.02, 0.0]
    matrix, residual = workshop.system(start, normal)
    step = np.linalg.solve(matrix, -np.append(residual, 0.0))
    iterations, y = workshop.correct(start, normal, limit=1)
    assert iterations == -1
    np.testing.assert_allclose((y - start) / problem.scale, step, rtol=0, atol=1e-14)
    change = np.append(workshop.system(y, normal)[1] - residual, normal @ step)
    expected = matrix + np.outer(change - matrix @ step, step) / (step @ step)
    secant = workshop.work[2:5]
    np.testing.assert_allclose(secant, expected, rtol=0, atol=1e-12)
    np.testing.assert_allclose(secant @ step, change, rtol=0, atol=1e-13)
    assert np.max(np.abs(secant - matrix)) > 1e-3


@pytest.mark.parametrize("away, restarts", [(0.02, 0), (0.9, 1)])
def test_broyden_follows_a_plain_implementation_with_restarts(away, restarts):
    """Iterate by iterate; the far start makes the residual fall by less than four, so that the method restarts."""
    problem, normal, start = duffing.duffing(), np.array([0.0, 0.0, 1.0]), UPPER + [away, -away, 0.0]
    workshop = Workshop(Broyden(), problem)
    y, (secant, residual), size, counted = start.copy(), workshop.system(start, normal), np.inf, 0
    for limit in range(1, 9):
        step = np.linalg.solve(secant, -np.append(residual, 0.0))
        y = y + step * problem.scale
        previous, (analytic, residual) = size, workshop.system(y, normal)
        size = np.max(np.abs(residual))
        if size > 0.25 * previous:
            secant, size, counted = analytic, np.inf, counted + 1
        else:
            secant = secant + np.outer(np.append(residual, 0.0), step) / (step @ step)
        np.testing.assert_allclose(workshop.correct(start, normal, 1e-300, limit)[1], y, rtol=0, atol=1e-9)
        if size < 1e-10:
            break
    assert (counted > 0) == bool(restarts)


@given(numbers(0.3, 1.2), numbers(0.0, 0.4), numbers(0.3, 1.9))
def test_both_correct_first_order_solutions_alike(f_pm, alpha, omega):
    model = MODELS["published"](f_pm=f_pm, alpha=alpha)
    row = sweep_row(model, "omega", [0.05, omega, 2.0])
    problem = first_order_problem(model, "omega", 0.05, 2.0)
    for s in range(row.n_solutions[1]):
        exact = np.array([row.mean[1, s], row.cos[1, s], row.sin[1, s], omega])
        for corrector in (Newton(), Broyden()):
            iterations, y = Workshop(corrector, problem).correct(exact + [1e-4, -1e-4, 1e-4, 0], [0, 0, 0, 1])
            assume(np.max(np.abs(y - exact)) < 1e-2)  # close to a fold the neighbour may be nearer
            assert iterations > 0
            np.testing.assert_allclose(y, exact, rtol=0, atol=1e-9)


PLACES = [("b", (0.1, 0.61, 1.5)), ("alpha", (0.0, 0.35, 0.8)), ("f_e", (0.0, 0.36, 0.5)), ("f_pm", (0.3, 0.58, 1.2))]


@pytest.mark.parametrize("parameter, values", PLACES)
def test_rows_do_not_depend_on_the_corrector(gear, parameter, values):
    _, model = gear
    for value in values:
        changed = model.replace(**{parameter: value})
        newton, broyden = (
            sweep_row(changed, "omega", GRID, continuation=Continuation(corrector=c)) for c in (Newton(), Broyden())
        )
        np.testing.assert_array_equal(newton.domain, broyden.domain)
        for name in ("n_solutions", "stable", "impact", "open"):
            np.testing.assert_array_equal(getattr(newton, name), getattr(broyden, name), err_msg=f"{parameter} {value}")
        for name in ("mean", "cos", "sin"):
            np.testing.assert_allclose(
                getattr(newton, name), getattr(broyden, name), rtol=0, atol=1e-8, err_msg=f"{name} {parameter} {value}"
            )
        assert [c.ends for c in newton.curves] == [c.ends for c in broyden.curves]


@pytest.mark.parametrize("kind", [Newton, Broyden])
def test_settings_out_of_range_are_refused(kind):
    for tolerance in (0.0, -1e-9, 1e-5, float("nan")):
        with pytest.raises(ParameterError, match=r"tolerance = .* 0 .* 1e-06"):
            kind(tolerance=tolerance)
    for limit in (1, 0, 101):
        with pytest.raises(ParameterError, match=f"max_iterations = {limit} .* from 2 to 100"):
            kind(max_iterations=limit)
    assert kind(tolerance=1e-6, max_iterations=2).tolerance == 1e-6
    assert kind() == kind() and hash(kind()) == hash(kind())
