"""Cubics through points and slopes: where they meet a line, and how few of them a curve needs."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicHermiteSpline

from pipeline.plane.arcs import arcs_of, needed_points

#: Angles on a circle, not evenly.
ANGLE = np.sort(np.concatenate([np.linspace(0.0, 6.0, 400), np.linspace(1.0, 1.1, 100)]))


def circle(radius):
    """Points of a circle in the plane (x, p), slopes, and arc lengths."""
    points, slopes = np.zeros((2, ANGLE.size, 5))
    points[:, 3:] = radius * np.column_stack([np.cos(ANGLE), np.sin(ANGLE)])
    slopes[:, 3:] = np.column_stack([-np.sin(ANGLE), np.cos(ANGLE)])
    return points, slopes, radius * ANGLE


@given(st.floats(1e-9, 1e-2), st.integers(0, 498), st.tuples(st.floats(0.1, 10.0), st.floats(0.1, 10.0)))
def test_cubics_through_needed_points_pass_by_the_others(detail, cut, sizes):
    """Two curves one after the other, cut anywhere."""
    points, slopes, length = (part[:, 3:] if part.ndim == 2 else part for part in circle(1.0))
    allowed = detail * np.array(sizes)
    runs = np.array([[0, cut], [cut + 1, ANGLE.size - 1]])
    kept = needed_points(points, slopes, length, runs, allowed)
    for first, last in runs:
        here = first + np.flatnonzero(kept[first : last + 1])
        assert here[0] == first and here[-1] == last
        if here.size > 1:
            spline = CubicHermiteSpline(length[here], points[here], slopes[here])
            off = (spline(length[first : last + 1]) - points[first : last + 1]) / allowed
            assert np.linalg.norm(off, axis=1).max() <= 1.0 + 1e-6
    if detail > 1e-4:
        assert kept.sum() < 40


def test_a_corner_stays():
    """Two straight lines that meet in a doubled point."""
    points = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 0.0], [2.0, 1.0], [2.0, 2.0]])
    slopes = np.array([[1.0, 0.0]] * 3 + [[0.0, 1.0]] * 3)
    kept = needed_points(points, slopes, np.array([0.0, 1.0, 2.0, 2.0, 3.0, 4.0]), np.array([[0, 5]]), np.full(2, 1e-3))
    assert kept.tolist() == [True, False, True, True, False, True]


@pytest.mark.parametrize("axis", [3, 4])
@given(levels=st.lists(st.floats(-0.99, 0.99), max_size=5), numbers=st.lists(st.integers(0, 499), max_size=5))
def test_crossings_of_a_circle(axis, levels, numbers):
    """Also with lines through its own points, where the root is the end of an arc."""
    points, slopes, length = circle(1.0)
    values = np.unique([*levels, *points[numbers, axis]])
    met = arcs_of(points, slopes, length).crossings(axis, values)
    np.testing.assert_allclose(np.linalg.norm(met.points[:, 3:], axis=1), 1.0, atol=1e-8)
    np.testing.assert_array_equal(met.points[:, axis], values[met.line])
    angle = np.mod(np.arctan2(met.points[:, 4], met.points[:, 3]), 2.0 * np.pi)
    np.testing.assert_array_equal(np.sign(-np.sin(angle) if axis == 3 else np.cos(angle)), met.direction)
    exact = (np.arccos, np.arcsin)[axis - 3](values)
    for line, place in enumerate(exact):
        both = np.mod([place, -place if axis == 3 else np.pi - place], 2.0 * np.pi)
        inside = both[(both > 1e-6) & (both < 6.0 - 1e-6)]
        found = angle[(met.line == line) & (angle > 1e-6) & (angle < 6.0 - 1e-6)]
        np.testing.assert_allclose(np.sort(found), np.sort(inside), atol=1e-6)
