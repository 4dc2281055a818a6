"""One undisturbed store for all tests of this folder, whichever process gets there first."""

from pathlib import Path

import pytest

from tests.made_once import made_once
from tests.pipeline.faults.runs import finished


def _undisturbed(folder: Path) -> None:
    run = finished(folder, "cluster=none")
    assert (run.code, run.err) == (0, ""), run.err


@pytest.fixture(scope="session")
def undisturbed() -> Path:
    """The store that an undisturbed run makes; not to be changed."""
    return made_once("undisturbed", _undisturbed) / "outputs/store/plane.zarr"
