"""Chunks that go missing while a store is written: what is kept is verified, and nothing is made up in its place."""

import itertools
import shutil
from pathlib import Path

import numpy as np
import pytest
import zarr

from pipeline import store
from pipeline.errors import DamagedError
from pipeline.run import sweep
from pipeline.run.recompute import drawn_rows
from pipeline.run.rows import sweep_block
from pipeline.store.arrays import arrays_of
from tests.conftest import slow_but
from tests.pipeline.faults.runs import same
from tests.pipeline.faults.test_damage import harm, run
from tests.pipeline.planes import small_plan, small_store

_FEW = ("plane.sweep.num=9", "plane.parameter.num=17", "solver.certify_columns=197")
#: The block of which a row must be computed again.
_AGAIN = 1
_KINDS = ("missing", "empty", "truncated", "flipped", "zeroed")


@pytest.fixture
def copy(undisturbed, tmp_path) -> Path:
    """A copy of the undisturbed store, of which one row must be computed again; it may be harmed."""
    path = Path(shutil.copytree(undisturbed, tmp_path / "outputs/store/plane.zarr"))
    zarr.open_group(path, mode="r+")["status"][store.read_plan(path).blocks[_AGAIN].start] = store.FAILED
    return path


def _file(path: Path, name: str, number: int) -> Path:
    (file,) = (file for file in (path / name / "c" / str(number),) if file.exists())
    while file.is_dir():
        (file,) = file.iterdir()
    return file


_LOST = list(itertools.product(["amplitude", "status", "message", "branches/n_folds", "branches/cos"], _KINDS))


@pytest.mark.parametrize(
    ("name", "kind"), slow_but([*itertools.product(["amplitude"], _KINDS[::3]), _LOST[5], _LOST[-5]], _LOST)
)
def test_a_chunk_lost_before_its_block_is_written_again_is_never_made_up(
    copy, undisturbed, tmp_path, capsys, monkeypatch, name, kind
):
    """Its rows are computed again, or the run says what is damaged; then repair brings the undisturbed store."""
    plan, honest = store.read_plan(copy), sweep._run_blocks

    def harmed(*arguments):
        harm(_file(copy, name, _AGAIN), kind)
        return honest(*arguments)

    monkeypatch.setattr(sweep, "_run_blocks", harmed)
    code, out, err = run(tmp_path, capsys, "stages=[sweep]")
    monkeypatch.undo()
    block = plan.blocks[_AGAIN]
    rows = f"rows {block.start}-{block.stop - 1}"
    if code == 0:
        lost = (name, kind) == ("status", "missing")
        assert lost or f"{rows} were computed again: {name}/c/{_AGAIN}" in out
        assert err == ""
    else:
        assert code == 1 and len(err.splitlines()) == 1 and f"is damaged: {name}/c/{_AGAIN}" in err
        code, _, _ = run(tmp_path, capsys, "stages=[check]", "check.repair=true")
    assert code == 0 and store.find_damage(copy) == []
    same(copy, undisturbed)


def test_a_chunk_lost_elsewhere_while_the_sweep_runs_is_named(copy, tmp_path, capsys, monkeypatch):
    """No row of that block is due, so that nobody would read it: the run must not end as if all were well."""
    honest = sweep._run_blocks

    def harmed(*arguments):
        result = honest(*arguments)
        _file(copy, "amplitude", _AGAIN + 1).unlink()
        return result

    monkeypatch.setattr(sweep, "_run_blocks", harmed)
    code, _, err = run(tmp_path, capsys, "stages=[sweep]")
    assert code == 1 and f"is damaged: amplitude/c/{_AGAIN + 1}/0/0 is missing" in err


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    plan = small_plan(columns=9, rows=17)
    return plan, small_store(tmp_path_factory.mktemp("small") / "plane.zarr", plan)


@pytest.mark.costly
@pytest.mark.parametrize("kind", _KINDS)
def test_every_array_of_a_block_is_verified_before_its_rows_are_kept(small, tmp_path, kind):
    plan, whole = small
    assert plan.rows_per_block == 2
    path = Path(shutil.copytree(whole, tmp_path / "plane.zarr"))
    for i, name in enumerate(arrays_of(plan)):
        # The last block fills its chunk in part.
        block = plan.blocks[-1] if i % 2 else plan.blocks[3]
        file = _file(path, name, block.start // 2)
        content = file.read_bytes()
        harm(file, kind)
        if (name, kind) == ("status", "missing"):
            assert store.kept_rows(path, plan, block) == {}
        else:
            with pytest.raises(DamagedError, match=name):
                store.kept_rows(path, plan, block)
        file.write_bytes(content)
        kept = store.kept_rows(path, plan, block)
        assert sorted(kept) == list(range(block.start, block.stop))
        for row, values in kept.items():
            np.testing.assert_array_equal(values[name], zarr.open_group(whole, mode="r")[name][row])


_HARMED = [
    (*place, kind) for place in (("mean", 3), ("message", 8), ("status", 8), ("branches/event", 8)) for kind in _KINDS
]


@pytest.mark.parametrize(
    ("name", "number", "kind"), slow_but([case for case in _HARMED if "mean" in case or "missing" in case], _HARMED)
)
def test_a_block_that_cannot_be_verified_is_computed_again(small, tmp_path, name, number, kind):
    plan, whole = small
    path = Path(shutil.copytree(whole, tmp_path / "plane.zarr"))
    harm(_file(path, name, number), kind)
    receipt = sweep_block(str(path), plan, plan.blocks[number])
    assert receipt.lost.startswith(name) or (name, kind) == ("status", "missing")
    same(path, whole)
    assert store.find_damage(path) == []


def test_what_was_verified_is_written_whatever_becomes_of_the_files(small, tmp_path, monkeypatch):
    plan, whole = small
    path = Path(shutil.copytree(whole, tmp_path / "plane.zarr"))
    block = plan.blocks[3]
    zarr.open_group(path, mode="r+")["status"][block.start] = store.FAILED
    honest, computed = sweep_block.__globals__["stored_row"], []

    def harmful(*arguments):
        computed.append(arguments[1])
        for name in ("mean", "branches/cos", "message"):
            _file(path, name, 3).unlink(missing_ok=True)
        return honest(*arguments)

    monkeypatch.setitem(sweep_block.__globals__, "stored_row", harmful)
    receipt = sweep_block(str(path), plan, block)
    assert computed == [plan.parameter.values[block.start]] and receipt.lost == ""
    same(path, whole)


@pytest.mark.costly
def test_no_group_is_written_from_rows_that_went_missing(small, tmp_path, monkeypatch, capsys):
    from pipeline.analysis.boundaries import tracing

    _, whole = small
    path = Path(shutil.copytree(whole, tmp_path / "outputs/store/plane.zarr"))
    honest = tracing.read_events

    def harmed(*arguments):
        _file(path, "branches/event", 5).unlink(missing_ok=True)
        return honest(*arguments)

    monkeypatch.setattr(tracing, "read_events", harmed)
    code, _, err = run(tmp_path, capsys, "stages=[boundaries]", *_FEW)
    assert code == 1 and "branches/event/c/5/0 is missing" in err and not (path / "boundaries").exists()


@pytest.mark.costly
def test_a_layer_is_not_taken_out_of_a_damaged_volume(tmp_path, capsys):
    words = ["plane=omega_b_fe", "plane.sweep.num=9", "plane.parameter.num=4", "plane.parameter2.num=2"]
    words += ["store.name=volume", "solver.certify_columns=9"]
    assert run(tmp_path, capsys, *words, "stages=[sweep]")[0] == 0
    volume = tmp_path / "outputs/store/volume.zarr"
    harm(volume / "mean/c/1/2/0/0", "flipped")
    code, _, err = run(tmp_path, capsys, *words, "stages=[figures]", "plane.layer=0.5")
    assert code == 1 and "mean/c/1/2/0/0 does not agree with its checksum" in err
    assert [place.name for place in volume.parent.glob("*.zarr")] == ["volume.zarr"]


def test_rows_computed_again_are_those_that_are_stored(small, tmp_path, capsys):
    plan, whole = small
    shutil.copytree(whole, tmp_path / "outputs/store/plane.zarr")
    code, out, err = run(tmp_path, capsys, "stages=[check]", "check.recompute=5", *_FEW)
    assert (code, err) == (0, "") and "5 rows are bit by bit what is computed here" in out
    assert drawn_rows(whole, plan, 5, 0) == drawn_rows(whole, plan, 5, 0) != drawn_rows(whole, plan, 5, 1)
    assert drawn_rows(whole, plan, 100, 0) == list(range(17))


@pytest.mark.costly
@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("amplitude", lambda values: np.nextafter(values, 2.0)),
        ("domain", lambda values: values + 1),
        ("branches/cos", lambda values: -values),
        ("message", lambda values: np.full(values.shape, "well", dtype=object)),
    ],
)
def test_a_wrong_number_with_a_right_checksum_is_found(small, tmp_path, capsys, name, change):
    plan, whole = small
    path = Path(shutil.copytree(whole, tmp_path / "outputs/store/plane.zarr"))
    array = zarr.open_group(path, mode="r+")[name]
    array[6] = change(array[6])
    assert store.find_damage(path) == []
    before = {file: file.read_bytes() for file in path.rglob("*") if file.is_file()}
    code, out, err = run(tmp_path, capsys, "stages=[check]", "check.recompute=17", *_FEW)
    assert code == 1 and "1 of 17 rows differ" in out
    assert len(err.splitlines()) == 1 and plan.row_text(6) in err and f": {name} (" in err
    assert {file: file.read_bytes() for file in path.rglob("*") if file.is_file()} == before
    assert 6 not in drawn_rows(path, plan, 3, 0)
    assert run(tmp_path, capsys, "stages=[check]", "check.recompute=3", *_FEW)[0] == 0


@pytest.mark.parametrize("word", ["check.recompute=-1", "check.recompute=x", "check.seed=-1", "check.recompute=1e99"])
def test_what_is_drawn_is_a_whole_number(tmp_path, capsys, word):
    code, _, err = run(tmp_path, capsys, "stages=[check]", word)
    assert code == 2 and len(err.splitlines()) == 1 and word.split("=")[0] in err
