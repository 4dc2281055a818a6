"""The first run: what its stages need is compiled before rows are due, by a process for every core, with progress."""

import os
import subprocess
import sys

from pipeline.run.cluster_settings import REMOTE
from pipeline.run.job import Job
from pipeline.run.kernels import NEEDED, kernels_for
from pipeline.run.progress import Reporter, RowProgress
from pipeline.run.workforce import Workforce

__all__ = ["warm_up", "warm_up_everything", "warm_up_for", "warm_up_where"]

#: Stages that give tasks to workers.
_ON_WORKERS = ("sweep", "attractors")

_HELPER = """
import sys
from solver.kernels.warm import kernels_of, warm
warm(kernels_of(sys.argv[1:]))
"""


def warm_up_for(job: Job, reporter: Reporter, workforce: Workforce | None = None) -> None:
    """`warm_up` what the stages of a job need; the first one that computes calls it.

    Parameters
    ----------
    job : Job
    reporter : Reporter
    workforce : Workforce, optional
        Where a stage computes, unless it does so here.
    """
    solver, stages = job.plan.solver, job.settings.config.stages
    if job.settings.config.cluster.kind in REMOTE:
        # Either side has its own; a stage that would keep other planes or layers waiting is done by workers.
        shared = workforce is not None and (workforce.planes > 1 or job.plan.parameter2 is not None)
        there = {*_ON_WORKERS, "boundaries"} if shared else _ON_WORKERS
        stages = [stage for stage in stages if (stage in there) == (workforce is not None)]
    warm_up_where(workforce, kernels_for(stages, solver["balance"], job.plan.kind), reporter)


def warm_up_where(workforce: Workforce | None, names: list[str], reporter: Reporter) -> None:
    """Have kernels here, unless tasks run on other machines: those may have a cache of their own, and see to it."""
    if workforce is not None and workforce.config.kind in REMOTE:
        workforce.needs(names)
    else:
        warm_up(names, reporter)


def warm_up_everything(reporter: Reporter) -> None:
    """`warm_up` every kernel there is, and say that they are ready."""
    import pkgutil

    import solver
    from solver.kernels.warm import kernels_of

    modules = [module.name for module in pkgutil.walk_packages(solver.__path__, "solver.") if not module.ispkg]
    # Those that take longest come first, so that no process is left alone with one in the end.
    names = list(
        dict.fromkeys([*kernels_for(NEEDED, "describing_function"), *kernels_for(NEEDED, "galerkin"), *modules])
    )
    warm_up(names, reporter)
    reporter.line(f"warmup: {len(kernels_of(names))} kernels are ready")


def warm_up(names: list[str], reporter: Reporter) -> None:
    """Compile what is not kept yet of some kernels, with a process for every core; says nothing if all are kept.

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
    reporter.line(f"compiling {len(missing)} kernels, which is done once: they are kept for the next runs")
    # Nothing depends on the helpers: what they left undone is done here.
    names = [f"{kernel.__module__}.{kernel.__name__}" for kernel in missing]
    quiet = dict(stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    helpers = min(os.cpu_count() or 1, len(missing)) - 1
    beside = [subprocess.Popen([sys.executable, "-c", _HELPER, *names], **quiet) for _ in range(helpers)]
    try:
        with RowProgress(reporter, len(missing), what="compile", unit="kernels") as progress:
            warm(missing, lambda name, done, total: progress.advance(done - progress.done, 0))
    finally:
        for helper in beside:
            helper.terminate()
            helper.wait()
