"""What a stage is, for the command line."""

from collections.abc import Callable
from dataclasses import dataclass

from pipeline.run.job import Job
from pipeline.run.progress import Reporter
from pipeline.run.workforce import Workforce

__all__ = ["Stage"]


def _nothing(job: Job) -> None:
    """Nothing to check."""


def _never(job: Job) -> bool:
    return False


def _waits(job: Job, workforce: Workforce) -> None:
    """Nothing to begin with."""


def _leaves_nothing(job: Job, reporter: Reporter) -> None:
    """Nothing to finish."""


@dataclass(frozen=True)
class Stage:
    """One thing to do.

    Parameters
    ----------
    name : str
        As typed in `stages=[...]`.
    run : callable
        run(job, workforce, reporter) does it and returns an exit status.
    check : callable
        check(job) raises ConfigurationError unless it can be done; writes nothing.
    on_workers : bool
        Whether it needs the cluster.
    writes : bool
        Whether it writes into the store, so that it must be alone there.
    only_reads : callable
        only_reads(job): whether it writes nothing at all this time, so that folders that cannot be written will do.
    needs_plan : bool
        Whether it is given the plan of the plane.
    of_volumes : bool
        Whether it works on a volume, and not on a plane alone.
    tells_map : bool
        Whether it is about the map, so that a run ends with what that tells.
    begin : callable
        begin(job, workforce) has helpers begin with it, when no stage before it will write into the store any more.
    finish : callable
        finish(job, reporter) does what no other stage waits for, when those that come next have begun.
    """

    name: str
    run: Callable[[Job, Workforce, Reporter], int]
    check: Callable[[Job], None] = _nothing
    on_workers: bool = False
    writes: bool = False
    only_reads: Callable[[Job], bool] = _never
    needs_plan: bool = True
    of_volumes: bool = False
    tells_map: bool = False
    begin: Callable[[Job, Workforce], None] = _waits
    finish: Callable[[Job, Reporter], None] = _leaves_nothing
