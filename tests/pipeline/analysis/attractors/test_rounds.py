"""Global continuation across rows, on a made-up world: whole domains, and the same bytes whatever interrupts it."""

import os
import shutil

import numpy as np
import pytest

from pipeline import store
from pipeline.__main__ import main
from pipeline.analysis.attractors import grid as grid_module
from pipeline.analysis.attractors import rounds, tasks
from pipeline.plan.plan import Plan
from pipeline.store.folder_files import FolderFiles
from pipeline.store.stored_arrays import open_group
from solver.timedomain import AttractorKind
from tests.conftest import slow_but
from tests.made_once import made_once
from tests.pipeline.analysis.attractors.made_up import World
from tests.pipeline.planes import assert_same_contents, contents, small_plan, small_store

ROWS, COLUMNS = 10, 9


def snake() -> np.ndarray:
    """A domain that leads up and down between the rows."""
    where = np.zeros((ROWS, COLUMNS), bool)
    where[1:9, 1], where[8, 1:4], where[2:9, 3], where[2, 3:6], where[2:10, 5] = True, True, True, True, True
    return where


def island() -> np.ndarray:
    where = np.zeros((ROWS, COLUMNS), bool)
    where[4:7, 6:9] = True
    return where


@pytest.fixture
def plan() -> Plan:
    return small_plan("plane=omega_fe", columns=COLUMNS, rows=ROWS)


@pytest.fixture
def world(plan, monkeypatch):
    """The made-up solver, and small blocks, so that there are several rows a block and several blocks."""
    made = World(
        plan.parameter.values,
        plan.sweep.values,
        {AttractorKind.PERIOD_2: (snake(), (1, 1)), AttractorKind.CHAOTIC: (island(), (5, 7))},
    )
    monkeypatch.setattr(tasks, "find_attractors", made.find)
    monkeypatch.setattr(tasks, "continue_attractors", made.go_on)
    monkeypatch.setattr(grid_module, "_BLOCKS", 4)
    return made


@pytest.fixture
def run(plan, tmp_path, capsys):
    """Runs the stage in this process; exit status, output and errors."""
    path = small_store(tmp_path / "store/plane.zarr", plan)

    def go(*words):
        code = main(
            [
                "plane=omega_fe",
                f"plane.sweep.num={COLUMNS}",
                f"plane.parameter.num={ROWS}",
                "stages=[attractors]",
                "store.name=plane",
                "cluster=none",
                f"output.root={tmp_path}",
                *words,
            ]
        )
        said = capsys.readouterr()
        return code, said.out, said.err

    go.path = path
    return go


def test_an_attractor_found_in_one_cell_is_followed_over_its_whole_domain(run, world):
    code, _, err = run()
    assert (code, err) == (0, "")
    found = contents(run.path)
    kind = found["attractors/kind"]
    for wanted, where in ((AttractorKind.PERIOD_2, snake()), (AttractorKind.CHAOTIC, island())):
        np.testing.assert_array_equal(np.any(kind == wanted, axis=-1), where)
    assert found["attractors/round"].max() >= 4  # up, down and up again
    assert found["attractors/rounds"].min() >= 0
    np.testing.assert_array_equal(found["attractors/n_attractors"], 1 + snake() + island())
    label, told = found["attractors/label"], open_group(run.path, "attractors").attributes_of("label")
    assert told["labels"][label[5, 7]] == "1T/0 + chaotic/2" and told["labels"][label[0, 0]] == "1T/0"
    assert len(told["labels"]) == len(told["flag_values"]) == len(told["flag_meanings"].split())
    assert store.find_damage(run.path) == []


@pytest.fixture
def whole(run, world):
    """What an undisturbed run makes, once for all tests; the store of this one has no attractors yet."""
    untouched = run.path.with_name("untouched.zarr")

    def make(folder):
        shutil.copytree(run.path, untouched)
        assert run()[0] == 0
        run.path.rename(folder / "plane.zarr")
        untouched.rename(run.path)

    return contents(made_once("attractors-made-up", make) / "plane.zarr")


@pytest.mark.costly
@pytest.mark.parametrize("blocks", [pytest.param(1, marks=pytest.mark.slow), 10])
def test_the_size_of_blocks_does_not_matter(run, whole, monkeypatch, blocks):
    monkeypatch.setattr(grid_module, "_BLOCKS", blocks)
    assert run()[0] == 0
    assert_same_contents(contents(run.path), whole)


@pytest.mark.parametrize("writes", [pytest.param(3, marks=pytest.mark.slow), 12])
def test_an_interrupted_run_is_gone_on_with(run, whole, monkeypatch, writes):
    """It ends before a block is written, of round 0 or of a later one."""
    honest, left = FolderFiles.write, [writes]

    def ended(files, contents):
        if files.place.name.endswith(".unfinished"):
            if left[0] == 0:
                raise KeyboardInterrupt
            left[0] -= 1
        honest(files, contents)

    with monkeypatch.context() as patch:
        patch.setattr(FolderFiles, "write", ended)
        assert run()[0] == 130
    assert not (run.path / "attractors").exists()
    code, out, err = run()
    assert (code, err) == (0, "")
    assert_same_contents(contents(run.path), whole)
    code, out, _ = run()
    assert code == 0 and "nothing to do" in out


@pytest.mark.costly
@pytest.mark.parametrize(("array",), slow_but([("kind",)], [("kind",), ("rounds",), ("message",), ("label",)]))
def test_a_damaged_chunk_is_found_and_repaired(run, whole, array):
    assert run()[0] == 0
    (file, *_) = sorted((run.path / "attractors" / array).rglob("c/1*"))
    file = file if file.is_file() else next(found for found in sorted(file.rglob("*")) if found.is_file())
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 16
    file.write_bytes(content)
    code, _, err = run("stages=[check]")
    assert code == 1 and f"attractors/{array}/" in err
    assert run("stages=[check]", "check.repair=true")[0] == 0
    assert store.find_damage(run.path) == []
    assert run()[0] == 0
    assert_same_contents(contents(run.path), whole)


@pytest.mark.costly
def test_what_is_sound_of_a_damaged_group_is_kept(run, whole, monkeypatch):
    assert run()[0] == 0
    os.truncate(run.path / "attractors/kind/c/2/0/0", 3)
    run("stages=[check]", "check.repair=true")
    searched = []
    honest = rounds.search_block
    monkeypatch.setattr(rounds, "search_block", lambda spec, block: searched.append(block) or honest(spec, block))
    assert run()[0] == 0
    assert len(searched) == 1
    assert_same_contents(contents(run.path), whole)


@pytest.mark.parametrize("round", [pytest.param(0, marks=pytest.mark.slow), 1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_row_that_raises_is_recorded_with_its_reason(run, world, round):
    row = {0: 7, 1: 2, 2: 3}[round]
    world.raising[row] = round
    code, out, err = run()
    assert code == 1 and f"row {row} cannot be done in round {round}" in err
    found = contents(run.path)
    assert f"row {row}" in str(found["attractors/message"][row])
    assert np.sum(found["attractors/message"] != "") == 1
    assert np.all(found["attractors/credibility"][row] == 0)
    if round == 0:
        assert not found["attractors/kind"][row].any() and found["attractors/rounds"][row] == -1
    # The others go on.
    assert np.all(found["attractors/kind"][np.arange(ROWS) != row][:, :, 0] == 1)


@pytest.mark.costly
def test_other_settings_and_another_map_begin_anew(run, whole):
    assert run()[0] == 0
    first = open_group(run.path, "attractors").attributes["made_from"]
    assert run("attractors.seed=1")[0] == 0
    second = open_group(run.path, "attractors").attributes["made_from"]
    assert first != second
    assert run("attractors.columns=3", "attractors.rows=[0.1,0.3]")[0] == 0
    found = contents(run.path)
    assert found["attractors/kind"].shape[:2] == (2, 3)
    assert found["attractors/omega"].size == 3 and store.find_damage(run.path) == []


def test_a_part_of_the_plane_has_the_random_starts_of_the_whole(run, whole):
    assert run("attractors.columns=5", "attractors.rows=4")[0] == 0
    found = contents(run.path)
    rows, columns = ([0, 3, 6, 9], [0, 2, 4, 6, 8])
    np.testing.assert_array_equal(
        found["attractors/hits"][..., 0], whole["attractors/hits"][np.ix_(rows, columns)][..., 0]
    )
