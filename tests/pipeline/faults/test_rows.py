"""Rows that raise, hang or take all memory: tried three times, marked failed with the reason; the rest completes."""

import numpy as np
import pytest

from pipeline import store
from pipeline.__main__ import main
from pipeline.run import rows
from tests.pipeline.faults.runs import COMMAND, INJECTED, ROWS, continued, finished, same
from tests.pipeline.planes import contents

_REASONS = {
    "raise": "FloatingPointError: injected (3 tries)",
    "sleep": "it did not end within 2 s (3 tries)",
    "spin": "it did not end within 1 s (3 tries)",
    "allocate": "its process was ended from outside, as happens when memory runs out (3 tries)",
}


def _fails(fault, tmp_path, undisturbed, *words):
    run = finished(tmp_path, *words, environment={"PYTHONPATH": str(INJECTED), "BEVELMAP_TEST_FAULT": fault})
    row = ROWS // 2
    assert (run.code, run.err) == (1, ""), run.err
    assert store.failures(run.path) == [(row, _REASONS[fault])]
    value = store.read_plan(run.path).row(row)[1]
    assert f"  row {row} (f_e = {value:.6g}) failed: {_REASONS[fault]}" in run.out and "1 row failed" in run.out
    status = store.statuses(run.path)
    assert status[row] == store.FAILED and np.all(np.delete(status, row) == store.COMPLETE)
    expected, found = contents(undisturbed), contents(run.path)
    others = [other for other in range(ROWS) if other != row]
    for name in ("mean", "stable", "n_solutions", "status"):
        assert found[name][others].tobytes() == expected[name][others].tobytes(), name
    assert not [left for left in run.path.parent.iterdir() if left != run.path]


@pytest.mark.costly
def test_a_row_that_hangs_fails_alone(tmp_path, undisturbed):
    _fails("spin", tmp_path, undisturbed, "cluster.row_seconds=1", "cluster.workers=1")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fault", "words"),
    [("raise", ("cluster.workers=2",)), ("sleep", ("cluster.row_seconds=2",)), ("allocate", ("cluster.memory=700MB",))],
)
def test_a_row_that_raises_sleeps_or_takes_all_memory_fails_alone(fault, words, tmp_path, undisturbed):
    _fails(fault, tmp_path, undisturbed, *words)


@pytest.mark.costly
@pytest.mark.parametrize(
    "words",
    [
        ("gear.xi_support=[0.004,0.005,0.034,0.035,0.012,0.02]",),
        ("gear.xi_support=[0.01,0.012,0.015,0.02,0.022,0.03]", "gear=consistent"),
        ("gear.xi_mesh=0", "gear.xi_translation=0", "gear.xi_support=0"),
    ],
)
def test_no_row_is_lost_whatever_each_support_damps(words, tmp_path):
    size = "plane.sweep.num=60", "plane.parameter.num=6", "store.name=plane", "stages=[sweep]"
    assert main([*size, "cluster=none", f"output.root={tmp_path}", *words]) == 0
    found = contents(tmp_path / "store/plane.zarr")
    assert np.all(found["status"] == store.COMPLETE) and np.all(found["certified"] == 1)


@pytest.mark.costly
def test_rows_without_any_solution_are_complete(tmp_path, capsys):
    """Every solution lies above a ceiling that is this low."""
    axis = "plane.sweep.name=kappa", "plane.sweep.min=0.1", "plane.sweep.max=1", "plane.omega=0.6"
    size = "plane.sweep.num=30", "plane.parameter.num=4", "store.name=plane", "solver.amplitude_max=1e-6"
    stages, png = "stages=[sweep,boundaries,figures,check,list]", ["figures.formats=[png]", "figures.dpi=30"]
    assert main([*axis, *size, stages, *png, "cluster=none", f"output.root={tmp_path}"]) == 0
    assert capsys.readouterr().err == "" and (tmp_path / "figures/plane/map.png").exists()
    found = contents(tmp_path / "store/plane.zarr")
    assert np.all(found["status"] == store.COMPLETE) and not np.any(found["n_solutions"])
    assert np.all(found["open"] == 1) and np.all(np.isnan(found["mean"])) and not np.any(found["branches/n_points"])


@pytest.mark.costly
def test_failed_rows_are_computed_by_the_next_run(tmp_path, undisturbed, capsys, monkeypatch):
    path, honest = tmp_path / "outputs/store/plane.zarr", rows.stored_row
    failing = store.read_plan(undisturbed).row(ROWS // 2)[1]

    def stored_row(plan, value, *others):
        if value == failing:
            raise FloatingPointError("injected")
        return honest(plan, value, *others)

    with monkeypatch.context() as patch:
        patch.setattr(rows, "stored_row", stored_row)
        assert main([*COMMAND, "cluster=none", f"output.root={tmp_path / 'outputs'}"]) == 1
    assert store.failures(path) == [(ROWS // 2, _REASONS["raise"])]
    continued(tmp_path, capsys)
    same(path, undisturbed)
