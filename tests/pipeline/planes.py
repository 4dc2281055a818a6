"""Small planes for tests: composed like a user's, computed in this process."""

import json
import shutil
from pathlib import Path

import numpy as np
import zarr

from pipeline import store
from pipeline.analysis import boundaries
from pipeline.config.compose import compose
from pipeline.config.schema import Cluster, Security
from pipeline.plan.plan import Plan
from pipeline.plan.planning import plan
from pipeline.run.rows import sweep_block
from pipeline.store.seal import sealed
from tests.made_once import made_once

__all__ = [
    "COARSE",
    "assert_same_contents",
    "assert_same_values",
    "cluster",
    "contents",
    "retold",
    "small_plan",
    "small_store",
    "traced_store",
]

#: The plane of the transmission error in few cells, with a row at 0.2. Tests that need its boundaries and no resolution
#: take this one: tracing them takes seconds, however few cells there are, and is done once for all of these tests.
COARSE = ("plane=omega_fe", "plane.sweep.num=41", "plane.parameter.num=6")
#: Whatever a test calls its copy.
_WHOLE = "whole.zarr"


def cluster(kind: str, **changes) -> Cluster:
    """Cluster settings as conf/cluster has them, two workers where they are local."""
    usual = dict(
        kind=kind,
        workers={"none": 1, "local": 2}.get(kind, 0),
        memory="auto",
        row_seconds=60.0,
        dashboard=False,
        address=None,
        scheduler_file=None,
        timeout=10.0,
        security=Security(None, None, None),
    )
    return Cluster(**{**usual, **changes})


def small_plan(*overrides: str, columns: int = 41, rows: int = 5) -> Plan:
    """The plan of a plane with few cells."""
    sizes = [f"plane.sweep.num={columns}", f"plane.parameter.num={rows}"]
    return plan(compose([*sizes, *overrides]))


def small_store(path: Path, plan: Plan, blocks=None) -> Path:
    """A store with the template and the given blocks; unless told, a copy of one with all, swept once in a session."""
    if blocks is None:
        whole = made_once(f"swept-{plan.fingerprint}", lambda folder: small_store(folder / _WHOLE, plan, plan.blocks))
        return shutil.copytree(whole / _WHOLE, path)
    store.create(path, plan, "plane", "configuration: test\n")
    for block in blocks:
        sweep_block(str(path), plan, block)
    return path


def traced_store(path: Path, plan: Plan) -> Path:
    """A copy of a whole store with its boundaries, traced once in a session."""

    def trace(folder: Path) -> None:
        boundaries.trace(small_store(folder / _WHOLE, plan), plan)

    return shutil.copytree(made_once(f"traced-{plan.fingerprint}", trace) / _WHOLE, path)


def retold(path: Path, **changes) -> None:
    """Change what a store says of itself, in both places and with its seal, as another program would have it."""
    root, branches = path / "zarr.json", path / "branches/zarr.json"
    document, second = json.loads(root.read_text()), json.loads(branches.read_text())
    attributes = sealed({**document["attributes"], **changes})
    document["attributes"] = second["attributes"]["plane"] = attributes
    document["consolidated_metadata"]["metadata"]["branches"]["attributes"]["plane"] = attributes
    root.write_text(json.dumps(document))
    branches.write_text(json.dumps(second))


def contents(path: Path) -> dict[str, np.ndarray]:
    """Every array of a store by name."""
    root = zarr.open_group(path, mode="r")
    return {name: array[:] for name, array in root.members(max_depth=None) if isinstance(array, zarr.Array)}


def assert_same_values(found: np.ndarray, expected: np.ndarray, name: str) -> None:
    """Fail unless two arrays are equal bit by bit."""
    assert found.dtype == expected.dtype and found.shape == expected.shape, name
    if found.dtype.kind == "T":
        assert found.tolist() == expected.tolist(), name
    else:
        assert found.tobytes() == expected.tobytes(), name


def assert_same_contents(found: dict[str, np.ndarray], expected: dict[str, np.ndarray]) -> None:
    """Fail unless two stores hold the same arrays, bit by bit."""
    assert found.keys() == expected.keys()
    for name in expected:
        assert_same_values(found[name], expected[name], name)
