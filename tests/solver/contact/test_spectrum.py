"""Contact arcs, spectra and extremes of a motion: against fine sampling, and at the places where sampling fails."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.contact import spectrum


def arcs(u, front, back):
    angles, zones = np.empty(2 * u.size + 8), np.empty(2 * u.size + 8, np.int64)
    count = spectrum.contact_arcs(u, front, back, angles, zones)
    return angles[:count], zones[: max(count, 1)]


def spectra(u, front, back, size):
    angles, zones = np.empty(2 * u.size + 8), np.empty(2 * u.size + 8, np.int64)
    count = spectrum.contact_arcs(u, front, back, angles, zones)
    contact, ahead, behind = np.empty((3, size), np.complex128)
    spectrum.contact_spectrum(count, angles, zones, contact, ahead, behind)
    return contact, ahead, behind


def extremes(u):
    return spectrum.extremes(u)


def sampled(u, angle):
    k = np.arange(1, u.size // 2 + 1)
    return u[0] + np.cos(np.outer(angle, k)) @ u[1::2] + np.sin(np.outer(angle, k)) @ u[2::2]


def motion(seed, order):
    draw = np.random.default_rng(seed)
    decay = np.repeat(np.arange(1, order + 1) ** draw.choice([0.5, 1.0, 2.0]), 2)
    return np.concatenate([draw.normal(size=1), draw.normal(size=2 * order) / decay]), draw.uniform(0.0, 1.5)


seeds, orders = st.integers(0, 10**6), st.sampled_from([1, 2, 5, 12, 40])


@given(seeds, orders, st.booleans())
def test_arcs_tell_the_zone_at_every_angle(seed, order, one_sided):
    u, gap = motion(seed, order)
    back = np.inf if one_sided else gap
    angles, zones = arcs(u, gap, back)
    assert np.all(np.diff(angles) >= 0.0) and np.all((angles >= 0.0) & (angles < 2.0 * np.pi))
    at = 2.0 * np.pi * (np.arange(4001) + 0.5) / 4001
    value = sampled(u, at)
    expected = np.where(value > gap, 1, np.where(value < -back, -1, 0))
    found = zones[np.searchsorted(angles, at, side="right") - 1] if angles.size else np.full(at.size, zones[0])
    # Where lambda lies on a flank to rounding either zone is right.
    clear = (np.abs(value - gap) > 1e-9) & (np.abs(value + back) > 1e-9)
    np.testing.assert_array_equal(found[clear], expected[clear])


@given(seeds, orders)
def test_crossings_lie_on_the_flanks(seed, order):
    u, gap = motion(seed, order)
    angles, _ = arcs(u, gap, gap)
    size = np.sum(np.hypot(u[1::2], u[2::2]) * np.arange(1, order + 1))
    np.testing.assert_allclose(np.abs(sampled(u, angles)), gap, rtol=0, atol=1e-13 * max(size, 1.0))


@given(seeds, orders)
def test_spectra_are_those_of_the_sampled_contact(seed, order):
    u, gap = motion(seed, order)
    angles, zones = arcs(u, gap, gap)
    contact, ahead, behind = spectra(u, gap, gap, 6)
    # Exact integrals over the arcs, by Gauss-Legendre quadrature.
    nodes, weights = np.polynomial.legendre.leggauss(40)
    begin, end = angles, np.append(angles[1:], angles[:1] + 2.0 * np.pi)
    if not angles.size:
        begin, end = np.zeros(1), np.full(1, 2.0 * np.pi)
    at = begin[:, None] + (nodes + 1.0) / 2.0 * (end - begin)[:, None]
    for m in range(6):
        parts = np.sum(weights * np.exp(-1j * m * at), axis=1) * (end - begin) / 2.0 / (2.0 * np.pi)
        assert abs(np.sum(parts[zones == 1]) - ahead[m]) < 1e-13
        assert abs(np.sum(parts[zones == -1]) - behind[m]) < 1e-13
    np.testing.assert_allclose(contact, ahead + behind, rtol=0, atol=1e-16)


@given(seeds, orders)
def test_extremes_bound_every_sample_and_are_taken(seed, order):
    u, _ = motion(seed, order)
    low, low_at, high, high_at = extremes(u)
    value = sampled(u, np.linspace(0.0, 2.0 * np.pi, 5000))
    assert low <= np.min(value) + 1e-12 and high >= np.max(value) - 1e-12
    np.testing.assert_allclose(sampled(u, np.array([low_at, high_at])), [low, high], rtol=0, atol=1e-12)


@pytest.mark.parametrize("depth", [1e-3, 1e-8, 1e-13, 0.0, -1e-8])
def test_a_short_touch_is_seen_as_long_as_it_matters(depth):
    # lambda = 1 - depth + cos(theta - 0.3) touches -back for a time of 2 sqrt(2 depth) at the bottom, theta = pi + 0.3.
    u = np.array([1.0 - depth, np.cos(0.3), np.sin(0.3)])
    _, _, behind = spectra(u, 5.0, 0.0, 1)
    expected = np.arccos(1.0 - depth) / np.pi if depth > 0.0 else 0.0
    assert behind[0].real == pytest.approx(expected, abs=1e-9)


def test_rest_and_level_motions():
    for value, zone in ((2.0, 1), (0.5, 0), (-2.0, -1)):
        angles, zones = arcs(np.array([value, 0.0, 0.0]), 1.0, 1.0)
        assert angles.size == 0 and zones.tolist() == [zone]
        assert extremes(np.array([value, 0.0, 0.0]))[::2] == (value, value)
