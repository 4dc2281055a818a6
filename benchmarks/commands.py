"""What a user waits for: whole commands from the shell, and the parts of them that a stored plane shows."""

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

from benchmarks.measurement import Baselines, Measurement, Sizes, timed
from pipeline import figures, store
from pipeline.analysis import boundaries
from pipeline.store import groups

__all__ = ["measure_commands", "run"]

ROOT = Path(__file__).resolve().parents[1]
_SMALL = ("plane.sweep.num=20", "plane.parameter.num=4")


def run(folder: Path, *arguments: str, **environment: str) -> float:
    """Seconds of one command."""
    begin = time.perf_counter()
    result = subprocess.run(
        [sys.executable, "-m", "pipeline", "plane=omega_fe", *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
    )
    if result.returncode != 0:
        raise SystemExit(result.stdout + result.stderr)
    return time.perf_counter() - begin


def measure_commands(folder: Path, sizes: Sizes, baselines: Baselines) -> list[Measurement]:
    """Planes, starts and what a stored plane takes to look at, in a scratch folder."""
    found = []
    for name, (columns, rows, repeats) in sizes.planes.items():
        size = (f"plane.sweep.num={columns}", f"plane.parameter.num={rows}", f"store.name={name}")
        values = tuple(run(folder, *size, "store.overwrite=true") for _ in range(repeats))
        what = f"{columns} x {rows}: sweep, boundaries and figures, shell to finish"
        found.append(Measurement(name, what, "s", values, baselines.of(columns, rows)))
    again = tuple(run(folder, *size, "stages=[sweep]") for _ in range(repeats))
    same = baselines.of(columns, rows)
    found.append(Measurement("resume", "the last of these again, finding its rows done", "s", again, same))
    found += _starts(folder, sizes, baselines)
    return [*found, *_stored(folder / f"outputs/store/{name}.zarr", folder, min(sizes.repeats, 3), same)]


def _starts(folder: Path, sizes: Sizes, baselines: Baselines) -> list[Measurement]:
    """The smallest of planes, for which starting is nearly all."""
    job, found = baselines.of(20, 4), []
    if sizes.cold:
        cache = {"NUMBA_CACHE_DIR": str(folder / "kernels")}
        cold = (run(folder, *_SMALL, "store.name=cold", **cache),)
        found.append(Measurement("start_cold", "20 x 4, every kernel compiled", "s", cold, job))
    # Those of the planes have filled the usual cache.
    warm = tuple(run(folder, *_SMALL, "store.name=warm", "store.overwrite=true") for _ in range(sizes.starts))
    return [*found, Measurement("start_warm", "20 x 4, kernels from the cache", "s", warm, job)]


def _stored(path: Path, folder: Path, repeats: int, job: dict[str, float]) -> list[Measurement]:
    """Boundaries, figures and size of the last plane."""
    planned = store.read_plan(path)
    rows, columns = planned.parameter.num, planned.sweep.num

    def trace():
        groups.remove_group(path, "boundaries")
        boundaries.trace(path, planned)

    pictures = len(figures.draw(path, folder / "pictures", None, ["png"], 200))
    drawing = timed(lambda: figures.draw(path, folder / "pictures", None, ["png"], 200), repeats, 1.0 / pictures)
    shutil.rmtree(folder / "pictures")
    traced = timed(trace, repeats)
    size = sum(file.stat().st_size for file in path.rglob("*") if file.is_file()) / (rows * columns)
    return [
        Measurement("boundaries", f"all boundary curves of {columns} x {rows}, traced and stored", "s", traced, job),
        Measurement("figure", f"one PNG of {columns} x {rows}, mean of {pictures}", "s", drawing, job),
        Measurement(
            "cell",
            f"{columns} x {rows} on disk, branches and boundaries included",
            "B/cell",
            (size,),
            {"uncompressed": planned.bytes / (rows * columns)},
        ),
    ]
