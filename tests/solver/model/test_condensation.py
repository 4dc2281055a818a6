"""Exact condensation: against the Schur complement of the 7 x 7 dynamic stiffness, and its derivatives."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solver import GEOMETRIC, ParameterError
from solver.model.condensation import mesh_receptance, rotation_coupling
from solver.model.packing import AXES, axis_vectors, parameter_vector
from tests.conftest import consistent, published
from tests.solver.independent import difference
from tests.solver.strategies import frequencies, models, value_on


def receptance(theta, direction, p, harmonic):
    """`mesh_receptance` at a harmonic of the frequency in theta."""
    s, d_s = 1j * harmonic * (theta[0] + p * direction[0]), 1j * harmonic * direction[0]
    return mesh_receptance(theta, direction, p, s, d_s)


def schur(model, omega):
    """T and U of docs/physics.md, section 3, by eliminating the translations from K - omega^2 M + i omega C."""
    mass, damping, stiffness = model.matrices()
    translation, rotation = model.mesh_vectors()
    dynamic = stiffness - omega**2 * mass + 1j * omega * damping
    across = np.linalg.solve(dynamic[:6, :6].T, dynamic[6, :6])
    row = dynamic[6, 6] - across @ dynamic[:6, 6]
    damping_term = (row + omega**2) / (2j * omega)
    assert rotation[6] == model.rotation
    return across @ translation[:6], model.rotation * model.xi_mesh - damping_term


@given(models(), frequencies, st.sampled_from([1, 2, 3]))
def test_mesh_receptance_is_the_schur_complement(model, omega, harmonic):
    T, U, *_ = receptance(*axis_vectors(model, "omega"), omega, harmonic)
    expected_T, expected_U = schur(model, harmonic * omega)
    assert abs(T - expected_T) < 1e-11 * max(1.0, abs(expected_T))
    assert abs(U - expected_U) < 1e-11 * max(1.0, abs(expected_U))


def test_mesh_receptance_of_the_published_pair():
    # 2 sigma omega^2 (kappa, xi_hg)/Z with all supports alike.
    omega = 0.7
    T, U, *_ = receptance(*axis_vectors(published(), "omega"), omega, 1)
    factor = 2.0 * 0.3173 * omega**2 / (1.0 - omega**2 + 0.02j * omega)
    assert pytest.approx(0.5 * factor, abs=1e-15) == T and pytest.approx(0.0125 * factor, abs=1e-15) == U


@pytest.mark.parametrize("axis", AXES)
@settings(max_examples=25)
@given(model=models(), omega=frequencies, harmonic=st.sampled_from([1.0, 2.0]))
def test_derivatives_along_every_axis(axis, model, omega, harmonic):
    theta, direction = axis_vectors(model, axis, omega)
    p = value_on(model, axis)

    def values(x):
        return [*receptance(theta, direction, x, harmonic)[:2], rotation_coupling(theta, direction, x)[0]]

    T, U, d_T, d_U = receptance(theta, direction, p, harmonic)
    found = np.array([d_T, d_U, rotation_coupling(theta, direction, p)[1]])
    expected = difference(values, p, 1e-4 if axis in ("xi_support", "omega", "k_support") else 1e-3)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-7 * max(1.0, *np.abs(expected), abs(T), abs(U)))
    if axis in ("omega", "k_support", "xi_support") and model.sigma > 0.0:
        assert abs(d_T) > 0.0


@given(models(), st.complex_numbers(min_magnitude=0.1, max_magnitude=3.0))
def test_mesh_receptance_is_analytic_in_the_complex_frequency(model, s):
    theta, _ = axis_vectors(model, "omega")
    still = np.zeros_like(theta)
    values = [np.array(mesh_receptance(theta, still, 0.5, s + step, 1.0)) for step in (0.0, 1e-5, -1e-5, 1e-5j, -1e-5j)]
    near = min(abs(k + 2.0 * xi * s + s * s) for k, xi in zip(model.k_support, model.xi_support, strict=True))
    for forward, backward, step in ((values[1], values[2], 2e-5), (values[3], values[4], 2e-5j)):
        expected = (forward - backward)[:2] / step
        np.testing.assert_allclose(values[0][2:], expected, rtol=0, atol=1e-6 * max(1.0, near**-4))


@pytest.mark.parametrize("axis", AXES)
@settings(max_examples=25)
@given(model=models(), omega=frequencies)
def test_an_axis_value_means_the_model_with_that_value(axis, model, omega):
    p = value_on(model, axis)
    theta, direction = axis_vectors(model, axis, omega)
    expected = parameter_vector(model, p) if axis == "omega" else parameter_vector(model.replace(**{axis: p}), omega)
    np.testing.assert_allclose(theta + p * direction, expected, rtol=0, atol=1e-15)


def test_the_model_s_own_value_of_the_axis_does_not_matter():
    for axis, value in [("b", 0.3), ("kappa", 0.9), ("rotation_coupling", GEOMETRIC), ("translation_coupling", 0.1)]:
        here, there = axis_vectors(published(), axis, 0.5), axis_vectors(published(**{axis: value}), axis, 0.5)
        np.testing.assert_array_equal(here, there)


def test_the_pressure_angle_moves_geometric_couplings_only():
    for model, moves in ((consistent(), True), (published(), False)):
        theta, direction = axis_vectors(model, "pressure_angle", 0.5)
        low, high = (rotation_coupling(theta, direction, p) for p in (15.0, 25.0))
        assert (low[0] != high[0]) is moves and (low[1] != 0.0) is moves
        assert low[0] == pytest.approx(np.cos(np.radians(15.0)) ** 2 if moves else 0.7719, abs=1e-15)


@given(models(), frequencies)
def test_harmonics_beyond_the_second_of_the_stiffness_are_not_read(model, omega):
    second = model.alpha_harmonics[:1] or ((0.1, 0.2),)
    longer, shorter = (model.replace(alpha_harmonics=(*second, *more)) for more in ([(0.3, 1.0)], []))
    np.testing.assert_array_equal(parameter_vector(longer, omega), parameter_vector(shorter, omega))


def test_an_unknown_axis_is_refused():
    with pytest.raises(ParameterError, match="axis = 'backlash' is not allowed: it must be one of omega, b, alpha"):
        axis_vectors(published(), "backlash", 0.5)
    assert len(AXES) == len(set(AXES)) == 19
