"""The results of a run as one table and as JSON, with the machine and the versions that made them."""

import json
import os
import platform
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path

from benchmarks.measurement import Measurement

__all__ = ["PAGE", "SCHEMA", "document", "fill", "table", "write"]

SCHEMA = 1
#: The page of the site that has the table of a whole run.
PAGE = Path(__file__).parents[1] / "docs/speed.md"
_FROM, _TO = "<!-- from here on by make bench -->\n", "<!-- to here -->\n"
_PACKAGES = ("numpy", "scipy", "numba", "llvmlite", "zarr", "xarray", "dask", "distributed", "matplotlib")
_BASELINES = ("fsolve", "runge_kutta")


def document(measurements: list[Measurement], quick: bool, seconds: float) -> dict:
    """Everything, as plain data."""
    return {
        "schema": SCHEMA,
        "made": datetime.now(UTC).isoformat(timespec="seconds"),
        "quick": quick,
        "seconds": seconds,
        "machine": {
            "processor": _processor(),
            "cores": os.cpu_count(),
            "system": platform.platform(),
            "load": os.getloadavg()[0],
        },
        "versions": {
            "python": platform.python_version(),
            **{package: metadata.version(package) for package in _PACKAGES},
        },
        "measurements": [measurement.plain for measurement in measurements],
    }


def _processor() -> str:
    """Its name where Linux says it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), platform.machine())


def table(found: dict) -> str:
    """For a terminal and for the site: Markdown."""
    lines = [
        "| what | measured | lowest–highest (n) | fsolve takes | Runge–Kutta takes |",
        "| --- | --- | --- | --- | --- |",
    ]
    for one in found["measurements"]:
        spread = f"{one['lowest']:.3g}–{one['highest']:.3g} ({one['repeats']})"
        ratios = [_times(one["baselines"].get(name)) for name in _BASELINES]
        note = "".join(
            f"; uncompressed {_times(ratio)}" for name, ratio in one["baselines"].items() if name not in _BASELINES
        )
        lines.append(
            f"| {one['name']}: {one['what']}{note} | {one['median']:.3g} {one['unit']} | {spread} | "
            f"{' | '.join(ratios)} |"
        )
    machine = found["machine"]
    lines += [
        "",
        f"{machine['processor']}, {machine['cores']} cores, load {machine['load']:.1f} at the end; "
        f"{found['seconds']:.0f} s in all. "
        "Columns three and four: the same job by the baseline, on one core, as a multiple.",
    ]
    return "\n".join(lines)


def _times(baseline: dict | None) -> str:
    return "" if baseline is None else f"{baseline['ratio']:.3g} ×"


def write(found: dict, file: Path) -> None:
    """Write the JSON."""
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


def fill(found: dict, page: Path) -> None:
    """Put the table of a run into a page, between its two marks."""
    before, _, rest = page.read_text(encoding="utf-8").partition(_FROM)
    _, _, after = rest.partition(_TO)
    versions = ", ".join(f"{name} {version}" for name, version in found["versions"].items())
    text = f"\n{table(found)}\n\nMeasured {found['made'][:10]} with {versions}.\n\n"
    page.write_text(f"{before}{_FROM}{text}{_TO}{after}", encoding="utf-8")
