"""Stores and configurations from someone else: nothing in them runs, writes elsewhere, or takes all memory."""

import json
import os
import pickle
import shutil
import tracemalloc
from pathlib import Path

import pytest
import xarray as xr

from pipeline import store
from pipeline.__main__ import main
from pipeline.config.compose import compose
from pipeline.config.units import quantity
from pipeline.errors import ConfigurationError, StoreError
from pipeline.store import groups
from tests.pipeline.faults.test_damage import run
from tests.pipeline.planes import retold, small_plan, small_store


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    """A small complete store; not to be changed."""
    return small_store(tmp_path_factory.mktemp("made") / "plane.zarr", small_plan(columns=9, rows=4))


@pytest.fixture
def copy(made, tmp_path) -> Path:
    return Path(shutil.copytree(made, tmp_path / "outputs/store/plane.zarr"))


def _listed(path: Path, name: str, **changes) -> None:
    """Change an array's metadata in both places."""
    for file, *keys in ((path / name / "zarr.json",), (path / "zarr.json", "consolidated_metadata", "metadata", name)):
        document = json.loads(file.read_text())
        node = document
        for key in keys:
            node = node.setdefault(key, {})
        node.update(changes)
        file.write_text(json.dumps(document))


class _Bomb:
    def __reduce__(self):
        return os.mkdir, ("went-off",)


def test_no_pickle_is_opened(copy, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    document = dict(
        zarr_format=2,
        shape=[4],
        chunks=[1],
        dtype="|O",
        fill_value=None,
        order="C",
        filters=[{"id": "pickle"}],
        compressor=None,
        dimension_separator=".",
    )
    (copy / "message/.zarray").write_text(json.dumps(document))
    for place in range(4):
        (copy / f"message/{place}").write_bytes(pickle.dumps([_Bomb()]))
    root = json.loads((copy / "zarr.json").read_text())
    root["consolidated_metadata"]["metadata"]["message"] = document
    (copy / "zarr.json").write_text(json.dumps(root))
    for said in ("no part of a store", "says something else than message"):
        with pytest.raises(StoreError, match=said):
            store.read_plan(copy)
        for stage in ("figures", "boundaries", "sweep", "check"):
            code, _, err = run(tmp_path, capsys, f"stages=[{stage}]")
            assert code in (1, 2) and "Traceback" not in err
        (copy / "message/.zarray").unlink(missing_ok=True)
    assert not (tmp_path / "went-off").exists()


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("mean", {"shape": [10**7, 10**6, 8]}),
        ("mean", {"data_type": "object"}),
        ("domain", {"codecs": [{"name": "numcodecs.pickle"}]}),
        ("status", {"chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [10**12]}}}),
        ("f_e", {"shape": [10**12]}),
        (
            "boundaries/x",
            {
                "shape": [10**12],
                "data_type": "float64",
                "node_type": "array",
                "zarr_format": 3,
                "fill_value": 0.0,
                "dimension_names": ["x"],
                "codecs": [{"name": "bytes"}, {"name": "zstd"}, {"name": "crc32c"}],
                "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [10**12]}},
                "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}},
            },
        ),
    ],
)
def test_claims_are_compared_with_the_plan_and_cost_nothing(copy, name, changes):
    if not (copy / name).exists():
        groups.write_group(copy, "boundaries", xr.Dataset())
        (copy / name).mkdir()
        (copy / name / "zarr.json").write_text("{}")
    _listed(copy, name, **changes)
    tracemalloc.start()
    with pytest.raises(StoreError) as caught:
        store.read_plan(copy)
    assert tracemalloc.get_traced_memory()[1] < 2e7
    tracemalloc.stop()
    assert "\n" not in str(caught.value) and "is damaged" in str(caught.value)


@pytest.mark.parametrize(
    "change",
    [
        {"sweep": {"name": "omega", "low": 0.05, "high": 2.0, "num": 10**12}},
        {"sweep": "x"},
        {"sweep": None},
        {"max_points": 10**12},
        {"parameter": {"name": "../../x", "low": 0.0, "high": 1.0, "num": 4}},
        {"max_solutions": True},
        {"parameter": {"name": "f_e", "low": float("nan"), "high": 1.0, "num": 4}},
        {"gear": {"b": [[[1.0]]]}},
        {"gear": 7},
        {"solver": {"order": 10**9}},
        {"omega": {"a": 1}},
        {"extra": 1},
        {"parameter": {"name": "omega", "low": 1, "high": 2, "num": 4}},
    ],
)
def test_numbers_that_no_plan_has_are_refused(copy, change):
    numbers = {**json.loads(json.loads((copy / "zarr.json").read_text())["attributes"]["numbers"]), **change}
    retold(copy, numbers=json.dumps(numbers))
    with pytest.raises(StoreError, match="makes no sense") as caught:
        store.read_plan(copy)
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 600


def test_nested_json_is_refused(copy):
    retold(copy, numbers="[" * 100_000)
    with pytest.raises(StoreError, match="not allowed"):
        store.read_plan(copy)


@pytest.mark.costly
def test_a_stored_configuration_is_text(copy, tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("SECRET_OF_THE_READER", "swordfish")
    stored = "a: ${oc.env:SECRET_OF_THE_READER}\nb: {_target_: os.mkdir, path: went-off}\n"
    retold(copy, configuration=stored, title="${oc.env:HOME}")
    monkeypatch.chdir(tmp_path)
    code = main(["stages=[figures]", "figures.formats=[svg]", "store.name=plane", "cluster=none"])
    out, err = capsys.readouterr()
    assert (code, err) == (0, "") and not (tmp_path / "went-off").exists()
    drawn = "".join(file.read_text() for file in (tmp_path / "outputs/figures").rglob("*.svg"))
    assert "swordfish" not in drawn + out


@pytest.mark.parametrize("place", ["mean", "branches", "mean/c/0/0/0", "mine"])
def test_links_lead_nowhere(copy, tmp_path, capsys, place):
    outside = tmp_path / "outside"
    if (copy / place).exists():
        (copy / place).rename(outside)
    else:
        outside.mkdir()
    (copy / place).symlink_to(outside)
    before = sorted(outside.rglob("*")), outside.stat().st_mtime_ns
    for stage in ("sweep", "figures", "check"):
        code, _, err = run(tmp_path, capsys, f"stages=[{stage}]", "check.repair=true")
        assert code == 2 and err == (
            f"error: {copy} is not allowed: '{place}' is a link; a store has files and folders only\n"
        ), err
    assert (sorted(outside.rglob("*")), outside.stat().st_mtime_ns) == before


@pytest.mark.parametrize("name", [".plane.zarr.lock", ".plane.zarr.tries", ".plane.zarr.template"])
def test_links_beside_a_store_lead_nowhere(tmp_path, capsys, name):
    root = tmp_path / "outputs/store"
    root.mkdir(parents=True)
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "thesis.tex").write_text("mine")
    (root / name).symlink_to(mine / "thesis.tex" if name.endswith("lock") else mine)
    code, _, err = run(tmp_path, capsys, "stages=[sweep]", "plane.parameter.num=3", "plane.sweep.num=9")
    assert (mine / "thesis.tex").read_text() == "mine" and len(list(mine.iterdir())) == 1
    assert code == (1 if name.endswith("lock") else 0) and len(err.splitlines()) == code


@pytest.mark.parametrize("name", ["../x", "/tmp/x", "a/b", ".hidden", "..", "x" * 200, "a\nb"])
def test_a_store_stays_in_its_folder(name):
    with pytest.raises(ConfigurationError, match="store.name"):
        compose([f"store.name='{name}'"])


@pytest.mark.parametrize(
    "choice", ["plane=../x", "gear=/etc/passwd", "plane=../gear/published", "plane=omega_fe/../omega_b"]
)
def test_group_choices_stay_in_their_folder(choice):
    with pytest.raises(ConfigurationError) as caught:
        compose([choice])
    assert "\n" not in str(caught.value)


_LAUGHS = "a0: &a0 [1,1,1,1,1,1,1,1,1,1]\n" + "".join(
    f"a{i}: &a{i} [{','.join([f'*a{i - 1}'] * 10)}]\n" for i in range(1, 12)
)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (_LAUGHS, "repeated ones included"),
        ("a: &a [*a]\n", "repeated ones included"),
        ("a: " + "[" * 5000, "nested deeper"),
        ("a: !!python/object/apply:os.mkdir [went-off]\n", "names no plain data"),
        ("a: !evil 1\n", "names no plain data"),
        ("a: [", "must be YAML"),
        ("b: 1\n" * 300_000, "bytes long"),
        ("\x00", "must be YAML"),
    ],
)
def test_configuration_files_are_plain_and_small(tmp_path, monkeypatch, capsys, text, said):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "theirs/gear").mkdir(parents=True)
    (tmp_path / "theirs/gear/bomb.yaml").write_text(text)
    code = main(["--config-dir", "theirs", "gear=bomb", "stages=[sweep]"])
    err = capsys.readouterr().err
    assert code == 2 and len(err.splitlines()) == 1 and "bomb.yaml" in err and said in err
    assert [place.name for place in tmp_path.iterdir()] == ["theirs"]


def test_configuration_files_run_nothing(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "theirs/gear").mkdir(parents=True)
    odd = "defaults: [published, _self_]\n_target_: os.mkdir\npath: went-off\n"
    (tmp_path / "theirs/gear/odd.yaml").write_text(odd)
    code = main(["--config-dir", "theirs", "gear=odd", "stages=[sweep]"])
    err = capsys.readouterr().err
    assert code == 2 and len(err.splitlines()) == 1 and "gear._target_" in err
    assert [place.name for place in tmp_path.iterdir()] == ["theirs"]


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os').mkdir('x')",
        "1 m**9999999",
        "1 " + "m*" * 40 + "m",
        "1e999 m",
        "9" * 5000 + " m",
        "1 m;1",
        "[1,2] m",
        "1 m^4^4^4",
    ],
)
def test_units_evaluate_nothing(text):
    with pytest.raises(ConfigurationError) as caught:
        quantity("gear.physical.module", text, "length")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("version", "said"), [(2, "an older version of this program (schema 2"), (99, "a newer")])
def test_stores_of_other_versions_are_refused(copy, tmp_path, capsys, version, said):
    retold(copy, bevelmap_schema=version)
    for stage in ("figures", "sweep", "check"):
        code, _, err = run(tmp_path, capsys, f"stages=[{stage}]", "check.repair=true")
        assert code == 2 and err.startswith(f"error: {copy} was made by {said}") and len(err.splitlines()) == 1
        assert ("store.overwrite=true" if version == 2 else "update it") in err
