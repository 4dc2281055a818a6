"""Branches of a row and motions at a place as Bokeh figures, against what was computed."""

import numpy as np
import pytest

from pipeline.analysis.motion.motions import motions_at
from pipeline.config.compose import compose
from pipeline.config.quantities import QUANTITIES
from pipeline.explorer.map_frame import frame_of_map
from pipeline.figures.motion_axes import units_of
from pipeline.figures.palette import hex_colour, state_colour
from pipeline.plane.row_curves import curves_at
from pipeline.plane.stored import read_stored
from solver import Event, ImpactState
from tests.pipeline.planes import small_plan, traced_store

pytest.importorskip("bokeh", reason="the extra explore is not installed")

from bokeh.models import Legend

from pipeline.explorer.row_figures import MOTION_FIGURES, curves_figure, motion_figures


@pytest.fixture(scope="module")
def plane(tmp_path_factory):
    plan = small_plan("gear=miter")
    return read_stored(traced_store(tmp_path_factory.mktemp("rows") / "plane.zarr", plan), physical=True)


def renderers(found, name):
    return [one for one in found.renderers if one.name == name]


@pytest.mark.parametrize("quantity", ["amplitude", "dynamic_factor", "mean"])
@pytest.mark.parametrize("physical", [False, True])
def test_branches_have_their_values_colours_and_dashes(plane, quantity, physical):
    row, frame = curves_at(plane, 0.5 * (plane.rows[-2] + plane.rows[-1])), frame_of_map(plane, physical)
    found = curves_figure(row, frame.x, quantity=quantity, scales=frame.scales)
    data = renderers(found, "branches")[0].data_source.data
    scale = frame.scales[QUANTITIES[quantity].scale].shown if physical and QUANTITIES[quantity].scale else 1.0
    dashes = {}
    for piece, lasts, *drawn in zip(
        row.pieces, row.lasting, data["xs"], data["ys"], data["colour"], data["dash"], data["state"], strict=True
    ):
        xs, ys, colour, dash, state = drawn
        np.testing.assert_allclose(xs, row.points["position"][piece.slice] * frame.x.size)
        np.testing.assert_allclose(ys, row.values(quantity)[piece.slice] * scale)
        symbol = ImpactState(piece.impact).symbol
        assert colour == hex_colour(state_colour(symbol)) and f"I = {symbol}:" in state
        dashes.setdefault((piece.stable, bool(lasts)), set()).add(dash)
    assert len(dashes) >= 2 and all(len(kinds) == 1 for kinds in dashes.values())
    assert len(set.union(*dashes.values())) == len(dashes) and dashes[True, True] == {""}
    folds = renderers(found, "fold")[0].data_source.data["x"]
    np.testing.assert_allclose(folds, row.points["position"][row.points["event"] == Event.FOLD] * frame.x.size)
    texts = [item.label.value for item in found.select_one(Legend).items]
    assert len(texts) == len(set(texts)) and "fold" in texts
    stable = row.values(quantity)[row.points["stable"] == 1] * scale
    assert found.y_range.start <= stable.min() and found.y_range.end >= stable.max()


def test_motions_are_drawn_as_they_were_found(plane):
    found = motions_at(plane.plan, 1.2, float(plane.rows[3]), compose([]).config.attractors)
    cards, units = [*found.attractors, *found.others], units_of(plane, found)
    drawn = motion_figures(cards, found.gap, units)
    assert tuple(drawn) == MOTION_FIGURES and drawn["force"].x_range is drawn["time"].x_range
    assert drawn["time"].xaxis.axis_label.startswith("time (ms)") and "µm" in drawn["phase"].xaxis.axis_label
    texts = [item.label.value for item in drawn["time"].select_one(Legend).items]
    assert len(texts) == len(cards) and all(card.label in text for card, text in zip(cards, texts, strict=True))
    for card, text in zip(cards, texts, strict=True):
        time, force = (renderers(drawn[name], text)[0].data_source.data["y"] for name in ("time", "force"))
        # Of a motion that does not repeat the first periods are shown.
        shown = slice(len(time) if card.curves.repeats is None else None)
        np.testing.assert_allclose(np.max(time), card.curves.displacement[shown].max() * units.length)
        np.testing.assert_allclose(np.max(force), card.curves.force[shown].max() * units.force)
        path = renderers(drawn["phase"], text)[0].data_source.data
        np.testing.assert_allclose(np.min(path["y"]), card.curves.speed.min() * units.speed)
        if card.curves.repeats is not None:
            lines = renderers(drawn["spectrum"], text)[0].data_source.data
            np.testing.assert_allclose(np.max(lines["y1"]), card.curves.amplitudes.max() * units.length)


def test_a_row_that_failed_and_no_motion_at_all_are_empty_figures(plane):
    from dataclasses import replace

    row = curves_at(plane, float(plane.rows[0]))
    none = replace(row, points={name: array[:0] for name, array in row.points.items()})
    found = curves_figure(none, frame_of_map(plane, False).x)
    assert renderers(found, "branches")[0].data_source.data["xs"] == []
    motions = motions_at(plane.plan, 1.2, float(plane.rows[3]), compose([]).config.attractors)
    assert tuple(motion_figures([], (-1.0, 1.0), units_of(plane, motions))) == MOTION_FIGURES
