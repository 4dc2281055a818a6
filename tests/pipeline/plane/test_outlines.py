"""Regions as polygons: against the division's own areas and codes, and lines against the curves that they stand for."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.path import Path as Outline

from pipeline.plane.division import stored_division
from pipeline.plane.outlines import flattened, region_polygons, thinned
from pipeline.plane.stored import read_stored
from solver.regions.labelling import static_code
from tests.pipeline.planes import small_plan, traced_store

DETAIL = 1e-6


@pytest.fixture(scope="module")
def division(tmp_path_factory):
    path = tmp_path_factory.mktemp("outlines") / "plane.zarr"
    return stored_division(read_stored(traced_store(path, small_plan(columns=60, rows=16))))


def area(polygon):
    x, y = polygon.T
    return 0.5 * abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))


def label(code):
    return int(static_code(code))


@pytest.mark.parametrize("meaning", [int, label])
def test_polygons_have_the_areas_of_their_regions(division, meaning):
    polygons = region_polygons(division, DETAIL, meaning)
    whole, shares = np.ptp(division.plane.x_range) * np.ptp(division.plane.p_range), {}
    for code, share in division.shares().items():
        shares[meaning(code)] = shares.get(meaning(code), 0.0) + share
    assert polygons.keys() == shares.keys()
    found = {code: sum(map(area, parts)) / whole for code, parts in polygons.items()}
    assert sum(found.values()) == pytest.approx(1.0, abs=1e-12)
    for code, share in shares.items():
        assert found[code] == pytest.approx(share, abs=5 * DETAIL)


def test_places_lie_in_the_polygon_of_their_region_alone(division):
    polygons = {code: [Outline(part) for part in parts] for code, parts in region_polygons(division, DETAIL).items()}
    draw = np.random.default_rng(0)
    for p in draw.uniform(*division.plane.p_range, 12):
        x = np.sort(draw.uniform(*division.plane.x_range, 80))
        borders = np.concatenate([curve.crossings(np.array([p]))[1][:, 3] for curve in division.curves])
        x = x[np.min(np.abs(x[:, None] - borders), axis=1, initial=np.inf) > 1e-4]
        places = np.column_stack([x, np.full(x.size, p)])
        inside = np.array([sum(part.contains_points(places) for part in parts) for parts in polygons.values()])
        assert np.all(inside.sum(axis=0) == 1)
        np.testing.assert_array_equal(
            np.array(list(polygons))[inside.argmax(axis=0)], division.codes_at(x, np.array([p]))[0]
        )


def test_corners_are_no_further_from_boundaries_than_asked(division):
    spans = np.array([np.ptp(division.plane.x_range), np.ptp(division.plane.p_range)])
    middles, far = [], []
    for parts in region_polygons(division, 1e-4, label).values():
        for part in parts:
            ends = np.stack([part, np.roll(part, -1, axis=0)])
            along = np.abs(ends[1] - ends[0])
            # Borders of slabs and of the plane run along the axes.
            middles.append(ends.mean(axis=0)[np.all(along > 0.0, axis=1)])
    for x, p in np.concatenate(middles)[::7]:
        met = np.concatenate([curve.crossings(np.array([p]))[1][:, 3] for curve in division.curves])
        far.append(np.min(np.abs(met - x), initial=np.inf) / spans[0])
    # Along x, which is further than across the boundary; next to turning points no row meets it.
    assert np.quantile(far, 0.9) < 1e-4


numbers = st.floats(-5.0, 5.0, allow_subnormal=False)


@given(st.lists(st.tuples(numbers, numbers), min_size=4, max_size=13), st.floats(1e-4, 1.0))
def test_flattened_cubics_stay_within_what_is_allowed(corners, allowed):
    corners = np.array(corners[: (len(corners) - 1) // 3 * 3 + 1])
    controls = np.stack([corners[k : len(corners) - 3 + k : 3] for k in range(4)], axis=1)
    line = flattened(controls, np.array([allowed, allowed]))
    np.testing.assert_array_equal(line[[0, -1]], corners[[0, -1]])
    t = np.linspace(0.0, 1.0, 60)[:, None]
    for a, b, c, d in controls:
        exact = (1 - t) ** 3 * a + 3 * (1 - t) ** 2 * t * b + 3 * (1 - t) * t * t * c + t**3 * d
        # Once for chords, once for points that are left out.
        assert np.max(distances(exact, line)) <= 2.0 * allowed * (1.0 + 1e-9)


@given(st.lists(st.tuples(numbers, numbers), min_size=2, max_size=40), st.floats(1e-3, 2.0))
def test_points_that_are_left_out_are_near_to_the_line(points, allowed):
    line = np.array(points)
    kept = thinned(line, np.array([allowed, allowed]))
    assert np.max(distances(line, kept)) <= allowed * (1.0 + 1e-9)
    np.testing.assert_array_equal(kept[[0, -1]], line[[0, -1]])


def test_a_straight_line_is_its_ends():
    line = np.column_stack([np.linspace(0.0, 1.0, 9), np.linspace(2.0, 4.0, 9)])
    np.testing.assert_array_equal(thinned(line, (1e-9, 1e-9)), line[[0, -1]])


def distances(points, line):
    """Distance of points from a line of points."""
    start, along = line[:-1], np.diff(line, axis=0)
    away, size = points[:, None] - start, np.sum(along**2, axis=1)
    share = np.clip(np.sum(away * along, axis=2) / np.where(size > 0.0, size, 1.0), 0.0, 1.0)
    rest = away - share[..., None] * along
    return np.min(np.hypot(rest[..., 0], rest[..., 1]), axis=1)
