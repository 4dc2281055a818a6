"""Figures in physical units: both scales on every axis, and dimensionless figures left as they were."""

import pytest

from pipeline import figures
from pipeline.figures.backbone import draw_backbone
from pipeline.figures.curves import draw_curves
from pipeline.figures.map import draw_map, draw_window
from pipeline.figures.multipliers import draw_multipliers
from pipeline.figures.naming import value_text
from pipeline.plane.stored import read_stored
from tests.pipeline.planes import small_plan, small_store


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return small_store(tmp_path_factory.mktemp("physical") / "plane.zarr", small_plan("gear=miter"))


@pytest.mark.parametrize(
    ("draw", "y"),
    [
        (draw_map, "f_e"),
        (lambda plane: draw_window(plane, [0.3, 0.6, 0.1, 0.2]), "f_e"),
        (lambda plane: draw_curves(plane, [0.2]), "length"),
        (draw_backbone, "length"),
    ],
    ids=["map", "window", "curves", "backbone"],
)
def test_both_scales_are_on_the_axes(made, draw, y):
    plane = read_stored(made, physical=True)
    figure = draw(plane)
    figure.draw_without_rendering()
    main = next(axes for axes in figure.axes if axes.child_axes)
    below, left = main.child_axes
    for limits, own, name in ((main.get_xlim(), below.get_xlim(), "omega"), (main.get_ylim(), left.get_ylim(), y)):
        assert own == pytest.approx([plane.scales[name].shown * limit for limit in limits], rel=1e-12)
    assert below.get_xlabel() == "pinion speed (rpm)" and left.get_ylabel().endswith(" (µm)")
    assert main.xaxis.get_label_position() == "top" and main.yaxis.get_label_position() == "right"
    assert main.get_xlabel() and main.get_ylabel()


def test_multipliers_are_drawn_over_both_scales(made):
    plane = read_stored(made, physical=True)
    figure = draw_multipliers(plane, [0.1, 0.2])
    figure.draw_without_rendering()
    first, last = (axes for axes in figure.axes if axes.child_axes)
    for axes in (first, last):
        assert axes.child_axes[0].get_xlim() == pytest.approx(
            [plane.scales["omega"].shown * x for x in axes.get_xlim()]
        )
    assert last.child_axes[0].get_xlabel() == "pinion speed (rpm)" and not first.child_axes[0].get_xlabel()
    assert first.get_xlabel() and "µm" in first.get_title()


def test_dimensionless_figures_have_no_second_scale(made):
    plane = read_stored(made)
    assert all(not axes.child_axes for draw in (draw_map, draw_backbone) for axes in draw(plane).axes)


@pytest.mark.costly
def test_a_parameter_without_a_unit_keeps_its_axis(tmp_path):
    overrides = ("gear=miter", "plane.parameter.name=alpha_phase", "plane.parameter.min=0", "plane.parameter.max=3")
    path = small_store(tmp_path / "plane.zarr", small_plan(*overrides, columns=21, rows=3))
    main = next(axes for axes in draw_map(read_stored(path, physical=True)).axes if axes.child_axes)
    assert len(main.child_axes) == 1 and main.yaxis.get_label_position() == "left"


def test_values_are_told_in_both(made):
    scales = read_stored(made, physical=True).scales
    assert value_text("b", 0.5, scales) == "$b$ = 0.5 (25 µm)"
    assert value_text("kappa", 0.5, scales) == value_text("kappa", 0.5)


@pytest.mark.costly
def test_drawn_files(made, tmp_path):
    paths, again = (
        figures.draw(made, tmp_path / folder, [0.25], ["png"], 30, units="physical", only=["map", "curves"])
        for folder in ("one", "two")
    )
    assert len(paths) == 2 and [a.read_bytes() for a in paths] == [b.read_bytes() for b in again]
