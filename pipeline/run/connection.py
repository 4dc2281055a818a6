"""A dask client of which no call waits for ever: a scheduler that goes away or falls silent is an error within a time.

Dask bounds the time in which a connection is opened. What comes after that (the first words, a count of workers, a
result on its way) it waits for without end, as for a scheduler that is suspended.
"""

import asyncio
import contextlib
import queue
import warnings
from collections.abc import Callable

from distributed import Client, Future, KilledWorker, Security
from distributed.client import ClosedClientError
from distributed.comm import get_address_host
from distributed.versions import VersionMismatchWarning

from pipeline.errors import WorkerLost

__all__ = ["Connection", "SchedulerGone"]

#: A program that was stopped and goes on finds one question too old. So two are asked, in half of the time each.
_QUESTIONS = 2
#: What a worker evaluates. A function that it cannot import is then the error of a task; a message that names one, it
#: cannot read, and it closes for all users of the scheduler.
_CALL = "getattr(__import__(module, fromlist=[name]), name)(*arguments)"


class SchedulerGone(ConnectionError):
    """The scheduler has ended, or does not answer in time."""


class _BoundedClient(Client):
    """A client that is connected in time, or closed."""

    async def _start(self, timeout=None, **kwargs):
        try:
            with warnings.catch_warnings():
                # Versions are compared by `pipeline.run.admission`, and differences are refused.
                warnings.simplefilter("ignore", VersionMismatchWarning)
                return await asyncio.wait_for(super()._start(timeout=timeout, **kwargs), self._timeout)
        except BaseException:
            # Left half open it would try to close itself when it is deleted, and complain.
            await self._close(fast=True)
            raise


class Connection:
    """What is asked of a scheduler.

    Parameters
    ----------
    where : str or distributed.SpecCluster
        An address, or a cluster of this process.
    security : Security
    timeout : float
        Seconds that the scheduler may take to answer.

    Raises
    ------
    OSError, ValueError
        If there is none, or it does not answer in time.
    """

    def __init__(self, where, security: Security, timeout: float):
        self._timeout = timeout
        self._client = _BoundedClient(where, security=security, timeout=timeout, set_as_default=False)
        self.address: str = self._client.scheduler.address

    def workers(self) -> dict[str, int]:
        """Threads of the workers that are there, by address."""
        return self._ask(self._client.scheduler.ncores, workers=None)

    def versions(self, packages: tuple[str, ...]) -> tuple[dict[str, str | None], str]:
        """Versions of packages of the scheduler, None where it has none, and of its Python."""
        found = self._ask(self._client.scheduler.versions, packages=list(packages))
        return found["packages"], found["host"]["python"]

    def dashboard(self) -> str | None:
        """Where the scheduler shows what it does, None if nowhere."""
        port = self._ask(self._client.scheduler.identity)["services"].get("dashboard")
        return None if port is None else f"http://{get_address_host(self.address)}:{port}/status"

    def _ask(self, question: Callable, **arguments):
        for _ in range(_QUESTIONS):
            try:
                return self._client.sync(question, callback_timeout=self._timeout / _QUESTIONS, **arguments)
            except TimeoutError:
                continue
            except (OSError, RuntimeError):
                raise self._gone() from None
        raise SchedulerGone(f"the scheduler at {self.address} does not answer within {self._timeout:g} s")

    def _gone(self) -> SchedulerGone:
        return SchedulerGone(f"the scheduler at {self.address} is gone")

    def submit(self, finished: queue.SimpleQueue, function: Callable, *arguments, **places) -> Future:
        """Have a function called; what comes of it is put into a queue, with the future.

        Parameters
        ----------
        finished : SimpleQueue
            To be read by `next`.
        function : callable
            Is found on the worker by its name.
        *arguments
            Of types that every Python has.
        **places
            `workers` and `allow_other_workers` of `Client.submit`.
        """
        call = {"module": function.__module__, "name": function.__name__, "arguments": arguments}
        try:
            future = self._client.submit(eval, _CALL, call, pure=False, retries=0, **places)
        except (OSError, RuntimeError, ClosedClientError):
            raise self._gone() from None
        # Each result on its own: one from a worker that is suspended must not keep those of others waiting.
        self._client.loop.add_callback(self._fetch, future, finished)
        return future

    async def _fetch(self, future: Future, finished: queue.SimpleQueue) -> None:
        try:
            result = await future.result()
        except KilledWorker:
            result = WorkerLost(
                "its worker was lost: the process was ended from outside, as happens when memory runs out"
            )
        except Exception as error:
            # What is no error of the task is one of the connection.
            result = error if future.status == "error" else self._gone()
        finished.put((future, result))

    def next(self, finished: queue.SimpleQueue, seconds: float) -> tuple[Future, object] | None:
        """A future that is over, with its result or what went wrong; None if there is none within some seconds.

        Raises
        ------
        SchedulerGone
        """
        try:
            future, result = finished.get(timeout=max(seconds, 0.0))
        except queue.Empty:
            return None
        if isinstance(result, SchedulerGone):
            raise result
        future.release()
        return future, result

    def cancel(self, futures) -> None:
        """Let go of futures that nobody waits for any more."""
        # A client whose scheduler has gone has nothing to cancel.
        with contextlib.suppress(Exception):
            self._client.cancel(list(futures))

    def close(self) -> None:
        """Say goodbye, and do not wait for an answer for longer than any other."""
        with contextlib.suppress(TimeoutError):
            self._client.close(timeout=self._timeout)
