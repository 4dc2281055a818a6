"""A scheduler in this process for workers in jobs of SLURM, which dask-jobqueue submits.

Every worker speaks TLS with a key that is made for the run. Jobs find it in a folder that is the user's alone.
"""

import contextlib
import logging
import secrets
import shlex
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import dask
from distributed import Scheduler, Security

from pipeline.config.schema import Cluster
from pipeline.errors import ConfigurationError
from pipeline.run.cluster_settings import jobs_of
from pipeline.run.jobqueue import SLURMCluster
from pipeline.run.libraries import with_own_dask
from pipeline.run.local_cluster import LOOPBACK, ONE_THREAD, QuietScheduler
from pipeline.run.slurm_jobs import Job, Jobs
from pipeline.run.slurm_settings import JobSettings

__all__ = ["slurm_cluster"]


@contextlib.contextmanager
def slurm_cluster(config: Cluster, say: Callable[[str], None]) -> Iterator[Jobs]:
    """A scheduler in this process for workers in jobs of SLURM; the jobs are given back in the end.

    Parameters
    ----------
    config : Cluster
        Checked.
    say : callable
        Takes a line about jobs.

    Raises
    ------
    ConfigurationError
        If the folder of the jobs cannot be written.
    """
    settings, name = jobs_of(config), f"bevelmap-{secrets.token_hex(4)}"
    (folder, made), jobs = _folder_in(settings.folder, name), None
    try:
        with with_own_dask(), dask.config.set(_DASK):
            cluster = _cluster(config, settings, name, folder)
            jobs = Jobs(config, cluster, name, folder, say)
            try:
                yield jobs
            finally:
                jobs.end()
                cluster.close()
    finally:
        if jobs is not None and jobs.error is not None:
            # It names the folder.
            for file in folder.glob("*.pem"):
                file.unlink()
        else:
            shutil.rmtree(folder, ignore_errors=True)
            with contextlib.suppress(OSError):
                for empty in made:
                    empty.rmdir()


_DASK = {
    # Whoever gave a task decides whether it is done again after its worker was lost.
    "distributed.scheduler.allowed-failures": 0,
    # Which jobs there are is decided here.
    "distributed.deploy.lost-worker-timeout": "365 days",
}

#: What a job does before its workers start, and after they have ended.
_PROLOGUE = (
    *(f"export {name}={value}" for name, value in ONE_THREAD.items()),
    "export DASK_DISTRIBUTED__WORKER__HTTP__ROUTES='[]'",
    'folder=$(mktemp -d -p "${SLURM_TMPDIR:-${TMPDIR:-/tmp}}" bevelmap-run-XXXXXX 2>/dev/null'
    " || mktemp -d -p /tmp bevelmap-run-XXXXXX)",
    'trap \'[ -n "$folder" ] && rm -rf -- "$folder"\' EXIT',
)


def _security(folder: Path) -> Security:
    """A key that is made for the run, in files that workers read."""
    parts = Security.temporary().get_tls_config_for_role("worker")
    files = {name: str(folder / f"{name}.pem") for name in ("ca_file", "cert", "key")}
    for name, file in files.items():
        Path(file).touch(0o600, exist_ok=False)
        Path(file).write_text(parts[name], encoding="ascii")
    ends = {f"tls_{role}_{name}": files[name] for role in ("scheduler", "client", "worker") for name in ("cert", "key")}
    return Security(require_encryption=True, tls_ca_file=files["ca_file"], **ends)


def _cluster(config: Cluster, settings: JobSettings, name: str, folder: Path) -> SLURMCluster:
    pages = {"dashboard": True, "dashboard_address": f"{LOOPBACK}:0"} if config.dashboard else {"dashboard": False}
    host = {} if config.host is None else {"host": config.host}
    try:
        return SLURMCluster(
            job_cls=Job,
            scheduler_cls=Scheduler if config.dashboard else QuietScheduler,
            scheduler_options={**pages, **host},
            security=_security(folder),
            silence_logs=logging.CRITICAL,
            queue=config.queue,
            account=config.account,
            cores=config.cores,
            processes=config.cores,
            memory=f"{settings.memory}B",
            walltime=settings.walltime,
            job_name=name,
            job_extra_directives=[*(config.directives or []), "--no-requeue"],
            job_script_prologue=list(_PROLOGUE),
            log_directory=str(folder),
            local_directory='"$folder"',
            python=shlex.quote(sys.executable),
            worker_extra_args=["--no-dashboard", "--lifetime", f"{settings.lifetime}s"],
        )
    except (OSError, RuntimeError, ValueError) as error:
        reason = " ".join(str(error).split())
        raise ConfigurationError(
            f"cluster.host = {config.host!r} is not allowed: jobs must reach this machine at it ({reason})"
        ) from None


def _folder_in(place: Path, name: str) -> tuple[Path, list[Path]]:
    """A new folder that nobody else can read, and those above it that had to be made."""
    made = [folder for folder in (place, *place.parents) if not folder.exists()]
    try:
        place.mkdir(parents=True, exist_ok=True)
        return Path(tempfile.mkdtemp(prefix=f"{name}-", dir=place)), made
    except OSError as error:
        raise ConfigurationError(
            f"cluster.folder = {str(place)!r} is not allowed: it must be a folder that can be written ({error})"
        ) from None
