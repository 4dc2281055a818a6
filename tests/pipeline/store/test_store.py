"""The store: its schema as a reader sees it, and what it refuses."""

import dataclasses
import json

import numpy as np
import pytest
import xarray as xr
import zarr

from pipeline import store
from pipeline.config.quantities import QUANTITIES, READ
from pipeline.errors import StoreError
from pipeline.plan.plan import Block
from pipeline.run.dispatch import dispatch
from pipeline.run.rows import sweep_block
from pipeline.run.workforce import Workforce
from solver import DescribingFunction, domain_label, sweep_row
from solver.harmonic.quantities import balance_quantities
from tests.conftest import published
from tests.pipeline.planes import cluster, contents, retold, small_plan, small_store

PLAN = dict(columns=61, rows=6)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    plan = small_plan(**PLAN)
    return plan, small_store(tmp_path_factory.mktemp("store") / "plane.zarr", plan)


def test_schema(made):
    plan, path = made
    plane = xr.open_zarr(path)
    assert plane.sizes == {"f_e": 6, "omega": 61, "solution": plan.max_solutions}
    np.testing.assert_array_equal(plane.omega, np.linspace(0.05, 2.0, 61))
    np.testing.assert_array_equal(plane.f_e, np.linspace(0.0, 0.5, 6))
    kinds = {
        "n_solutions": "uint8",
        "n_stable": "uint8",
        "domain": "uint16",
        **dict.fromkeys(QUANTITIES, "float64"),
        "phase": "float64",
        "stable": "int8",
        "impact": "int8",
        "instability": "int8",
        "multiplier": "float64",
        "open": "int8",
        "certified": "int8",
        "status": "uint8",
    }
    for name, kind in kinds.items():
        assert plane[name].dtype == kind, name
        assert plane[name].attrs["long_name"]
    assert all(plane[name].attrs == {"long_name": one.title, "units": one.unit} for name, one in QUANTITIES.items())
    assert set(plane.data_vars) == {*kinds, "message"}
    assert np.all(plane.certified == 1) and store.proven_cells(path) == (6 * 61, 6 * 61)
    assert plane.attrs["bevelmap_schema"] == 4
    assert plane.attrs["Conventions"].startswith("CF") and plane.attrs["configuration_hash"] == plan.fingerprint
    assert {"numpy", "numba", "zarr", "bevelmap"} <= set(plane.attrs["versions"])
    assert plane.omega.attrs["units"] == "1" and plane.phase.attrs["units"] == "rad"
    assert zarr.open_group(path).metadata.zarr_format == 3
    assert zarr.open_group(path).metadata.consolidated_metadata is not None


def test_flags_follow_cf(made):
    _, path = made
    plane, branches = xr.open_zarr(path), xr.open_zarr(path, group="branches")
    for variable in (
        plane.domain,
        plane.stable,
        plane.impact,
        plane.instability,
        plane.status,
        branches.event,
        branches.end_reason,
    ):
        meanings = variable.attrs["flag_meanings"].split(" ")
        assert len(meanings) == len(variable.attrs["flag_values"]) == len(set(meanings))
        assert all(c.isalnum() or c in "_-.+@" for meaning in meanings for c in meaning)
    labels = dict(zip(plane.domain.attrs["flag_values"], plane.domain.attrs["labels"], strict=True))
    for code in np.unique(plane.domain):
        assert labels[int(code)] == domain_label(int(code)) != ""


def test_values_are_the_rows(made):
    plan, path = made
    plane, branches = xr.open_zarr(path).load(), xr.open_zarr(path, group="branches").load()
    assert np.all(plane.status == store.COMPLETE) and np.all(plane.message == "")
    for f_e in plan.parameter.values:
        row = sweep_row(published(f_e=float(f_e)), "omega", plan.sweep.values)
        here, points = plane.sel(f_e=f_e), branches.sel(f_e=f_e)
        count = row.mean.shape[1]
        for name in ("mean", "amplitude", "phase", "stable", "impact"):
            np.testing.assert_array_equal(here[name][:, :count], getattr(row, name))
        found = balance_quantities(
            DescribingFunction(), published(f_e=float(f_e)), "omega", plan.sweep.values[:, None], row.motions
        )
        for one in READ:
            np.testing.assert_allclose(here[one.name][:, :count], found[..., one.slot], rtol=1e-12, atol=1e-14)
            assert np.all(np.isnan(here[one.name][:, count:]))
        assert np.all(here.stable[:, count:] == -1)
        for name in ("n_solutions", "n_stable", "domain", "open"):
            np.testing.assert_array_equal(here[name], getattr(row, name))
        n = int(points.n_points)
        np.testing.assert_array_equal(points.omega[:n], np.concatenate([curve.points[:, 3] for curve in row.curves]))
        assert np.all(np.isnan(points.omega[n:])) and np.all(points.branch[n:] == -1)
        ends = [[int(end) for end in curve.ends] for curve in row.curves]
        assert points.end_reason[: len(ends)].values.tolist() == ends


def test_solutions_are_sorted_and_counted(made):
    _, path = made
    plane = xr.open_zarr(path).load()
    amplitude = plane.amplitude.values
    np.testing.assert_array_equal(np.sum(~np.isnan(amplitude), axis=2), plane.n_solutions)
    np.testing.assert_array_equal(np.sum(plane.stable == 1, axis=2), plane.n_stable)
    steps = np.diff(amplitude, axis=2)
    assert np.all(np.isnan(steps) | (steps >= 0.0)) and np.nanmin(amplitude) >= 0.0


def test_datatree_opens_whole(made):
    _, path = made
    tree = xr.open_datatree(path, engine="zarr")
    assert tree["branches"]["mean"].dims == tree["branches"]["omega"].dims == ("f_e", "point")
    assert tree["branches"].to_dataset(inherit=False).isel(f_e=5).omega.dims == ("point",)


def test_template_appears_whole_and_replaces_leftovers(tmp_path):
    plan = small_plan(columns=5, rows=3)
    path = tmp_path / "plane.zarr"
    (tmp_path / ".plane.zarr.template/mean").mkdir(parents=True)
    (tmp_path / ".plane.zarr.template/mean/zarr.json").write_text("from a killed run")
    store.create(path, plan, "plane", "x: 1\n")
    assert [p.name for p in tmp_path.iterdir()] == ["plane.zarr"]
    assert store.pending_blocks(path, plan) == plan.blocks
    plane = xr.open_zarr(path).load()
    assert np.all(plane.n_solutions == 255) and np.all(plane.domain == 0) and np.all(plane.status == 0)


def test_only_blocks_that_are_not_complete_are_pending(tmp_path):
    plan = small_plan(columns=9, rows=40)
    assert plan.rows_per_block > 1
    path = small_store(tmp_path / "plane.zarr", plan, plan.blocks[2:4])
    assert store.pending_blocks(path, plan) == plan.blocks[:2] + plan.blocks[4:]
    zarr.open_group(path, mode="r+")["status"][plan.blocks[2].start] = store.FAILED
    assert plan.blocks[2] in store.pending_blocks(path, plan)


def test_another_configuration_is_refused_with_the_difference(made):
    _, path = made
    with pytest.raises(StoreError) as caught:
        store.check(path, small_plan("gear.b=0.5", "solver.corrector=broyden", **PLAN))
    for part in (
        "gear.b: stored 1.0, asked 0.5",
        "solver.corrector: stored newton, asked broyden",
        "store.overwrite=true",
        "store.name=",
    ):
        assert part in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("kind", ["file", "folder", "zarr", "newer"])
def test_something_else_is_refused_and_kept(tmp_path, kind):
    path = tmp_path / "plane.zarr"
    plan = small_plan(columns=5, rows=3)
    if kind == "file":
        path.write_text("mine")
    elif kind == "folder":
        path.mkdir()
        (path / "thesis.tex").write_text("mine")
    elif kind == "zarr":
        zarr.create_group(path, attributes={"title": "mine"})
    else:
        small_store(path, plan, [])
        retold(path, bevelmap_schema=99)
    before = sorted(p.relative_to(tmp_path) for p in tmp_path.rglob("*"))
    attempts = [lambda: store.check(path, plan), lambda: store.read_plan(path)]
    # A store of another version is ours all the same: who asks for it may overwrite it.
    attempts += [lambda: store.refuse_foreign(path)] if kind != "newer" else []
    for attempt in attempts:
        with pytest.raises(StoreError):
            attempt()
    assert sorted(p.relative_to(tmp_path) for p in tmp_path.rglob("*")) == before


def test_a_store_gives_back_its_plan(made):
    plan, path = made
    assert store.read_plan(path) == plan
    assert json.loads(xr.open_zarr(path).attrs["numbers"]) == plan.inputs


def test_a_failed_row_is_recorded_and_the_others_go_on(tmp_path):
    plan = small_plan("store.max_solutions=2", columns=200, rows=8)
    path = small_store(tmp_path / "plane.zarr", plan)
    plane = xr.open_zarr(path).load()
    failed = np.flatnonzero(plane.status == store.FAILED)
    assert 0 < failed.size < 8
    assert store.failures(path) == [(int(row), str(plane.message[row].values)) for row in failed]
    for row in failed:
        assert "more than store.max_solutions = 2" in str(plane.message[row].values)
        assert np.all(plane.n_solutions[row] == 255) and np.all(plane.domain[row] == 0)
        assert np.all(np.isnan(plane["mean"][row]))
    whole = contents(small_store(tmp_path / "roomy.zarr", small_plan(columns=200, rows=8)))
    good = np.flatnonzero(plane.status == store.COMPLETE)
    np.testing.assert_array_equal(plane["mean"].values[good], whole["mean"][good][:, :, :2])


def test_an_unforeseen_error_in_a_row_is_recorded_by_name(tmp_path, monkeypatch):
    import solver

    plan = small_plan(columns=9, rows=3)
    path = small_store(tmp_path / "plane.zarr", plan, [])
    honest = solver.sweep_row

    def breaks(model, *args, **kwargs):
        if model.f_e == 0.25:
            raise FloatingPointError("invalid value")
        return honest(model, *args, **kwargs)

    monkeypatch.setattr(solver, "sweep_row", breaks)
    with Workforce(cluster("none")) as workforce:
        receipts = [receipt for _, receipt in dispatch(path, plan, plan.blocks, workforce)]
    failures = [failure for receipt in receipts for failure in receipt.failures]
    assert failures == [(1, "FloatingPointError: invalid value (3 tries)")]
    assert xr.open_zarr(path).status.values.tolist() == [1, 2, 1]


@pytest.mark.costly
def test_results_do_not_depend_on_blocks_or_order(tmp_path):
    plan = small_plan(columns=41, rows=12)
    forward = small_store(tmp_path / "forward.zarr", plan)
    backward = small_store(tmp_path / "backward.zarr", plan, list(reversed(plan.blocks)))
    single = small_plan(columns=41, rows=12)
    alone = small_store(tmp_path / "alone.zarr", single, [])
    for row in range(12):
        sweep_block(str(alone), single, Block(row, row + 1))
    expected = contents(forward)
    for path in (backward, alone):
        for name, values in contents(path).items():
            assert values.tobytes() == expected[name].tobytes() if values.dtype.kind != "T" else True, name


@pytest.mark.costly
def test_only_rows_that_are_not_complete_are_computed(tmp_path, monkeypatch):
    import solver

    plan = small_plan(columns=9, rows=40)
    path = small_store(tmp_path / "plane.zarr", plan)
    (first, second, *_), before = plan.blocks, contents(path)
    seen, honest = [], solver.sweep_row

    def watched(model, *args, **kwargs):
        seen.append(model.f_e)
        return honest(model, *args, **kwargs)

    monkeypatch.setattr(solver, "sweep_row", watched)
    zarr.open_group(path, mode="r+")["status"][1] = store.FAILED
    sweep_block(str(path), plan, first)
    assert seen == [plan.parameter.values[1]]
    for name, values in contents(path).items():
        np.testing.assert_array_equal(values, before[name])
    # A block that was being written is computed as a whole.
    zarr.open_group(path, mode="r+")["status"][plan.place(second)] = store.PENDING
    sweep_block(str(path), plan, second)
    assert seen[1:] == plan.parameter.values[second.start : second.stop].tolist()


def test_what_a_row_could_not_decide_is_stored_and_listed_and_its_cells_are_not_counted(tmp_path, monkeypatch):
    import solver

    plan = small_plan(columns=9, rows=3)
    path, honest = small_store(tmp_path / "plane.zarr", plan, []), solver.sweep_row

    def undecided(model, *args, **kwargs):
        row = honest(model, *args, **kwargs)
        if model.f_e != 0.25:
            return row
        certified = row.certified.copy()
        certified[[2, 5]] = 0
        return dataclasses.replace(row, certified=certified, notes=("At two places.", "For two reasons."))

    monkeypatch.setattr(solver, "sweep_row", undecided)
    for block in plan.blocks:
        sweep_block(str(path), plan, block)
    assert store.proven_cells(path) == (25, 27) and not store.failures(path)
    assert store.notes(path) == [(1, "At two places. For two reasons.")]
