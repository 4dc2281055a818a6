"""The stage tables: tables 1 to 3 of the study from the stored planes."""

from pipeline import store
from pipeline.config.typed import SYSTEMS
from pipeline.errors import ConfigurationError
from pipeline.run.job import Job, command
from pipeline.run.preparation import stored_plan
from pipeline.run.progress import Reporter
from pipeline.run.stage import Stage
from pipeline.run.workforce import Workforce

__all__ = ["STAGE"]

TABLE_PLANES = ("omega_b", "omega_alpha", "omega_fpm")


def _check(job: Job) -> None:
    gear = job.settings.config.gear
    for name in SYSTEMS:
        if getattr(gear, name) is not None:
            raise ConfigurationError(
                f"gear = {job.settings.choices['gear']!r} is not allowed with stages=[tables]: "
                "they are the study's, of a bevel pair"
            )


def _run(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    from pipeline.study import tables

    settings, stores = job.settings, {}
    for plane in TABLE_PLANES:
        own = settings.of_plane(plane)
        path = own.store_path.resolve()
        if store.exists(path):
            # Refused unless it is what was typed.
            stored_plan(own)
        stores[plane] = (path, command(own))
    folder = settings.output_root / "tables"
    paths = tables.write(stores, folder)
    reporter.line(f"tables: {', '.join(path.name for path in paths)} in {folder.resolve()}")
    return 0


STAGE = Stage("tables", _run, _check)
