"""What a power cut and a bad disk leave behind: found by `stages=[check]`, named, mended by computing blocks again."""

import json
import re
import shutil
from pathlib import Path

import pytest
import xarray as xr
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from pipeline import store
from pipeline.__main__ import main
from pipeline.run.rows import sweep_block
from pipeline.store import groups
from pipeline.store.arrays import arrays_of
from pipeline.store.repair import repair
from tests.conftest import slow_but
from tests.pipeline.faults.runs import COMMAND, continued, same
from tests.pipeline.planes import small_plan, small_store

_GROUP = "boundaries"
_SHARED = [word for word in COMMAND if not word.startswith("stages=")]
_READING = ["sweep", "boundaries", "attractors", "figures"]


def _with_group(path: Path) -> None:
    values = ("x", [float(i) for i in range(20)], {"long_name": "some numbers"})
    groups.write_group(path, _GROUP, xr.Dataset({"values": values}, attrs={"configuration_hash": "none of ours"}))


def run(folder: Path, capsys, *words: str) -> tuple[int, str, str]:
    """Exit status, output and errors of a run in this process."""
    code = main([*_SHARED, f"output.root={folder / 'outputs'}", "cluster=none", *words])
    said = capsys.readouterr()
    return code, said.out, said.err


@pytest.fixture(scope="module")
def whole(undisturbed, tmp_path_factory) -> Path:
    """The undisturbed store with an added group; not to be changed."""
    path = tmp_path_factory.mktemp("whole") / "outputs/store/plane.zarr"
    shutil.copytree(undisturbed, path)
    _with_group(path)
    return path


@pytest.fixture
def copy(whole, tmp_path) -> Path:
    """A copy that may be harmed."""
    return Path(shutil.copytree(whole, tmp_path / "outputs/store/plane.zarr"))


def harm(file: Path, kind: str, place: float = 0.5, bit: int = 0) -> None:
    """Damage one file."""
    content = file.read_bytes()
    at = int(place * len(content))
    if kind == "missing":
        file.unlink()
    elif kind == "empty":
        file.write_bytes(b"")
    elif kind == "truncated":
        file.write_bytes(content[:at])
    elif kind == "zeroed":
        file.write_bytes(bytes(len(content)))
    else:
        file.write_bytes(content[:at] + bytes([content[at] ^ 1 << bit]) + content[at + 1 :])


def _chunks(path: Path) -> dict[str, tuple[int, int]]:
    """Where every chunk of the plane is on the disk, and when it was written."""
    return {
        str(file.relative_to(path)): (file.stat().st_ino, file.stat().st_mtime_ns)
        for file in path.rglob("*")
        if "c" in file.parts and file.is_file() and _GROUP not in file.parts
    }


def _equal_json(file: Path, original: Path) -> bool:
    """Whether a changed metadata file says the same all the same, as 1E5 does for 1e5."""
    try:
        return file.name == "zarr.json" and json.loads(file.read_bytes()) == json.loads(original.read_bytes())
    except (OSError, ValueError):
        return False


def _kinds_of_files(path: Path) -> dict[str, list[str]]:
    files = sorted(str(file.relative_to(path)) for file in path.rglob("*") if file.is_file())
    kinds = {
        "root": [file for file in files if file == "zarr.json"],
        "branches": [file for file in files if file == "branches/zarr.json"],
        "metadata": [file for file in files if file.endswith("/zarr.json") and _GROUP not in file],
        "axis": [file for file in files if re.match(r"(branches/)?f_e/c/|omega/c/", file)],
        "status": [file for file in files if file.startswith("status/c/")],
        "group": [file for file in files if file.startswith(f"{_GROUP}/")],
    }
    return {**kinds, "rows": sorted(set(files) - {file for some in kinds.values() for file in some})}


# Shrinking would run for minutes, and a file's name says enough.
_UNSHRUNK = (Phase.explicit, Phase.generate)


@pytest.mark.costly
@settings(max_examples=5, phases=_UNSHRUNK)
@given(data=st.data())
def test_any_damage_is_found_named_and_mended(whole, tmp_path_factory, data):
    _is_mended(whole, tmp_path_factory, data)


@pytest.mark.slow
@settings(max_examples=40, phases=_UNSHRUNK)
@given(data=st.data())
def test_any_damage_is_found_named_and_mended_forty_times(whole, tmp_path_factory, data):
    _is_mended(whole, tmp_path_factory, data)


def _is_mended(whole, tmp_path_factory, data):
    kinds = _kinds_of_files(whole)
    file = data.draw(st.sampled_from(sorted(kinds)).flatmap(lambda kind: st.sampled_from(kinds[kind])))
    kind = data.draw(st.sampled_from(["missing", "empty", "truncated", "flipped", "zeroed"]))
    folder = tmp_path_factory.mktemp("damaged")
    path = Path(shutil.copytree(whole, folder / "outputs/store/plane.zarr"))
    before = _chunks(path)
    harm(path / file, kind, data.draw(st.floats(0.0, 0.999)), data.draw(st.integers(0, 7)))
    if _equal_json(path / file, whole / file):
        return
    damage = store.find_damage(path)
    assert any(file in item.sentence for item in damage), (file, kind, damage)
    assert {item.file for item in damage} <= {file, "zarr.json"} or file == "zarr.json"
    repair(path, damage)
    repaired = {item.block for item in damage if item.block is not None}
    code = main([*_SHARED, f"output.root={folder / 'outputs'}", "cluster=none", "stages=[sweep]"]) if repaired else 0
    assert code == 0
    if _GROUP in file or not (path / _GROUP).exists():
        groups.remove_added(path)
        same(path, _without_group(whole, folder))
    elif not repaired:
        same(path, whole)
    assert store.find_damage(path) == [] and store.read_plan(path) == store.read_plan(whole)
    # Exactly the damaged blocks were computed again; of an axis, exactly its file was put back.
    plan, after = store.read_plan(path), _chunks(path)
    owned = {
        str(chunk.relative_to(path))
        for name in arrays_of(plan)
        for block in repaired
        for chunk in (path / name / "c").glob(f"{block.start // plan.rows_per_block}*")
        for chunk in _under(chunk)
    }
    changed = {name for name in before if before[name] != after[name]}
    exact = {
        name
        for name in owned
        if int(name.split("/c/")[1].split("/")[0]) in {block.start // plan.rows_per_block for block in repaired}
    }
    assert changed == (exact or ({file} if "/c/" in file and _GROUP not in file else set()))


def _under(place: Path) -> list[Path]:
    return [place] if place.is_file() else [file for file in place.rglob("*") if file.is_file()]


def _without_group(whole: Path, folder: Path) -> Path:
    path = Path(shutil.copytree(whole, folder / "bare.zarr"))
    groups.remove_added(path)
    return path


@pytest.mark.costly
def test_check_mends_what_it_names(copy, whole, tmp_path, capsys):
    """All of it by the command line, several files at once."""
    before = _chunks(copy)
    harm(copy / "mean/c/3/0/0", "flipped")
    harm(copy / "branches/cos/c/7/0", "missing")
    harm(copy / "status/c/11", "truncated")
    harm(copy / "branches/zarr.json", "empty")
    harm(copy / "omega/c/0", "empty")
    code, out, err = run(tmp_path, capsys, "stages=[check]")
    assert code == 1 and "Traceback" not in err
    assert sorted(err.splitlines()) == [
        "error: check: branches/cos/c/7/0 is missing (rows 21-23)",
        "error: check: branches/zarr.json cannot be read",
        "error: check: mean/c/3/0/0 does not agree with its checksum (rows 9-11)",
        "error: check: omega/c/0 is empty",
        "error: check: status/c/11 does not agree with its checksum (rows 33-35)",
    ]
    assert "check: 5 damaged files, 9 rows in 3 blocks; the same command with check.repair=true mends them" in out
    code, out, err = run(tmp_path, capsys, "stages=[check]", "check.repair=true")
    assert code == 0 and "5 damaged files, 9 rows in 3 blocks mended" in out
    same(copy, whole)
    after = _chunks(copy)
    written = {name for name in before if before[name] != after[name]} - {"omega/c/0"}
    changed = {name.split("/c/")[1].split("/")[0] for name in written}
    assert changed == {"3", "7", "11"}
    code, out, err = run(tmp_path, capsys, "stages=[check]")
    assert (code, err) == (0, "") and "is sound" in out


def test_a_damaged_group_is_taken_away_and_named(copy, undisturbed, tmp_path, capsys):
    harm(copy / _GROUP / "values/c/0", "flipped")
    code, out, err = run(tmp_path, capsys, "stages=[check]", "check.repair=true")
    assert code == 0 and err == f"error: check: {_GROUP}/values/c/0 does not agree with its checksum\n"
    assert f"check: the damaged group {_GROUP} was taken away: stages=[{_GROUP}] makes it again" in out
    same(copy, undisturbed)


_HARMS = [
    ("status/c/2", "flipped"),
    ("branches/sin/c/5/0", "missing"),
    ("domain/zarr.json", "missing"),
    ("zarr.json", "truncated"),
    ("branches/zarr.json", "flipped"),
]
_NAMED = [(stage, *harmed) for stage in _READING for harmed in _HARMS]
#: Every stage and every harm.
_SOME = [case for case in _NAMED if case[0] == "sweep" or case[1:] == _HARMS[1]]


@pytest.mark.parametrize(("stage", "file", "kind"), slow_but(_SOME, _NAMED))
def test_every_stage_names_damage_on_one_line(copy, tmp_path, capsys, stage, file, kind):
    harm(copy / file, kind)
    before = _chunks(copy)
    code, _, err = run(tmp_path, capsys, f"stages=[{stage}]")
    assert code == 1 and len(err.splitlines()) == 1 and err.startswith(f"error: {copy} is damaged: "), err
    assert file.partition("/c/")[0] in err and "stages=[check] lists and check.repair=true mends it" in err
    assert _chunks(copy) == before and [place.name for place in tmp_path.rglob("*") if place.name == "runs"] == []


@pytest.mark.parametrize(("stage", "file"), [("figures", "domain/c/4/0"), ("boundaries", "branches/event/c/4/0")])
def test_damage_that_only_reading_finds_is_named_too(copy, tmp_path, capsys, stage, file):
    harm(copy / file, "flipped")
    groups.remove_added(copy)
    code, _, err = run(tmp_path, capsys, f"stages=[{stage}]")
    assert code == 1 and err.splitlines() == [
        f"error: {copy} is damaged: {file} does not agree with its checksum (rows 12-14); "
        "stages=[check] lists and check.repair=true mends it"
    ]


def test_tables_name_a_damaged_plane(tmp_path, capsys):
    for name in ("omega_b", "omega_alpha"):
        plan = small_plan(f"plane={name}", columns=20, rows=2)
        path = small_store(tmp_path / f"outputs/store/{name}.zarr", plan, plan.blocks[:1])
    harm(path / "branches/sin/c/0/0", "missing")
    code = main(["stages=[tables]", f"output.root={tmp_path / 'outputs'}"])
    err = capsys.readouterr().err
    assert code != 0 and len(err.splitlines()) == 1
    assert "omega_alpha.zarr is damaged: branches/sin/c/0/0 is missing" in err


def test_left_overs_of_killed_writers_are_removed(copy, tmp_path, capsys):
    left = copy / "mean/c/3/0/0.0123456789abcdef0123456789abcdef.partial"
    left.write_bytes(b"half of a chunk")
    code, out, err = run(tmp_path, capsys, "stages=[sweep]")
    assert (code, err) == (0, "") and "nothing to do" in out and not left.exists()


@pytest.mark.costly
def test_chunks_without_a_store_are_made_again(undisturbed, tmp_path, capsys):
    """What a task leaves that ran on while the store was taken away."""
    path = tmp_path / "outputs/store/plane.zarr"
    shutil.copytree(undisturbed / "mean/c/3", path / "mean/c/3")
    continued(tmp_path, capsys)
    same(path, undisturbed)


@pytest.mark.costly
@pytest.mark.parametrize(("kind",), slow_but([("flipped",)], [("flipped",), ("truncated",), ("empty",)]))
def test_a_last_block_that_fills_its_chunk_in_part_is_mended(tmp_path, kind):
    """What is written to such a chunk goes into what is read from it."""
    plan = small_plan(columns=9, rows=17)
    last = plan.blocks[-1]
    assert last.stop - last.start < plan.rows_per_block
    path = small_store(tmp_path / "plane.zarr", plan)
    whole = Path(shutil.copytree(path, tmp_path / "whole.zarr"))
    harm(path / f"status/c/{len(plan.blocks) - 1}", kind)
    harm(path / f"mean/c/{len(plan.blocks) - 1}/0/0", kind)
    damage = store.find_damage(path)
    assert {item.block for item in damage} == {last} and len(damage) == 2
    repair(path, damage)
    assert store.pending_blocks(path, plan) == [last]
    sweep_block(str(path), plan, last)
    assert store.find_damage(path) == []
    same(path, whole)
