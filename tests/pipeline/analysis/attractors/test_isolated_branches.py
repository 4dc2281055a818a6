"""Branches that rows lack, stored beside the attractors that they were found from."""

import csv
import shutil

import numpy as np
import pytest

import pipeline
from pipeline.__main__ import main
from pipeline.analysis.attractors import isolated
from pipeline.errors import StoreError
from pipeline.figures.curves import draw_curves
from pipeline.figures.isolated_curves import isolated_curves_at
from pipeline.plan.numerics import row_system, sweep_axis
from solver import Event
from solver.timedomain import find_attractors
from tests.made_once import made_once
from tests.pipeline.planes import small_plan

#: Two rows over the upper resonance, where motions of two periods are (docs/physics.md, section 8).
SMALL = [
    "plane=omega_fe",
    "plane.sweep.num=15",
    "plane.parameter.num=2",
    "plane.sweep.min=1.1",
    "plane.sweep.max=1.45",
    "plane.parameter.min=0.25",
    "plane.parameter.max=0.3",
    "solver.certify_columns=15",
    "cluster=none",
    "attractors.starts=2",
    "attractors.columns=8",
]


def run(root, *words):
    return main([*SMALL, *words, "store.name=plane", f"output.root={root}"])


@pytest.fixture(scope="module")
def made():
    def make(folder):
        assert run(folder, "stages=[sweep,attractors]", "attractors.branches=3") == 0

    return made_once("isolated-omega_fe", make)


@pytest.fixture(scope="module")
def plane(made):
    return pipeline.open_plane(made / "store/plane.zarr")


def test_points_are_solutions_on_their_period(plane):
    found = plane.isolated_branches(f_e=0.25)
    assert found.order == 3 and set(found.period.values) <= {2, 3, 4} and found.sizes["isolated_row"] == 1
    twice = found.isel(isolated_point=np.flatnonzero(found.period.values == 2))
    assert twice.sizes["isolated_point"] > 20 and np.any(twice.event == Event.FOLD)
    # What integration ends on beside the branch is on it.
    cells = plane.tree["attractors"].sel(f_e=0.25)
    column, slot = np.argwhere(cells.kind.values == 2)[0]
    place, there = float(cells.omega[column]), twice.sortby("isolated_omega")
    assert there.isolated_omega.min() - 0.03 < place < there.isolated_omega.max() + 0.03
    gap = np.hypot(there.isolated_omega - place, there.highest - float(cells.highest[column, slot]))
    assert float(gap.min()) < 0.1


def test_extremes_are_those_of_the_balance(plane):
    """A point is corrected to itself, and has the extremes that are stored."""
    stored = isolated.read_isolated(plane.path)
    assert np.all(np.diff(stored.branch.values) >= 0) and not np.any(stored.failed)
    row = float(stored.isolated_f_e[0])
    results = isolated.isolated_task(
        plane.plan,
        row,
        plane.tree["attractors"].omega.values,
        isolated.row_of_values(
            {str(name): array.values for name, array in plane.tree["attractors"].sel(f_e=row).variables.items()}, 4
        ),
        3,
    )
    here = stored.isel(isolated_point=np.flatnonzero(stored.isolated_f_e.values == row))
    np.testing.assert_array_equal(results.points["position"], here.isolated_omega.values)
    np.testing.assert_array_equal(results.points["highest"], here.highest.values)


def test_a_spur_pair_has_its_isola_of_two_periods():
    """tests/cases/kahraman_singh.py: from 1.36863 to 2.01142 at order 9."""
    ranges = ("plane.sweep.min=1.2", "plane.sweep.max=2.2", "plane.parameter.min=0.08", "plane.parameter.max=0.1")
    plan = small_plan("gear=spur", "plane=omega_load", *ranges, "solver.certify_columns=9", columns=11, rows=2)
    x = np.array([1.8])
    attractors = find_attractors(row_system(plan, 0.1), sweep_axis(plan), x)
    found = isolated.isolated_task(plan, 0.1, x, attractors, 5)
    assert found.notes == () and set(found.points["period"]) == {2} and set(found.points["closed"]) == {1}
    ends = np.sort(found.points["position"][found.points["event"] == Event.FOLD])
    np.testing.assert_allclose(ends, [1.36863, 2.01142], rtol=0, atol=2e-5)


def test_what_is_made_is_kept(made, tmp_path, capsys):
    shutil.copytree(made / "store", tmp_path / "store")
    assert run(tmp_path, "stages=[attractors]", "attractors.branches=3") == 0
    assert "nothing to do" in [line for line in capsys.readouterr().out.splitlines() if "order 3" in line][0]
    with (tmp_path / "attractors/plane-isolated.csv").open() as file:
        lines = list(csv.DictReader(file))
    stored = isolated.read_isolated(tmp_path / "store/plane.zarr")
    assert len(lines) == len(np.unique(stored.branch)) and {line["period"] for line in lines} >= {"2"}


def test_a_row_that_fails_is_named_and_the_others_are_kept(made, tmp_path, monkeypatch, capsys):
    shutil.copytree(made / "store", tmp_path / "store")
    original = isolated.isolated_branches

    def failing(row, *arguments, **options):
        if row.system.f_e > 0.27:
            raise ArithmeticError("no way")
        return original(row, *arguments, **options)

    monkeypatch.setattr(isolated, "isolated_branches", failing)
    assert run(tmp_path, "stages=[attractors]", "attractors.branches=2") == 1
    said = capsys.readouterr()
    assert "f_e = 0.3 failed: ArithmeticError: no way" in said.out + said.err
    stored = isolated.read_isolated(tmp_path / "store/plane.zarr")
    assert stored.order == 2 and stored.failed.values.tolist() == [0, 1] and stored.sizes["isolated_point"] > 0


def test_curves_show_them_where_the_row_was_integrated(plane):
    stored = plane.stored
    assert isolated_curves_at(stored, 0.27, ("amplitude",)) is None
    found = isolated_curves_at(stored, 0.25, ("amplitude", "mean"))
    figure = draw_curves(stored, [0.25])
    drawn = [line for axes in figure.axes for part in axes.collections for line in part.get_segments()]
    point = np.array([found.points["position"][0], found.points["amplitude"][0]])
    assert any(np.any(np.all(np.isclose(line, point), axis=1)) for line in drawn)
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert any("attractors" in text for text in texts)


def test_a_plane_without_them_says_how_to_make_them(made, tmp_path):
    shutil.copytree(made / "store", tmp_path / "store")
    shutil.rmtree(tmp_path / "store/plane.zarr/isolated")
    with pytest.raises(StoreError, match=r"attractors\.branches"):
        pipeline.open_plane(tmp_path / "store/plane.zarr").isolated_branches(f_e=0.25)


@pytest.mark.parametrize(
    "words",
    [
        ["attractors.points=[[1.2,0.25]]"],
        ["plane.parameter2.name=alpha", "plane.parameter2.min=0", "plane.parameter2.max=1", "plane.parameter2.num=2"],
        ["attractors.branches=33"],
    ],
)
def test_what_it_cannot_do_is_refused(tmp_path, words):
    assert run(tmp_path, "stages=[sweep,attractors]", "attractors.branches=3", *words) == 2
    assert not (tmp_path / "store").exists()
