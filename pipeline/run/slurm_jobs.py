"""How many jobs of SLURM a run has, and that none outlives it.

Their number follows what is left to do. Dask's own adaptive scaling would go by the tasks that its scheduler holds, and
it is given a few at a time. Jobs are asked after with squeue: one that has ended is replaced, whatever ended it.
"""

import asyncio
import contextlib
import getpass
import itertools
import re
import subprocess
import time
from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from pathlib import Path

from distributed import Status

from pipeline.config.schema import Cluster
from pipeline.errors import ConfigurationError, shown
from pipeline.run.jobqueue import SLURMCluster, SLURMJob
from pipeline.run.processes import deaf_to_interrupts

__all__ = ["Job", "Jobs", "give_back"]

#: Seconds between two changes, between two looks at the queue, and between a refused job and the next.
_FIT_EVERY, _LOOK_EVERY, _REFUSED_PAUSE = 1.0, 10.0, 60.0
#: Seconds that a job is without a task before it is given back.
_IDLE = 10.0
#: A run without jobs ends when so many submissions were refused one after the other.
_MOST_REFUSALS = 5
#: A run ends when so many jobs have ended before a worker of any came.
_MOST_STILLBORN = 3
#: Seconds for what is under way when the run ends, and for the scancel that follows.
_FINISH = 3.0
#: What squeue says of jobs that do not come back.
_OVER = re.compile(r"(CANCELLED|COMPLET|DEADLINE|FAILED|NODE_FAIL|OUT_OF_MEM|TIMEOUT|BOOT_FAIL|PREEMPTED).*")
#: Which setting it is that sbatch complains about.
_COMPLAINTS = {"partition": "queue", "account": "account", "memory": "memory", "time limit": "walltime"}


class Job(SLURMJob):
    """A job; what sbatch says where it refuses one is kept, since nobody waits for that answer."""

    refusal = ""

    async def start(self):
        try:
            await super().start()
        except (RuntimeError, OSError, ValueError) as error:
            self.refusal = _said(error)
            self.status = Status.running

    async def close(self):
        await super().close()
        self.status = Status.closed


def _said(error: Exception) -> str:
    """What sbatch said, without what is said of it."""
    lines = re.findall(r"^sbatch: (?:error: )?(.+)$", str(error), re.MULTILINE)
    return shown("; ".join(lines) or " ".join(str(error).split()), 500)


class Jobs:
    """The jobs of a run.

    Parameters
    ----------
    config : Cluster
    cluster : SLURMCluster
        Without jobs.
    name : str
        Of every job of this run, and of no other.
    folder : Path
        With the logs of jobs.
    say : callable
        Takes a line about jobs.
    """

    def __init__(self, config: Cluster, cluster: SLURMCluster, name: str, folder: Path, say: Callable[[str], None]):
        self.cluster, self.name, self._config, self._folder, self._say = cluster, name, config, folder, say
        #: What is to be said: by the thread that asks, and not by dask's.
        self._lines: deque[str] = deque()
        self._numbers = itertools.count(1)
        self._change: Future | None = None
        self._resting: Future | None = None
        #: Of changes, one at a time.
        self._lock = asyncio.Lock()
        #: Jobs that have had workers, jobs that had none when they ended, and since when jobs have had no task.
        self._seen: set[str] = set()
        self._stillborn: list[str] = []
        self._idle: dict[str, float] = {}
        self._fitted, self._looked, self._pause, self._reason = 0.0, time.monotonic(), 0.0, ""
        self._refusals = 0
        self.error: Exception | None = None
        _UNDER_WAY.add(name)

    @property
    def sentence(self) -> str:
        """Where tasks run."""
        queue = f" of queue {self._config.queue}" if self._config.queue else ""
        return f"tasks run in SLURM jobs{queue}, {self._config.maximum_jobs} at most"

    def begin(self) -> None:
        """Submit the first jobs.

        Raises
        ------
        ConfigurationError
            If sbatch refuses.
        """
        refusal = self.cluster.sync(self._submit, max(self._config.minimum_jobs, 1))
        self._tell()
        if not self.cluster.workers:
            key = next((key for word, key in _COMPLAINTS.items() if word in refusal.lower()), None)
            setting = "cluster = slurm" if key is None else f"cluster.{key} = {getattr(self._config, key)!r}"
            raise ConfigurationError(f"{setting} is not allowed: sbatch says: {refusal}")

    def fit(self, parts: int | None) -> None:
        """Have as many jobs as what is left to do needs; returns at once.

        Parameters
        ----------
        parts : int or None
            How many workers could have something to do; None: as many as there can be.

        Raises
        ------
        OSError
            If jobs end before they do anything, or none is taken any more.
        """
        self._wake()
        if time.monotonic() - self._fitted < _FIT_EVERY or (self._change is not None and not self._change.done()):
            return
        self._fitted = time.monotonic()
        if self._change is not None:
            self._change.result()
        self._tell()
        if self.error is not None:
            raise self.error
        least, most = self._config.minimum_jobs, self._config.maximum_jobs
        wanted = most if parts is None else min(max(-(-parts // self._config.cores), least), most)
        self._change = asyncio.run_coroutine_threadsafe(self._changed(wanted), self.cluster.loop.asyncio_loop)

    def rest(self) -> None:
        """There is nothing to do at present: jobs are given back, unless there soon is."""
        self._wake()
        self._resting = asyncio.run_coroutine_threadsafe(self._rested(), self.cluster.loop.asyncio_loop)

    def _wake(self) -> None:
        if self._resting is not None:
            self._resting.cancel()
            self._resting = None

    async def _rested(self) -> None:
        await asyncio.sleep(_IDLE)
        # What has begun is finished, whatever comes meanwhile.
        await asyncio.shield(self._drop_all_but(self._config.minimum_jobs))

    async def _drop_all_but(self, number: int) -> None:
        async with self._lock:
            if surplus := list(self.cluster.workers)[number:]:
                self._lines.append(f"jobs: {self._ids(surplus)} given back, there is nothing to do for now")
                await self._drop(surplus)

    def end(self) -> None:
        """Give all jobs back, those too that are just being submitted."""
        self._wake()
        if self._change is not None:
            with contextlib.suppress(Exception):
                self._change.result(timeout=_FINISH)
        self._tell()
        # By name: Ctrl-C may have ended an sbatch that had not said yet which job is its own.
        if not _cancelled(self.name) and self.cluster.workers:
            self._say(f"note: jobs could not be given back: scancel --name={self.name} does it")
        for job in self.cluster.workers.values():
            job.job_id = None
        _UNDER_WAY.discard(self.name)

    def _tell(self) -> None:
        while self._lines:
            self._say(self._lines.popleft())

    async def _changed(self, wanted: int) -> None:
        """Drop jobs that have ended; then submit some, or give some back."""
        async with self._lock:
            await self._drop_ended()
            present = self._present()
            count = len(self.cluster.workers)
            if wanted > count and time.monotonic() > self._pause:
                self._note_refusal(await self._submit(wanted - count))
            elif wanted < count:
                waiting = [name for name in self.cluster.workers if name not in present]
                surplus = [*reversed(waiting), *self._unemployed(present)][: count - wanted]
                if surplus:
                    self._lines.append(f"jobs: {self._ids(surplus)} given back, the others are enough")
                    await self._drop(surplus)
            else:
                self._idle.clear()

    def _note_refusal(self, refusal: str) -> None:
        """A limit of jobs, or a SLURM that does not answer, may be otherwise in a minute."""
        if not refusal:
            self._refusals = 0
            return
        self._refusals, self._pause = self._refusals + 1, time.monotonic() + _REFUSED_PAUSE
        if self._refusals < _MOST_REFUSALS or self.cluster.workers:
            self._lines.append(f"note: {len(self.cluster.workers)} jobs for now: sbatch says: {refusal}")
        else:
            self.error = OSError(f"no job is taken any more: sbatch says: {refusal}")

    async def _submit(self, number: int) -> str:
        """Submit jobs; why the last one was refused, if one was."""
        for _ in range(number):
            # Dask takes a name again that is free, of a job whose workers may not have gone yet.
            self.cluster.worker_spec[f"{self.name}-{next(self._numbers)}"] = self.cluster.new_spec
        before = set(self.cluster.workers)
        await self.cluster
        added = {name: job for name, job in self.cluster.workers.items() if name not in before}
        refused = [name for name, job in added.items() if job.refusal]
        refusal = added[refused[-1]].refusal if refused else ""
        taken = [name for name in added if name not in refused]
        await self._drop(refused)
        if taken:
            self._lines.append(f"jobs: {self._ids(taken)} submitted, {len(self.cluster.workers)} in all")
        return refusal

    async def _drop(self, names: Iterable[str]) -> None:
        for name in names:
            self.cluster.worker_spec.pop(name, None)
            self._idle.pop(name, None)
        await self.cluster

    def _present(self) -> dict[str, list]:
        """Workers by the name of their job, as the scheduler knows them."""
        found = {}
        for worker in self.cluster.scheduler.workers.values():
            # Workers of a job with several have a number each.
            job = worker.name if self._config.cores == 1 else worker.name.rpartition("-")[0]
            found.setdefault(job, []).append(worker)
        self._seen |= found.keys()
        return found

    def _unemployed(self, present: dict[str, list]) -> list[str]:
        """Jobs none of whose workers has had a task for a while."""
        now = time.monotonic()
        free = [name for name, workers in present.items() if not any(worker.processing for worker in workers)]
        self._idle = {name: self._idle.get(name, now) for name in free if name in self.cluster.workers}
        return [name for name, since in self._idle.items() if now - since >= _IDLE]

    def _ids(self, names: Iterable[str]) -> str:
        ids = [self.cluster.workers[name].job_id for name in names]
        return f"job {ids[0]}" if len(ids) == 1 else f"{len(ids)} jobs ({', '.join(ids[:3])}{', ...' * (len(ids) > 3)})"

    async def _drop_ended(self) -> None:
        present = self._present()
        left = [name for name in self.cluster.workers if name in self._seen and name not in present]
        # A job that has just lost its workers is asked after sooner.
        if time.monotonic() - self._looked < (1.0 if left else _LOOK_EVERY):
            return
        asked, self._looked = dict(self.cluster.workers), time.monotonic()
        if (states := await self._states()) is None:
            return
        ended = [name for name, job in asked.items() if job.job_id not in states]
        for name in ended:
            if name in self._seen:
                self._lines.append(f"jobs: {self._ids([name])} has ended, others go on with its rows")
            else:
                self._stillborn.append(name)
                self._lines.append(
                    f"note: {self._ids([name])} ended before it had a worker{self._last_words(asked[name])}"
                )
        if not self._seen and len(self._stillborn) >= _MOST_STILLBORN:
            words = self._last_words(asked[ended[-1]]) if ended else ""
            self.error = OSError(f"jobs end before they have a worker{words}; logs are in {self._folder}")
        await self._drop(ended)
        waiting = {reason for state, reason in states.values() if state == "PENDING"}
        if not present and waiting and (reason := ", ".join(sorted(waiting))) not in (self._reason, "None"):
            self._reason = reason
            self._lines.append(f"jobs: {len(states)} wait in the queue ({reason})")

    async def _states(self) -> dict[str, tuple[str, str]] | None:
        """State and reason of the jobs that are not over, by id; None where SLURM does not say."""
        command = ["squeue", "--noheader", f"--name={self.name}", "--format=%A|%T|%r"]
        asked = await asyncio.create_subprocess_exec(
            *command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
        )
        said, _ = await asked.communicate()
        if asked.returncode:
            return None
        rows = [line.split("|", 2) for line in said.decode(errors="replace").split("\n") if line.count("|") >= 2]
        return {number: (state, reason) for number, state, reason in rows if not _OVER.match(state)}

    def _last_words(self, job: Job) -> str:
        """The last line of the log of a job, to be said after what happened to it."""
        with contextlib.suppress(OSError):
            text = (self._folder / f"{self.name}-{job.job_id}.err").read_text(errors="replace").strip()
            if text:
                return f": {shown(text.splitlines()[-1].strip(), 300)}"
        return ""


#: Names of the jobs of runs that are under way.
_UNDER_WAY: set[str] = set()


def give_back() -> None:
    """Cancel the jobs of all runs of this process, which is about to end."""
    for name in _UNDER_WAY:
        _cancelled(name)


def _cancelled(name: str) -> bool:
    command = ["scancel", f"--name={name}", f"--user={getpass.getuser()}"]
    try:
        # A terminal's Ctrl-C goes to all processes.
        with deaf_to_interrupts():
            return not subprocess.run(
                command, capture_output=True, stdin=subprocess.DEVNULL, timeout=_FINISH
            ).returncode
    except (OSError, subprocess.TimeoutExpired):
        return False
