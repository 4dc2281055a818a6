"""Layers of the map as plain data: what they say is what the store and the printed figures say."""

import numpy as np
import pytest
from matplotlib.path import Path as Outline

from pipeline.analysis.attractors.credibility import Credibility
from pipeline.analysis.attractors.dataset import read_attractors
from pipeline.analysis.attractors.wording import cell_label
from pipeline.config.quantities import QUANTITIES
from pipeline.errors import ConfigurationError
from pipeline.explorer.layers import layer, layer_names
from pipeline.figures.attractors import class_of
from pipeline.figures.palette import hex_colour, label_colour
from pipeline.figures.panels import lines_of, panel_of, shares_of_labels
from pipeline.plane.stored import read_stored
from tests.pipeline.explorer.planes import integrated_store
from tests.pipeline.planes import small_plan, small_store, traced_store


@pytest.fixture(scope="module")
def plane(tmp_path_factory):
    return read_stored(integrated_store(tmp_path_factory.mktemp("layers")))


@pytest.fixture(scope="module")
def physical(tmp_path_factory):
    plan = small_plan("gear=miter")
    return read_stored(traced_store(tmp_path_factory.mktemp("layers") / "plane.zarr", plan))


def test_layers_are_those_that_the_store_has(plane, physical):
    assert layer_names(plane) == ("domains", "dynamic", "attractors", "credibility", *QUANTITIES)
    assert layer_names(physical) == ("domains", "dynamic", *QUANTITIES)
    with pytest.raises(ConfigurationError, match="attractors.*domains"):
        layer(physical, "attractors")
    with pytest.raises(ConfigurationError, match="physical"):
        layer(plane, "domains", physical=True)


@pytest.mark.parametrize("name", ["domains", "dynamic"])
def test_regions_have_the_labels_colours_and_shares_of_the_figures(plane, name):
    shown, counted = layer(plane, name), plane.counting(dynamic=name == "dynamic")
    shares, panel = shares_of_labels(counted), panel_of(counted)
    assert shown.exact and [one.name.replace("–", "-") for one in shown.classes] == [
        counted.labels[code] for code in sorted(shares)
    ]
    x, y = (
        ends[0] + (np.arange(count) + 0.5) / count * (ends[1] - ends[0])
        for ends, count in ((panel.x, panel.code.shape[1]), (panel.y, panel.code.shape[0]))
    )
    # Rows between those of cells, where nothing is a boundary.
    picked = np.ix_(np.arange(7, len(y), 90), np.arange(3, len(x), 40))
    places = np.stack(np.meshgrid(x, y), axis=-1)[picked].reshape(-1, 2)
    seen = np.zeros(len(places), int)
    for one, code in zip(shown.classes, sorted(shares), strict=True):
        assert one.colour == hex_colour(label_colour(counted.labels[code]))
        within = sum(Outline(part).contains_points(places) for part in one.polygons).astype(bool)
        seen += within
        np.testing.assert_array_equal(panel.code[picked].ravel()[within], code)
    assert np.mean(seen == 1) > 0.98 and seen.max() == 1


def test_lines_are_those_of_the_figures(plane):
    shown = {one.kind: one for one in layer(plane, "domains").lines}
    ends = (plane.plan.sweep.low, plane.plan.sweep.high), (plane.plan.parameter.low, plane.plan.parameter.high)
    outlines = lines_of(plane, *ends)
    assert shown.keys() == {*outlines, "mode 2"}
    for kind, outline in outlines.items():
        corners = np.concatenate([line[[0, -1]] for line in shown[kind].lines])
        starts = outline.vertices[outline.codes == Outline.MOVETO]
        np.testing.assert_array_equal(corners[::2], starts)
    np.testing.assert_allclose(shown["mode 2"].lines[0][:, 0], plane.modes[0, 1], rtol=1e-5)


def test_integration_and_its_verdict_are_told_of_every_cell(plane):
    found = read_attractors(plane.path)
    integration, verdict = layer(plane, "domains").told
    # 12 of 40 columns are no even lattice.
    for place in ((0, 0), (2, 5), (3, 11), (1, 7)):
        x = found[plane.plan.sweep.name].values[place[1]]
        p = found[plane.plan.parameter.name].values[place[0]]
        said = cell_label(found.kind.values[place], found.impact.values[place]) or "nothing found"
        assert at(integration, x, p) == said
        assert at(verdict, x, p) == Credibility(int(found.credibility.values[place])).words


def at(told, x, p):
    """What is told of a place."""
    (x0, x1), (y0, y1), values = told.cells.x, told.cells.y, told.cells.values
    row = int((p - y0) / (y1 - y0) * values.shape[0])
    return told.texts[values[row, int((x - x0) / (x1 - x0) * values.shape[1])]]


def test_attractors_and_credibility_have_a_class_in_every_cell(plane):
    found, shown = read_attractors(plane.path), layer(plane, "attractors")
    calmest = np.min(np.where((k := class_of(found.kind.values)) < 0, 99, k), axis=-1)
    assert set(np.unique(shown.cells.values)) == set(np.unique(calmest))
    several = [shade for shade in shown.shades if shade.name.startswith("several")]
    share = float(np.mean(np.sum(k >= 0, axis=-1) >= 2))
    assert f"{100.0 * share:.1f} %" in shown.title and bool(several) == (share > 0.0)
    judged = layer(plane, "credibility")
    names = [judged.classes[number].name for number in np.unique(judged.cells.values) if number >= 0]
    assert {Credibility(int(code)).words for code in np.unique(found.credibility.values)} >= set(names)


@pytest.mark.costly
@pytest.mark.parametrize("name", ["dynamic_factor", "impact_velocity"])
def test_quantities_are_the_stored_ones_in_units_of_the_axis(physical, name):
    plain, shown = layer(physical, name), layer(physical, name, physical=True)
    np.testing.assert_array_equal(plain.cells.values, physical.extreme(name, "worst"))
    mildest = layer(physical, name, of="mildest").cells.values
    assert np.all((mildest <= plain.cells.values) | np.isnan(mildest))
    scale = {"dynamic_factor": 1.0, "impact_velocity": 1.0}[name] if name == "dynamic_factor" else None
    if scale is None:
        assert shown.unit == "m/s"
        known = plain.cells.values > 0.0
        ratio = shown.cells.values[known] / plain.cells.values[known]
        assert np.ptp(ratio) < 1e-12 * ratio.max() and ratio.max() != 1.0
    assert shown.ends == (np.nanmin(shown.cells.values), np.nanmax(shown.cells.values))


@pytest.mark.costly
def test_physical_maps_are_dimensionless_ones_in_other_units(physical):
    plain, shown = layer(physical, "domains"), layer(physical, "domains", physical=True)
    assert (shown.x.unit, shown.y.unit) == ("rpm", "µm") and shown.x.low == plain.x.low * shown.x.size
    factor = np.array([shown.x.size, shown.y.size])
    for one, other in zip(plain.classes, shown.classes, strict=True):
        np.testing.assert_allclose(np.concatenate(other.polygons), np.concatenate(one.polygons) * factor, rtol=1e-14)
    for one, other in zip(plain.lines, shown.lines, strict=True):
        np.testing.assert_allclose(np.concatenate(other.lines), np.concatenate(one.lines) * factor, rtol=1e-14)


def test_a_plane_without_boundaries_is_shown_in_cells(tmp_path):
    plan = small_plan(columns=30, rows=6)
    plane = read_stored(small_store(tmp_path / "plane.zarr", plan, plan.blocks[:1] if len(plan.blocks) > 1 else None))
    shown = layer(plane, "domains")
    assert not shown.exact and "cells" in shown.notes[-1]
    for code, label in plane.labels.items():
        names = [one.name.replace("–", "-") for one in shown.classes]
        number = names.index(label) if label in names else -1
        np.testing.assert_array_equal(shown.cells.values[plane.domain == code], number)


def test_symbols_have_no_markup_as_plain_text():
    from pipeline.explorer.plain_text import plain
    from pipeline.figures.naming import _SYMBOLS

    texts = [*_SYMBOLS.values(), *(one.symbol for one in QUANTITIES.values())]
    assert not [text for text in texts if set("\\${}") & set(plain(f"${text}$"))]
    assert plain(r"$\zeta$, $\Lambda_0$, $\varepsilon_t$, $\Delta T$") == "ζ, Λ_0, ε_t, ΔT"
