"""Parts of a design answer without a store: boxes between straight boundaries, divided lines, severity of labels."""

import dataclasses
import doctest

import numpy as np
import pytest
from hypothesis import Phase, example, given, settings
from hypothesis import strategies as st

import pipeline.analysis.margins.worst
from pipeline.analysis.margins import Design
from pipeline.analysis.margins.box import largest_box
from pipeline.analysis.margins.curves import Boundaries
from pipeline.analysis.margins.lines import divided
from pipeline.analysis.margins.worst import severity
from pipeline.plane.arcs import Arcs
from solver import Event
from tests.pipeline.planes import small_plan

unit = st.floats(0.0, 1.0).map(lambda value: round(value, 3))


@settings(max_examples=4, phases=(Phase.explicit, Phase.generate))
@example([(0.0, 0.5, 1.0, 0.0), (1.0, 0.562, 0.0, 1.0)])
@example([(0.3, 0.6, 0.32, 0.65), (0.7, 0.4, 0.72, 0.45)])
@given(st.lists(st.tuples(unit, unit, unit, unit), min_size=1, max_size=6))
def test_boxes_between_straight_boundaries(ends):
    """The plane and boundaries made up: no boundary inside, and none larger among the rectangles of a grid."""
    segments = np.array([end for end in ends if np.hypot(end[0] - end[2], end[1] - end[3]) > 0.01]).reshape(-1, 4)
    t = np.linspace(0.0, 1.0, 2001)[:, None, None]
    points = ((1.0 - t) * segments[None, :, :2] + t * segments[None, :, 2:]).reshape(-1, 2)
    if len(segments) == 0 or np.min(np.max(np.abs(points - 0.5), axis=1)) < 0.01:
        return
    made = small_plan("plane.sweep.min=1", "plane.sweep.max=2")
    made = dataclasses.replace(
        made,
        sweep=dataclasses.replace(made.sweep, low=0.0, high=1.0),
        parameter=dataclasses.replace(made.parameter, low=0.0, high=1.0),
    )
    start, end = (np.pad(part, ((0, 0), (3, 0))) for part in (segments[:, :2], segments[:, 2:]))
    arcs = Arcs(start, end, end - start, end - start)
    box = largest_box(Boundaries(arcs, np.ones(len(segments), int)), made, Design(0.5, 0.5, 0.5, 0.5))
    (left, right), (low, high) = box.x, box.p
    inner = (points > [left + 1e-7, low + 1e-7]) & (points < [right - 1e-7, high - 1e-7])
    assert not np.any(inner.all(axis=1))
    assert box.area == pytest.approx((right - left) * (high - low), rel=1e-12)
    grid = np.linspace(0.0, 0.5, 13)
    for down in grid:
        rows = points[(points[:, 1] > 0.5 - down) & (points[:, 1] <= 0.5)]
        for up in grid:
            part = np.concatenate([rows, points[(points[:, 1] > 0.5) & (points[:, 1] < 0.5 + up)]])
            if np.any(part[:, 0] == 0.5):
                continue
            width = np.min(part[part[:, 0] > 0.5, 0], initial=1.0) - np.max(part[part[:, 0] < 0.5, 0], initial=0.0)
            # Between two points of a segment there is up to 1/2000 of it, to either side.
            assert width * (down + up) <= box.area + 2e-3


slope = st.floats(-6.0, 6.0).map(lambda value: round(value, 2))


@given(st.tuples(unit, unit, unit, unit), st.tuples(slope, slope, slope, slope))
def test_between_marked_places_an_arc_is_monotonic(ends, slopes):
    """An arc never goes beyond what is marked of it, in x or in p, and its turns are where its samples turn."""
    corners = [np.array([[0.0, 0.0, 0.0, *pair]]) for pair in (ends[:2], ends[2:], slopes[:2], slopes[2:])]
    boundaries = Boundaries(Arcs(*corners), np.array([Event.FOLD]))
    places, kinds = boundaries.marked
    assert len(places) == len(kinds) and set(kinds) == {Event.FOLD}
    t = np.linspace(0.0, 1.0, 2001)
    samples = boundaries.arcs.at(np.zeros(t.size, int), t)[:, 3:]
    for axis in (0, 1):
        assert np.min(places[:, axis]) <= np.min(samples[:, axis]) + 1e-12
        assert np.max(places[:, axis]) >= np.max(samples[:, axis]) - 1e-12
        rising = np.diff(samples[:, axis]) > 0.0
        seen = t[1:-1][rising[1:] != rising[:-1]] if np.ptp(samples[:, axis]) > 1e-6 else []
        turns = boundaries.arcs.turns(3 + axis)
        assert all(np.min(np.abs(turns - place)) < 1e-3 for place in seen)


def test_severity():
    assert doctest.testmod(pipeline.analysis.margins.worst).failed == 0
    assert severity("1/2") > severity("3/0-1") > severity("2/0-1") > severity("1/1") > severity("2/0") > severity("1/0")


def test_lines_find_what_no_boundary_says():
    """A label that changes without a stored boundary, and a stretch too narrow to be told."""

    def codes(places):
        return np.where(np.abs(np.asarray(places) - 0.5) < 1e-5, 0, np.where(np.asarray(places) > 0.8, 131, 66))

    line = divided(np.array([0.3, 0.5 + 1e-6, 0.5 - 1e-6]), np.array([1, 2, 1]), (0.0, 1.0), codes)
    assert [one.code for one in line.stretches] == [66, 131] and line.kinds == (Event.NONE,)
    assert line.stretches[0].high == pytest.approx(0.8, abs=1e-9) and line.beyond(0.5, False) is None
    bare = divided(np.array([0.3, 0.6]), np.array([1, 2]), (0.0, 1.0), None)
    assert bare.kinds == (Event.FOLD, Event.MIN_AT_DRIVE) and bare.beyond(0.5, False) == (0.3, Event.FOLD, 0)
