"""What cells cost: processor time of every stage, two workers against one, bytes; and what a billion cells take.

    python -m benchmarks.cost_model [--columns 400] [--rows 200] [--attractor-rows 24] [--repeats 3]

prints two tables and puts them into docs/scale.md. Cells per core-second are of processor time, which hardly depends on
what else the machine does; efficiencies are of the wall clock, and want a machine that does nothing else.
"""

import argparse
import os
import statistics
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

os.environ.update({f"{library}_NUM_THREADS": "1" for library in ("OMP", "MKL", "OPENBLAS", "NUMBA")})

import psutil

from benchmarks.cluster_limits import ROOT

PAGE = ROOT / "docs/scale.md"
_FROM, _TO = "<!-- from here on by python -m benchmarks.cost_model -->", "<!-- to here -->"
#: What is extrapolated.
_CELLS, _CORES = 1e9, 1000


@dataclass(frozen=True)
class Effort:
    """Seconds: of the wall clock, and of the processor by workers and by the client with its scheduler."""

    wall: float
    workers: float
    client: float


@dataclass(frozen=True)
class Stage:
    """What a stage costs."""

    name: str
    cells_per_second: float
    bytes_per_cell: float
    efficiency: float | None = None
    client: float | None = None


def processor_seconds() -> tuple[float, float]:
    """Used so far by the children of this process, which are the workers, and by itself, with the scheduler in it."""
    children = [child.cpu_times() for child in psutil.Process().children(recursive=True)]
    return sum(child.user + child.system for child in children), time.process_time()


def effort(work: Callable[[], object]) -> Effort:
    """What some work takes."""
    begin, before = time.perf_counter(), processor_seconds()
    work()
    wall = time.perf_counter() - begin
    return Effort(wall, *(late - early for late, early in zip(processor_seconds(), before, strict=True)))


def size_of(folder: Path) -> int:
    """Bytes of all files."""
    return sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())


def on_workers(settings, path: Path, planned, workers: int, integrated: list[str]) -> tuple[Effort, Effort]:
    """The sweep of a plane and its attractors on so many warm workers."""
    from pipeline import store
    from pipeline.analysis.attractors.options import grid_of
    from pipeline.analysis.attractors.rounds import Progress, run_rounds
    from pipeline.analysis.attractors.stage import _map_digest
    from pipeline.analysis.attractors.summary import summary_of
    from pipeline.analysis.attractors.tasks import Spec
    from pipeline.config.compose import compose
    from pipeline.run.dispatch import dispatch
    from pipeline.run.job import Job
    from pipeline.run.workforce import Workforce
    from pipeline.store.files import files_at
    from pipeline.store.names import STORE_FILE

    job = Job(
        compose([*settings.overrides, *integrated, f"store.root={path.parent}", f"store.name={path.stem}"]), planned
    )
    options = job.settings.config.attractors

    def sweep() -> None:
        for _, receipt in dispatch(path, planned, planned.blocks, workforce):
            if isinstance(receipt, Exception):
                raise receipt

    def seek() -> None:
        grid = grid_of(planned, options)
        spec = Spec(path, grid, options, _map_digest(job))
        spec.group.begin()
        if lost := run_rounds(spec, workforce, Progress()):
            raise RuntimeError(lost[0])
        spec.group.finish(summary_of(path, spec.group, grid, options))

    with Workforce(replace(settings.config.cluster, workers=workers)) as workforce:
        workforce.start()
        # Workers load what rows need with their first one.
        warm = path.with_name("warm.zarr")
        for _ in range(2):
            files_at(warm).clear(STORE_FILE)
            store.create(warm, planned, "warm", "benchmark\n")
            list(dispatch(warm, planned, planned.blocks[: 2 * workers], workforce))
        store.create(path, planned, "measured", "benchmark\n")
        return effort(sweep), effort(seek)


def stages(columns: int, rows: int, attractor_rows: int, repeats: int) -> list[Stage]:
    """What every stage of a plane costs; of several repeats the medians."""
    from pipeline.analysis import boundaries
    from pipeline.config.compose import compose
    from pipeline.figures import draw
    from pipeline.plan.planning import plan

    settings = compose([f"plane.sweep.num={columns}", f"plane.parameter.num={rows}"])
    planned, efforts = plan(settings), {1: [], 2: []}
    integrated, cells = [f"attractors.rows={attractor_rows}"], (columns * rows, columns * attractor_rows)
    with tempfile.TemporaryDirectory(prefix="bevelmap-cost-") as scratch:
        for number in range(repeats):
            for workers in (1, 2):
                path = Path(scratch) / f"{workers}-{number}.zarr"
                efforts[workers].append(on_workers(settings, path, planned, workers, integrated))
        bytes_per_cell = (
            (size_of(path) - size_of(path / "attractors")) / cells[0],
            size_of(path / "attractors") / cells[1],
        )
        found = [
            _of_pairs(name, count, size, [(one[i], two[i]) for one, two in zip(efforts[1], efforts[2], strict=True)])
            for i, (name, count, size) in enumerate(zip(("sweep", "attractors"), cells, bytes_per_cell, strict=True))
        ]
        traced = effort(lambda: boundaries.trace(path, planned))
        found.append(Stage("boundaries", cells[0] / traced.client, size_of(path / "boundaries") / cells[0]))
        drawn = effort(lambda: draw(path, Path(scratch) / "figures", None, ["png"], 100))
        found.append(Stage("figures", cells[0] / drawn.client, size_of(Path(scratch) / "figures") / cells[0]))
    return found


def _of_pairs(name: str, cells: int, size: float, pairs: list[tuple[Effort, Effort]]) -> Stage:
    """From pairs of one worker and two."""
    return Stage(
        name,
        statistics.median(cells / one.workers for one, _ in pairs),
        size,
        statistics.median(one.wall / (2.0 * two.wall) for one, two in pairs),
        statistics.median(two.client / two.workers for _, two in pairs),
    )


def tables(found: list[Stage], columns: int, rows: int, attractor_rows: int) -> str:
    """Both tables, in Markdown."""
    lines = [
        "| stage | cells per core-second | bytes per cell | two workers against one | client and scheduler |",
        "| --- | ---: | ---: | ---: | ---: |",
    ]
    for stage in found:
        efficiency = "" if stage.efficiency is None else f"{stage.efficiency:.2f}"
        client = "" if stage.client is None else f"{stage.client:.1%}"
        lines.append(
            f"| {stage.name} | {stage.cells_per_second:,.0f} | {stage.bytes_per_cell:.0f} | {efficiency} | {client} |"
        )
    lines += [
        "",
        f"A plane of {columns} × {rows}, attractors in {attractor_rows} of its rows; {os.cpu_count()} cores, load "
        f"{os.getloadavg()[0]:.1f} at the end. Boundaries and figures cost more per cell the fewer cells a plane has.",
        "",
        f"| {_CELLS:.0e} cells | core-hours | on {_CORES:,} cores | bytes |".replace("1e+09", "10⁹"),
        "| --- | ---: | ---: | ---: |",
    ]
    for stage in found:
        seconds = _CELLS / stage.cells_per_second
        lines.append(
            f"| {stage.name} | {seconds / 3600:,.0f} | {_duration(seconds / _CORES)} | "
            f"{_CELLS * stage.bytes_per_cell / 1e9:,.0f} GB |"
        )
    return "\n".join(lines)


def _duration(seconds: float) -> str:
    return (
        f"{seconds / 3600:.1f} h"
        if seconds > 3600
        else f"{seconds / 60:.0f} min"
        if seconds > 60
        else f"{seconds:.0f} s"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name, number in (("columns", 400), ("rows", 200), ("attractor-rows", 24), ("repeats", 3)):
        parser.add_argument(f"--{name}", type=int, default=number)
    parser.add_argument("--print-only", action="store_true", help="leave docs/scale.md as it is")
    given = parser.parse_args()
    text = tables(
        stages(given.columns, given.rows, given.attractor_rows, given.repeats),
        given.columns,
        given.rows,
        given.attractor_rows,
    )
    print(text)
    if not given.print_only:
        before, _, rest = PAGE.read_text(encoding="utf-8").partition(_FROM)
        PAGE.write_text(f"{before}{_FROM}\n\n{text}\n\n{_TO}{rest.partition(_TO)[2]}", encoding="utf-8")


if __name__ == "__main__":
    main()
