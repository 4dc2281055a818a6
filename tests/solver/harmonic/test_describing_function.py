"""The condensed first-order balance: residual against quadrature, Jacobian and monitor against finite differences."""

import numpy as np
import pytest
from hypothesis import assume, given, settings

from solver import first_order_problem
from solver.harmonic import describing_function
from solver.harmonic.condensed import coefficients
from solver.harmonic.describing_function import evaluate, linear_solution
from solver.model.packing import AXES, axis_vectors
from tests.conftest import published
from tests.solver.independent import difference, linear_response, projected_balance
from tests.solver.strategies import frequencies, models, motions, value_on


def residual_and_jacobian(theta, direction, y):
    residual, jacobian = np.empty(3), np.empty((3, 4))
    describing_function.residual_and_jacobian(theta, direction, np.array(y, dtype=float), residual, jacobian)
    return residual, jacobian


def observed(theta, direction, y):
    values, gradient = np.empty(5), np.empty((5, 4))
    describing_function.test_functions(theta, direction, np.array(y, dtype=float), values, gradient)
    return values, gradient


def away_from_kinks(unknowns, b):
    """Second derivatives grow without bound at grazing, first ones jump where amplitude is 0."""
    amplitude = np.hypot(unknowns[1], unknowns[2])
    return amplitude > 0.1 and min(abs(abs(s * b - unknowns[0]) - amplitude) for s in (1, -1)) > 0.02


@given(models(), frequencies, motions)
def test_residual_is_the_projection_of_the_equation_of_motion(model, omega, unknowns):
    residual, _ = evaluate(model, omega, unknowns)
    expected = projected_balance(model, omega, unknowns)
    np.testing.assert_allclose(residual, expected, rtol=0, atol=5e-7 * max(1.0, np.max(np.abs(expected))))


def test_residual_with_every_term_present_to_many_digits():
    model = published(
        alpha=0.4,
        alpha_phase=0.7,
        alpha_harmonics=[[0.25, -0.9], [0.2, 0.4]],
        variation_rotation=0.6,
        variation_translation=0.8,
        f_pv=0.15,
        f_e_phase=1.1,
        f_e_harmonics=[[0.1, 0.2]],
        kappa=[0.4, 0.7],
        xi_support=[0.01, 0.02, 0.03, 0.04, 0.05, 0.06],
        k_support=[1.0, 0.8, 1.2, 2.0, 0.5, 1.5],
    )
    for unknowns in ([0.9, 0.8, -0.7], [1.6, 0.2, 0.1], [-0.5, 1.0, 2.0]):
        residual, _ = evaluate(model, 0.77, unknowns)
        np.testing.assert_allclose(residual, projected_balance(model, 0.77, unknowns, 2**20), rtol=0, atol=1e-10)


@pytest.mark.parametrize("field", ["alpha_harmonics", "alpha_phase", "f_pv", "f_e_phase", "xi_mesh", "xi_translation"])
def test_the_residual_feels(field):
    changes = {"alpha_harmonics": [[0.25, -0.9]]}.get(field, 0.1)
    here, there = (evaluate(model, 0.77, [0.9, 0.8, -0.7])[0] for model in (published(), published(**{field: changes})))
    assert np.max(np.abs(here - there)) > 1e-3


@pytest.mark.parametrize("axis", AXES)
@settings(max_examples=25)
@given(model=models(), omega=frequencies, unknowns=motions)
def test_jacobian_of_all_columns_along_every_axis(axis, model, omega, unknowns):
    theta, direction = axis_vectors(model, axis, omega)
    y = np.append(unknowns, value_on(model, axis))
    assume(away_from_kinks(unknowns, theta[1] + y[3] * direction[1]))
    _, jacobian = residual_and_jacobian(theta, direction, y)
    for column in range(4):
        expected = difference(
            lambda x, column=column: residual_and_jacobian(theta, direction, y + x * np.eye(4)[column])[0], 0.0, 1e-4
        )
        scale = max(1.0, np.max(np.abs(expected)))
        np.testing.assert_allclose(jacobian[:, column], expected, rtol=0, atol=2e-7 * scale, err_msg=f"column {column}")


@pytest.mark.parametrize("axis", AXES)
@settings(max_examples=25)
@given(model=models(), omega=frequencies, unknowns=motions)
def test_an_axis_value_gives_the_residual_of_the_model_with_that_value(axis, model, omega, unknowns):
    p = value_on(model, axis)
    residual, jacobian = residual_and_jacobian(*axis_vectors(model, axis, omega), np.append(unknowns, p))
    changed, frequency = (model, p) if axis == "omega" else (model.replace(**{axis: p}), omega)
    expected, expected_jacobian = evaluate(changed, frequency, unknowns)
    size = max(1.0, np.max(np.abs(expected_jacobian)))
    np.testing.assert_allclose(residual, expected, rtol=0, atol=1e-12 * size)
    np.testing.assert_allclose(jacobian[:, :3], expected_jacobian, rtol=0, atol=1e-12 * size)


@given(models(), frequencies)
def test_derivatives_of_the_coefficients_along_frequency(model, omega):
    vectors = axis_vectors(model, "omega")
    values, slopes, constants, constant_slopes = coefficients(*vectors, omega)
    expected = difference(lambda x: coefficients(*vectors, x)[0], omega, 1e-4)
    np.testing.assert_allclose(slopes, expected, rtol=0, atol=1e-7 * max(1.0, *np.abs(expected), *np.abs(values)))
    assert constants == (model.rotation, model.f_pm, model.b, model.b, 0.0, 1.0)
    assert constant_slopes == (0.0,) * 6


@given(models(), frequencies, motions)
def test_amplitude_zero_is_a_regular_point(model, omega, unknowns):
    at_rest = np.array([unknowns[0], 0.0, 0.0])
    residual, jacobian = evaluate(model, omega, at_rest)
    assert np.all(np.isfinite(residual)) and np.all(np.isfinite(jacobian))
    if abs(abs(unknowns[0]) - model.b) > 0.01:
        for column in range(3):
            expected = difference(lambda x, c=column: evaluate(model, omega, at_rest + x * np.eye(3)[c])[0], 0.0, 1e-4)
            np.testing.assert_allclose(jacobian[:, column], expected, rtol=0, atol=1e-8)


@pytest.mark.parametrize("axis", ["omega", "b", "f_e"])
@given(model=models(), unknowns=motions)
def test_monitor_and_its_gradient(axis, model, unknowns):
    theta, direction = axis_vectors(model, axis, 0.7)
    y = np.append(unknowns, value_on(model, axis))
    b = y[3] if axis == "b" else model.b
    values, gradient = observed(theta, direction, y)
    motion = unknowns[0] + unknowns[1] * np.cos(t := np.linspace(0, 2 * np.pi, 20001)) + unknowns[2] * np.sin(t)
    lowest, highest = motion.min(), motion.max()
    expected = [0.5 * (highest - lowest), lowest - b, lowest + b, highest - b, highest + b]
    np.testing.assert_allclose(values, expected, rtol=0, atol=1e-7)
    assume(np.hypot(unknowns[1], unknowns[2]) > 0.1)
    for column in range(4):
        slope = difference(lambda x, c=column: observed(theta, direction, y + x * np.eye(4)[c])[0], 0.0, 1e-3)
        np.testing.assert_allclose(gradient[:, column], slope, rtol=0, atol=1e-7)


def test_monitor_at_amplitude_zero_is_finite():
    values, gradient = observed(*axis_vectors(published(), "omega"), [1.5, 0.0, 0.0, 0.7])
    assert list(values) == [0.0, 0.5, 2.5, 0.5, 2.5] and np.all(np.isfinite(gradient))


@given(models(), frequencies)
def test_linear_solution_and_its_determinant(model, omega):
    unknowns = np.empty(3)
    determinant = linear_solution(*axis_vectors(model, "omega"), omega, unknowns)
    matrix = evaluate(model.replace(b=0.0), omega, [0.5, 0.1, 0.2])[1]
    assume(np.linalg.cond(matrix) < 1e6)
    expected, expected_determinant = linear_response(model, omega)
    np.testing.assert_allclose(unknowns, expected, rtol=1e-8, atol=1e-8)
    assert determinant == pytest.approx(expected_determinant, rel=1e-8)


def test_signs_of_the_rows_make_a_linear_pair_without_variation_stable():
    # docs/physics.md, section 5: det J <= 0 is unstable for the rows (mean, Re E_1, -Im E_1).
    for omega in (0.1, 0.59, 1.0, 1.226, 3.0):
        assert np.linalg.det(evaluate(published(alpha=0.0, b=0.0), omega, [0.6, 0.0, 0.0])[1]) > 0.0


def test_the_middle_one_of_three_solutions_is_unstable():
    solutions = {0.40040130: 1.6477523, 1.29089291: 1.42808129, 1.79064815: 1.15146214}
    signs = []
    for amplitude, mean in solutions.items():
        angles = np.linspace(0.0, 2.0 * np.pi, 721)
        for _ in range(3):
            states = [(mean, amplitude * np.cos(angle), amplitude * np.sin(angle)) for angle in angles]
            sizes = [np.linalg.norm(evaluate(published(), 0.6, state)[0]) for state in states]
            best = int(np.argmin(sizes))
            angles = angles[best] + np.linspace(-1.0, 1.0, 21) * (angles[1] - angles[0])
        assert sizes[best] < 1e-5
        signs.append(np.sign(np.linalg.det(evaluate(published(), 0.6, states[best])[1])))
    assert signs == [1.0, -1.0, 1.0]


@given(models())
def test_scales_are_positive_and_homogeneous(model):
    size = model.motion_size
    assert size > 0.0
    larger = model.replace(b=3 * model.b, f_pm=3 * model.f_pm, f_pv=3 * model.f_pv, f_e=3 * model.f_e)
    if any((model.b, model.f_pm, model.f_pv, model.f_e)):
        assert larger.motion_size == pytest.approx(3.0 * size, rel=1e-14)
    problem = first_order_problem(model, "omega", 0.2, 1.2)
    np.testing.assert_allclose(problem.scale, [size, size, size, 0.1], rtol=1e-14)
    assert problem.unknowns == 3 and problem.test_count == 5


def test_a_pair_without_load_and_gap_has_a_scale():
    assert published(b=0.0, f_pm=0.0, f_e=0.0).motion_size == 1.0
