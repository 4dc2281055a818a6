"""Stages of one plane, tried: whatever ends them is one line, so that the next plane has its turn."""

from collections.abc import Callable, Sequence
from pathlib import Path

from pipeline import store
from pipeline.errors import KEPT, ConfigurationError
from pipeline.run.job import Job
from pipeline.run.libraries import load_zarr
from pipeline.run.progress import Reporter
from pipeline.run.workforce import Workforce

__all__ = ["attempt"]


def attempt(
    run: Callable[[Job, Workforce, Reporter], int],
    job: Job,
    workforce: Workforce,
    reporter: Reporter,
    beside: Sequence[Path] = (),
) -> int:
    """The exit status of `run(job, workforce, reporter)`, whatever ends it.

    Parameters
    ----------
    run : callable
    job : Job
    workforce : Workforce
    reporter : Reporter
    beside : sequence of Path
        Stores that it reads besides the job's own.

    Raises
    ------
    Exception
        What is neither a mistake of the user's, nor damage of a store, nor of the system.
    """
    try:
        return run(job, workforce, reporter)
    except ConfigurationError as error:
        reporter.error(str(error))
        return error.status
    except Exception as error:  # where a store is damaged, anything may come of it; what is no damage goes on up
        own = [job.store_path] if job.layer is None else [job.store_path, job.layer.volume]
        reporter.error(_explained(error, dict.fromkeys([*own, *beside])))
        return 1


def _explained(error: Exception, paths) -> str:
    """What to say of an error: damage of a store, if there is any, or what the system said; others are ours."""
    load_zarr()
    for path in paths:
        if path.exists() and (found := store.damage_error(path)) is not None:
            return str(found)
    if isinstance(error, OSError):
        return f"{error}{KEPT}"
    raise error
