"""Figures: the same bytes every time, what they show of a plane, and what cannot be drawn."""

import os
import subprocess
import sys

import numpy as np
import pytest
import xarray as xr

from pipeline import figures, store
from pipeline.errors import ConfigurationError
from pipeline.figures.backbone import draw_backbone
from pipeline.figures.curves import chosen_rows, draw_curves
from pipeline.figures.map import draw_map
from pipeline.figures.map_legend import CONTRADICTORY_CELLS, UNSTABLE_CELLS
from pipeline.figures.peaks import resonance_peaks
from pipeline.figures.windows import coexistence_windows
from pipeline.plane.segments import labels_at
from pipeline.plane.stored import read_stored
from solver import domain_code
from tests.pipeline.planes import small_plan, small_store

#: With c = cos 20 degrees and the stiffness varying in the mesh row only, branches run away (docs/physics.md,
#: section 7).
RUNAWAY = (
    "plane=omega_alpha",
    "plane.parameter.min=0.5",
    "plane.parameter.max=0.7",
    "gear.rotation_coupling=0.93969262",
    "gear.translation_coupling=geometric",
    "gear.variation.translation=0.0",
    "gear.variation.rotation=1.0",
)
NO_FREQUENCY = (
    "plane.sweep.name=f_e",
    "plane.sweep.min=0.1",
    "plane.sweep.max=0.3",
    "plane.parameter.name=omega",
    "plane.parameter.min=0.5",
    "plane.parameter.max=0.7",
)


STABILITY = {UNSTABLE_CELLS["hatch"], CONTRADICTORY_CELLS["hatch"]}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A small plane of the transmission error, with three stable solutions in places."""
    return small_store(tmp_path_factory.mktemp("figures") / "plane.zarr", small_plan())


@pytest.fixture(scope="module")
def plane(made):
    return read_stored(made)


def drawn(path, folder, formats=("png",)):
    return figures.draw(path, folder, None, list(formats), 60)


def test_what_is_written_and_the_same_bytes_again(made, tmp_path):
    """Again with the formats in another order and another style in force, and in another process with other hashes."""
    import matplotlib

    formats = ["png", "pdf", "svg"]
    first = drawn(made, tmp_path / "new" / "folder", formats)
    names = [f"{name}.{kind}" for name in ("map", "curves", "backbone") for kind in formats]
    assert [path.name for path in first] == names
    assert {path.name for path in (tmp_path / "new" / "folder").iterdir()} == set(names)
    assert first[0].read_bytes().startswith(b"\x89PNG") and first[1].read_bytes().startswith(b"%PDF")
    with matplotlib.rc_context({"font.size": 20.0, "lines.linewidth": 5.0}):
        drawn(made, tmp_path / "second", formats[::-1])
        assert matplotlib.rcParams["font.size"] == 20.0
    code = f"from pathlib import Path; from pipeline import figures; figures.draw(Path({str(made)!r}), "
    code += f"Path({str(tmp_path / 'third')!r}), None, {formats[:2]}, 60)"
    subprocess.run([sys.executable, "-c", code], check=True, env={**os.environ, "PYTHONHASHSEED": "1"})
    for path in first:
        assert path.read_bytes() == (tmp_path / "second" / path.name).read_bytes(), path.name
        if path.suffix != ".svg":
            assert path.read_bytes() == (tmp_path / "third" / path.name).read_bytes(), path.name


def test_options_are_checked_without_matplotlib():
    code = "import sys, pipeline.figures; assert 'matplotlib' not in sys.modules; pipeline.figures.check_options"
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize(
    ("curves", "formats", "dpi", "message"),
    [
        ([0.1, 7.0], ["png"], 200, "figures.curves = 7.0 is not allowed: it must lie within f_e = 0 ... 0.5"),
        ([-0.1], ["png"], 200, "figures.curves = -0.1 is not allowed: it must lie within f_e = 0 ... 0.5"),
        ([float("nan")], ["png"], 200, "figures.curves = nan is not allowed: it must lie within f_e = 0 ... 0.5"),
        ([], ["png"], 200, "figures.curves = [] is not allowed: it must be null or hold at least one value"),
        (None, ["gif"], 200, "figures.formats = 'gif' is not allowed: it must be a list of png, pdf, svg"),
        (None, [], 200, "figures.formats = [] is not allowed: it must be a list of png, pdf, svg"),
        (None, ["png"], 0, "figures.dpi = 0 is not allowed: it must be from 30 to 1200"),
        (None, ["png"], 10**6, "figures.dpi = 1000000 is not allowed: it must be from 30 to 1200"),
    ],
)
def test_options_not_allowed(made, tmp_path, curves, formats, dpi, message):
    with pytest.raises(ConfigurationError) as error:
        figures.check_options(store.read_plan(made), curves, formats, dpi)
    assert str(error.value) == message
    with pytest.raises(ConfigurationError):
        figures.draw(made, tmp_path / "none", curves, formats, dpi)
    assert not (tmp_path / "none").exists()


# Pieces


def test_pieces_give_the_stored_raster(plane):
    """Labels from the exactly located events are those of the solved cells."""
    code, n = labels_at(plane.pieces, plane.plan.sweep.values)
    # The last column is the end of every piece.
    np.testing.assert_array_equal(code[:, :-1], plane.domain[:, :-1])
    np.testing.assert_array_equal(n[:, :-1], plane.n_stable[:, :-1])


def test_windows(plane):
    low, high = plane.plan.sweep.low, plane.plan.sweep.high
    windows = coexistence_windows(plane.pieces, low, high)
    assert len(windows) == 2
    x = np.linspace(low, high, 3001)
    several = x[np.any(labels_at(plane.pieces, x)[1] >= 2, axis=0)]
    assert all(any(left <= value <= right for left, right in windows) for value in several)
    assert coexistence_windows([[] for _ in plane.pieces], low, high) == []
    # Two everywhere is no narrow region.
    assert coexistence_windows([pieces + pieces for pieces in plane.pieces], low, high) == []


# Figures


def texts(figure):
    legends = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    return legends + [text.get_text() for axes in figure.axes for text in axes.texts]


def hatches(figure):
    return {patch.get_hatch() for patch in figure.axes[0].patches} - {None}


def test_map_shows_what_the_plane_has(plane):
    figure = draw_map(plane)
    shown = texts(figure)
    codes = np.unique(plane.domain)
    assert {plane.labels[int(code)] for code in codes} <= set(shown)
    shares = [text for text in shown if text.endswith("%") and "<" not in text]
    assert sum(float(text.rstrip(" %")) for text in shares) == pytest.approx(100.0, abs=0.5)
    assert {
        "fold: $n$ changes",
        "grazing: only $I$ changes",
        "natural frequency, mesh",
        "natural frequency, shaft",
    } <= set(shown)
    assert figure.axes[0].get_xlabel() == r"dimensionless mesh frequency $\Omega$"
    assert figure.axes[0].get_ylabel() == "transmission error amplitude $f_e$"
    # Cells are centred on the grid values.
    assert figure.axes[0].get_xlim() == pytest.approx((0.05 - 1.95 / 80, 2.0 + 1.95 / 80))
    assert hatches(figure) == STABILITY


def test_curves_show_the_nearest_rows(plane):
    np.testing.assert_allclose(plane.rows, [0.0, 0.125, 0.25, 0.375, 0.5])
    assert chosen_rows(plane, None) == [1, 2, 3]
    assert chosen_rows(plane, [0.49, 0.13, 0.5, 0.12]) == [4, 1]
    figure = draw_curves(plane, [0.3])
    assert "$f_e$ = 0.25" in [figure.axes[0].get_title(place) for place in ("left", "center")]
    assert len(figure.axes) == 2
    top = np.nanmax(plane.points["amplitude"][2, : plane.n_points[2]])
    assert top < figure.axes[0].get_ylim()[1] < 1.2 * top
    assert {"stable", "unstable", "fold", "grazing, drive flank", "linear natural frequency", "backbone"} <= set(
        texts(figure)
    )


def test_peaks_are_on_the_softening_side(plane):
    peaks = resonance_peaks(plane, np.arange(1, 5))
    lower, upper = plane.modes[0]
    assert np.all(peaks[:, 0, 0] < lower)
    assert np.all(np.diff(peaks[:, 0, 1]) > 0.0)
    # From single-sided impact on, the peak of the shaft-frequency resonance moves below the linear frequency too.
    assert np.all(peaks[2:, 1, 0] < upper)
    stable = plane.points["stable"] == 1
    assert peaks[3, 0, 1] == pytest.approx(np.max(plane.points["amplitude"][4][stable[4]]), rel=1e-2)


def test_failed_and_missing_rows(tmp_path):
    plan = small_plan(columns=41, rows=4)
    path = small_store(tmp_path / "plane.zarr", plan, plan.blocks[:2])
    store.write_block(path, plan, plan.blocks[2], [store.row_values(plan, "no reason")])
    plane = read_stored(path)
    assert plane.status.tolist() == [1, 1, 2, 0]
    figure = draw_map(plane)
    assert hatches(figure) - STABILITY == {"//////"} and "row failed" in texts(figure)
    said = texts(draw_curves(plane, plane.rows.tolist()))
    assert said.count("row failed") == said.count("row not computed") == 2
    assert np.isnan(resonance_peaks(plane, np.arange(4))[2:]).all()
    assert len(drawn(path, tmp_path)) == 3


def test_nothing_but_failed_rows(tmp_path):
    plan = small_plan(columns=5, rows=2)
    path = small_store(tmp_path / "plane.zarr", plan, [])
    for block in plan.blocks:
        store.write_block(path, plan, block, [store.row_values(plan, "no reason")] * (block.stop - block.start))
    assert len(drawn(path, tmp_path)) == 3
    shown = texts(draw_map(read_stored(path)))
    assert "row failed" in shown and not any("%" in text for text in shown)


def test_tiny_and_uniform(tmp_path):
    path = small_store(tmp_path / "tiny.zarr", small_plan(columns=5, rows=4))
    assert len(drawn(path, tmp_path)) == 3
    overrides = ("plane.sweep.min=1.4", "plane.sweep.max=1.6", "plane.parameter.max=0.05")
    path = small_store(tmp_path / "uniform.zarr", small_plan(*overrides, columns=4, rows=2))
    plane = read_stored(path)
    assert len(np.unique(plane.domain)) == 1
    shown = texts(draw_map(plane))
    assert "100.0 %" in shown and not any("fold" in text or "natural" in text for text in shown)
    assert len(drawn(path, tmp_path)) == 3


def test_runaway_branches(tmp_path):
    """Cells below the amplitude ceiling's exits are hatched, and the curves stay readable."""
    path = small_store(tmp_path / "plane.zarr", small_plan(*RUNAWAY, columns=61, rows=3))
    plane = read_stored(path)
    assert np.any(plane.open == 1) and np.nanmax(plane.points["amplitude"]) > 90.0
    figure = draw_map(plane)
    assert hatches(figure) - STABILITY == {"...."} and "not excluded: motions" in texts(figure)
    figure = draw_curves(plane, None)
    assert all(axes.get_ylim()[1] < 45.0 for axes in figure.axes)
    assert any(r"ceiling $\lambda_a$ = 100" in text for text in texts(figure))
    exits = [line for line in figure.axes[0].lines if line.get_marker() == "^"]
    assert exits and all(0.4 < x < 0.7 for line in exits for x in line.get_xdata())
    draw_backbone(plane)


def test_without_frequency_along_the_rows(tmp_path):
    path = small_store(tmp_path / "plane.zarr", small_plan(*NO_FREQUENCY, columns=21, rows=3))
    assert [p.name for p in drawn(path, tmp_path)] == ["map.png", "curves.png"]
    plane = read_stored(path)
    for figure in (draw_map(plane), draw_curves(plane, [0.6])):
        assert not any("natural" in text or "backbone" in text for text in texts(figure))


def test_without_mean_load_there_is_no_backbone(tmp_path):
    path = small_store(tmp_path / "plane.zarr", small_plan("gear.f_pm=0", columns=5, rows=2))
    assert [p.name for p in drawn(path, tmp_path)] == ["map.png", "curves.png"]


def test_labels_by_dynamic_stability_leave_out_what_is_not_stable(made):
    static, dynamic = read_stored(made), read_stored(made, dynamic=True)
    root = xr.open_zarr(made)
    kept = (root.stable == 1) & (root.instability == 0)
    np.testing.assert_array_equal(dynamic.n_stable, kept.sum("solution"))
    assert np.all(dynamic.n_stable <= static.n_stable)
    marked = dynamic.unstable | dynamic.contradictory
    np.testing.assert_array_equal(marked, dynamic.n_stable < static.n_stable)
    np.testing.assert_array_equal(dynamic.domain[~marked], static.domain[~marked])
    assert np.any(marked)
    for row, column in np.argwhere(marked):
        states = root.impact[row, column].values[kept[row, column].values]
        mask = sum({1 << int(state) for state in states})
        assert dynamic.domain[row, column] == domain_code(states.size, mask)


@pytest.mark.parametrize("stability", ["static", "dynamic"])
def test_maps_hatch_what_is_dynamically_unstable(made, stability):
    plane = read_stored(made, stability == "dynamic")
    figure = draw_map(plane)
    hatches = {patch.get_hatch() for axes in figure.axes for patch in axes.patches}
    assert (CONTRADICTORY_CELLS["hatch"] in hatches) == bool(plane.contradictory.any())
    unstable = bool(np.any(plane.unstable & ~plane.contradictory))
    assert (UNSTABLE_CELLS["hatch"] in hatches) == (stability == "static" and unstable)
