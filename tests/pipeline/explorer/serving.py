"""The explorer as users start it: a process of its own over a tiny plane."""

import contextlib
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tests.pipeline.planes import COARSE, small_plan, traced_store

__all__ = ["Served", "served_plane", "serving"]

_ROOT = Path(__file__).parents[3]
#: Seconds that a process has to end.
_PATIENCE = 60


@dataclass(frozen=True)
class Served:
    """A running explorer: its address without a query, its process, its store."""

    url: str
    process: subprocess.Popen
    store: Path


def served_plane(folder: Path) -> Path:
    """A tiny plane with its boundaries, as a run has it below `folder`."""
    path = folder / "store" / "omega_fe.zarr"
    path.parent.mkdir(parents=True)
    return traced_store(path, small_plan(*COARSE))


@contextlib.contextmanager
def serving(folder: Path, *overrides: str) -> Iterator[Served]:
    """An explorer over the plane below `folder`; ended by Ctrl-C, of which it must say so."""
    words = [*COARSE, f"output.root={folder}", "stages=[explore]", "store.name=omega_fe", *overrides]
    process = subprocess.Popen(
        [sys.executable, "-m", "pipeline", *words],
        cwd=_ROOT,
        env={**os.environ, "PYTHONPATH": str(_ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        # Ctrl-C of whoever runs the tests is none of it; and a shell may have it ignored.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    try:
        lines = []
        for line in process.stdout:
            lines.append(line)
            if found := re.search(r"http://127\.0\.0\.1:\d+/", line):
                break
        assert found, "".join(lines)
        yield Served(found[0], process, folder / "store" / "omega_fe.zarr")
        assert process.poll() is None, process.stdout.read()
        process.send_signal(signal.SIGINT)
        said, _ = process.communicate(timeout=_PATIENCE)
        assert process.returncode == 0 and "explore: ended" in said and "Traceback" not in said, said
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()
