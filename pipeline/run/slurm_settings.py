"""What the settings of jobs may be, and what sbatch and dask are told of them."""

import importlib.util
import re
import shutil
from dataclasses import dataclass
from pathlib import Path

from pipeline.config.folders import local_folder
from pipeline.config.schema import Cluster
from pipeline.errors import ConfigurationError

__all__ = ["JobSettings", "job_settings"]

#: Bytes of a job for each core, unless told.
_MEMORY = 2_000_000_000
#: Seconds that a job may have; less, and its workers leave before they have done something.
_SHORTEST, _LONGEST = 60, 366 * 86400
#: Workers leave this share of the wall time before its end, but not more and not fewer seconds than these.
_MARGIN, _LEAST_MARGIN, _MOST_MARGIN = 0.1, 15, 300
#: Names of queues, accounts and machines, which stand in a line of a script.
_WORD = re.compile(r"[\w.,:@%+-]+")
#: Of folders too: nothing that a shell or sbatch takes for something else.
_PATH = re.compile(r"[\w./,:@+=-]+")
_OPTION = re.compile(r"--?[A-Za-z][\x20-\x7e]*")
#: What SLURM takes for a time, in its order: days-hours[:minutes[:seconds]], hours:minutes:seconds, minutes[:seconds].
_TIMES = (
    re.compile(r"(?P<days>\d{1,4})-(?P<hours>\d{1,4})(:(?P<minutes>\d{1,4})(:(?P<seconds>\d{1,4}))?)?"),
    re.compile(r"(?P<hours>\d{1,6}):(?P<minutes>\d{1,4}):(?P<seconds>\d{1,4})"),
    re.compile(r"(?P<minutes>\d{1,8})(:(?P<seconds>\d{1,4}))?"),
)
_UNITS = {"days": 86400, "hours": 3600, "minutes": 60, "seconds": 1}


@dataclass(frozen=True)
class JobSettings:
    """Settings of jobs as sbatch and dask take them.

    Parameters
    ----------
    memory : int
        Bytes of a job.
    walltime : str
        As days-hours:minutes:seconds.
    lifetime : int
        Seconds after which workers leave.
    folder : Path
        That this machine and the jobs share.
    """

    memory: int
    walltime: str
    lifetime: int
    folder: Path


def job_settings(config: Cluster, least_memory: int) -> JobSettings:
    """Check the settings of jobs; nothing is written or submitted.

    Parameters
    ----------
    config : Cluster
    least_memory : int
        Bytes that a worker must have.

    Raises
    ------
    ConfigurationError
        If one of them is not allowed, or there is no dask-jobqueue or no SLURM here.
    """
    for name in ("cores", "walltime", "minimum_jobs", "maximum_jobs", "folder"):
        if getattr(config, name) is None:
            raise _refused(name, None, "it must have a value")
    if config.minimum_jobs > config.maximum_jobs:
        raise _refused("minimum_jobs", config.minimum_jobs, f"cluster.maximum_jobs = {config.maximum_jobs} is less")
    for name in ("queue", "account", "host"):
        if (value := getattr(config, name)) is not None and not _WORD.fullmatch(value):
            raise _refused(name, value, "it must be a name of letters, digits and _ . , : @ % + -")
    for option in config.directives or []:
        if not _OPTION.fullmatch(option):
            raise _refused("directives", option, "each must be an option of sbatch, such as --constraint=cascadelake")
    folder = Path(local_folder("cluster.folder", config.folder)).absolute()
    if not _PATH.fullmatch(str(folder)):
        raise _refused(
            "folder", str(folder), "it stands in scripts of jobs: letters, digits and / _ . , : @ + = - alone"
        )
    memory, seconds = _memory(config, least_memory), _seconds(config.walltime)
    if importlib.util.find_spec("dask_jobqueue") is None:
        raise ConfigurationError(
            "cluster = slurm is not allowed here: it needs the package dask-jobqueue: pip install 'bevelmap[slurm]'"
        )
    for command in ("sbatch", "squeue", "scancel"):
        if shutil.which(command) is None:
            raise ConfigurationError(
                f"cluster = slurm is not allowed here: there is no {command} on this machine; "
                "run it where jobs are submitted"
            )
    margin = min(max(_MARGIN * seconds, _LEAST_MARGIN), _MOST_MARGIN)
    days, rest = divmod(seconds, 86400)
    walltime = f"{days}-{rest // 3600:02}:{rest // 60 % 60:02}:{rest % 60:02}"
    return JobSettings(memory, walltime, int(seconds - margin), folder)


def _memory(config: Cluster, least: int) -> int:
    from dask.utils import parse_bytes

    if config.memory == "auto":
        return _MEMORY * config.cores
    if (memory := parse_bytes(config.memory)) < least * config.cores:
        raise _refused(
            "memory",
            config.memory,
            f"it is that of a job, {least / 1e6:.0f}MB at least for each of its {config.cores} cores",
        )
    return memory


def _seconds(walltime: str) -> int:
    """Seconds of a time as sbatch takes it.

    Examples
    --------
    >>> _seconds("90"), _seconds("90:30"), _seconds("01:00:00"), _seconds("2-0"), _seconds("1-02:03:04")
    (5400, 5430, 3600, 172800, 93784)
    """
    for form in _TIMES:
        if found := form.fullmatch(walltime):
            seconds = sum(_UNITS[name] * int(value) for name, value in found.groupdict().items() if value)
            if _SHORTEST <= seconds <= _LONGEST:
                return seconds
    raise _refused("walltime", walltime, "it must be minutes, HH:MM:SS or days-HH:MM:SS, from 1 minute to 366 days")


def _refused(name: str, value, words: str) -> ConfigurationError:
    return ConfigurationError(f"cluster.{name} = {value!r} is not allowed: {words}")
