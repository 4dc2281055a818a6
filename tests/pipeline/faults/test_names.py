"""Whatever a store says its parts are called: nothing outside it is opened, and inside only its own is removed."""

import contextlib
import itertools
import json
import os
import shutil
import sys
from pathlib import Path

import pytest
import xarray as xr

import pipeline
from pipeline import store
from pipeline.errors import StoreError
from pipeline.store import groups
from pipeline.store.files import files_at
from pipeline.store.listing import listing
from pipeline.store.names import GROUP_FILE, STORE_FILE, is_name
from tests.pipeline.faults.runs import same
from tests.pipeline.faults.test_damage import run
from tests.pipeline.planes import small_plan, small_store

_SIZES = ("plane.sweep.num=9", "plane.parameter.num=4", "solver.certify_columns=197")
_STAGES = ("sweep", "boundaries", "attractors", "margins", "figures", "check", "debug", "list")
_GROUP = {"node_type": "group", "zarr_format": 3, "attributes": {}}
_ARRAY = {
    "node_type": "array",
    "zarr_format": 3,
    "attributes": {},
    "shape": [2],
    "data_type": "float64",
    "fill_value": 0.0,
    "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [2]}},
    "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}},
    "codecs": [{"name": "bytes", "configuration": {"endian": "little"}}, {"name": "zstd"}, {"name": "crc32c"}],
    "dimension_names": ["x"],
    "storage_transformers": [],
}
_touched: list[str] = []
_guarded: list[str] = []


def _watch(event: str, arguments: tuple) -> None:
    """Note every file below a guarded folder that Python opens, lists, renames or removes."""
    if _guarded and event.split(".")[0] in ("open", "os", "shutil"):
        for argument in arguments:
            if isinstance(argument, str | bytes | os.PathLike):
                place = str(Path(os.fsdecode(argument)).resolve())
                if any(os.path.commonpath([place, folder]) == folder for folder in _guarded):
                    _touched.append(f"{event} {place}")


sys.addaudithook(_watch)


@contextlib.contextmanager
def untouched(*folders: Path):
    """Fail if anything below these folders is opened, listed, renamed or removed."""
    _touched.clear()
    _guarded[:] = [str(folder.resolve()) for folder in folders]
    try:
        yield
    finally:
        _guarded.clear()
    assert _touched == []


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    """A small complete store; not to be changed."""
    return small_store(tmp_path_factory.mktemp("made") / "plane.zarr", small_plan(columns=9, rows=4))


@pytest.fixture
def copy(made, tmp_path) -> Path:
    """A copy that may be harmed, a sister and the user's own files beside it."""
    path = Path(shutil.copytree(made, tmp_path / "outputs/store/plane.zarr"))
    shutil.copytree(made, path.with_name("sister.zarr"))
    (path.with_name("sister.zarr") / "thesis.tex").write_text("mine")
    return path


def _lists(path: Path, name: str, document: dict) -> None:
    """Make the root list a part under a name, as another program could."""
    root = json.loads((path / "zarr.json").read_text())
    root["consolidated_metadata"]["metadata"][name] = document
    (path / "zarr.json").write_text(json.dumps(root))


_OUTSIDE = ("../sister.zarr", "..", "../sister.zarr/mean", "boundaries/../../sister.zarr", "branches/../../sister.zarr")
_ODD = ("", ".", "/", "mean/c", "a/b/c", ".hidden", "x\x1b[2Jy", "\ud800", "mine", "boundaries/..", "n" * 5000)


_NAMES = [*_OUTSIDE, *_ODD]
_LISTED = list(itertools.product(_NAMES, [_GROUP, _ARRAY]))
_READERS = [stage for stage in _STAGES if stage != "list"]


@pytest.mark.costly
@pytest.mark.parametrize(
    ("name", "document", "stages"),
    [
        # Every name for one stage, and every stage for some names; all for all of them are slow.
        *((name, (_GROUP, _ARRAY)[i % 2], [_READERS[i % len(_READERS)]]) for i, name in enumerate(_NAMES)),
        *(pytest.param(*listed, _READERS, marks=pytest.mark.slow) for listed in _LISTED),
    ],
)
def test_listed_names_lead_nowhere(copy, made, tmp_path, capsys, name, document, stages):
    sister = copy.with_name("sister.zarr")
    _lists(copy, name, document)
    with untouched(sister):
        for stage in stages:
            code, _, err = run(tmp_path, capsys, f"stages=[{stage}]", *_SIZES, "debug.row=null")
            assert code in (1, 2) and len(err.splitlines()) == 1 and "Traceback" not in err, err
        with pytest.raises(StoreError, match="which is no name of this program"):
            pipeline.open_plane(copy)
        code, out, err = run(tmp_path, capsys, "stages=[check]", "check.repair=true")
        assert code == 0 and "1 damaged file," in out and len(err.splitlines()) == 1 and "\x1b" not in err
    same(copy, made)
    assert store.find_damage(copy) == [] and (sister / "thesis.tex").read_text() == "mine"
    assert listing(copy.parent).entries[0].status == "complete"


def test_an_absolute_name_leads_nowhere(copy, tmp_path, capsys):
    sister = copy.with_name("sister.zarr")
    _lists(copy, str(sister), _GROUP)
    with untouched(sister):
        assert run(tmp_path, capsys, "stages=[check]", "check.repair=true")[0] == 0
    assert (sister / "thesis.tex").exists() and store.find_damage(copy) == []


@pytest.mark.parametrize("file", ["mine/zarr.json", "boundaries/deep/er/zarr.json", "mean/.zarray", ".zgroup"])
def test_foreign_arrays_and_groups_are_named_and_kept(copy, tmp_path, capsys, file):
    (copy / file).parent.mkdir(parents=True, exist_ok=True)
    (copy / file).write_text(json.dumps(_GROUP))
    for stage in ("sweep", "figures", "check"):
        code, _, err = run(tmp_path, capsys, f"stages=[{stage}]", *_SIZES, "check.repair=true")
        assert (
            code == 2
            and err
            == f"error: {copy} is not allowed: {file!r} is no part of a store of this program; " + ("move it away\n")
        )
    assert (copy / file).exists()


def test_repair_removes_only_what_is_its_own(copy, tmp_path, capsys):
    """The user's files stay: beside a damaged chunk, in a damaged group, where a chunk should be."""
    groups.write_group(copy, "boundaries", xr.Dataset({"values": ("x", [1.0, 2.0], {"long_name": "some numbers"})}))
    (copy / "mean/c/0/0/notes.txt").write_text("mine")
    (copy / "mean/c/0/0/0").write_bytes(b"")
    code, _, err = run(tmp_path, capsys, "stages=[check]", *_SIZES, "check.repair=true")
    assert code == 0 and (copy / "mean/c/0/0/notes.txt").read_text() == "mine", err
    (copy / "boundaries/notes.txt").write_text("mine")
    (copy / "boundaries/values/c/0").write_bytes(b"")
    before = sorted(copy.rglob("*"))
    code, _, err = run(tmp_path, capsys, "stages=[check]", *_SIZES, "check.repair=true")
    assert code == 2 and "'notes.txt' in it is no file of this program" in err
    assert sorted(copy.rglob("*")) == before
    (copy / "boundaries/notes.txt").unlink()
    (copy / "amplitude/c/1/0/0").unlink()
    (copy / "amplitude/c/1/0/0").mkdir()
    (copy / "amplitude/c/1/0/0/notes.txt").write_text("mine")
    code, _, err = run(tmp_path, capsys, "stages=[check]", *_SIZES, "check.repair=true")
    assert (
        code == 2 and "it should be a file, and is a folder" in err and (copy / "amplitude/c/1/0/0/notes.txt").exists()
    )


@pytest.mark.costly
def test_overwriting_removes_no_file_of_the_user(copy, tmp_path, capsys):
    (copy / "notes.txt").write_text("mine")
    before = sorted(copy.rglob("*"))
    again = ("stages=[sweep]", *_SIZES, "store.overwrite=true")
    code, _, err = run(tmp_path, capsys, *again)
    assert code == 2 and "'notes.txt' in it is no file of this program" in err
    assert sorted(copy.rglob("*")) == before
    (copy / "notes.txt").unlink()
    code, _, err = run(tmp_path, capsys, *again)
    assert (code, err) == (0, "")


def test_known_names_are_those_that_zarr_makes(copy):
    groups.write_group(copy, "boundaries", xr.Dataset({"values": ("x", [1, 2])}))
    names = [str(file.relative_to(copy)) for file in copy.rglob("*") if file.is_file()]
    assert len(names) > 50 and all(map(STORE_FILE.fullmatch, names))
    inside = [name.removeprefix("boundaries/") for name in names if name.startswith("boundaries/")]
    assert len(inside) == 3 and all(map(GROUP_FILE.fullmatch, inside))
    for name in (
        "../zarr.json",
        "notes.txt",
        "mean/notes.txt",
        "a/b/c/d/zarr.json",
        "mean/c/x",
        "/mean/zarr.json",
        "c",
    ):
        assert not STORE_FILE.fullmatch(name) and not GROUP_FILE.fullmatch(name)
    assert all(map(is_name, (*store.read_plan(copy).inputs["gear"], "mean")))


def test_removal_stops_before_anything_unknown(tmp_path):
    folder = tmp_path / "old"
    (folder / "values/c").mkdir(parents=True)
    (folder / "values/c/0").write_bytes(b"x")
    (folder / "values/thesis.tex").write_text("mine")
    with pytest.raises(StoreError, match="values/thesis.tex"):
        files_at(folder).clear(GROUP_FILE)
    assert (folder / "values/c/0").exists()
    (folder / "values/thesis.tex").unlink()
    outside = tmp_path / "outside"
    outside.mkdir()
    (folder / "link").symlink_to(outside)
    with pytest.raises(StoreError, match="is a link"):
        files_at(folder).clear(GROUP_FILE)
    (folder / "link").unlink()
    files_at(folder).clear(GROUP_FILE)
    assert not folder.exists() and outside.exists()
