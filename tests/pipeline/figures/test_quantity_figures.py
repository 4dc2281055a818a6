"""Quantities over the plane and along curves: what is drawn is what is stored, and what a reader is told of it."""

import itertools

import numpy as np
import pytest
from matplotlib.collections import LineCollection

from pipeline import figures, store
from pipeline.config.quantities import QUANTITIES
from pipeline.errors import ConfigurationError
from pipeline.figures.curves import draw_curves
from pipeline.figures.palette import sequential_colours
from pipeline.figures.quantity_map import draw_quantity_map
from pipeline.plane.row_curves import curves_at
from pipeline.plane.stored import read_stored
from solver import Event
from solver.stability import Instability
from tests.conftest import slow_but
from tests.pipeline.planes import contents, small_plan, small_store, traced_store


@pytest.fixture(scope="module")
def traced(tmp_path_factory):
    plan = small_plan(columns=60, rows=16)
    return traced_store(tmp_path_factory.mktemp("quantities") / "traced.zarr", plan)


def texts(figure):
    figure.draw_without_rendering()
    return " ".join(text.get_text() for text in figure.findobj(lambda artist: hasattr(artist, "get_text")))


def colours_of(figure, plane):
    """The colour of every cell in the first panel, (P, X, 3)."""
    image = figure.axes[0].images[0].get_array()
    rows, columns = plane.domain.shape
    return image[:: image.shape[0] // rows, :: image.shape[1] // columns][:rows, :columns]


_COLOURED = ("dynamic_factor", "contact_loss", "error_lowest")
_WAYS = list(itertools.product(["static", "dynamic"], ["worst", "mildest"]))


@pytest.mark.costly
@pytest.mark.parametrize(
    ("stability", "of", "names"),
    [
        # Every way and every quantity; all of them in all ways are slow.
        *((*way, [_COLOURED[i % len(_COLOURED)]]) for i, way in enumerate(_WAYS)),
        *(pytest.param(*way, _COLOURED, marks=pytest.mark.slow) for way in _WAYS),
    ],
)
def test_every_cell_has_the_colour_of_its_value(traced, stability, of, names):
    plane, stored = read_stored(traced, dynamic=stability == "dynamic"), contents(traced)
    for name in names:
        values = np.full(plane.domain.shape, np.nan)
        for place in np.ndindex(values.shape):
            counted = stored["stable"][place] == 1
            if stability == "dynamic":
                counted &= np.isin(stored["instability"][place], (Instability.NONE, Instability.CONTRADICTORY))
            if np.any(counted):
                values[place] = (max if of == "worst" else min)(stored[name][place][counted])
        np.testing.assert_array_equal(plane.extreme(name, of), values)
        figure = draw_quantity_map(plane, name, of)
        low, high = np.nanmin(values), np.nanmax(values)
        share = np.clip((values - low) / (high - low) * 256, 0, 255)
        shown = colours_of(figure, plane)
        known = np.isfinite(values)
        np.testing.assert_array_equal(shown[known], sequential_colours()[share[known].astype(int)])
        assert np.all(shown[~known] == 255)
        said = texts(figure)
        assert QUANTITIES[name].label in said and f"${QUANTITIES[name].symbol}$" in said
        assert ("Largest" in said) == (of == "worst") and ("dynamically stable motions" in said) == plane.dynamic
        assert "fold: $n$ changes" in said


def test_a_part_of_the_plane_is_drawn_alone_in_the_colours_of_the_whole(traced):
    plane, window = read_stored(traced), (0.55, 0.65, 0.1, 0.3)
    whole, part = (draw_quantity_map(plane, "rms", "worst", here) for here in (None, window))
    assert (*part.axes[0].get_xlim(), *part.axes[0].get_ylim()) == window
    assert part.axes[-1].get_ylim() == whole.axes[-1].get_ylim() and len(part.axes) < len(whole.axes)
    np.testing.assert_array_equal(colours_of(part, plane), colours_of(whole, plane))


def test_worst_and_mildest_differ_where_motions_coexist_and_nowhere_else(traced):
    plane = read_stored(traced)
    worst, mildest = (plane.extreme("rms", of) for of in ("worst", "mildest"))
    assert np.array_equal(worst > mildest, plane.n_stable > 1) and np.any(worst > mildest)


@pytest.mark.costly
def test_cells_without_a_value_are_told(tmp_path):
    planned = small_plan(columns=21, rows=6)
    path = small_store(tmp_path / "plane.zarr", planned)
    assert "no value" not in texts(draw_quantity_map(read_stored(path), "rms", "worst"))
    store.write_block(path, planned, planned.blocks[2], [store.row_values(planned, "no reason")])
    said = texts(draw_quantity_map(read_stored(path), "rms", "worst"))
    assert "row failed" in said and "no value" not in said
    store.write_block(path, planned, planned.blocks[3], [store.row_values(planned, None)])
    plane = read_stored(path)
    assert np.all(np.isnan(plane.extreme("rms", "worst")[2:4]))
    assert "no value" in texts(draw_quantity_map(plane, "rms", "worst"))
    # Without load there is no dynamic factor anywhere, and a picture that says so.
    idle = small_store(tmp_path / "idle.zarr", small_plan("gear.f_pm=0.0", columns=11, rows=3))
    figure = draw_quantity_map(read_stored(idle), "dynamic_factor", "worst")
    assert "no value" in texts(figure) and len(figure.axes) == 2


@pytest.mark.costly
def test_physical_values_stand_at_the_bar_and_beside_curves(tmp_path):
    path = small_store(tmp_path / "plane.zarr", small_plan("gear=miter"))
    plane = read_stored(path, physical=True)
    for name, unit in (("rms", "µm"), ("support_force", "N")):
        scale = plane.scales[QUANTITIES[name].scale]
        assert scale.unit == unit
        figure = draw_quantity_map(plane, name, "worst")
        figure.draw_without_rendering()
        (bar,) = (axes for axes in figure.axes if axes.child_axes and axes.get_position().width < 0.1)
        right = bar.child_axes[0]
        assert right.get_ylim() == pytest.approx([scale.shown * end for end in bar.get_ylim()], rel=1e-12)
        assert f"({unit})" in texts(figure)
        curves = draw_curves(plane, [0.2], name)
        curves.draw_without_rendering()
        below, left = curves.axes[0].child_axes
        assert left.get_ylabel() == f"{QUANTITIES[name].label} ({unit})"
        assert left.get_ylim() == pytest.approx([scale.shown * end for end in curves.axes[0].get_ylim()], rel=1e-12)
    factor = draw_quantity_map(plane, "dynamic_factor", "worst")
    assert all(not axes.child_axes for axes in factor.axes if axes.get_position().width < 0.1)


#: One with a backbone, one with a sign, one of the loads, and one of a share.
_DRAWN = ("amplitude", "lowest", "dynamic_factor", "contact_loss")


@pytest.mark.parametrize(
    ("name",), slow_but([(name,) for name in _DRAWN], [(name,) for name in QUANTITIES if name != "mean"])
)
def test_curves_are_of_the_quantity_with_its_events(traced, name):
    plane = read_stored(traced)
    figure, row = draw_curves(plane, [0.3], name), curves_at(plane, 0.3)
    main = figure.axes[0]
    assert main.get_ylabel() == f"{QUANTITIES[name].label} ${QUANTITIES[name].symbol}$"
    values = row.values(name)
    drawn = np.concatenate(
        [path.vertices for c in main.collections if isinstance(c, LineCollection) for path in c.get_paths()]
    )
    expected = np.concatenate(
        [np.column_stack([row.points["position"], values])[segment.slice] for segment in row.segments]
    )
    np.testing.assert_array_equal(np.unique(drawn, axis=0), np.unique(expected, axis=0))
    folds = row.points["event"] == Event.FOLD
    marked = next(line for line in main.lines if line.get_marker() == "o")
    np.testing.assert_array_equal(marked.get_xydata(), np.column_stack([row.points["position"], values])[folds])
    low, high = main.get_ylim()
    assert low <= values.min() and values.max() <= high and (low == 0.0 or QUANTITIES[name].signed)
    assert ("backbone" in texts(figure)) == (name == "amplitude")


def test_beside_the_mean_stands_the_amplitude(traced):
    names = [axes.get_ylabel().split(" ")[0] for axes in draw_curves(read_stored(traced), [0.3], "mean").axes]
    assert [name for name in names if name] == ["mean", "amplitude"]


@pytest.mark.costly
def test_files_have_the_name_of_the_quantity(tmp_path):
    path = small_store(tmp_path / "plane.zarr", small_plan(columns=21, rows=6))
    one, two = (
        figures.draw(path, tmp_path / folder, [0.3], ["png"], 40, quantity="peak_to_peak", of="mildest", only=only)
        for folder, only in (("one", ["map", "map-quantity", "curves"]), ("two", ["map-quantity", "curves"]))
    )
    assert {path.name for path in one} == {"map.png", "map-peak_to_peak-mildest.png", "curves-peak_to_peak.png"}
    assert len(two) == 2 and all(path.read_bytes() == (tmp_path / "one" / path.name).read_bytes() for path in two)
    only = figures.draw(path, tmp_path, [0.3], ["png"], 40, quantity="amplitude", only=["map-quantity", "curves"])
    assert [path.name for path in only] == ["curves.png", "map-amplitude-worst.png"]


@pytest.mark.parametrize(("options", "named"), [({"quantity": "loudness"}, "quantity"), ({"of": "best"}, "of")])
def test_words_that_are_none_are_refused(traced, tmp_path, options, named):
    with pytest.raises(ConfigurationError, match=f"^figures.{named} = ") as error:
        figures.draw(traced, tmp_path / "none", None, ["png"], 40, **options)
    assert "\n" not in str(error.value) and not (tmp_path / "none").exists()


def test_a_volume_has_no_such_map():
    with pytest.raises(ConfigurationError, match="figures.quantity = rms is not allowed for a volume"):
        options = figures.figure_options(None, ["png"], 40, quantity="rms")
        figures.check_options(small_plan("plane=omega_b_fe", "plane.parameter2.num=2"), options)
