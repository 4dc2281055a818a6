"""Real runs to be harmed: processes of the command line, what is in their store, who works for them."""

import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import psutil

from pipeline import store
from pipeline.__main__ import main
from pipeline.errors import StoreError
from pipeline.store.files import files_at
from pipeline.store.names import METADATA
from tests.pipeline.planes import assert_same_contents, contents

__all__ = [
    "COMMAND",
    "INJECTED",
    "KEPT",
    "ROOT",
    "ROWS",
    "Run",
    "complete",
    "continued",
    "finished",
    "same",
    "start",
    "until",
    "workers_of",
]

ROOT = Path(__file__).parents[3]
#: Put on PYTHONPATH, it makes processes fail as BEVELMAP_TEST_FAULT says.
INJECTED = Path(__file__).parent / "injected"
ROWS = 36
#: A plane of twelve blocks, each of three rows that take some hundredths of a second.
COMMAND = (
    "plane=omega_fe",
    "plane.sweep.num=240",
    f"plane.parameter.num={ROWS}",
    "solver.certify_columns=25",
    "stages=[sweep]",
    "store.name=plane",
)
KEPT = "; what is stored is kept, and the same command goes on from there"


class Run:
    """`python -m pipeline` in a folder, as a process of its own.

    Parameters
    ----------
    folder : Path
    *arguments : str
        Beside `COMMAND`; one says where rows are computed, since a plane so small has no workers unless told.
    environment : dict, optional
        What to add to the environment.
    """

    def __init__(self, folder: Path, *arguments: str, environment=None, **options):
        assert any(argument.startswith("cluster") for argument in arguments), arguments
        self.path = folder / "outputs/store/plane.zarr"
        paths = os.pathsep.join([*filter(None, [(environment or {}).get("PYTHONPATH")]), str(ROOT)])
        self.process = subprocess.Popen(
            [sys.executable, "-W", "error", "-m", "pipeline", *COMMAND, *arguments],
            cwd=folder,
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,
            env={**os.environ, **(environment or {}), "PYTHONPATH": paths},
            **options,
        )

    def end(self, timeout: float = 120.0) -> "Run":
        """Wait for it; `code`, `out` and `err` are there then."""
        self.out, self.err = self.process.communicate(timeout=timeout)
        self.code = self.process.returncode
        return self


def start(folder: Path, *arguments: str, **options) -> Run:
    """Start a run in a folder that is made if need be."""
    folder.mkdir(parents=True, exist_ok=True)
    return Run(folder, *arguments, **options)


def finished(folder: Path, *arguments: str, **options) -> Run:
    """A run that has ended."""
    return start(folder, *arguments, **options).end()


def continued(folder: Path, capsys) -> str:
    """What the same command says that goes on after a harm, which it must do well; in this process, kernels loaded."""
    capsys.readouterr()
    code = main([*COMMAND, "cluster=none", f"output.root={folder / 'outputs'}"])
    said = capsys.readouterr()
    assert (code, said.err) == (0, ""), said.err
    return said.out


def complete(path: Path) -> int:
    """Complete rows of a store that others are writing."""
    try:
        return int(np.sum(store.statuses(path) == store.COMPLETE))
    except (OSError, ValueError, KeyError, StoreError):
        return 0


def until(run: Run, rows: int, timeout: float = 120.0) -> int:
    """Wait until so many rows are complete; how many are."""
    deadline = time.monotonic() + timeout
    while (seen := complete(run.path)) < rows and run.process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.01)
    assert run.process.poll() is None, run.end().err
    return seen


def workers_of(run: Run) -> list[psutil.Process]:
    """The worker processes of a run with a cluster of its own."""
    children = psutil.Process(run.process.pid).children()
    return [child for child in children if "spawn_main" in " ".join(child.cmdline())]


def same(path: Path, reference: Path) -> None:
    """Assert that two stores are bitwise equal, `branches` included."""
    # Equal files hold equal arrays, and what zarr goes by is looked over; only where files differ it has to read them.
    store.read_layout(path)
    if _arrays(path) != _arrays(reference):
        assert_same_contents(contents(path), contents(reference))


def _arrays(path: Path) -> dict[str, bytes]:
    """The files of a store by their names, without the two that say when it was made."""
    names = files_at(path).sizes().keys() - {METADATA, f"branches/{METADATA}"}
    return {name: (path / name).read_bytes() for name in names}
