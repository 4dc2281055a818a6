"""The map as a Bokeh figure: what it holds is the layer, and the data are sent once."""

import numpy as np
import pytest

from pipeline.explorer.layers import layer
from pipeline.plane.stored import read_stored
from tests.pipeline.explorer.planes import integrated_store

pytest.importorskip("bokeh", reason="the extra explore is not installed")

from bokeh.models import ColorBar, HoverTool, Legend

from pipeline.explorer.map_figure import NO_VALUE, encoded, map_figure, update_map
from pipeline.explorer.sources import Sources

NAMES = ("domains", "attractors", "dynamic_factor")


@pytest.fixture(scope="module")
def layers(tmp_path_factory):
    """Some layers of a plane, made once."""
    plane = read_stored(integrated_store(tmp_path_factory.mktemp("maps")))
    return {name: layer(plane, name) for name in NAMES}


def renderer(found, name):
    (one,) = [one for one in found.renderers if one.name == name]
    return one


def test_regions_and_lines_of_a_figure_are_the_layers(layers):
    shown = layers["domains"]
    found = map_figure(shown)
    areas = renderer(found, "areas").data_source.data
    assert list(areas["colour"]) == [one.colour for one in shown.classes]
    for xs, ys, one in zip(areas["xs"], areas["ys"], shown.classes, strict=True):
        corners = [np.column_stack([x, y]) for (x,), (y,) in zip(xs, ys, strict=True)]
        assert all(np.allclose(a, b, atol=2e-9) for a, b in zip(corners, one.polygons, strict=True))
    for kind in shown.lines:
        lines = renderer(found, kind.kind).data_source.data
        np.testing.assert_array_equal(np.concatenate(lines["xs"]), np.concatenate(kind.lines)[:, 0])
    assert renderer(found, "labels").data_source.data["text"] == [one.text for one in shown.written]
    texts = [item.label.value for item in found.select_one(Legend).items]
    assert all(any(text.startswith(one.name) for text in texts) for one in (*shown.classes, *shown.shades))
    (hover,) = found.select(HoverTool)
    assert [row[0] for row in hover.tooltips] == ["Ω", "f_e", "n/I", "integration", "verdict"]


def test_values_come_back_from_what_is_sent(layers):
    shown = layers["dynamic_factor"]
    codes, values = encoded(shown), shown.cells.values
    low, high = shown.ends
    known = codes != NO_VALUE
    np.testing.assert_array_equal(known, np.isfinite(values))
    back = low + codes[known] / (NO_VALUE - 1) * (high - low)
    np.testing.assert_allclose(back, values[known], atol=0.51 * (high - low) / (NO_VALUE - 1))
    bar = map_figure(shown).select_one(ColorBar)
    assert (bar.color_mapper.low, bar.color_mapper.high) == shown.ends


@pytest.mark.costly
@pytest.mark.parametrize("legend", [True, False])
def test_every_layer_can_follow_every_other_in_a_figure(layers, legend):
    found = map_figure(layers["attractors"], legend=legend)
    x_range = found.x_range
    for name in (*NAMES, "domains"):
        shown = layers[name]
        update_map(found, shown)
        fresh = map_figure(shown, legend=legend)
        assert [one.name for one in found.renderers] == [one.name for one in fresh.renderers]
        assert len(found.select(HoverTool)) == 1 and found.title.text == shown.title
        assert bool(found.select(Legend)) == legend
        assert len(found.right) == len(fresh.right)
    assert found.x_range is x_range


def test_layers_of_one_page_share_what_they_have_in_common(layers):
    sources = Sources()
    one, other = (map_figure(layers[name], sources=sources) for name in ("domains", "dynamic_factor"))
    assert renderer(one, "fold").data_source is renderer(other, "fold").data_source
    assert renderer(one, "areas").data_source is not renderer(other, "cells").data_source
