"""Describing functions of the dead zone against numerical quadrature, their derivatives and their regular points."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from solver.contact.dead_zone import dead_zone, describing_functions, force_and_gain
from tests.solver.independent import difference
from tests.solver.strategies import numbers

NODES, WEIGHTS = np.polynomial.legendre.leggauss(40)

means, amplitudes, gaps = numbers(-3.0, 3.0), numbers(0.0, 3.0), numbers(0.0, 2.0)


def quadrature(mean, amplitude, b):
    """Mean of f and its fundamental by Gauss-Legendre panels between the kinks, over half a period."""
    kinks = [np.arccos((level - mean) / amplitude) for level in (b, -b) if abs(level - mean) < amplitude]
    edges = np.unique([0.0, *kinks, np.pi])
    middle, half = (edges[1:] + edges[:-1]) / 2.0, (edges[1:] - edges[:-1]) / 2.0
    angle = middle[:, None] + half[:, None] * NODES
    force = dead_zone(mean + amplitude * np.cos(angle), b) * WEIGHTS * half[:, None]
    return force.sum() / np.pi, 2.0 * (force * np.cos(angle)).sum() / np.pi


def test_dead_zone_is_continuous_odd_and_has_slope_one_outside():
    x = np.linspace(-3.0, 3.0, 601)
    force = dead_zone(x, 0.7)
    np.testing.assert_array_equal(force, -dead_zone(-x, 0.7))
    np.testing.assert_array_equal(force[np.abs(x) <= 0.7], 0.0)
    np.testing.assert_allclose(force[x > 0.7], x[x > 0.7] - 0.7, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(dead_zone(x, 0.0), x)
    assert dead_zone(0.7, 0.7) == 0.0
    assert np.max(np.abs(np.diff(force))) <= 0.01 + 1e-12


@given(means, amplitudes, gaps)
def test_mean_and_fundamental_are_those_of_quadrature(mean, amplitude, b):
    force, gain, *_ = describing_functions(mean, amplitude, b)
    if amplitude == 0.0:
        assert force == pytest.approx(float(dead_zone(mean, b)), abs=1e-15)
        return
    expected, fundamental = quadrature(mean, amplitude, b)
    assert force == pytest.approx(expected, abs=1e-12)
    assert gain * amplitude == pytest.approx(fundamental, abs=1e-12)


@given(means, numbers(0.02, 3.0), gaps)
def test_derivatives_are_those_of_finite_differences(mean, amplitude, b):
    # Away from grazing, where second derivatives grow without bound.
    assume(min(abs(abs(b - mean) - amplitude), abs(abs(b + mean) - amplitude)) > 0.01)
    h = 1e-5
    _, _, *derivatives = describing_functions(mean, amplitude, b)
    state = np.array([mean, amplitude, b])
    for i, (force_slope, gain_slope) in enumerate(zip(derivatives[:3], derivatives[3:], strict=True)):
        unit = np.eye(3)[i]
        expected = difference(lambda x, unit=unit: describing_functions(*(state + x * unit))[:2], 0.0, h)
        assert force_slope == pytest.approx(expected[0], abs=1e-8)
        assert gain_slope == pytest.approx(amplitude * expected[1], abs=1e-8)


@given(means, amplitudes, gaps, numbers(0.1, 10.0))
def test_symmetry_and_scale(mean, amplitude, b, size):
    values = np.array(describing_functions(mean, amplitude, b))
    mirrored = np.array(describing_functions(-mean, amplitude, b))
    np.testing.assert_allclose(mirrored, values * [-1, 1, 1, -1, -1, -1, 1, 1], rtol=0, atol=1e-14)
    scaled = np.array(describing_functions(size * mean, size * amplitude, size * b))
    np.testing.assert_allclose(scaled, values * [size, 1, 1, 1, 1, 1, 1, 1], rtol=0, atol=1e-12 * max(1.0, size))
    force, gain, force_mean, _, _, gain_mean, gain_amplitude, gain_b = values
    # Euler's relations: f_0 is homogeneous of degree one, N_a of degree zero.
    degree_one = mean * force_mean + amplitude * values[3] + b * values[4]
    assert degree_one == pytest.approx(force, abs=1e-13)
    assert mean * gain_mean + amplitude * gain_amplitude + b * gain_b == pytest.approx(0.0, abs=1e-13)
    assert -1e-15 <= gain <= 1.0 + 1e-15 and -1e-15 <= force_mean <= 1.0 + 1e-15


@pytest.mark.parametrize("mean, gain", [(1.5, 1.0), (1.0, 0.5), (0.4, 0.0), (0.0, 0.0), (-1.0, 0.5), (-2.0, 1.0)])
def test_amplitude_zero_is_a_regular_point(mean, gain):
    values = describing_functions(mean, 0.0, 1.0)
    assert values[0] == pytest.approx(float(dead_zone(mean, 1.0)), abs=1e-15)
    assert values[1] == values[2] == gain
    assert values[3] == 0.0 and values[5:] == (0.0, 0.0, 0.0)
    near = describing_functions(mean, 1e-12, 1.0)
    np.testing.assert_allclose(near[:3], values[:3], rtol=0, atol=1e-11)
    # On the kink itself the derivatives by and of the amplitude have no limit, only bounds.
    if abs(mean) != 1.0:
        np.testing.assert_allclose(near, values, rtol=0, atol=1e-11)
    assert np.all(np.abs(near) <= 2.0)


@given(amplitudes, gaps)
def test_mean_zero_is_a_regular_point(amplitude, b):
    force, gain, force_mean, force_amplitude, force_b, gain_mean, *_ = describing_functions(0.0, amplitude, b)
    assert force == force_amplitude == force_b == gain_mean == 0.0
    assert 0.0 <= gain <= 1.0 and 0.0 <= force_mean <= 1.0


@given(means, amplitudes)
def test_no_gap_is_linear(mean, amplitude):
    force, gain, force_mean, force_amplitude, force_b, gain_mean, gain_amplitude, gain_b = describing_functions(
        mean, amplitude, 0.0
    )
    assert force == pytest.approx(mean, abs=1e-15)
    assert (force_amplitude, gain_mean, gain_amplitude) == (0.0, 0.0, 0.0)
    if mean != 0.0 or amplitude != 0.0:
        assert gain == pytest.approx(1.0, abs=1e-15) and force_mean == pytest.approx(1.0, abs=1e-15)
    assert -1.0 <= force_b <= 1.0 and -4.0 / np.pi - 1e-15 <= gain_b <= 0.0


def test_the_point_without_motion_and_without_gap_is_regular():
    values = describing_functions(0.0, 0.0, 0.0)
    assert values[:3] == (0.0, 1.0, 1.0)
    assert np.all(np.isfinite(values))


@given(st.sampled_from([1, -1]), numbers(0.0, 2.0), amplitudes, gaps)
def test_permanent_contact_is_linear_shifted_by_the_gap(side, margin, amplitude, b):
    mean = side * (b + amplitude + margin)
    values = describing_functions(mean, amplitude, b)
    if margin > 1e-9:
        np.testing.assert_allclose(values, [mean - side * b, 1, 1, 0, -side, 0, 0, 0], rtol=0, atol=1e-14)


@given(numbers(-1.0, 1.0), numbers(0.0, 1.0), gaps)
def test_motion_inside_the_gap_feels_nothing(mean, amplitude, b):
    mean, amplitude = mean * b * (1.0 - amplitude), 0.999 * amplitude * b
    if abs(mean) + amplitude < b:
        force, *others = describing_functions(mean, amplitude, b)
        assert abs(force) <= 1e-15 and others == [0.0] * 7


@given(means, numbers(0.1, 2.0))
def test_values_and_first_derivatives_pass_grazing_continuously(mean, b):
    for flank in (b, -b):
        amplitude = abs(flank - mean)
        if amplitude > 0.01:
            inside, outside = (np.array(describing_functions(mean, amplitude + e, b)) for e in (-1e-10, 1e-10))
            np.testing.assert_allclose(inside, outside, rtol=0, atol=1e-4)
            np.testing.assert_allclose(inside[:2], outside[:2], rtol=0, atol=1e-9)


@given(means, amplitudes, gaps)
def test_arrays_have_what_the_kernel_has_one_by_one(mean, amplitude, b):
    force, gain = force_and_gain([mean, 2.0 * mean], [amplitude, amplitude], b)
    for k, place in enumerate((mean, 2.0 * mean)):
        np.testing.assert_allclose(
            (force[k], gain[k]), describing_functions(place, amplitude, b)[:2], rtol=0, atol=1e-14
        )
