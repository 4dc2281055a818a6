"""One writer per store where nothing like `flock` is: an object that says who writes, changed only by conditional puts.

The object is a record: who holds the lease, and how often it was renewed. It is never removed, and it passes through
these states, each step a put under the condition that the version is the one that was read (`If-Match`):

    none ──create──► held by A, 0 ──► held by A, 1 ──► …          A renews four times in each `seconds`
                        │                 │
                        │                 └──► free, A ──► held by B, 0      A lets go; whoever comes next takes it
                        └── not renewed for `seconds` ───► held by B, 0      A has died, or sleeps

No two records are equal, so that no version comes again, also where a version is a checksum of the content. Of several
puts under one condition, at most one is done: versions form one line, and each has one author.

*Two writers.* B measures on its own clock that one version stayed for `seconds`, from after it read it, and then puts
under the condition of that version. A measures on its own clock from before it put that version, and takes itself for
the holder for three quarters of `seconds` after that: so A's time is over before B's begins, whatever the hour is on
either machine; only the speeds of their clocks matter, by less than a quarter. Clocks go on while a machine sleeps.

*A holder that was stopped* and goes on later finds its time over before it writes anything: `Lease.check` then renews
at once, which succeeds if and only if nobody has taken over. Else it raises, now and at each further write.

*An answer that is lost.* Whatever is answered but success, the record is read again: if it is ours, the put was done.
One that is done later still was under a condition; its version is ours as well, or it is refused.

*What remains* is a single put that was begun in time and arrives after a takeover. Rows guard themselves against that:
`pipeline.store.blocks.write_block`.
"""

import contextlib
import json
import os
import socket
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from typing import Any

from pipeline.errors import LeaseLost, StoreError

__all__ = ["Lease", "Record", "check_held", "leased"]

#: Seconds after which a lease that was not renewed is over; of one that another client made, what it says, up to a day.
SECONDS, _LONGEST = 60.0, 86_400.0
#: Of these seconds: how long a holder takes itself for one, how often it renews, and how often others look.
_SURE, _RENEW, _LOOK = 0.75, 0.25, 1 / 30
#: Leases that this process holds or has lost, by label.
_HELD: "dict[str, Lease]" = {}


@dataclass(frozen=True)
class Record:
    """What the object says.

    Parameters
    ----------
    host : str
    pid : int
    since : str
        Time of the holder's clock, for people only.
    holder : str
        Differs for every lease.
    renewal : int
        Counts the versions of one holder.
    seconds : float
        After which it is over unless it changes.
    free : bool
        Whether it was let go.
    """

    host: str
    pid: int
    since: str
    holder: str
    renewal: int = 0
    seconds: float = SECONDS
    free: bool = False

    def __str__(self) -> str:
        """Who holds it, in words."""
        return f"process {self.pid} on {self.host} since {self.since}" if self.pid else "another process"


#: A record that cannot be read, so that it is taken for somebody's.
_UNKNOWN = Record("", 0, "", "")


def _elapsed() -> float:
    """Seconds on a clock that nobody sets, and that goes on while the machine sleeps, where there is one."""
    return time.clock_gettime(time.CLOCK_BOOTTIME) if hasattr(time, "CLOCK_BOOTTIME") else time.monotonic()


class Lease:
    """One client's side of a lease; made by `leased`.

    Parameters
    ----------
    objects : obstore.store.ObjectStore
    name : str
        Of the object.
    label : str
        What is leased, for messages.
    seconds : float
    clock : callable
        Seconds since whenever.
    """

    def __init__(
        self, objects: Any, name: str, label: str, seconds: float = SECONDS, clock: Callable[[], float] = _elapsed
    ):
        self.label, self.seconds = label, seconds
        self._objects, self._name, self._clock = objects, name, clock
        since = datetime.now(UTC).isoformat(timespec="seconds")
        self._mine = Record(socket.gethostname(), os.getpid(), since, uuid.uuid4().hex, seconds=seconds)
        self._one_at_a_time = threading.Lock()
        #: The version that is ours, and until when it surely is.
        self._version, self._sure = None, float("-inf")
        #: The version of another that is watched, and since when.
        self._watched: tuple[dict, float] | None = None
        #: Who else has or had it, if anybody, and whether that one was seen to renew.
        self.other, self.other_lives = None, False
        self.is_held = False

    def attempt(self) -> bool:
        """Take it if nobody has it, or has had it for too long without a sign of life; whether it is ours.

        Raises
        ------
        StoreError
            If the object store does not keep conditions.
        obstore.exceptions.BaseError
            If it does not do as asked.
        """
        begin = self._clock()
        found = self._read()
        if found is None:
            self.other = None
            return self._take(begin, None)
        self.other, version = found
        if self.other.free:
            return self._take(begin, version)
        if self._watched is None or self._watched[0] != version:
            self.other_lives = self._watched is not None
            self._watched = version, self._clock()
            return False
        return begin - self._watched[1] >= self.other.seconds and self._take(begin, version)

    def renew(self) -> None:
        """Say that its holder lives.

        Raises
        ------
        LeaseLost
            If another one has it.
        obstore.exceptions.BaseError
            If that cannot be known.
        """
        with self._one_at_a_time:
            self._renew()

    def check(self) -> None:
        """Before anything is written: raise unless nobody else can have it; raises as `renew`."""
        if self._clock() < self._sure:
            return
        with self._one_at_a_time:
            if self._clock() >= self._sure:
                self._renew()

    def release(self) -> None:
        """Let it go, if it is ours."""
        with self._one_at_a_time:
            self._sure = float("-inf")
            if self.is_held:
                self._put(replace(self._next(), free=True), self._version)
                self.is_held = False

    def _take(self, begin: float, version: dict | None) -> bool:
        mine = self._put(self._mine, version)
        if mine is None:
            # Another was faster, and may have done with it already: begin anew.
            self._watched = None
            return False
        self.is_held, self._version, self._sure = True, mine, begin + _SURE * self._mine.seconds
        self._renew()
        self._refuse_unconditional(mine)
        return True

    def _refuse_unconditional(self, old: dict) -> None:
        """A store that does what is asked whatever the condition would let everybody have it."""
        import obstore

        try:
            obstore.put(self._objects, self._name, _written(self._mine), mode=old)
        except obstore.exceptions.PreconditionError:
            return
        raise StoreError(f"{self.label} cannot be written: this object store does not keep the conditions of puts")

    def _renew(self) -> None:
        begin = self._clock()
        if self.is_held:
            version = self._put(record := self._next(), self._version)
            if version is not None:
                self._mine, self._version, self._sure = record, version, begin + _SURE * record.seconds
                return
            self.is_held, self._sure = False, float("-inf")
            self.other, _ = self._read() or (_UNKNOWN, None)
        raise LeaseLost(
            f"{self.label} was taken over by {self.other}, because this run gave no sign of life for "
            f"{self._mine.seconds:g} s: it writes nothing more"
        )

    def _next(self) -> Record:
        return replace(self._mine, renewal=self._mine.renewal + 1)

    def _put(self, record: Record, version: dict | None) -> dict | None:
        """The new version, or None where another came before; a put that fails may have been done."""
        import obstore

        try:
            return _version(
                obstore.put(self._objects, self._name, _written(record), mode="create" if version is None else version)
            )
        except (obstore.exceptions.AlreadyExistsError, obstore.exceptions.PreconditionError):
            failure = None
        except obstore.exceptions.BaseError as error:
            failure = error
        now, version = self._read() or (None, None)
        if now == record:
            return version
        if failure is not None:
            raise failure
        return None

    def _read(self) -> tuple[Record, dict] | None:
        import obstore

        try:
            found = obstore.get(self._objects, self._name)
            return _record(found.bytes().to_bytes()), _version(found.meta)
        except FileNotFoundError:
            return None


@contextlib.contextmanager
def leased(
    objects: Any, name: str, label: str, wait: bool, say: Callable[[str], None], *, seconds: float = SECONDS
) -> Iterator[bool]:
    """Hold a lease while in the block.

    Parameters
    ----------
    objects : obstore.store.ObjectStore
    name : str
        Of the object in it that says who holds the lease. It is kept, so that letting go cannot remove another's.
    label : str
        What is leased, for messages and for `check_held`.
    wait : bool
        Whether to wait for another holder to end. Whether it lives is only known after a while.
    say : callable
        Takes a line about a wait, about a holder that ended without letting go, or about the loss of the lease.
    seconds : float, optional
        After which the lease is over if it is not renewed; at most a day.

    Yields
    ------
    bool
        Whether there was another holder: then the store is not what it was.

    Raises
    ------
    StoreError
        If another process holds it and `wait` is false: host, process and since when.
    obstore.exceptions.BaseError
        If the object store does not do as asked.
    """
    lease = Lease(objects, name, label, seconds)
    waited = told = False
    while not lease.attempt():
        waited, other = True, lease.other
        if lease.other_lives and not wait:
            raise StoreError(f"{label} is in use by {other}: wait for it, or say store.wait=true")
        if not told and other is not None and not other.free:
            doubt = "waiting" if wait else f"whether it still lives is known within {other.seconds:.0f} s"
            say(f"store: {label} is in use by {other}, {doubt}")
            told = True
        time.sleep(seconds * _LOOK)
    over = threading.Event()
    renewer = threading.Thread(target=_keep, args=(lease, over, say), name="lease", daemon=True)
    try:
        _HELD[label] = lease
        renewer.start()
        if lease.other is not None and not lease.other.free:
            say(f"store: {lease.other} ended without letting go of {label}, going on")
        yield waited
    finally:
        over.set()
        renewer.join()
        del _HELD[label]
        # What cannot be let go is over in a while; that must not hide why the run ended.
        with contextlib.suppress(Exception):
            lease.release()


def check_held(label: str) -> None:
    """Before anything is written below a label: raise if this process had its lease and may not have it any more.

    Raises
    ------
    LeaseLost
        If another has it.
    obstore.exceptions.BaseError
        If that cannot be known.
    """
    for held, lease in list(_HELD.items()):
        if label == held or label.startswith(f"{held}/"):
            lease.check()


def _keep(lease: Lease, over: threading.Event, say: Callable[[str], None]) -> None:
    """Renew a lease until it is let go or lost."""
    import obstore

    while not over.wait(lease.seconds * _RENEW):
        try:
            lease.renew()
        except LeaseLost as error:
            say(f"store: {error}")
            return
        except obstore.exceptions.BaseError:
            # Until it succeeds, `check` lets nothing be written after the time that is sure.
            continue


def _written(record: Record) -> bytes:
    return json.dumps(asdict(record)).encode()


def _record(content: bytes) -> Record:
    """A record as it is stored, whoever wrote it."""
    try:
        told = json.loads(content)
        return Record(
            host=str(told["host"])[:80],
            pid=int(told["pid"]),
            since=str(told["since"])[:40],
            holder=str(told["holder"]),
            renewal=int(told["renewal"]),
            seconds=min(max(float(told["seconds"]), 0.0), _LONGEST),
            free=told["free"] is True,
        )
    except (ValueError, KeyError, TypeError, OverflowError, RecursionError):
        return _UNKNOWN


def _version(told: Any) -> dict[str, str]:
    """What a conditional put takes, from what a store tells of an object."""
    return {key: told[key] for key in ("e_tag", "version") if told.get(key) is not None}
