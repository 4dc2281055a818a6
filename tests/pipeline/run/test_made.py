"""Files made from a store are made again exactly when they would be others, or somebody has changed them."""

import json

import pytest

from pipeline.run import made


@pytest.fixture
def store(tmp_path):
    folder = tmp_path / "plane.zarr"
    (folder / "amplitude" / "c").mkdir(parents=True)
    (folder / "zarr.json").write_text("{}")
    (folder / "amplitude" / "c" / "0").write_bytes(b"chunk")
    return folder


@pytest.fixture
def record(tmp_path, store):
    (tmp_path / "map.png").write_bytes(b"picture")
    (tmp_path / "map.pdf").write_bytes(b"page")
    record = tmp_path / ".figures.json"
    made.write_record(record, made.made_from(store, {"dpi": 200}), [tmp_path / "map.png", tmp_path / "map.pdf"])
    return record


def current(record, store, **options):
    return made.still_made(record, made.made_from(store, options))


def test_nothing_has_changed(record, store):
    assert [path.name for path in current(record, store, dpi=200)] == ["map.png", "map.pdf"]


@pytest.mark.parametrize(
    "change",
    [
        lambda store: (store / "amplitude" / "c" / "0").write_bytes(b"other"),
        lambda store: (store / "amplitude" / "c" / "1").write_bytes(b"more"),
        lambda store: (store / "amplitude" / "c" / "0").unlink(),
        lambda store: (store.parent / "map.png").write_bytes(b"edited!"),
        lambda store: (store.parent / "map.pdf").unlink(),
        lambda store: (store.parent / ".figures.json").unlink(),
        lambda store: (store.parent / ".figures.json").write_text("{"),
        lambda store: (store.parent / ".figures.json").write_text("[1]"),
    ],
)
def test_something_has_changed(record, store, change):
    change(store)
    assert current(record, store, dpi=200) is None


def test_other_options_sources_and_libraries(record, store, monkeypatch):
    assert current(record, store, dpi=100) is None
    known = made.facts()
    monkeypatch.setattr(made, "facts", lambda: {**known, "pipeline/figures/map.py": "edited"})
    assert current(record, store, dpi=200) is None


def test_a_record_points_nowhere_else(record, store, tmp_path):
    secret = tmp_path / "elsewhere" / "map.png"
    secret.parent.mkdir()
    secret.write_bytes(b"secret")
    said = json.loads(record.read_text())
    said["files"] = {"elsewhere/../../../etc/passwd": "0", **said["files"]}
    record.write_text(json.dumps(said))
    assert current(record, store, dpi=200) is None
