"""Two clients on one store of an S3 server, in whole runs: one is refused, one has died, one has lost the store."""

import json

import obstore
import pytest

from pipeline import store
from pipeline.__main__ import main
from pipeline.config.places import place_of
from pipeline.store import lease, objects
from pipeline.store.files import files_at
from pipeline.store.lease import leased
from pipeline.store.names import METADATA

pytestmark = pytest.mark.costly

SIZES = ("plane=omega_fe", "plane.sweep.num=9", "plane.parameter.num=4", "cluster=none", "store.name=plane")
#: These two say when the store was made, and by which configuration.
DATED = {METADATA, f"branches/{METADATA}"}


class Shared:
    """A store on the server of the tests, and its lease."""

    def __init__(self, server, prefix):
        self.root = server.url(f"clients/{prefix}")
        self.place = place_of("store.root", self.root) / "plane.zarr"
        self.bucket, self.lease = objects.of_bucket(self.place), self.place.with_name(".plane.zarr.lease").key

    def claim(self, seconds):
        """Another client takes it, whatever is there, and is not heard of again."""
        told = {"host": "elsewhere", "pid": 7, "since": "1999-12-31", "holder": "x", "renewal": 0, "free": False}
        obstore.put(self.bucket, self.lease, json.dumps(told | {"seconds": seconds}).encode())


@pytest.fixture
def shared(object_server, request, monkeypatch):
    for name, value in object_server.environment.items():
        monkeypatch.setenv(name, value)
    return Shared(object_server, request.node.name)


@pytest.fixture
def run(shared, capsys, tmp_path):
    """A command on it: exit status, and what it said."""

    def run(*words):
        code = main([*SIZES, f"store.root={shared.root}", f"output.root={tmp_path}", "stages=[sweep]", *words])
        return code, *capsys.readouterr()

    return run


def contents_of(place):
    files = files_at(place)
    return {name: files.read(name, size) for name, size in files.sizes().items()}


def test_a_store_that_another_client_holds_is_refused(shared, run):
    with leased(shared.bucket, shared.lease, str(shared.place), False, str, seconds=2.0):
        code, out, err = run()
        assert code == 2 and len(err.splitlines()) == 1
        assert str(shared.place) in err and "is in use by process" in err and "store.wait=true" in err
        assert "whether it still lives" in out and not store.exists(shared.place)


def test_a_client_that_died_is_followed(shared, run):
    shared.claim(0.5)
    code, out, err = run()
    assert (code, err) == (0, "")
    assert "process 7 on elsewhere since 1999-12-31 ended without letting go" in out
    assert lease._record(obstore.get(shared.bucket, shared.lease).bytes().to_bytes()).free


def test_a_run_that_has_lost_its_store_ends_and_is_gone_on_with(shared, run, tmp_path, capsys, monkeypatch):
    """It was stopped for so long that another client came: it finds out before its next write."""
    honest, blocks = store.write_block, []

    def stopped(place, plan, block, rows):
        honest(place, plan, block, rows)
        blocks.append(block)
        if len(blocks) == 2:
            shared.claim(0.5)
            # As much later: what it had been sure of is over.
            lease._HELD[str(place)]._sure = float("-inf")

    with monkeypatch.context() as patch:
        patch.setattr(store, "write_block", stopped)
        code, _, err = run()
    assert code == 1 and len(err.splitlines()) == 1
    assert str(shared.place) in err and "taken over by process 7 on elsewhere" in err
    assert len(blocks) == 2 and store.statuses(shared.place).tolist() == [1, 1, 0, 0]
    code, out, err = run()
    assert (code, err) == (0, "") and "continues: 2 rows" in out
    assert main([*SIZES, "stages=[sweep]", f"output.root={tmp_path / 'folder'}"]) == 0
    expected, found = contents_of(tmp_path / "folder/store/plane.zarr"), contents_of(shared.place)
    assert {name for name in expected if found.get(name) != expected[name]} <= DATED
