"""Figures: the same bytes every time, what they show of a plane, and what cannot be drawn."""

import dataclasses
import os
import subprocess
import sys

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import cKDTree

import pipeline
from pipeline import figures, store
from pipeline.errors import ConfigurationError
from pipeline.figures.backbone import draw_backbone, round_values
from pipeline.figures.curves import _free_corner, chosen_values, draw_curves
from pipeline.figures.map import draw_map
from pipeline.figures.panels import panel_of, shares_of_labels
from pipeline.figures.peaks import resonance_peaks
from pipeline.figures.region_labels import placed_labels
from pipeline.figures.windows import coexistence_windows
from pipeline.plane.division import stored_division
from pipeline.plane.row_curves import curves_at, solved_curves
from pipeline.plane.segments import labels_at
from pipeline.plane.stored import read_stored
from solver import Event, domain_code
from solver.regions.labelling import dynamic_code, is_contradictory, static_code
from solver.stability import Instability
from tests.pipeline.planes import small_plan, small_store, traced_store

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


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A small plane of the transmission error, with three stable solutions in places."""
    return small_store(tmp_path_factory.mktemp("figures") / "plane.zarr", small_plan())


@pytest.fixture(scope="module")
def plane(made):
    return read_stored(made)


def drawn(path, folder, formats=("png",), only=None, curves=None):
    return figures.draw(path, folder, curves, list(formats), 30, only=only)


@pytest.mark.costly
def test_what_is_written_and_the_same_bytes_again(made, tmp_path):
    """Again with the formats in another order and another style in force, and in another process with other hashes."""
    import matplotlib

    folder, formats = tmp_path / "new" / "folder", ["png", "pdf", "svg"]
    first = [*drawn(made, folder, curves=[0.25]), *drawn(made, folder, formats[1:], only=["backbone"])]
    names = ["map.png", "curves.png", "backbone.png", "backbone.pdf", "backbone.svg"]
    assert [path.name for path in first] == names and {path.name for path in folder.iterdir()} == set(names)
    assert first[0].read_bytes().startswith(b"\x89PNG") and first[3].read_bytes().startswith(b"%PDF")
    with matplotlib.rc_context({"font.size": 20.0, "lines.linewidth": 5.0}):
        again = drawn(made, tmp_path / "second", only=["map", "curves"], curves=[0.25])
        again += drawn(made, tmp_path / "second", formats[::-1], only=["backbone"])
        assert matplotlib.rcParams["font.size"] == 20.0
    code = f"from pathlib import Path; from pipeline import figures; made = Path({str(made)!r}), "
    code += f"Path({str(tmp_path / 'third')!r}), [0.25]; figures.draw(*made, ['png'], 30, only=['map', 'curves']); "
    code += "figures.draw(*made, ['pdf'], 30, only=['backbone'])"
    subprocess.run([sys.executable, "-c", code], check=True, env={**os.environ, "PYTHONHASHSEED": "1"})
    assert len(again) == len(first)
    for path in first:
        assert path.read_bytes() == (tmp_path / "second" / path.name).read_bytes(), path.name
        if path.name not in ("backbone.png", "backbone.svg"):
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
        figures.check_options(store.read_plan(made), figures.figure_options(curves, formats, dpi))
    assert str(error.value) == message
    with pytest.raises(ConfigurationError):
        figures.draw(made, tmp_path / "none", curves, formats, dpi)
    assert not (tmp_path / "none").exists()


# Pieces


def test_pieces_give_the_stored_raster(plane):
    """Labels from the exactly located events are those of the solved cells."""
    code, n = labels_at(plane.segments, plane.plan.sweep.values)
    # The last column is the end of every segment.
    np.testing.assert_array_equal(code[:, :-1], plane.domain[:, :-1])
    np.testing.assert_array_equal(n[:, :-1], plane.n_stable[:, :-1])


def test_windows(plane):
    low, high = plane.plan.sweep.low, plane.plan.sweep.high
    windows = coexistence_windows(plane)
    assert len(windows) == 2
    x = np.linspace(low, high, 3001)
    several = x[np.any(labels_at(plane.segments, x)[1] >= 2, axis=0)]
    assert all(any(left <= value <= right for left, right in windows) for value in several)
    # Nowhere two, and two everywhere, which is no narrow region.
    for times in (0, 2):
        other = dataclasses.replace(plane)
        vars(other)["segments"] = [times * segments for segments in plane.segments]
        assert coexistence_windows(other) == []


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
    assert sum(float(text.rstrip(" %")) for text in shares) == pytest.approx(100.0, abs=0.05)
    assert {
        "fold: $n$ changes",
        "grazing: only $I$ changes",
        "linear mode, 46 % mesh",
        "linear mode, 54 % mesh",
    } <= set(shown)
    head = " ".join(text.get_text() for text in figure.texts)
    assert "plane:  order 1 (describing function)" in head and "41" in head and "= 0.3173" in head
    assert figure.axes[0].get_xlabel() == r"dimensionless mesh frequency $\Omega$"
    assert figure.axes[0].get_ylabel() == "transmission error amplitude $f_e$"
    # Cells are centred on the grid values; what begins next to zero is drawn from there.
    assert figure.axes[0].get_xlim() == pytest.approx((0.0, 2.0 + 1.95 / 80))
    assert not hatches(figure)


def test_curves_are_those_of_the_values_asked_for(plane):
    np.testing.assert_allclose(plane.rows, [0.0, 0.125, 0.25, 0.375, 0.5])
    assert chosen_values(plane, None) == [0.125, 0.25, 0.375]
    assert chosen_values(plane, [0.49, 0.13, 0.49]) == [0.49, 0.13]
    figure = draw_curves(plane, [0.3])
    assert "$f_e$ = 0.3" in [figure.axes[0].get_title(place) for place in ("left", "center")]
    row = curves_at(plane, 0.3)
    top = np.nanmax(row.points["amplitude"])
    assert top < figure.axes[0].get_ylim()[1] < 1.2 * top and figure.axes[0].get_xlim()[0] == 0.0
    assert {"stable", "statically unstable", "dynamically unstable", "fold", "grazing, drive flank", "backbone"} <= set(
        texts(figure)
    )


def test_a_row_that_is_solved_is_the_stored_one(plane):
    """What is stored at 0.25 is what would be solved there, and its motions' stability that of its cells."""
    stored, solved = curves_at(plane, 0.25), solved_curves(plane.plan, 0.25)
    assert stored.points.keys() == solved.points.keys() and stored.ends == solved.ends
    for name, array in stored.points.items():
        np.testing.assert_allclose(solved.points[name], array, rtol=0.0, atol=1e-9, err_msg=name)
    assert [segment.impact for segment in stored.segments] == [segment.impact for segment in solved.segments]
    np.testing.assert_array_equal(stored.lasting, solved.lasting)
    x, looked = plane.plan.sweep.values, 0
    for segment, lasting in zip(stored.segments, stored.lasting, strict=True):
        inside = np.flatnonzero((x > segment.low) & (x < segment.high))
        if not segment.stable or not inside.size:
            continue
        place, height = (stored.points[name][segment.slice] for name in ("position", "amplitude"))
        order = np.argsort(place)
        for column in inside:
            amplitude = np.interp(x[column], place[order], height[order])
            gaps = np.abs(plane.amplitude[2, column] - amplitude)
            if np.nanmin(gaps) < 0.02 * amplitude:
                kind = plane.instability[2, column, np.nanargmin(gaps)]
                assert (kind in (Instability.NONE, Instability.CONTRADICTORY)) == lasting
                looked += 1
    assert looked > 30


def test_every_event_of_a_row_is_drawn(plane):
    """As markers in both panels; those that would hide each other once more, in an inset."""
    row = curves_at(plane, 0.375)
    drawn = draw_curves(plane, [0.375])
    events = row.points["event"]
    assert {Event.FOLD, Event.PERIOD_DOUBLING, Event.NEIMARK_SACKER, Event.MIN_AT_BACK} <= set(events)
    for axes, name in zip(drawn.axes[:1], ("amplitude",), strict=True):
        places = {
            (float(x), float(y))
            for line in axes.lines
            if line.get_linestyle() == "None" and line.get_marker() != "^"
            for x, y in zip(*line.get_data(), strict=True)
        }
        assert places == {
            (float(x), float(y))
            for x, y in zip(row.points["position"][events > 0], row.points[name][events > 0], strict=True)
        }
    frames = [(axes, patch) for axes in drawn.axes for patch in axes.patches if patch.get_zorder() == 8]
    assert len(frames) >= len(drawn.axes) == 2
    for axes, frame in frames:
        enlarged = [line for line in axes.lines if line.get_zorder() > 8]
        box = frame.get_window_extent()
        there = {tuple(place) for line in enlarged for place in line.get_transform().transform(line.get_xydata())}
        inside = np.array([place for place in there if box.contains(*place)])
        assert len(inside) > 1
        # Further from each other than a marker is wide.
        assert cKDTree(inside).query(inside, 2)[0][:, 1].min() > 0.04 * drawn.dpi


@given(st.integers(0, 2**32 - 1), st.integers(0, 60))
def test_an_inset_is_put_where_it_hides_nothing(seed, count):
    """Against all corners one by one."""
    draw = np.random.default_rng(seed)
    size, near = np.array([2.0, 1.5]), draw.uniform(0.0, 1.5, 2)
    blocked = draw.uniform((-0.1, -0.1), size + 0.1, (count, 2))
    found = _free_corner(size, blocked, near)
    across, up = (np.arange(0.04, length - side - 0.04, 0.06) for length, side in zip(size, (0.72, 0.56), strict=True))
    free = [
        (x, y)
        for x in across
        for y in up
        if not np.any(
            np.all((blocked >= (x - 0.04, y - 0.04)) & (blocked <= (x + 0.72 + 0.04, y + 0.56 + 0.04)), axis=1)
        )
    ]
    if not free:
        assert found is None
    else:
        assert tuple(found) in free
        away = [np.hypot(*(np.array(corner) + (0.36, 0.28) - near)) for corner in free]
        assert np.hypot(*(found + (0.36, 0.28) - near)) == pytest.approx(min(away))


def test_peaks_are_on_the_softening_side(plane):
    peaks = resonance_peaks([curves_at(plane, value) for value in plane.rows[1:]])
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
    assert hatches(figure) == {"//////"} and "row failed" in texts(figure)
    said = texts(draw_curves(plane, plane.rows.tolist()))
    assert said.count("row failed") == said.count("row not computed") == 2
    assert np.isnan(resonance_peaks([curves_at(plane, value) for value in plane.rows])[2:]).all()
    assert len(drawn(path, tmp_path, only=["backbone"])) == 1


@pytest.mark.costly
def test_nothing_but_failed_rows(tmp_path):
    plan = small_plan(columns=5, rows=2)
    path = small_store(tmp_path / "plane.zarr", plan, [])
    for block in plan.blocks:
        store.write_block(path, plan, block, [store.row_values(plan, "no reason")] * (block.stop - block.start))
    assert len(drawn(path, tmp_path, only=["curves", "backbone"])) == 2
    shown = texts(draw_map(read_stored(path)))
    assert "row failed" in shown and not any(text.endswith("%") for text in shown)


@pytest.mark.costly
def test_tiny_and_uniform(tmp_path):
    path = small_store(tmp_path / "tiny.zarr", small_plan(columns=5, rows=4))
    assert len(drawn(path, tmp_path)) == 3
    overrides = ("plane.sweep.min=1.4", "plane.sweep.max=1.6", "plane.parameter.max=0.05")
    path = small_store(tmp_path / "uniform.zarr", small_plan(*overrides, columns=4, rows=2))
    plane = read_stored(path)
    assert len(np.unique(plane.domain)) == 1
    shown = texts(draw_map(plane))
    assert "100.00 %" in shown and not any("fold" in text or "mode" in text for text in shown)
    assert len(drawn(path, tmp_path, only=["curves"])) == 1


@pytest.mark.costly
def test_runaway_branches(tmp_path):
    """Cells below the amplitude ceiling's exits are hatched, and the curves stay readable."""
    path = small_store(tmp_path / "plane.zarr", small_plan(*RUNAWAY, columns=61, rows=3))
    plane = read_stored(path)
    assert np.any(plane.open == 1) and np.nanmax(plane.points["amplitude"]) > 90.0
    figure = draw_map(plane)
    assert hatches(figure) == {"xx"} and "not excluded: motions" in texts(figure)
    figure = draw_curves(plane, None)
    assert all(axes.get_ylim()[1] < 45.0 for axes in figure.axes)
    assert any(r"ceiling $\lambda_a$ = 100" in text for text in texts(figure))
    exits = [line for line in figure.axes[0].lines if line.get_marker() == "^"]
    assert exits and all(0.4 < x < 0.7 for line in exits for x in line.get_xdata())
    draw_backbone(plane)


@pytest.mark.costly
def test_without_frequency_along_the_rows(tmp_path):
    path = small_store(tmp_path / "plane.zarr", small_plan(*NO_FREQUENCY, columns=21, rows=3))
    assert [p.name for p in drawn(path, tmp_path)] == ["map.png", "curves.png"]
    plane = read_stored(path)
    for figure in (draw_map(plane), draw_curves(plane, [0.6])):
        assert not any("mode" in text or "backbone" in text for text in texts(figure))


@pytest.mark.costly
def test_without_mean_load_there_is_no_backbone(tmp_path):
    path = small_store(tmp_path / "plane.zarr", small_plan("gear.f_pm=0", columns=5, rows=2))
    assert [p.name for p in drawn(path, tmp_path)] == ["map.png", "curves.png"]


def test_labels_by_dynamic_stability_leave_out_what_is_not_stable(made):
    """A multiplier beyond +1 is left to static stability (docs/physics.md, section 6)."""
    static, dynamic = read_stored(made), read_stored(made, dynamic=True)
    root = xr.open_zarr(made)
    kept = (root.stable == 1) & root.instability.isin((Instability.NONE, Instability.CONTRADICTORY))
    np.testing.assert_array_equal(dynamic.n_stable, kept.sum("solution"))
    assert np.all(dynamic.n_stable <= static.n_stable)
    np.testing.assert_array_equal(dynamic.unstable, dynamic.n_stable < static.n_stable)
    np.testing.assert_array_equal(dynamic.domain[~dynamic.unstable], static.domain[~dynamic.unstable])
    assert np.any(dynamic.unstable) and np.any(dynamic.contradictory)
    for row, column in np.argwhere(dynamic.unstable):
        states = root.impact[row, column].values[kept[row, column].values]
        mask = sum({1 << int(state) for state in states})
        assert dynamic.domain[row, column] == domain_code(states.size, mask)


@pytest.fixture(scope="module")
def traced(tmp_path_factory):
    """A plane with boundaries."""
    plan = small_plan("plane=omega_fe", columns=60, rows=16)
    return traced_store(tmp_path_factory.mktemp("figures") / "plane.zarr", plan)


@pytest.mark.costly
@pytest.mark.parametrize("dynamic", [False, True])
def test_what_is_unstable_is_shaded_up_to_the_curves(traced, dynamic):
    """At the magnification of a window as in the whole: no cell is seen."""
    plane = read_stored(traced, dynamic=dynamic)
    for x, y in ((None, None), ((1.2, 1.2003), (0.35, 0.3502))):
        panel = panel_of(plane, x, y)
        assert panel.code.shape == (900, 1440)
        codes = stored_division(plane).codes_at(
            *(low + (np.arange(n) + 0.5) / n * (high - low) for (low, high), n in ((panel.x, 1440), (panel.y, 900)))
        )
        shown = dynamic_code(codes) if dynamic else static_code(codes)
        np.testing.assert_array_equal(panel.code, shown)
        np.testing.assert_array_equal(panel.unstable, (static_code(codes) != dynamic_code(codes)) & (not dynamic))
        np.testing.assert_array_equal(panel.contradictory, is_contradictory(codes))
    said = texts(draw_map(plane))
    assert ("not all $n$ dynamically stable" in said) == (not dynamic)
    assert any(text.startswith("0/\N{EN DASH}  no stable") for text in said) == dynamic
    assert "stability contradictory:" in said


def test_windows_are_those_of_the_branches(traced):
    """Two ways: the division of the plane by its boundaries, and the branches of its rows."""
    plane, without = read_stored(traced), read_stored(traced)
    vars(without)["boundaries"] = None
    assert stored_division(plane) is not None and stored_division(without) is None
    assert coexistence_windows(plane) == coexistence_windows(without) != []


@pytest.mark.costly
def test_shares_of_the_legend_are_those_of_the_thresholds(traced):
    found: dict[str, float] = {}
    for one in pipeline.thresholds(traced):
        found[one.label] = found.get(one.label, 0.0) + one.share
    plane = read_stored(traced)
    shares = {plane.labels[code]: share for code, share in shares_of_labels(plane).items()}
    assert shares == pytest.approx(found, abs=2e-7)
    said = texts(draw_map(plane))
    for label, share in found.items():
        following = [said[i + 1] for i, text in enumerate(said[:-1]) if text == label]
        assert following.count(f"{100 * share:.2f} %" if share >= 5e-5 else "< 0.01 %") == 1


def test_backbones_are_drawn_once_at_round_values(tmp_path):
    """Backbones of two gaps are one up to the smaller; rows with one and the same peak show it once."""
    plan = small_plan("plane=omega_b", "plane.parameter.min=0.9", columns=41, rows=3)
    plane = read_stored(small_store(tmp_path / "b.zarr", plan))
    assert round_values(plane, 5) == [1.0, 1.2, 1.4]
    assert round_values(plane, 26)[:3] == [0.9, 0.925, 0.95]
    figure = draw_backbone(plane)
    for axes in figure.axes[:2]:
        lines = [line for line in axes.lines if line.get_linewidth() > 1.0]
        assert len(lines) == 3
        segments = {
            tuple(np.round(end, 9))
            for line in lines
            for end in zip(line.get_xdata()[:-1], line.get_ydata()[:-1], line.get_xdata()[1:], strict=True)
        }
        assert len(segments) == sum(len(line.get_xdata()) - 1 for line in lines)
        dots = np.concatenate([found.get_offsets() for found in axes.collections])
        assert len(np.unique(np.round(dots, 6), axis=0)) == len(dots) > 0
    titles = [axes.get_title(loc="left") or axes.get_title() for axes in figure.axes[:2]]
    assert titles == ["(a) backbone of the lower mode, 46 % mesh", "(b) backbone of the upper mode, 54 % mesh"]
    assert any("order 1" in text for text in texts(figure))


@pytest.mark.costly
def test_figures_of_dynamic_stability_have_names_of_their_own(traced, tmp_path):
    paths = figures.draw(traced, tmp_path, [0.25], ["png"], 30, stability="dynamic", only=["map", "curves"])
    names = ["map-dynamic.png", "curves-dynamic.png"]
    assert [path.name for path in paths] == names and {path.name for path in tmp_path.iterdir()} == set(names)


@pytest.mark.costly
def test_labels_are_written_into_their_regions(traced):
    """Inside of the region, or with a line that ends in it; each label once or more in an enlargement or the whole."""
    plane = read_stored(traced)
    panel = panel_of(plane, (0.5, 0.7))
    labels = placed_labels(panel.code, np.zeros_like(panel.code), plane.labels, (3.2, 2.5))
    assert {label.text for label in labels} >= {plane.labels[int(c)] for c in np.unique(panel.code)} - {"3/1-2", "2/2"}
    rows, columns = panel.code.shape
    for label in labels:
        across, up = label.leads_to or label.place
        assert panel.code[int(up * rows), int(across * columns)] == label.code
        assert all(0.0 < share < 1.0 for share in label.place)
    boxes = [(*label.place, 0.052 * len(label.text) / 3.2, 0.1 / 2.5) for label in labels]
    for i, (x, y, wide, tall) in enumerate(boxes):
        for other, level, width, height in boxes[:i]:
            assert abs(x - other) >= 0.5 * (wide + width) or abs(y - level) >= 0.5 * (tall + height)


@pytest.mark.costly
def test_multipliers_along_a_row(plane, tmp_path):
    """Drawn where asked for: those of the motions of the row, the largest ones up to what cells store."""
    assert "multipliers.png" not in {path.name for path in drawn(plane.path, tmp_path / "without")}
    paths = figures.draw(plane.path, tmp_path, None, ["png"], 50, multipliers=[0.25, 0.3], only=["multipliers"])
    assert [path.name for path in paths] == ["multipliers.png"]
    row = curves_at(plane, 0.25)
    largest = np.abs(row.multipliers).max(axis=1)
    columns, looked = plane.plan.sweep.values, 0
    for column in range(len(columns)):
        for point in np.flatnonzero(np.abs(row.points["position"] - columns[column]) < 1e-12):
            gaps = np.abs(plane.amplitude[2, column] - row.points["amplitude"][point])
            if np.nanmin(gaps) < 1e-9:
                stored = plane.array("multiplier")[2, column, np.nanargmin(gaps)]
                assert largest[point] == pytest.approx(stored, abs=1e-9)
                looked += 1
    assert looked > 0
    # At a period doubling one is -1, at a Neimark-Sacker a pair lies on the circle.
    for event, miss in (
        (Event.PERIOD_DOUBLING, np.min(np.abs(row.multipliers + 1.0), axis=1)),
        (Event.NEIMARK_SACKER, np.min(np.abs(np.abs(row.multipliers) - 1.0), axis=1)),
    ):
        at = row.points["event"] == event
        assert np.any(at) and np.all(miss[at] < 1e-6)
    with pytest.raises(ConfigurationError, match="figures.multipliers = 7.0"):
        figures.check_options(plane.plan, figures.figure_options(None, ["png"], 60, multipliers=[7.0]))
