"""Which workers may compute: those that would give this process's results, bit by bit (`pipeline.run.environment`).

Every task carries a digest of the client's facts, and a worker compares its own before it looks at the task. So one
that joins later, or was started again from other sources, is found out before it computes anything.
"""

import importlib
import pickle
import socket
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from pipeline.run.environment import differences, digest_of, facts

__all__ = ["Admission", "Ready", "Unequal", "call_if_equal", "get_ready", "introduce", "worker_address"]

#: Workers that are named one by one.
_MOST_NAMED = 3


@dataclass(frozen=True)
class Unequal:
    """What a worker answers whose facts are not those of the client: where it is, and what they are."""

    worker: str
    facts: Mapping[str, str]


def call_if_equal(expected: str, payload: bytes):
    """On a worker: what a pickled (function, arguments) gives, or `Unequal`, and then the payload is not even read."""
    found = facts()
    if digest_of(found) != expected:
        return Unequal(worker_address(), found)
    function, arguments = pickle.loads(payload)
    return function(*arguments)


@dataclass(frozen=True)
class Ready:
    """What a worker answers that is ready for tasks.

    Parameters
    ----------
    host : str
        Its machine.
    compiled : int
        Kernels that it compiled itself.
    seconds : float
        That it took to have all of them.
    """

    host: str
    compiled: int
    seconds: float


def get_ready(names: tuple[str, ...]) -> Ready:
    """On a worker: have kernels; workers of one machine share what is to be compiled, each kernel once."""
    from solver.kernels.store import kernel_store
    from solver.kernels.warm import kernels_of, warm

    begin, before = time.perf_counter(), kernel_store().made
    warm(kernels_of(names))
    return Ready(socket.gethostname(), kernel_store().made - before, time.perf_counter() - begin)


def introduce(load: bool) -> dict[str, str]:
    """On a worker: its facts, after it has loaded the solver if that is asked for (a second, better now than later)."""
    found = facts()
    if load:
        for module in ("solver.rows.row", "solver.kernels.backend"):
            importlib.import_module(module)
    return found


def worker_address() -> str | None:
    """The address of the worker that this runs on, None in a process of its own."""
    # A process without dask is no worker, and dask takes half a second to import.
    if "distributed" not in sys.modules:
        return None
    from distributed import get_worker

    try:
        return get_worker().address
    except ValueError:
        return None


class Admission:
    """Workers by what is known of them: equal, refused (with the reason), or not asked yet.

    Parameters
    ----------
    say : callable
        Takes a line about a worker that is refused.
    """

    def __init__(self, say: Callable[[str], None]):
        self.own = facts()
        #: What a task carries.
        self.digest = digest_of(self.own)
        self.equal: set[str] = set()
        self.refused: dict[str, str] = {}
        self._say = say

    def learn(self, worker: str, answer: Mapping[str, str] | Exception) -> None:
        """Note the facts of a worker, or why it cannot tell them."""
        if isinstance(answer, Exception):
            self._refuse(
                worker, f"bevelmap cannot be used there ({type(answer).__name__}: {' '.join(str(answer).split())})"
            )
        elif digest_of(answer) != self.digest:
            self._refuse(worker, differences(answer, self.own))
        else:
            self.equal.add(worker)

    def _refuse(self, worker: str, reason: str) -> None:
        if worker not in self.refused:
            self.refused[worker] = reason
            self._say(f"note: worker {worker} is not used, its results would not be equal: {reason}")

    def unknown(self, workers) -> list[str]:
        """Those that have not been asked."""
        return [worker for worker in workers if worker not in self.equal and worker not in self.refused]

    def allowed(self, workers) -> list[str]:
        """Those that are not refused."""
        return [worker for worker in workers if worker not in self.refused]

    def nobody(self) -> str:
        """What to say where none is left."""
        named = [f"{worker}: {reason}" for worker, reason in list(self.refused.items())[:_MOST_NAMED]]
        more = len(self.refused) - len(named)
        return f"no worker computes as this program does ({'; '.join(named)}{f'; and {more} more' if more > 0 else ''})"
