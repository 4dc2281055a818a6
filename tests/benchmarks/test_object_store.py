"""The benchmark of object stores measures both kinds, and counts requests of the one that has any."""

import pytest

from benchmarks.object_store import Server, measure
from pipeline.config.compose import compose
from pipeline.plan.planning import plan
from pipeline.store.arrays import row_layouts

SIZES = ["plane.sweep.num=9", "plane.parameter.num=4"]


@pytest.mark.costly
def test_seconds_of_both_kinds_and_requests_of_one(monkeypatch):
    server = Server()
    try:
        for name, value in server.environment.items():
            monkeypatch.setenv(name, value)
        found, blocks = measure(server, SIZES, 1)
    finally:
        server.end()
    planned = plan(compose(SIZES))
    assert blocks == len(planned.blocks)
    for kinds in found.values():
        (folder,), (objects,) = kinds["folder"], kinds["objects"]
        assert min(folder.wall, folder.processor, objects.wall, objects.processor) > 0.0
        assert not folder.requests and objects.requests["GET"] > 0
    # Every array of every block is put once, its states once more; what is there is not put again.
    (swept,), (again,) = found["sweep"]["objects"], found["the same again, done"]["objects"]
    assert swept.requests["PUT"] >= blocks * (len(row_layouts(planned)) + 1)
    assert again.requests["PUT"] < blocks * len(row_layouts(planned))
