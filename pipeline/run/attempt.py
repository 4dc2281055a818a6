"""Stages of one plane, tried: whatever ends them is one line, so that the next plane has its turn."""

from collections.abc import Callable, Iterable

from pipeline import store
from pipeline.config.places import Place
from pipeline.errors import KEPT, ConfigurationError, DamagedError, Unreachable
from pipeline.run.job import Job
from pipeline.run.progress import Reporter
from pipeline.run.workforce import Workforce
from pipeline.store.files import files_at

__all__ = ["attempt"]


def attempt(
    run: Callable[[Job, Workforce, Reporter], int],
    job: Job,
    workforce: Workforce,
    reporter: Reporter,
    beside: bool = False,
) -> int:
    """The exit status of `run(job, workforce, reporter)`, whatever ends it.

    Parameters
    ----------
    run : callable
    job : Job
    workforce : Workforce
    reporter : Reporter
    beside : bool
        Whether it reads the other stores of the folder, too.

    Raises
    ------
    Exception
        What is neither a mistake of the user's, nor damage of a store, nor of the system.
    """
    try:
        return run(job, workforce, reporter)
    except DamagedError as error:
        # Whoever reads a file does not know which rows are lost with it.
        reporter.error(_explained(error, job, beside))
        return error.status
    except ConfigurationError as error:
        reporter.error(str(error))
        return error.status
    except Exception as error:  # where a store is damaged, anything may come of it; what is no damage goes on up
        reporter.error(_explained(error, job, beside))
        return 1


def _explained(error: Exception, job: Job, beside: bool) -> str:
    """What to say of an error: damage of a store, if there is any, or what the system said; others are ours."""
    if isinstance(error, Unreachable):
        return f"{error}{KEPT}"
    # zarr passes on what an object store says.
    if type(error).__module__.startswith("obstore"):
        from pipeline.store.objects import said_of

        return f"{job.store_path} {said_of(error)}{KEPT}"
    for path in _read(job, beside):
        if store.exists(path) and (found := store.damage_error(path)) is not None:
            return str(found)
    if isinstance(error, DamagedError):
        return str(error)
    if isinstance(error, OSError):
        return f"{error}{KEPT}"
    raise error


def _read(job: Job, beside: bool) -> Iterable[Place]:
    """The stores that a job reads, each once."""
    found = [job.store_path] if job.layer is None else [job.store_path, job.layer.volume]
    if beside:
        root = job.store_path.parent
        names = files_at(root).folders()
        found += [root / name for name in names if name.endswith(".zarr") and not name.startswith(".")]
    return dict.fromkeys(found)
