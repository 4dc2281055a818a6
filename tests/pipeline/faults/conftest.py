"""One undisturbed store for all tests of this folder, whichever process gets there first."""

from pathlib import Path

import pytest
from filelock import lock_descriptor

from tests.pipeline.faults.runs import finished


@pytest.fixture(scope="session")
def undisturbed(tmp_path_factory) -> Path:
    """The store that an undisturbed run makes; not to be changed."""
    base = tmp_path_factory.getbasetemp()
    # Below pytest-xdist every process has a folder of its own in a common one.
    folder = (base.parent if base.name.startswith("popen-") else base) / "undisturbed"
    folder.mkdir(exist_ok=True)
    with (folder / "lock").open("w") as lock:
        lock_descriptor(lock.fileno())
        path = folder / "outputs/store/plane.zarr"
        if not path.exists():
            run = finished(folder, "cluster=none")
            assert (run.code, run.err) == (0, ""), run.err
    return path
