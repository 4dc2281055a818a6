"""Amplitudes by order: sums of cosines that are known, Parseval, half orders, and what the window is for."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solver.timedomain import order_spectrum


def places(count: int, periods: float) -> np.ndarray:
    """Phases of the mesh frequency at so many even places of a record."""
    return 2.0 * np.pi * periods * np.arange(count) / count


@pytest.mark.parametrize("window", [None, "hann"])
@pytest.mark.parametrize("count", [256, 257])
def test_amplitudes_of_known_cosines_are_told_at_their_orders(window, count):
    phase, lines = places(count, 8), {0.5: 0.3, 1.0: 1.7, 2.5: 0.02, 6.0: 1e-6}
    samples = -0.4 + sum(a * np.cos(order * phase + 0.9 * order) for order, a in lines.items())
    orders, amplitudes = order_spectrum(samples, 8, window)
    np.testing.assert_allclose(orders, np.arange(count // 2 + 1) / 8)
    assert amplitudes[0] == pytest.approx(-0.4, abs=1e-14)
    for order, a in lines.items():
        assert amplitudes[orders == order] == pytest.approx([a], rel=1e-9, abs=1e-15)
    if window is None:
        others = ~np.isin(orders, [0.0, *lines])
        assert np.max(np.abs(amplitudes[others])) < 1e-14


@settings(max_examples=50, deadline=None)
@given(
    samples=st.lists(st.floats(-1e3, 1e3), min_size=2, max_size=65),
    periods=st.integers(1, 9),
    factor=st.floats(-3.0, 3.0),
)
def test_parseval_and_linearity(samples, periods, factor):
    samples = np.array(samples)
    orders, amplitudes = order_spectrum(samples, periods)
    squares = 0.5 * amplitudes**2
    squares[0] *= 2.0
    if samples.size % 2 == 0:
        squares[-1] *= 2.0
    assert orders[1] == 1.0 / periods
    assert squares.sum() == pytest.approx(np.mean(samples**2), rel=1e-9, abs=1e-9)
    scaled = order_spectrum(factor * samples, periods)[1]
    np.testing.assert_allclose(np.abs(scaled), abs(factor) * np.abs(amplitudes), rtol=1e-9, atol=1e-9)


def test_rows_of_samples_are_as_one_by_one():
    samples = np.random.default_rng(3).normal(size=(3, 2, 64))
    for window in (None, "hann"):
        both = order_spectrum(samples, 4, window)[1]
        for i in np.ndindex(3, 2):
            np.testing.assert_array_equal(both[i], order_spectrum(samples[i], 4, window)[1])


def test_the_window_keeps_what_does_not_repeat_in_its_place():
    # An order between two bins: without a window it is seen everywhere, with one nowhere but near itself.
    samples = 2.0 + np.cos(1.31 * places(4096, 64))
    found = {window: order_spectrum(samples, 64, window) for window in (None, "hann")}
    orders = found[None][0]
    far = (np.abs(orders - 1.31) > 1.0) & (orders > 0.0)
    assert np.max(found[None][1][far]) > 1e-3
    assert np.max(found["hann"][1][far]) < 1e-5
    # The largest line is too low by at most 1.42 dB (Harris 1978, Table I).
    largest = np.argmax(found["hann"][1][1:]) + 1
    assert abs(orders[largest] - 1.31) <= 0.5 / 64
    assert 10.0 ** (-1.43 / 20.0) <= found["hann"][1][largest] <= 1.0 + 1e-3
    assert found["hann"][1][0] == pytest.approx(2.0, abs=1e-3)


def test_a_motion_of_two_periods_has_half_orders_and_one_of_one_period_has_none():
    phase = places(128, 2)
    double = order_spectrum(np.cos(phase) + 0.2 * np.cos(1.5 * phase), 2)
    single = order_spectrum(np.cos(phase) + 0.2 * np.cos(2.0 * phase), 2)
    half = double[0] % 1.0 == 0.5
    assert np.max(double[1][half]) == pytest.approx(0.2) and np.max(np.abs(single[1][half])) < 1e-14
