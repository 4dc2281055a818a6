"""Sizes that a store claims: bounded and compared with what is there before anything is built or decompressed."""

import itertools
import json
import shutil
import tracemalloc
from pathlib import Path

import google_crc32c
import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from numcodecs.zstd import Zstd

import pipeline
from pipeline import store
from pipeline.__main__ import main
from pipeline.errors import ConfigurationError, StoreError
from pipeline.plan.plan import Plan, plan_of
from pipeline.plan.planning import check_numbers
from pipeline.store import groups
from pipeline.store.array_layout import MOST_TEXT, ArrayLayout
from pipeline.store.arrays import layouts_of, row_layouts, status_layout
from pipeline.store.chunk_files import ChunkError, claim_of, decoded
from pipeline.store.damage import damaged
from pipeline.store.files import files_at
from pipeline.store.listing import listing
from tests.conftest import slow_but
from tests.pipeline.faults.test_damage import run
from tests.pipeline.planes import retold, small_plan, small_store

_SIZES = ("plane.sweep.num=9", "plane.parameter.num=4", "solver.certify_columns=197")
#: Bytes that looking a small store over may take, and that stages with all their imports may.
_LITTLE, _SOME = 2e7, 1e8


def bomb(size: int, entry: int = 0) -> bytes:
    """A chunk file of some bytes that stands for `size` of them, its checksum right."""
    frame = b"\x28\xb5\x2f\xfd" + bytes([0b11100000]) + size.to_bytes(8, "little")
    left = size
    while left:
        # One byte, repeated (RFC 8878, section 3.1.1.2): last block or not, kind 1, how often.
        here = min(left, 2**17)
        left -= here
        frame += (int(not left) | 1 << 1 | here << 3).to_bytes(3, "little") + bytes([entry])
    return frame + google_crc32c.value(frame).to_bytes(4, "little")


def test_the_bombs_of_these_tests_go_off():
    assert Zstd().decode(bomb(3 * 2**17 + 5)[:-4]) == bytes(3 * 2**17 + 5)
    assert len(bomb(2 * 10**9)) < 62_000


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    """A small complete store with a group; not to be changed."""
    path = small_store(tmp_path_factory.mktemp("made") / "plane.zarr", small_plan(columns=9, rows=4))
    groups.write_group(path, "boundaries", xr.Dataset({"values": ("x", np.arange(50.0))}))
    return path


@pytest.fixture
def copy(made, tmp_path) -> Path:
    return Path(shutil.copytree(made, tmp_path / "outputs/store/plane.zarr"))


class Traced:
    """The most bytes that were allocated at a time inside the block."""

    def __enter__(self):
        tracemalloc.start()
        return self

    def __exit__(self, *_):
        self.peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()


_BOMBS = [
    ("mean/c/1/0/0", 0),
    ("status/c/2", 0),
    ("status/c/2", 1),
    ("message/c/0", 0),
    ("branches/cos/c/3/0", 0),
    ("omega/c/0", 0),
    ("boundaries/values/c/0", 0),
]


@pytest.mark.parametrize(("file", "entry"), _BOMBS)
def test_a_chunk_that_stands_for_more_than_it_may_is_not_decompressed(copy, file, entry):
    # Not a trace of its imports.
    open_plane = pipeline.open_plane
    for size in (2 * 10**9, 3 * 10**7):
        (copy / file).write_bytes(bomb(size, entry))
        with Traced() as traced, pytest.raises(StoreError, match="claims|is longer than a chunk can be") as caught:
            open_plane(copy)
        assert traced.peak < _LITTLE and file in str(caught.value)
    assert "claims 30000000 bytes, where a chunk has" in str(caught.value)
    with Traced() as traced:
        assert [item.file for item in store.find_damage(copy)] == [file]
        (entry,) = listing(copy.parent).entries
    assert traced.peak < _LITTLE and "damaged" in entry.status


@pytest.mark.costly
@pytest.mark.parametrize(("file", "entry"), slow_but([_BOMBS[2]], _BOMBS))
def test_no_stage_decompresses_such_a_chunk(copy, tmp_path, capsys, file, entry):
    (copy / file).write_bytes(bomb(3 * 10**7, entry))
    with Traced() as traced:
        for stage in ("sweep", "figures", "boundaries", "check", "list"):
            code, out, err = run(tmp_path, capsys, f"stages=[{stage}]", *_SIZES)
            assert (code, err.count("\n")) == (int(stage != "list"), int(stage != "list")), err
    assert traced.peak < _SOME
    code, _, err = run(tmp_path, capsys, "stages=[check]", "check.repair=true", *_SIZES)
    assert code == 0 and store.find_damage(copy) == []


def _chunk(entries: bytes) -> bytes:
    frame = Zstd().encode(entries)
    return frame + google_crc32c.value(frame).to_bytes(4, "little")


@pytest.mark.parametrize(
    ("entries", "said"),
    [
        ((4 * 10**9).to_bytes(4, "little") + bytes(4), "another number of texts"),
        ((1).to_bytes(4, "little") + (10**9).to_bytes(4, "little"), "holds what is no text"),
        ((1).to_bytes(4, "little") + (1).to_bytes(4, "little") + b"\xff", "holds what is no text"),
        ((1).to_bytes(4, "little") + bytes(4 * MOST_TEXT + 8), "where a chunk has"),
    ],
)
def test_texts_are_as_many_and_as_long_as_they_may_be(copy, entries, said):
    (copy / "message/c/1").write_bytes(_chunk(entries))
    with Traced() as traced, pytest.raises(StoreError, match=said):
        store.read_plan(copy)
    assert traced.peak < _LITTLE


def test_texts_longer_than_they_may_be_are_cut_when_they_are_written(copy):
    plan = store.read_plan(copy)
    store.write_block(copy, plan, plan.blocks[1], [store.row_values(plan, "ä" * 10**6)])
    groups.write_group(copy, "boundaries", xr.Dataset({"why": ("x", np.array(["ä" * 10**6, "b"], dtype=object))}))
    assert store.find_damage(copy) == [] and store.failures(copy) == [(1, "ä" * MOST_TEXT)]


@pytest.mark.parametrize("content", [b"", b"x", b"\x28\xb5\x2f\xfd", b"PK\x03\x04" + bytes(40), bytes(40)])
def test_what_is_no_chunk_is_no_chunk(copy, content):
    (copy / "mean/c/1/0/0").write_bytes(content)
    with pytest.raises(StoreError, match="mean/c/1/0/0 is (empty|no compressed chunk)"):
        store.read_plan(copy)


def test_a_file_longer_than_a_chunk_can_be_is_not_read(copy):
    with (copy / "mean/c/1/0/0").open("r+b") as stream:
        stream.truncate(10**10)
    with Traced() as traced:
        with pytest.raises(StoreError, match="is longer than a chunk can be"):
            store.read_plan(copy)
        assert [item.file for item in store.find_damage(copy)] == ["mean/c/1/0/0"]
        with pytest.raises(StoreError, match="is longer than a chunk can be"):
            store.read_rows(copy, small_plan(columns=9, rows=4), small_plan(columns=9, rows=4).blocks[1])
    assert traced.peak < _LITTLE


def _claims(path: Path, **changes) -> None:
    """Have a store say of itself that it is of another plane, everywhere and with the right seal."""
    numbers = json.loads(json.loads((path / "zarr.json").read_text())["attributes"]["numbers"])
    for key, change in changes.items():
        numbers[key] = {**numbers[key], **change} if isinstance(change, dict) else change
    retold(path, numbers=json.dumps(numbers))


_TOO_MANY = [
    {"parameter": {"num": 3 * 10**8}},
    {"parameter": {"num": 10**6}, "max_points": 10**7},
    {"sweep": {"num": 3 * 10**8}},
    {"sweep": {"num": 10**6}, "parameter": {"num": 10**6}},
    {"parameter": {"num": 10**15}},
]
_ON = [("plane=omega_fe",), ("plane=omega_temperature", "gear=miter")]


def _too_large(path: Path, words: tuple[str, ...], changes: dict) -> Path:
    path = small_store(path, small_plan(*words, columns=9, rows=4), blocks=[])
    _claims(path, **changes)
    return path


@pytest.mark.parametrize("changes", _TOO_MANY)
@pytest.mark.parametrize("words", _ON)
def test_a_plane_of_too_many_rows_costs_nothing(tmp_path, words, changes):
    path = _too_large(tmp_path / "plane.zarr", words, changes)
    with Traced() as traced:
        for look in (store.read_plan, store.find_damage, pipeline.open_plane):
            with pytest.raises(StoreError, match="makes no sense"):
                look(path)
        (entry,) = listing(path.parent).entries
    assert traced.peak < _LITTLE and entry.status == "damaged metadata"


_CASES = list(itertools.product(_ON, _TOO_MANY))


@pytest.mark.costly
@pytest.mark.parametrize(("words", "changes"), slow_but([_CASES[5]], _CASES))
def test_a_plane_of_too_many_rows_costs_no_stage_much(tmp_path, capsys, words, changes):
    _too_large(tmp_path / "outputs/store/plane.zarr", words, changes)
    with Traced() as traced:
        for stage in ("figures", "boundaries", "check", "list"):
            code, _, err = run(tmp_path, capsys, f"stages=[{stage}]", *words)
            assert (code, err.count("\n")) == ((0, 0) if stage == "list" else (2, 1)), err
    assert traced.peak < _SOME


def test_a_large_plane_with_next_to_nothing_in_it_is_not_opened(tmp_path, capsys):
    """Made by this program, and all but empty: it is listed, checked and computed on, and its rows are not read."""
    plan = small_plan(columns=2000, rows=5000)
    assert plan.bytes > 2**30 and len(plan.blocks) == plan.n_blocks == 625
    path = tmp_path / "outputs/store/plane.zarr"
    store.create(path, plan, "plane", "")
    with Traced() as traced:
        for look in (store.read_plan, pipeline.open_plane):
            with pytest.raises(StoreError, match="next to nothing of it is computed"):
                look(path)
        assert store.find_damage(path) == [] and store.check(path, plan)
        assert listing(path.parent).entries[0].status == "0 of 5000 rows"
        assert store.pending_blocks(path, plan) == plan.blocks
    assert traced.peak < _LITTLE
    code, _, err = run(tmp_path, capsys, "stages=[figures]")
    assert code == 2 and "next to nothing of it is computed, stages=[sweep] goes on with it" in err


def test_a_group_cannot_claim_what_is_not_there(copy):
    """All chunks are there and honest, each of a size that it may have; only together they are too much."""
    path, name = copy / "boundaries/values", "boundaries/values"
    size = 2 * 10**9 // 8
    for file, *keys in ((path / "zarr.json",), (copy / "zarr.json", "consolidated_metadata", "metadata", name)):
        document = json.loads(file.read_text())
        node = document
        for key in keys:
            node = node[key]
        node["shape"] = [size]
        node["chunk_grid"]["configuration"]["chunk_shape"] = [size]
        file.write_text(json.dumps(document))
    (path / "c/0").write_bytes(bomb(2 * 10**9))
    with Traced() as traced:
        with pytest.raises(StoreError, match="claims 2000000000 bytes, of which 6"):
            store.read_plan(copy)
        assert [item.group for item in store.find_damage(copy)] == ["boundaries"]
    assert traced.peak < _LITTLE


@pytest.mark.parametrize(
    ("words", "name"),
    [
        (["plane.sweep.num=1000001"], "plane.sweep.num = 1000001"),
        (["plane.parameter.num=1000001"], "plane.parameter.num = 1000001"),
        (
            ["plane.parameter.num=1000000", "plane.sweep.num=2", "store.max_points=10000000"],
            "plane.parameter.num = 1000000",
        ),
        (
            ["plane=omega_b_fe", "plane.parameter.num=10000", "plane.parameter2.num=101", "plane.sweep.num=2"],
            "plane.parameter.num x plane.parameter2.num = 1010000",
        ),
    ],
)
def test_configurations_are_bounded_alike(tmp_path, capsys, words, name):
    code = main([*words, "plane.max_cells=1e15", f"output.root={tmp_path}", "stages=[sweep]", "cluster=none"])
    err = capsys.readouterr().err
    assert code == 2 and len(err.splitlines()) == 1 and f"{name} is not allowed: " in err
    assert list(tmp_path.iterdir()) == []


def test_chunks_have_the_sizes_that_are_expected_of_them(made):
    for name, array in layouts_of(store.read_plan(made)).items():
        for file in array.files():
            low, high = array.chunk_bytes
            assert low <= claim_of(files_at(made), file, array) <= high, name
            content = (made / file).read_bytes()
            assert decoded(content, array).shape == array.chunks


@given(content=st.binary(max_size=60), checked=st.booleans())
def test_no_bytes_are_taken_for_a_chunk_or_raise_anything_else(content, checked):
    array = ArrayLayout("x", (4,), (4,), "int16", ("x",), 0)
    text = ArrayLayout("x", (2,), (2,), "string", ("x",), "")
    if checked:
        content = _chunk(content)
    for one in (array, text):
        try:
            found = decoded(content, one)
        except ChunkError as error:
            assert str(damaged(Path("x"), str(error)))
        else:
            assert found.shape == one.chunks


def test_the_number_of_blocks_is_known_without_making_them():
    for words, columns, rows in ((), 9, 17), (("plane=omega_b_fe",), 9, 7), (("store.max_points=100000",), 9, 40):
        plan = small_plan(*words, columns=columns, rows=rows)
        assert len(plan.blocks) == plan.n_blocks
        assert [plan.chunk_of(block) for block in plan.blocks] == [
            tuple(int(part) for part in next(row_layouts(plan)["status"].files(*plan.place(block))).split("/")[2:])
            for block in plan.blocks
        ]
        assert status_layout(plan) == row_layouts(plan)["status"]


def test_a_thermal_plane_of_many_rows_is_checked_at_some_of_them(monkeypatch):
    from pipeline.plan import planning

    plan = small_plan("plane=omega_temperature", "gear=miter", columns=9, rows=4)
    numbers = plan.inputs
    numbers["parameter"]["num"] = 5000
    many: Plan = plan_of(numbers)
    seen, honest = [], planning.model_at
    monkeypatch.setattr(planning, "model_at", lambda plane, row, column: seen.append(row) or honest(plane, row, column))
    check_numbers(many)
    assert len(set(seen)) == 1001 and {many.parameter.low, many.parameter.high} <= set(seen)
    numbers["parameter"]["num"] = 10**6 + 1
    with pytest.raises(ConfigurationError, match="plane.parameter.num"):
        check_numbers(plan_of(numbers))
