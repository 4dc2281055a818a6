"""Motions at a place as Bokeh figures, against what was computed."""

import numpy as np
import pytest

from pipeline.analysis.motion.motions import motions_at
from pipeline.config.compose import compose
from pipeline.figures.motion_axes import units_of
from pipeline.plane.stored import read_stored
from tests.pipeline.planes import small_plan, small_store

pytest.importorskip("bokeh", reason="the extra explore is not installed")

from bokeh.models import Span

from pipeline.explorer.motion_figures import MOTION_FIGURES, fill_motions, motion_figures
from pipeline.explorer.plain_figure import source_of


@pytest.fixture(scope="module")
def plane(tmp_path_factory):
    plan = small_plan("gear=miter")
    return read_stored(small_store(tmp_path_factory.mktemp("rows") / "plane.zarr", plan), physical=True)


@pytest.fixture(scope="module")
def found(plane):
    return motions_at(plane.plan, 1.2, float(plane.rows[3]), compose([]).config.attractors)


def test_motions_are_drawn_as_they_were_found(plane, found):
    cards, units, drawn = [*found.attractors, *found.others], units_of(plane, found), motion_figures()
    entries = fill_motions(drawn, cards, found, units)
    assert tuple(drawn) == MOTION_FIGURES and drawn["force"].x_range is drawn["time"].x_range
    assert drawn["time"].xaxis.axis_label.startswith("time (ms)") and "µm" in drawn["phase"].xaxis.axis_label
    assert len(entries) == len(cards) and all(
        card.label in text for card, (_, text, _) in zip(cards, entries, strict=True)
    )
    in_time, paths, lines = (source_of(drawn[name], "motions").data for name in ("time", "phase", "spectrum"))
    assert source_of(drawn["force"], "motions").data is in_time
    for number, card in enumerate(cards):
        # Of a motion that does not repeat the first periods are shown.
        shown = slice(len(in_time["time"][number]) if card.curves.repeats is None else None)
        for name, values, unit in (
            ("displacement", card.curves.displacement, units.length),
            ("force", card.curves.force, units.force),
        ):
            np.testing.assert_allclose(np.max(in_time[name][number]), values[shown].max() * unit, rtol=1e-6)
        np.testing.assert_allclose(np.min(paths["ys"][number]), card.curves.speed.min() * units.speed, rtol=1e-6)
        largest = card.curves.amplitudes.max() * units.length
        np.testing.assert_allclose(np.nanmax(lines["ys"][number]), largest, rtol=1e-6)
    # Whatever is drawn is in sight.
    for name, data, x, y in (
        ("time", in_time, "time", "displacement"),
        ("force", in_time, "time", "force"),
        ("phase", paths, "xs", "ys"),
    ):
        for values, ends in ((data[x], drawn[name].x_range), (data[y], drawn[name].y_range)):
            low, high = min(map(np.min, values)), max(map(np.max, values))
            assert ends.start <= low + 1e-6 * abs(low) and high - 1e-6 * abs(high) <= ends.end
    points = source_of(drawn["phase"], "points").data
    assert len(points["x"]) == sum(len(card.curves.points) for card in cards) == len(points["colour"])


def test_figures_that_are_filled_again_are_as_new_ones(plane, found):
    units, used, new = units_of(plane, found), motion_figures(), motion_figures()
    fill_motions(used, [*found.attractors, *found.others], found, units)
    models = set.union(*(one.references() for one in used.values()))
    for one in (used, new):
        fill_motions(one, found.attractors[:1], found, units)
    assert set.union(*(one.references() for one in used.values())) == models
    for name in MOTION_FIGURES:
        np.testing.assert_equal(*(source_of(one[name], "motions").data for one in (used, new)))
        ranges = [(one[name].y_range.start, one[name].y_range.reset_end) for one in (used, new)]
        assert ranges[0] == ranges[1]


def test_no_motion_at_all_and_no_gap_are_empty_figures(plane, found):
    units, drawn = units_of(plane, found), motion_figures()
    fill_motions(drawn, found.attractors, found, units)
    spans = [one for one in drawn["time"].center if isinstance(one, Span)]
    assert [one.visible for one in spans] == [bool(np.isfinite(end)) for end in found.gap]
    assert fill_motions(drawn, [], found, units) == []
    assert source_of(drawn["spectrum"], "motions").data["xs"] == []
