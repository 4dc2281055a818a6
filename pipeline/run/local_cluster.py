"""Worker processes of this machine that no other user can reach.

Whoever reaches a dask scheduler, a nanny or a worker runs code there, and loopback is open to every user. So all of
them speak TLS with a key that is made for the run and never leaves its processes: a peer without it, client or worker,
is refused before anything that it sends is read. The HTTP servers, which dask starts even without a dashboard, are left
out.
"""

import contextlib
import logging
from collections.abc import Iterator

import dask
from dask.utils import parse_bytes
from distributed import Nanny, Scheduler, Security, SpecCluster, Worker
from distributed.system import MEMORY_LIMIT

from pipeline.run.libraries import with_own_dask
from pipeline.run.processes import deaf_to_interrupts, main_module_hidden
from pipeline.run.scratch import scratch_folder

__all__ = ["LOOPBACK", "ONE_THREAD", "QuietScheduler", "local_cluster"]

LOOPBACK = "127.0.0.1"

#: One thread each for the libraries that would otherwise start one per core in every worker.
ONE_THREAD = {
    f"{library}_NUM_THREADS": "1" for library in ("OMP", "MKL", "OPENBLAS", "NUMBA", "NUMEXPR", "VECLIB_MAXIMUM")
}


class _WithoutHttp:
    """A server of dask that listens for its peers alone."""

    def start_http_server(self, *_, **__) -> None:
        """No HTTP server, so no port of one."""


class QuietScheduler(_WithoutHttp, Scheduler):
    """A scheduler without a page."""


class _QuietWorker(_WithoutHttp, Worker):
    pass


class _HastyNanny(Nanny):
    """Ends its worker at once, as nobody waits for it any more: what it has computed is stored."""

    async def close(self, *arguments, **options):
        self.auto_restart = False
        if self.process is not None and self.process.process is not None:
            await self.process.process.kill()
        return await super().close(*arguments, **options)


@contextlib.contextmanager
def local_cluster(workers: int, memory: str, dashboard: bool) -> Iterator[SpecCluster]:
    """A scheduler in this process and workers as processes of their own, one thread each.

    Parameters
    ----------
    workers : int
    memory : str
        Of each worker, such as 4GB; auto: its share of the machine.
    dashboard : bool
        Whether the scheduler shows what it does on a port of loopback, which every user of this machine can read.

    Yields
    ------
    SpecCluster
        Its `security` holds the key that a client needs.
    """
    # Workers import and read what is in their folders; dask's usual place for them may belong to somebody else.
    with scratch_folder() as folder, with_own_dask(), contextlib.ExitStack() as opened:
        with deaf_to_interrupts(), main_module_hidden():
            # An interrupt that came meanwhile is raised when this ends, and closes it.
            cluster = opened.enter_context(contextlib.closing(_started(workers, memory, dashboard, str(folder))))
        with main_module_hidden():
            yield cluster


def _started(workers: int, memory: str, dashboard: bool, folder: str) -> SpecCluster:
    security = Security.temporary()
    common = {"host": LOOPBACK, "protocol": "tls://", "security": security}
    pages = {"dashboard": True, "dashboard_address": f"{LOOPBACK}:0"} if dashboard else {"dashboard": False}
    worker = {
        "cls": _HastyNanny,
        "options": {
            **common,
            "worker_class": _QuietWorker,
            "nthreads": 1,
            "memory_limit": MEMORY_LIMIT // workers if memory == "auto" else parse_bytes(memory),
            "local_directory": folder,
            "silence_logs": logging.CRITICAL,
        },
    }
    scheduler = {"cls": Scheduler if dashboard else QuietScheduler, "options": {**common, **pages}}
    settings = {
        "distributed.nanny.pre-spawn-environ": ONE_THREAD,
        # Whoever gave a task decides whether it is done again after its worker was lost.
        "distributed.scheduler.allowed-failures": 0,
    }
    with dask.config.set(settings):
        return SpecCluster(
            scheduler=scheduler,
            workers=dict.fromkeys(range(workers), worker),
            security=security,
            silence_logs=logging.CRITICAL,
        )
