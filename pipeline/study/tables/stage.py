"""The stage tables: tables 1 to 3 of the study from the stored planes."""

from pathlib import Path

from pipeline.run.job import Job, sweep_command
from pipeline.run.progress import Reporter
from pipeline.run.stage import Stage
from pipeline.run.workforce import Workforce

__all__ = ["STAGE"]

TABLE_PLANES = ("omega_b", "omega_alpha", "omega_fpm")


def _run(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    from pipeline.study import tables

    settings = job.settings
    root = Path(settings.config.store.root).resolve()
    stores = {
        plane: (root / f"{settings.name_of(plane)}.zarr", sweep_command(settings, plane)) for plane in TABLE_PLANES
    }
    folder = settings.output_root / "tables"
    paths = tables.write(stores, folder)
    reporter.line(f"tables: {', '.join(path.name for path in paths)} in {folder.resolve()}")
    return 0


STAGE = Stage("tables", _run)
