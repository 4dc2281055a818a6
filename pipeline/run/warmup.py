"""The first run: what its stages need is compiled before rows are due, by two processes, and said while it lasts."""

import os
import subprocess
import sys

from pipeline.run.job import Job
from pipeline.run.kernels import kernels_for
from pipeline.run.progress import Reporter, RowProgress

__all__ = ["warm_up", "warm_up_for"]

_HELPER = """
import sys
from solver.kernels.warm import kernels_of, warm
warm(kernels_of(sys.argv[1:]))
"""


def warm_up_for(job: Job, reporter: Reporter) -> None:
    """`warm_up` what the stages of a job need; the first one that computes calls it.

    Workers of a running scheduler have a cache of their own, which this process cannot fill.
    """
    config = job.settings.config
    if config.cluster.kind != "scheduler":
        warm_up(kernels_for(config.stages, job.plan.solver["balance"]), reporter)


def warm_up(names: list[str], reporter: Reporter) -> None:
    """Compile what is not kept yet of some kernels, with one process beside this one; says nothing if all are kept.

    Parameters
    ----------
    names : list of str
        Modules or kernels, as for `solver.kernels.warm.kernels_of`.
    reporter : Reporter
    """
    from solver.kernels.warm import kernels_of, warm

    missing = [kernel for kernel in kernels_of(names) if not kernel.is_kept()]
    if not missing:
        return
    reporter.line(f"first run: {len(missing)} kernels are compiled and kept for the next ones")
    # Nothing depends on the helper: what it left undone is done here.
    names = [f"{kernel.__module__}.{kernel.__name__}" for kernel in missing]
    quiet = dict(stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    beside = subprocess.Popen([sys.executable, "-c", _HELPER, *names], **quiet) if (os.cpu_count() or 1) > 1 else None
    try:
        with RowProgress(reporter, len(missing), what="compile", unit="kernels") as progress:
            warm(missing, lambda name, done, total: progress.advance(done - progress.done, 0))
    finally:
        if beside is not None:
            beside.terminate()
            beside.wait()
