"""A real SLURM of one node on loopback, with folder, ports, keys and configuration of its own.

`munged`, `slurmctld` and `slurmd` are those of the PATH, installed or unpacked anywhere; nothing of a SLURM that runs
on this machine is read or written. Jobs run as the user of the tests.
"""

import contextlib
import getpass
import os
import secrets
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

__all__ = ["MISSING", "SlurmCluster", "slurm_cluster"]


def _program(name: str) -> str | None:
    """Where a daemon is: Debian's have a suffix until they are installed, and the folder is often not on the PATH."""
    path = os.pathsep.join([os.environ.get("PATH", ""), "/usr/sbin", "/usr/local/sbin"])
    return shutil.which(name, path=path) or shutil.which(f"{name}-wlm", path=path)


_PROGRAMS = ("munged", "slurmctld", "slurmd", "slurmstepd", "sbatch", "squeue", "scancel", "scontrol", "sinfo")
_LACKING = [name for name in _PROGRAMS if _program(name) is None]
#: Why there cannot be one here; empty where there can.
MISSING = f"SLURM and munge are not installed: no {', '.join(_LACKING)}" if _LACKING else ""

_CONFIGURATION = """
ClusterName=bevelmap
SlurmctldHost=localhost(127.0.0.1)
SlurmctldPort={controller}
SlurmdPort={node}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
{plugins}
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SwitchType=switch/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerType=sched/builtin
SchedulerParameters=sched_interval=1
SlurmdParameters=config_overrides
KillWait=2
NodeName=localhost NodeAddr=127.0.0.1 CPUs=4 RealMemory=16000 State=UNKNOWN
PartitionName=main Nodes=localhost Default=YES MaxTime=INFINITE State=UP
PartitionName=closed Nodes=localhost State=DOWN
"""


class SlurmCluster:
    """What the daemons run, for tests.

    Parameters
    ----------
    folder : Path
    """

    def __init__(self, folder: Path):
        self.folder = folder
        #: What whoever submits needs.
        self.environment = {"SLURM_CONF": str(folder / "slurm.conf")}
        self._daemons: list[subprocess.Popen] = []

    def start(self) -> None:
        """Start the daemons, and wait until the node takes jobs."""
        for name in ("state", "spool"):
            (self.folder / name).mkdir()
        key = self.folder / "munge.key"
        key.write_bytes(secrets.token_bytes(1024))
        key.chmod(0o400)
        ports = dict(zip(("controller", "node"), _free_ports(2), strict=True))
        values = {"user": getpass.getuser(), "folder": self.folder, "plugins": _plugins(), **ports}
        (self.folder / "slurm.conf").write_text(_CONFIGURATION.format(**values))
        files = {name: self.folder / f"munge.{name}" for name in ("socket", "log", "pid", "seed")}
        options = [f"--{name}{'' if name == 'socket' else '-file'}={file}" for name, file in files.items()]
        self._run("munged", "--foreground", "--force", f"--key-file={key}", *options)
        self._wait(files["socket"].exists)
        configuration = ["-D", "-f", str(self.folder / "slurm.conf")]
        self._run("slurmctld", *configuration, "-c")
        self._run("slurmd", *configuration, "-N", "localhost", "-d", _program("slurmstepd"))
        self._wait(lambda: "idle" in self.ask("sinfo", "--noheader", "--format=%T"))

    def ask(self, command: str, *options: str) -> str:
        """What a command of SLURM prints."""
        environment = {**os.environ, **self.environment}
        return subprocess.run([command, *options], capture_output=True, text=True, env=environment, timeout=30).stdout

    def jobs(self) -> list[str]:
        """Numbers of the jobs that wait or run."""
        return self.ask("squeue", "--noheader", "--format=%A", "--states=PENDING,RUNNING,CONFIGURING").split()

    def stop(self) -> None:
        """End all jobs, and the daemons."""
        self.ask("scancel", f"--user={getpass.getuser()}")
        with contextlib.suppress(AssertionError):
            self._wait(lambda: not self.ask("squeue", "--noheader"), 15.0)
        for daemon in reversed(self._daemons):
            daemon.terminate()
            try:
                daemon.wait(10)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()

    def _run(self, name: str, *options: str) -> None:
        log = (self.folder / f"{name}.out").open("wb")
        environment = {**os.environ, **self.environment}
        with log:
            daemon = subprocess.Popen([_program(name), *options], stdout=log, stderr=log, env=environment)
        self._daemons.append(daemon)

    def _wait(self, happens, seconds: float = 60.0) -> None:
        deadline = time.monotonic() + seconds
        while not happens():
            ended = [daemon.args[0] for daemon in self._daemons if daemon.poll() is not None]
            assert not ended and time.monotonic() < deadline, f"{ended} ended; logs are in {self.folder}"
            time.sleep(0.05)


def _free_ports(number: int) -> list[int]:
    with contextlib.ExitStack() as opened:
        sockets = [opened.enter_context(socket.socket()) for _ in range(number)]
        for one in sockets:
            one.bind(("127.0.0.1", 0))
        return [one.getsockname()[1] for one in sockets]


def _plugins() -> str:
    """Where the plugins are, unless they are where SLURM was installed to."""
    root = Path(_program("slurmctld")).resolve().parents[1]
    found = [] if root == Path("/usr") else sorted(root.glob("lib/*/slurm-wlm"))
    return f"PluginDir={found[0]}" if found else ""


@contextlib.contextmanager
def slurm_cluster(folder: Path) -> Iterator[SlurmCluster]:
    """One that runs within."""
    cluster = SlurmCluster(folder)
    try:
        cluster.start()
        yield cluster
    finally:
        cluster.stop()
