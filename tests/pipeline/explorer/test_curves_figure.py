"""Branches of a row as a Bokeh figure, against what was computed; the same figure shows row after row."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.config.quantities import QUANTITIES
from pipeline.explorer.map_frame import frame_of_map
from pipeline.figures.curves import LINES, MARKS
from pipeline.figures.palette import hex_colour, state_colour
from pipeline.plane.row_curves import curves_at
from pipeline.plane.stored import read_stored
from solver import Event, ImpactState
from tests.pipeline.planes import small_plan, small_store

pytest.importorskip("bokeh", reason="the extra explore is not installed")

from pipeline.explorer.curves_figure import curves_figure, fill_curves
from pipeline.explorer.plain_figure import source_of


@pytest.fixture(scope="module")
def plane(tmp_path_factory):
    plan = small_plan("gear=miter")
    return read_stored(small_store(tmp_path_factory.mktemp("rows") / "plane.zarr", plan), physical=True)


@pytest.fixture(scope="module")
def row(plane):
    return curves_at(plane, 0.5 * (plane.rows[-2] + plane.rows[-1]))


@pytest.mark.parametrize("quantity", ["amplitude", "dynamic_factor", "mean"])
@pytest.mark.parametrize("physical", [False, True])
def test_branches_have_their_values_colours_and_dashes(plane, row, quantity, physical):
    frame, found = frame_of_map(plane, physical), curves_figure()
    entries = fill_curves(found, [row], frame.x, quantity=quantity, scales=frame.scales)
    data = source_of(found, "branches").data
    scale = frame.scales[QUANTITIES[quantity].scale].shown if physical and QUANTITIES[quantity].scale else 1.0
    # Every segment is a part of the line of its kind, between gaps.
    drawn = {}
    for state, standing, colour, dash, *line in zip(
        *(data[name] for name in ("state", "standing", "colour", "dash", "xs", "ys")), strict=True
    ):
        points = np.column_stack(line)
        drawn[state, standing] = np.split(points, np.flatnonzero(np.isnan(points[:, 1])))
        assert dash == "" if standing == LINES[True, True][0] else dash
        assert colour == hex_colour(state_colour(state[4 : state.index(":")]))
    for segment, lasts in zip(row.segments, row.lasting.tolist(), strict=True):
        symbol = ImpactState(segment.impact).symbol
        (kind,) = (one for one in drawn if one[0][4:].startswith(symbol) and one[1] == LINES[segment.stable, lasts][0])
        part = drawn[kind].pop(0)
        part = part[np.isfinite(part[:, 0])]
        np.testing.assert_allclose(part[:, 0], row.points["position"][segment.slice] * frame.x.size, rtol=1e-6)
        np.testing.assert_allclose(part[:, 1], row.values(quantity)[segment.slice] * scale, rtol=1e-6)
    assert not any(drawn.values()) and len({standing for _, standing in drawn}) >= 2
    events = source_of(found, "events").data
    folds = np.array(events["x"])[np.array(events["marker"]) == "circle"]
    np.testing.assert_allclose(folds, row.points["position"][row.points["event"] == Event.FOLD] * frame.x.size)
    texts = [text for _, text, _ in entries]
    assert len(texts) == len(set(texts)) == len(drawn) + len(set(texts) & set(MARKS)) and "fold" in texts
    # As in the figures on paper: stable lines of a state first, marks in their own order.
    standings = [words for words, _ in LINES.values()]
    order = [(text.partition(",")[0], standings.index(text.partition(", ")[2])) for text in texts if text not in MARKS]
    assert order == sorted(order) and texts[len(order) :] == [name for name in MARKS if name in texts]
    stable = row.values(quantity)[row.points["stable"] == 1] * scale
    assert found.y_range.start <= stable.min() and found.y_range.end >= stable.max()


def test_a_figure_that_is_filled_again_is_as_one_that_is_new(plane, row):
    used, new, frame = curves_figure(), curves_figure(), frame_of_map(plane, True)
    fill_curves(used, [curves_at(plane, float(plane.rows[0]))], frame_of_map(plane, False).x, quantity="mean")
    models = used.references()
    entries = [fill_curves(one, [row], frame.x, scales=frame.scales) for one in (used, new)]
    assert entries[0] == entries[1] and used.references() == models
    for name in ("branches", "events"):
        np.testing.assert_equal(*(source_of(one, name).data for one in (used, new)))
    for axis in ("x_range", "y_range"):
        ends = [(r.start, r.end, r.reset_start, r.reset_end) for r in (getattr(used, axis), getattr(new, axis))]
        assert ends[0] == ends[1]
    assert used.yaxis.axis_label == new.yaxis.axis_label and used.hover.tooltips == new.hover.tooltips


def test_a_row_that_failed_is_an_empty_figure(plane, row):
    none = replace(row, points={name: array[:0] for name, array in row.points.items()})
    found = curves_figure()
    assert fill_curves(found, [none], frame_of_map(plane, False).x) == []
    assert source_of(found, "branches").data["xs"] == []
