"""Basins and jumps: the numbers of the time domain, what is stored, exported and redone, and what is not allowed."""

import csv
import dataclasses

import numpy as np
import pytest
import xarray as xr

from pipeline.__main__ import main
from pipeline.analysis.attractor_flags import attractor_code, attractor_flags, attractor_label
from pipeline.analysis.basins import running as basins
from pipeline.analysis.jumps import running as jumps
from pipeline.analysis.verification.verdicts import settling_of
from pipeline.config.compose import compose
from pipeline.plan.numerics import point_of
from pipeline.plane.stored import StoredPlane
from pipeline.run.workforce import Workforce
from solver import domain_parts, gear_system
from solver.timedomain import AttractorKind, basin_shares, settle, wilson_interval
from tests.pipeline.planes import cluster, small_plan, small_store

RUN = Workforce(cluster("none")).run


def silent(done, failed):
    """Progress that nobody watches."""


def options(section, **changes):
    return dataclasses.replace(getattr(compose([]).config, section), **{"max_periods": 600, **changes})


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A small plane around the lower resonance."""
    plan = small_plan("plane.sweep.min=0.5", "plane.sweep.max=0.66", columns=9, rows=4)
    return plan, small_store(tmp_path_factory.mktemp("basins") / "plane.zarr", plan)


def test_labels_of_attractors():
    flags = attractor_flags()
    meanings = flags["flag_meanings"].split()
    assert len(meanings) == len(set(meanings)) == len(flags["flag_values"]) == len(flags["labels"])
    assert {"1T/0", "2T/1", "nT/2", "chaotic/2", "quasi-periodic/1", "unbounded"} <= set(flags["labels"])
    assert {"T1_I0", "T2_I1", "chaotic_I2", "quasi_periodic_I1"} <= set(meanings)
    assert all(meaning[0].isalpha() for meaning in meanings) and attractor_label(0) == ""
    (attractor,) = settle(gear_system(point_of(small_plan(), 0.1, 1.0)[0]), 1.0, [[1.6, 1.6, 0.0, 0.0]])
    assert attractor.kind is AttractorKind.PERIOD_1 and attractor_label(attractor_code(attractor)) == "1T/0"


def test_basins_of_coexisting_motions(made, tmp_path):
    plan, path = made
    asked = options("basins", cells=3, starts=6)
    found, done = basins.measure(path, plan, asked, RUN, silent)
    assert not done and found.messages.tolist() == [""] * 3
    group = xr.open_zarr(path, group="basins").load()
    domain = StoredPlane(path, plan).domain
    assert np.all(domain_parts(domain[group.row, group.column])[0] >= 2)
    np.testing.assert_array_equal(group["count"].sum("attractor"), 6)
    for i in range(3):
        x, p = float(group.cell_omega[i]), float(group.cell_f_e[i])
        model, omega = point_of(plan, p, x)
        expected = basin_shares(gear_system(model), omega, 6, 0, settling=settling_of(600))
        assert int(group.n_attractors[i]) == len(expected)
        for j, one in enumerate(expected):
            assert int(group["count"][i, j]) == one.count and float(group.share[i, j]) == one.share
            assert (float(group.share_low[i, j]), float(group.share_high[i, j])) == wilson_interval(one.count, 6)
            assert int(group.attractor_code[i, j]) == attractor_code(one.attractor)
            np.testing.assert_array_equal(group.amplitude[i, j], one.attractor.amplitude)
        assert np.all(group.attractor_code[i, len(expected) :] == 0)
    assert basins.measure(path, plan, asked, None, silent)[1]
    sheet = basins.write_sheet(found, plan, tmp_path, "plane")
    with sheet.open(newline="") as file:
        lines = list(csv.DictReader(file))
    assert len(lines) == int(group.n_attractors.sum()) and sum(int(line["count"]) for line in lines) == 18
    assert {line["attractor"] for line in lines} <= set(attractor_flags()["labels"])


def test_basins_at_given_points(made):
    plan, path = made
    found, _ = basins.measure(path, plan, options("basins", points=[[0.52, 0.1], [0.6, 0.2]], starts=4), RUN, silent)
    assert found.places["x"].tolist() == [0.52, 0.6] and found.places["p"].tolist() == [0.1, 0.2]
    assert found.places["row"].tolist() == [-1, -1] and found.places["n_attractors"][0] == 1
    assert np.all(found.found["count"].sum(axis=1) == 4)


def test_a_plane_without_coexisting_motions(tmp_path):
    plan = small_plan("plane.sweep.min=1.6", "plane.parameter.max=0.05", columns=3, rows=2)
    path = small_store(tmp_path / "plane.zarr", plan)
    found, done = basins.measure(path, plan, options("basins"), RUN, silent)
    assert not done and found.messages.size == 0 and basins.measure(path, plan, options("basins"), RUN, silent)[1]
    assert xr.open_zarr(path, group="basins").load().sizes["cell"] == 0


def test_jumps_along_rows(made, tmp_path):
    plan, path = made
    asked = options("jumps", rows=2)
    found, done = jumps.follow(path, plan, asked, RUN, silent)
    assert not done and found.rows.tolist() == [0, 3]
    group = xr.open_zarr(path, group="jumps").load()
    labels = group.sweep_up.attrs["labels"]
    # Without transmission error nothing happens; beside the resonance the stable motion of the map is found.
    said = [labels[group.sweep_up.attrs["flag_values"].index(int(code))] for code in group.sweep_up[0]]
    assert said == ["1T/0"] * 9 and np.all(group.hysteresis[0] == 0) and group.hysteresis_width[0] == 0.0
    np.testing.assert_array_equal(group.amplitude_up[0], found.followed["amplitude_up"][0])
    assert group.row_f_e.values.tolist() == plan.parameter.values[[0, 3]].tolist()
    # Both ways start where the neighbour ended: settling from there gives the same.
    differs = group.hysteresis[1].values == 1
    change = np.abs(group.amplitude_up[1] - group.amplitude_down[1]).values > 1e-6
    assert differs.any() and np.all(change[differs] | (group.sweep_up[1] != group.sweep_down[1]).values[differs])
    intervals = found.intervals[1][~np.isnan(found.intervals[1, :, 0])]
    assert found.widths[1] == pytest.approx(np.sum(intervals[:, 1] - intervals[:, 0]))
    assert found.widths[1] == float(group.hysteresis_width[1])
    for x, flag in zip(plan.sweep.values, differs, strict=True):
        assert np.any((intervals[:, 0] <= x) & (x <= intervals[:, 1])) == flag
    assert jumps.follow(path, plan, asked, None, silent)[1]
    sheets = jumps.write_sheets(found, plan, tmp_path, "plane")
    assert [len(path.read_text().splitlines()) for path in sheets] == [1 + 2 * 9, 1 + len(intervals)]


def test_rows_by_value():
    plan = small_plan("plane.parameter.max=0.4", rows=5)
    assert jumps.rows_of(plan, options("jumps", values=[0.39, 0.12, 0.4])).tolist() == [1, 4]
    assert jumps.rows_of(plan, options("jumps", rows=5)).tolist() == [0, 1, 2, 3, 4]


def test_what_fails_is_recorded(made, monkeypatch):
    plan, path = made

    def broken(*arguments, **options):
        raise ArithmeticError("the step is lost")

    monkeypatch.setattr("solver.timedomain.basin_shares", broken)
    monkeypatch.setattr("solver.timedomain.sweep_attractors", broken)
    found, _ = basins.measure(path, plan, options("basins", cells=2, starts=5), RUN, silent)
    assert found.messages.tolist() == ["ArithmeticError: the step is lost"] * 2 and found.found["count"].shape == (2, 0)
    found, _ = jumps.follow(path, plan, options("jumps", rows=1), RUN, silent)
    assert found.messages.tolist() == ["ArithmeticError: the step is lost"]
    assert np.all(xr.open_zarr(path, group="jumps").sweep_up == 0)


SMALL = [
    "store.name=omega_fe",
    "plane.sweep.min=0.5",
    "plane.sweep.max=0.66",
    "plane.sweep.num=5",
    "plane.parameter.num=3",
    "cluster=none",
    "basins.starts=3",
    "basins.cells=2",
    "basins.max_periods=400",
    "jumps.rows=2",
    "jumps.max_periods=400",
]


def test_the_stages(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main([*SMALL, "stages=[sweep,basins,jumps]"]) == 0
    said = capsys.readouterr().out
    assert "basins: " in said and "jumps: 2 rows" in said
    assert {path.name for path in (tmp_path / "outputs/jumps").iterdir()} == {"omega_fe.csv", "omega_fe-hysteresis.csv"}
    assert (tmp_path / "outputs/basins/omega_fe.csv").is_file()
    assert main([*SMALL, "stages=[basins,jumps]"]) == 0
    assert capsys.readouterr().out.count("nothing to do") == 2


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("basins.cells=0", "basins.cells = 0 is not allowed: it must be from 1 to 1e+06"),
        ("basins.starts=0", "basins.starts = 0 is not allowed: it must be from 1 to 1e+06"),
        ("basins.points=[]", "basins.points = [] is not allowed: it must be null or a list of [omega, f_e]"),
        (
            "basins.points=[[0.6,0.7]]",
            "basins.points = [0.6, 0.7] is not allowed: it must be [omega, f_e] within omega",
        ),
        ("basins.points=[[0.6]]", "basins.points = [0.6] is not allowed: it must be [omega, f_e] within"),
        ("basins.points=[0.6,0.2]", "basins.points = 0.6 is not allowed: it must be [omega, f_e] within"),
        ("basins.points=[[0.6,nan]]", "basins.points = [0.6, nan] is not allowed: it must be [omega, f_e] within"),
        ("basins.points=here", "basins.points = here is not allowed: it must be null or a list of [omega, f_e]"),
        ("jumps.rows=4", "jumps.rows = 4 is not allowed: it must be from 1 to 3"),
        ("jumps.values=[0.7]", "jumps.values = 0.7 is not allowed: it must lie within f_e = 0 ... 0.5"),
        ("jumps.max_periods=1", "jumps.max_periods = 1 is not allowed: it must be from 300 to 1e+07"),
    ],
)
def test_bad_input_is_one_line(tmp_path, monkeypatch, capsys, override, message):
    monkeypatch.chdir(tmp_path)
    assert main([*SMALL, "stages=[sweep,basins,jumps]", override]) == 2
    error = capsys.readouterr().err
    assert message in error and len(error.splitlines()) == 1 and not list(tmp_path.iterdir())
