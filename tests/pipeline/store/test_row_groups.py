"""A group written block by block: whole in the store or not there, gone on with after any interruption."""

import contextlib
import os

import numpy as np
import pytest
import zarr

from pipeline import store
from pipeline.errors import DamagedError
from pipeline.plan.row_blocks import RowBlocks
from pipeline.store import groups
from pipeline.store.folder_files import FolderFiles
from pipeline.store.repair import repair
from pipeline.store.row_groups import RowArray, RowGroup
from pipeline.store.stored_arrays import open_group
from tests.pipeline.planes import small_plan, small_store

ROWS = RowBlocks((7,), 3)
ARRAYS = {
    "kind": RowArray(("x", "slot"), (4, 2), "int8", 0, {"long_name": "kind"}),
    "mean": RowArray(("x", "slot"), (4, 2), "float64", float("nan"), {"long_name": "mean"}),
    "message": RowArray((), (), "str", "", {"long_name": "why"}),
    "rounds": RowArray((), (), "int16", -1, {"long_name": "rounds"}),
}


@pytest.fixture
def path(tmp_path):
    plan = small_plan(columns=9, rows=4)
    return small_store(tmp_path / "plane.zarr", plan)


def group_of(path, rows=ROWS, dims=("p",), made="a"):
    places = {"p": (("p",), np.arange(float(rows.of_layer)), {"long_name": "p"})}
    return RowGroup(path, "attractors", rows, dims, ARRAYS, places, {"made_from": made, "starts": 4})


def values_of(block):
    rows = np.arange(block.start, block.stop)
    kind = np.tile(rows[:, None, None], (1, 4, 2)).astype(np.int8)
    texts = np.array([f"row {row}, ä" if row % 2 else "" for row in rows], dtype=object)
    return {"kind": kind, "mean": kind / 3.0, "message": texts, "rounds": rows.astype(np.int16)}


def finish(group):
    label = RowArray(("x",), (4,), "int16", 0, {"long_name": "label", "labels": ["", "1T/0"]})
    group.finish({"label": (label, np.ones((*group.rows.shape, 4), np.int16))})


def write_all(group):
    group.begin()
    for block in group.rows.all:
        group.write(block, values_of(block))


@pytest.mark.parametrize("rows", [ROWS, RowBlocks((2, 7), 3), RowBlocks((7,), 1)])
def test_what_is_written_is_read_by_anybody_and_checked(path, rows):
    group = group_of(path, rows, ("layer", "p")[-len(rows.shape) :])
    write_all(group)
    assert not group.is_finished and open_group(path, "attractors") is None
    for block in rows.all:
        found, wanted = group.read(block), values_of(block)
        assert all(np.array_equal(found[name], wanted[name], equal_nan=name == "mean") for name in wanted)
    finish(group)
    assert group.is_finished and not group.folder.exists()
    told = zarr.open_group(path / "attractors", mode="r")
    assert told["kind"][...].reshape(-1, 4, 2)[:, 0, 0].tolist() == list(range(rows.rows))
    assert told["message"][...].ravel().tolist()[:2] == ["", "row 1, ä"] and told["label"][...].all()
    assert store.find_damage(path) == []


def test_a_block_is_whole_or_not_there(path):
    group = group_of(path)
    write_all(group)
    again = group_of(path)
    again.begin()
    assert all(again.read(block) is not None for block in ROWS.all)
    file = group.folder.place / "packed/c/1"
    sound = file.read_bytes()
    for place in range(0, len(sound), 7):
        harmed = bytearray(sound)
        harmed[place] ^= 4
        file.write_bytes(harmed)
        assert again.read(ROWS.all[1]) is None, place
    for size in (0, 5, len(sound) // 2, len(sound) - 1):
        file.write_bytes(sound[:size])
        assert again.read(ROWS.all[1]) is None
    assert again.read(ROWS.all[0]) is not None
    file.unlink()
    assert again.read(ROWS.all[1]) is None
    again.write(ROWS.all[1], values_of(ROWS.all[1]))
    assert again.read(ROWS.all[1]) is not None and file.read_bytes() == sound


@pytest.mark.parametrize("writes", [0, 1, 3, 4])
def test_an_interrupted_finish_is_made_again(path, monkeypatch, writes):
    group = group_of(path)
    write_all(group)
    honest, left = FolderFiles.write, [writes]

    def ended(files, contents):
        left[0] -= files == group.folder
        honest(files, dict(list(contents.items())[: 1 if left[0] < 0 else None]))
        if left[0] < 0:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(FolderFiles, "write", ended)
        with contextlib.suppress(KeyboardInterrupt):
            finish(group)
    assert group.is_finished == (writes == 4)
    if writes < 4:
        group.begin()
        assert all(group.read(block) is not None for block in ROWS.all)
        finish(group)
    told = zarr.open_group(path / "attractors", mode="r")
    assert told["kind"][:, 0, 0].tolist() == list(range(7)) and store.find_damage(path) == []
    assert not (path / "attractors/packed").exists()


def test_another_group_is_begun_anew(path):
    write_all(group_of(path))
    other = group_of(path, made="b")
    other.begin()
    assert all(other.read(block) is None for block in ROWS.all)


def test_a_damaged_group_is_taken_out_and_gone_on_with(path):
    group = group_of(path)
    write_all(group)
    finish(group)
    os.truncate(path / "attractors/kind/c/1/0/0", 5)
    damage = store.find_damage(path)
    assert [item.file for item in damage] == ["attractors/kind/c/1/0/0"]
    repair(path, damage)
    assert store.find_damage(path) == [] and not group.is_finished
    group.begin()
    assert [group.read(block) is None for block in ROWS.all] == [False, True, False]
    group.write(ROWS.all[1], values_of(ROWS.all[1]))
    finish(group)
    assert group.is_finished and store.find_damage(path) == []


def test_a_group_that_the_store_does_not_list_is_taken_up(path):
    group = group_of(path)
    write_all(group)
    finish(group)
    before = {str(file): file.read_bytes() for file in (path / "attractors/kind").rglob("*") if file.is_file()}
    # As where a run ends between the group's move and the list's.
    (path / "attractors").rename(path.parent / "moved")
    store.consolidate(path)
    (path.parent / "moved").rename(path / "attractors")
    assert not group.is_finished
    group.begin()
    finish(group)
    assert group.is_finished
    assert before == {str(file): file.read_bytes() for file in (path / "attractors/kind").rglob("*") if file.is_file()}


def test_a_damaged_coordinate_begins_anew(path):
    group = group_of(path)
    write_all(group)
    (group.folder.place / "p/c/0").unlink()
    group.begin()
    assert all(group.read(block) is None for block in ROWS.all) and group.folder.has("p/c/0")


def test_a_sweep_takes_away_what_is_unfinished(path):
    group = group_of(path)
    write_all(group)
    groups.remove_added(path)
    assert not group.folder.exists()


def test_a_block_of_another_group_is_none_of_this_one(path):
    """A task may outlive its run, and write where another run makes a group from something else."""
    late, group = group_of(path, made="a"), group_of(path, made="b")
    write_all(group)
    late.write(ROWS.all[0], values_of(ROWS.all[0]))
    assert group.read(ROWS.all[0]) is None and group.read(ROWS.all[1]) is not None
    with pytest.raises(DamagedError, match="another group"):
        finish(group)
    group.write(ROWS.all[0], values_of(ROWS.all[0]))
    finish(group)
    assert group.is_finished and store.find_damage(path) == []
