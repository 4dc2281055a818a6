"""Seconds from the shell to the figures of one plane, and the peak memory of every process on the way."""

import os
import re
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import psutil

ROOT = Path(__file__).resolve().parents[1]


def run(folder: Path, *arguments: str, **environment: str) -> tuple[float, float, str]:
    """Seconds, peak resident megabytes of any one process, and what the command said."""
    command = [sys.executable, "-m", "pipeline", "plane=omega_fe", *arguments]
    begin = time.perf_counter()
    process = subprocess.Popen(
        command,
        cwd=folder,
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
    )
    peak, family = 0.0, psutil.Process(process.pid)
    while process.poll() is None:
        try:
            for member in [family, *family.children(recursive=True)]:
                peak = max(peak, member.memory_info().rss / 1e6)
        except psutil.NoSuchProcess:
            pass
        time.sleep(0.1)
    seconds = time.perf_counter() - begin
    said = process.stdout.read()
    if process.returncode != 0:
        raise SystemExit(said)
    return seconds, peak, said


def sweeping(said: str) -> float:
    """Seconds of the sweep stage, as the command reports them."""
    return float(re.search(r"branch points in ([\d.]+) s", said).group(1))


def main() -> None:
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        cold = {"NUMBA_CACHE_DIR": str(folder / "cache")}
        seconds, peak, said = run(folder, **cold)
        print(f"first run, kernels compiled:        {seconds:6.1f} s, peak {peak:4.0f} MB")
        results = [run(folder, "store.overwrite=true", **cold) for _ in range(5)]
        print(
            f"400 x 200, kernels cached:          {statistics.median(r[0] for r in results):6.2f} s"
            f" of which sweeping {statistics.median(sweeping(r[2]) for r in results):.2f} s,"
            f" peak {max(r[1] for r in results):.0f} MB   (median of 5)"
        )
        for rows in (200, 400, 800, 1600):
            said = run(folder, f"plane.parameter.num={rows}", "stages=[sweep]", "store.overwrite=true", **cold)[2]
            took = sweeping(said)
            print(f"400 x {rows:<4d} sweep stage:             {took:6.2f} s, {1e3 * took / rows:.2f} ms per row")
        seconds, _, _ = run(folder, "stages=[figures]", "store.name=omega_fe", **cold)
        print(f"redraw from the store:              {seconds:6.2f} s")


if __name__ == "__main__":
    main()
