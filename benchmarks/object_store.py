"""What a store in an object store costs against one in a folder: requests, and seconds of the same commands.

    python -m benchmarks.object_store [--columns 160] [--rows 60] [--repeats 3]

The object store is the tests' S3 server on this machine (extra `test`), so that what a network adds is left out: add
its time for one request, times the requests that follow each other. Both kinds do the same in turn, in this process;
seconds are those of this process's processor time, which leaves the server out, and of the wall clock; medians.
"""

import argparse
import contextlib
import io
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from pipeline import open_plane
from pipeline.__main__ import main as run
from pipeline.store import read_plan

ROOT = Path(__file__).resolve().parents[1]
#: Runs the server; answers each line of its input with the requests since the last one.
_SERVER = """
import json, sys
from tests.object_server import served_objects
with served_objects() as server:
    print(json.dumps([server.url("bench"), server.environment]), flush=True)
    for _ in sys.stdin:
        print(json.dumps(server.count()), flush=True)
"""

_METHODS = ("GET", "HEAD", "PUT", "POST", "DELETE")


@dataclass(frozen=True)
class Cost:
    """Of one command on one kind of store: seconds of the wall clock and of the processor, and requests by method."""

    wall: float
    processor: float
    requests: Counter[str]


def command(*words: str) -> None:
    """Run a command in this process, quietly."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        status = run(list(words))
    if status:
        raise SystemExit(said.getvalue())


class Server:
    """The server, in a process of its own that ends with its input."""

    def __init__(self):
        self._process = subprocess.Popen(
            [sys.executable, "-c", _SERVER], cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self.url, self.environment = json.loads(self._process.stdout.readline())

    def count(self) -> Counter[str]:
        """Requests since last asked, by method."""
        print(file=self._process.stdin, flush=True)
        return Counter(json.loads(self._process.stdout.readline()))

    def end(self) -> None:
        """Until it has ended."""
        self._process.stdin.close()
        self._process.wait()
        self._process.stdout.close()


def cost(server: Server, action: Callable[[], object]) -> Cost:
    """What it takes."""
    server.count()
    wall, processor = time.perf_counter(), time.process_time()
    action()
    return Cost(time.perf_counter() - wall, time.process_time() - processor, server.count())


def actions(root: str, scratch: Path, sizes: list[str]) -> dict[str, Callable[[], object]]:
    """What is measured, by name, in its order."""
    usual = [
        "plane=omega_fe",
        *sizes,
        "cluster=none",
        f"store.root={root}",
        "store.name=plane",
        f"output.root={scratch}",
    ]
    return {
        "sweep": lambda: command(*usual, "stages=[sweep]"),
        "the same again, done": lambda: command(*usual, "stages=[sweep]"),
        "boundaries": lambda: command(*usual, "stages=[boundaries]"),
        "check": lambda: command(*usual, "stages=[check]"),
        "list": lambda: command(*usual, "stages=[list]"),
        "open_plane": lambda: open_plane("plane", root=root),
    }


def measure(server: Server, sizes: list[str], repeats: int) -> tuple[dict[str, dict[str, list[Cost]]], int]:
    """Costs by action and kind of store, and the number of blocks; the first turn is not counted."""
    found: dict[str, dict[str, list[Cost]]] = {}
    with tempfile.TemporaryDirectory() as scratch:
        for turn in range(repeats + 1):
            for kind in ("folder", "objects"):
                root = f"{server.url}/{turn}" if kind == "objects" else str(Path(scratch) / f"stores-{turn}")
                for name, action in actions(root, Path(scratch) / f"{kind}-{turn}", sizes).items():
                    one = cost(server, action)
                    if turn:
                        found.setdefault(name, {}).setdefault(kind, []).append(one)
        return found, len(read_plan(Path(scratch) / "stores-0/plane.zarr").blocks)


def median(costs: list[Cost], what: str) -> float:
    """Of the repeats."""
    return statistics.median(getattr(one, what) for one in costs)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name, usual in (("--columns", 160), ("--rows", 60), ("--repeats", 3)):
        parser.add_argument(name, type=int, default=usual)
    given = parser.parse_args()
    sizes = [f"plane.sweep.num={given.columns}", f"plane.parameter.num={given.rows}"]
    server = Server()
    try:
        os.environ.update(server.environment)
        found, blocks = measure(server, sizes, given.repeats)
    finally:
        server.end()
    print(f"{given.columns} x {given.rows}, {blocks} blocks, {given.repeats} repeats, load {os.getloadavg()[0]:.1f}\n")
    print(f"| what | folder | objects | ratio | processor: folder | objects | ratio | {' | '.join(_METHODS)} |")
    print(f"|{' --- |' * (7 + len(_METHODS))}")
    for name, kinds in found.items():
        cells = []
        for what in ("wall", "processor"):
            folder, objects = (median(kinds[kind], what) for kind in ("folder", "objects"))
            cells += [f"{folder:.3g} s", f"{objects:.3g} s", f"{objects / folder:.2f}"]
        requests = kinds["objects"][-1].requests
        print(f"| {name} | {' | '.join(cells)} | {' | '.join(str(requests[method]) for method in _METHODS)} |")
    requests = found["sweep"]["objects"][-1].requests
    print(f"\nper block of the sweep: {', '.join(f'{requests[name] / blocks:.1f} {name}' for name in _METHODS)}")


if __name__ == "__main__":
    main()
