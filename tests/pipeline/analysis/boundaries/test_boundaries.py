"""Boundaries in the store: schema, agreement with the rows, atomicity, CSV, and windows drawn from them."""

import csv
import shutil

import numpy as np
import pytest
import xarray as xr
import zarr

from pipeline import figures, store
from pipeline.__main__ import main
from pipeline.analysis import boundaries
from pipeline.analysis.boundaries.events import MARGINS, dead_zone_at, read_events
from pipeline.errors import ConfigurationError
from pipeline.plan.numerics import model_at
from pipeline.plane.boundaries import read_boundaries, special_places
from pipeline.plane.division import stored_division
from pipeline.plane.stored import read_stored
from pipeline.run.rows import sweep_block
from pipeline.store import groups
from solver import Event, all_solutions, domain_code, impact_state
from solver.boundaries import BIFURCATIONS, FOLDS_AND_GRAZINGS, SPECTRAL, SpecialPoint
from solver.regions.labelling import static_code
from tests.pipeline.planes import contents, small_plan, small_store, traced_store

PLANES = ("omega_b", "omega_alpha", "omega_fe", "omega_fpm")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A small plane with its boundaries, and what is said of them."""
    plan = small_plan("plane=omega_fe", columns=60, rows=16)
    path = traced_store(tmp_path_factory.mktemp("boundaries") / "plane.zarr", plan)
    return plan, path, boundaries.trace(path, plan)


@pytest.fixture(scope="module")
def few(tmp_path_factory):
    """As `made`, of few rows and columns, where it is no matter which boundaries there are."""
    window = ("plane.sweep.min=0.55", "plane.sweep.max=0.65", "plane.parameter.max=0.1")
    plan = small_plan("plane=omega_fe", *window, columns=10, rows=3)
    return plan, traced_store(tmp_path_factory.mktemp("few") / "plane.zarr", plan)


def test_schema(made):
    plan, path, summary = made
    group = xr.open_zarr(path, group="boundaries").load()
    sizes = group.row_size.values
    assert group.row_size.attrs["sample_dimension"] == "boundary_point"
    assert group.sizes == {"curve": sizes.size, "end": 2, "boundary_point": sizes.sum()}
    assert set(group.coords) == {"omega", "f_e"} and group.omega.dims == group.f_e.dims == ("boundary_point",)
    for name in ("mean", "cos", "sin", "amplitude", "arclength", "stable", "special"):
        assert group[name].dims == ("boundary_point",) and group[name].attrs["long_name"]
    for name in ("kind", "closed", "side", "end_reason", "stable", "special"):
        flags = group[name].attrs
        assert len(flags["flag_values"]) == len(flags["flag_meanings"].split())
        assert set(np.unique(group[name])) <= set(flags["flag_values"])
    assert group.special.attrs["flag_meanings"].split()[SpecialPoint.CUSP] == "cusp"
    assert np.all(np.isin(group.kind, (*FOLDS_AND_GRAZINGS, *SPECTRAL)))
    # Which side of a curve of multipliers the motion is stable on is not told.
    np.testing.assert_array_equal(group.side == 0, np.isin(group.kind, SPECTRAL))
    np.testing.assert_array_equal(group.amplitude, np.hypot(group.cos, group.sin))
    assert sum(summary.curves.values()) == sizes.size and summary.points == sizes.sum() and not summary.cut_short
    assert group.attrs["configuration_hash"] == plan.fingerprint
    assert xr.open_zarr(path).sizes == {"f_e": 16, "omega": 60, "solution": plan.max_solutions}
    tree = xr.open_datatree(path, engine="zarr")
    assert tree["boundaries"]["omega"].dims == tree["boundaries"]["mean"].dims == ("boundary_point",)
    assert zarr.open_group(path).metadata.consolidated_metadata is not None


def test_stored_curves_are_read_back(made):
    plan, path, _ = made
    group = xr.open_zarr(path, group="boundaries").load()
    curves = read_boundaries(path, plan).curves
    np.testing.assert_array_equal(np.concatenate([curve.points[:, 3] for curve in curves]), group.omega)
    np.testing.assert_array_equal(np.concatenate([curve.slopes[:, 4] for curve in curves]), group.f_e_slope)
    for curve in curves:
        assert np.all(np.diff(curve.arclength) >= 0.0)
        grazed = np.array([MARGINS.get(curve.kind, (0.0, 0.0))])
        if curve.kind in MARGINS:
            margin = curve.points[:, 0] + grazed[:, 0] * curve.amplitude - grazed[:, 1] * 1.0
            np.testing.assert_allclose(margin, 0.0, atol=1e-8)


def test_every_event_of_the_rows_lies_on_a_stored_curve(made):
    plan, path, _ = made
    events, curves = read_events(path, plan), read_boundaries(path, plan).curves
    assert events.rows == 16 and len(events.kind) > 50
    for kind, point in zip(events.kind, events.points, strict=True):
        # Along both axes: next to an extremum one of them is ill-conditioned. On the border a line meets only the end.
        found = [curve.points[[0, -1]] for curve in curves if curve.kind == kind]
        found += [
            curve.arcs.crossings(axis, point[[axis]]).points
            for curve in curves
            for axis in (3, 4)
            if curve.kind == kind
        ]
        assert np.min(np.max(np.abs(np.concatenate(found) - point), axis=1)) < 1e-6


def check_bifurcations(path, plan) -> int:
    """Rows between the first and the last one have located what stored bifurcation curves cross there, and no more."""
    events, rows = read_events(path, plan), plan.parameter.values[1:-1]
    wanted = np.isin(events.kind, BIFURCATIONS) & np.isin(events.points[:, 4], rows)
    seen = np.zeros(events.kind.size, dtype=int)
    for curve in read_boundaries(path, plan).curves:
        for point in curve.arcs.crossings(4, rows).points if curve.kind in BIFURCATIONS else ():
            # Where a curve turns round in the row parameter its place along the row is not as exact.
            near = np.max(np.abs(events.points - point), axis=1) < 1e-5
            assert np.sum(near & (events.kind == curve.kind)) == 1, (curve.kind.name, point)
            seen += near & (events.kind == curve.kind)
    np.testing.assert_array_equal(seen, wanted)
    return int(seen.sum())


def test_rows_locate_what_stored_bifurcation_curves_cross(made):
    assert check_bifurcations(made[1], made[0]) > 50


@pytest.mark.slow
@pytest.mark.parametrize("gear", ["published", "antiphase"])
@pytest.mark.parametrize("name", PLANES)
def test_rows_locate_what_stored_bifurcation_curves_cross_in_all_planes(tmp_path, name, gear):
    plan = small_plan(f"plane={name}", f"gear={gear}", columns=200, rows=60)
    path = small_store(tmp_path / "plane.zarr", plan)
    boundaries.trace(path, plan)
    assert check_bifurcations(path, plan) > 50


def along_rows(curve, plan):
    """Where a curve crosses the rows, in which interval of columns, and whether its side lies towards growing x."""
    rows = plan.parameter.values.copy()
    # On the first row a curve only begins.
    rows[0] += 1e-12 * (rows[-1] - rows[0])
    found = curve.arcs.crossings(4, rows)
    interval = np.searchsorted(plan.sweep.values, found.points[:, 3]) - 1
    # To the right of a curve that runs upwards.
    return found, interval, -found.direction * curve.side


def check_raster_against_curves(path, plan):
    """Number of solutions and of stable ones in each impact state: what differs between neighbouring cells of a row is
    the sum over the curves that pass between them."""
    plane = xr.open_zarr(path).load()
    count = plane.n_solutions.values.astype(int)
    stable = (plane.stable.values == 1)[..., None] & (plane.impact.values[..., None] == np.arange(6))
    states = stable.sum(axis=2)
    count_change, state_change = np.zeros_like(np.diff(count)), np.zeros_like(np.diff(states, axis=1))
    crossings = 0
    for curve in read_boundaries(path, plan).curves:
        found, interval, sign = along_rows(curve, plan)
        inside = (interval >= 0) & (interval < plan.sweep.num - 1) & curve.arc_shows[found.arc]
        points, place, sign = found.points[inside], (found.line[inside], interval[inside]), sign[inside]
        crossings += len(points)
        _, b = dead_zone_at(plan, points[:, 3], points[:, 4])
        size = np.hypot(points[:, 1], points[:, 2])
        if curve.kind is Event.FOLD:
            np.add.at(count_change, place, 2 * sign)
            np.add.at(state_change, (*place, impact_state(points[:, 0] - size, points[:, 0] + size, b)), sign)
            continue
        for beyond, share in ((1e-6, 1), (-1e-6, -1)):
            moved = points[:, 0] + beyond
            np.add.at(state_change, (*place, impact_state(moved - size, moved + size, b)), share * sign)
    np.testing.assert_array_equal(count_change, np.diff(count))
    np.testing.assert_array_equal(state_change, np.diff(states, axis=1))
    assert crossings > 0


def test_raster_and_curves_are_two_methods_for_the_same_thing(made):
    check_raster_against_curves(made[1], made[0])


@pytest.mark.slow
@pytest.mark.parametrize("name", PLANES)
def test_raster_and_curves_agree_on_the_reference_planes(tmp_path, name):
    plan = small_plan(f"plane={name}", columns=200, rows=60)
    path = small_store(tmp_path / "plane.zarr", plan)
    boundaries.trace(path, plan)
    check_raster_against_curves(path, plan)
    plane = read_stored(path)
    said = stored_division(plane).codes_at(plan.sweep.values[1:-1], plane.rows)
    np.testing.assert_array_equal(said, plane.stability_codes[:, 1:-1])


@pytest.mark.costly
def test_regions_are_what_enumeration_finds(made):
    plan, path, _ = made
    x, p = np.linspace(0.52, 0.69, 7), np.linspace(0.013, 0.491, 8)
    code = static_code(stored_division(read_stored(path)).codes_at(x, p))
    assert np.unique(code).size > 5
    for i, f_e in enumerate(p):
        for j, omega in enumerate(x):
            assert code[i, j] == enumerated_code(plan, omega, f_e)


def enumerated_code(plan, omega, value):
    found = all_solutions(model_at(plan, value, omega), omega)
    lasting = found.stable == 1
    states = impact_state((found.mean - found.amplitude)[lasting], (found.mean + found.amplitude)[lasting], 1.0)
    return domain_code(lasting.sum(), np.bitwise_or.reduce(1 << states.astype(int), initial=0))


def test_a_second_time_there_is_nothing_to_do(few, tmp_path):
    plan, traced = few
    path = shutil.copytree(traced, tmp_path / "plane.zarr")
    groups.remove_group(path, "boundaries")
    first = boundaries.trace(path, plan)
    before = (path / "boundaries/mean/c/0").stat().st_mtime_ns
    again = boundaries.trace(path, plan)
    assert again.found_done and not first.found_done and again.curves == first.curves
    assert (path / "boundaries/mean/c/0").stat().st_mtime_ns == before


@pytest.mark.costly
def test_what_a_killed_run_leaves_behind_is_replaced(few, tmp_path):
    plan, path = few
    expected = contents(path)
    for state in ("moved in, not listed", "taken away, still listed", "old draft"):
        copy = shutil.copytree(path, tmp_path / f"{state[:3]}.zarr")
        if state == "moved in, not listed":
            (copy / "boundaries").rename(tmp_path / "aside")
            store.consolidate(copy)
            (tmp_path / "aside").rename(copy / "boundaries")
        elif state == "taken away, still listed":
            (copy / "boundaries").rename(tmp_path / f".{copy.name}.boundaries.old")
        else:
            groups.remove_group(copy, "boundaries")
            (tmp_path / f".{copy.name}.boundaries.draft" / "left over").mkdir(parents=True)
        assert read_boundaries(copy, plan) is None
        assert not boundaries.trace(copy, plan).found_done
        for name, values in contents(copy).items():
            assert values.tobytes() == expected[name].tobytes() if values.dtype.kind != "T" else True, name
        assert [p.name for p in tmp_path.iterdir()] == [copy.name]
        assert xr.open_zarr(copy, group="boundaries").sizes == xr.open_zarr(path, group="boundaries").sizes
        shutil.rmtree(copy)


@pytest.mark.costly
def test_other_rows_give_other_boundaries(tmp_path):
    plan = small_plan("plane=omega_fe", "plane.sweep.min=0.55", "plane.sweep.max=0.65", columns=20, rows=6)
    path = small_store(tmp_path / "plane.zarr", plan, plan.blocks[:2])
    few = boundaries.trace(path, plan)
    # The sweep goes on: rows that were not complete now are.
    for block in plan.blocks[2:]:
        sweep_block(str(path), plan, block)
    more = boundaries.trace(path, plan)
    assert not more.found_done and sum(more.curves.values()) > sum(few.curves.values())


@pytest.mark.costly
def test_a_plane_without_boundaries(tmp_path):
    plan = small_plan("plane=omega_fe", "plane.sweep.min=1.6", "plane.parameter.max=0.1", columns=5, rows=3)
    path = small_store(tmp_path / "plane.zarr", plan)
    summary = boundaries.trace(path, plan)
    assert summary.points == 0 and summary.curves == {} and boundaries.trace(path, plan).found_done
    assert xr.open_zarr(path, group="boundaries").load().sizes["curve"] == 0
    paths = boundaries.write_sheets(read_boundaries(path, plan), plan, tmp_path, "plane")
    assert [len(path.read_text().splitlines()) for path in paths] == [1, 1]
    assert all(path.stat().st_size > 0 for path in figures.draw(path, tmp_path / "figures", None, ["png"], 60))


def test_csv_equals_the_store(made, tmp_path):
    plan, path, summary = made
    stored = read_boundaries(path, plan)
    paths = boundaries.write_sheets(stored, plan, tmp_path / "one", "plane")
    again = boundaries.write_sheets(stored, plan, tmp_path / "two", "plane")
    assert [path.name for path in paths] == ["plane.csv", "plane-special.csv"]
    assert [path.read_bytes() for path in paths] == [path.read_bytes() for path in again]
    with paths[0].open(newline="") as file:
        lines = list(csv.DictReader(file))
    group = xr.open_zarr(path, group="boundaries").load()
    for name in ("omega", "f_e", "mean", "amplitude"):
        np.testing.assert_array_equal([float(line[name]) for line in lines], group[name])
    np.testing.assert_array_equal([int(line["stable"]) for line in lines], group.stable)
    np.testing.assert_array_equal([SpecialPoint[line["special"].upper()] for line in lines], group.special)
    curve = np.repeat(np.arange(group.sizes["curve"]), group.row_size)
    np.testing.assert_array_equal([int(line["curve"]) for line in lines], curve)
    np.testing.assert_array_equal([Event[line["kind"].upper()] for line in lines], group.kind.values[curve])
    with paths[1].open(newline="") as file:
        special = list(csv.DictReader(file))
    assert len(special) == sum(summary.special.values()) and special[0]["special"] == "cusp"


@pytest.mark.parametrize(
    "window",
    [
        [0.5, 0.6, 0.1],
        [0.6, 0.5, 0.1, 0.2],
        [0.5, 0.6, 0.2, 0.2],
        [0.01, 0.6, 0.1, 0.2],
        [0.5, 0.6, 0.1, 0.9],
        [0.5, float("nan"), 0.1, 0.2],
        [0.5, 0.5000001, 0.1, 0.2],
        [],
    ],
)
def test_windows_that_are_refused(window):
    with pytest.raises(ConfigurationError, match=r"figures\.window = .* is not allowed") as caught:
        figures.check_options(small_plan("plane=omega_fe"), figures.figure_options(None, ["png"], 100, window=window))
    assert "\n" not in str(caught.value)


@pytest.mark.costly
def test_a_window_at_a_thousandfold_magnification_around_a_cusp(made, tmp_path):
    plan, path, _ = made
    (x, p), *_ = [
        curve.points[place, 3:]
        for curve in read_boundaries(path, plan).curves
        for place in special_places(curve)
        if 0.2 < curve.points[place, 4] < 0.3
    ]
    window = [x - 1e-3, x + 1e-3, p - 2.5e-4, p + 2.5e-4]
    # Away from the edges of the wedge, which is a tenth of this window wide at its border.
    across, up = np.linspace(window[0], window[1], 12), np.linspace(window[2], window[3], 10)
    code = static_code(stored_division(read_stored(path)).codes_at(across, up))
    assert np.unique(code).size > 1
    for i, f_e in enumerate(up):
        for j, omega in enumerate(across):
            assert code[i, j] == enumerated_code(plan, omega, f_e)
    made_twice = []
    for folder in ("one", "two"):
        (drawn,) = figures.draw(path, tmp_path / folder, None, ["pdf"], 60, window=window, only=["map-window"])
        made_twice.append(drawn.read_bytes())
    assert drawn.name == "map-window.pdf" and made_twice[0] == made_twice[1]


SMALL = [
    "plane=omega_fe",
    "store.name=omega_fe",
    "plane.sweep.min=0.55",
    "plane.sweep.max=0.65",
    "plane.parameter.max=0.3",
    "plane.sweep.num=20",
    "plane.parameter.num=8",
    "cluster=none",
    "figures.formats=[png]",
    "figures.dpi=30",
    "figures.curves=[0.2]",
]


@pytest.mark.costly
def test_the_stage(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main([*SMALL, "stages=[sweep,boundaries]"]) == 0
    said = capsys.readouterr().out
    assert "fold curves" in said and "cusp" in said
    names = {path.name for path in (tmp_path / "outputs/boundaries").glob("[!.]*")}
    assert names == {"omega_fe.csv", "omega_fe-special.csv"}
    assert main([*SMALL, "stages=[boundaries]"]) == 0
    assert "nothing to do" in capsys.readouterr().out

    def fails(*arguments, **options):
        raise ArithmeticError("the corrector fails")

    groups.remove_group(tmp_path / "outputs/store/omega_fe.zarr", "boundaries")
    monkeypatch.setattr("pipeline.analysis.boundaries.tracing.boundary_curves", fails)
    assert main([*SMALL, "figures.window=[0.56,0.64,0.1,0.28]"]) == 1
    caught = capsys.readouterr()
    assert "cannot be traced: the corrector fails" in caught.err and len(caught.err.splitlines()) == 1
    assert "map-window.png" in caught.out
    # The figures come from the raster then.
    for name in ("map", "map-window"):
        assert (tmp_path / f"outputs/figures/omega_fe/{name}.png").stat().st_size > 0


@pytest.mark.costly
def test_incomplete_rows_are_left_out_and_said(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main([*SMALL, "stages=[sweep]"]) == 0
    path = tmp_path / "outputs/store/omega_fe.zarr"
    zarr.open_group(path, mode="r+")["status"][3] = store.FAILED
    capsys.readouterr()
    assert main([*SMALL, "stages=[boundaries,figures]"]) == 0
    assert capsys.readouterr().out.count("note: 1 row ") == 2
    stored = store.read_plan(path)
    assert read_events(path, stored).rows == 7
    # A sweep that goes on takes the boundaries of the rows as they were away.
    assert main([*SMALL, "stages=[sweep]"]) == 0
    assert read_boundaries(path, stored) is None
