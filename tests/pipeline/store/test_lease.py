"""One writer at a time on an object store: whatever clients, clocks and answers do."""

import json
import threading
import time
from unittest import mock

import obstore
import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import Bundle, RuleBasedStateMachine, consumes, invariant, rule
from obstore.exceptions import GenericError
from obstore.store import MemoryStore

from pipeline.errors import StoreError
from pipeline.store import lease as module
from pipeline.store.lease import Lease, check_held, leased
from tests.pipeline.store.lease_client import NAME, record

S = 60.0


class Clock:
    """A clock that goes when told to, and shows whatever hour."""

    def __init__(self, now=0.0):
        self.now = now

    def __call__(self):
        return self.now


@pytest.fixture
def store():
    return MemoryStore()


def taken(store, clock, seconds=S):
    lease = Lease(store, NAME, "plane", seconds, clock)
    assert lease.attempt()
    return lease


def test_a_lease_that_was_let_go_is_taken_at_once(store):
    clock = Clock()
    first = taken(store, clock)
    second = Lease(store, NAME, "plane", S, clock)
    assert not second.attempt()
    first.release()
    assert second.attempt()
    first.release()
    second.check()


@pytest.mark.parametrize("hours", [-5.0, 0.0, 5.0])
def test_only_the_clock_of_who_waits_counts(store, hours):
    """The holder's clock may be wrong by hours: its lease is over when it was not renewed for so long as one waited."""
    mine, its = Clock(), Clock(hours * 3600)
    with mock.patch.object(module, "datetime") as wall:
        wall.now().isoformat.return_value = f"{2026 + hours:.0f}-01-01"
        holder = taken(store, its)
    waiting = Lease(store, NAME, "plane", S, mine)
    for _ in range(4):
        assert not waiting.attempt()
        mine.now += 0.6 * S
        its.now += 0.6 * S
        holder.renew()
    assert not waiting.attempt()
    mine.now += 0.99 * S
    assert not waiting.attempt()
    mine.now += 0.02 * S
    assert waiting.attempt()
    with pytest.raises(StoreError, match="taken over"):
        holder.renew()


def test_a_holder_that_slept_goes_on_unless_another_came(store):
    clock = Clock()
    holder, waiting = taken(store, clock), Lease(store, NAME, "plane", S, clock)
    clock.now += 100 * S
    holder.check()
    assert not waiting.attempt()
    clock.now += S
    assert waiting.attempt()
    for _ in range(2):
        with pytest.raises(StoreError):
            holder.check()
    waiting.check()


def test_a_lease_is_over_after_what_its_holder_said(store):
    clock = Clock()
    taken(store, clock, 10 * S)
    waiting = Lease(store, NAME, "plane", S, clock)
    assert not waiting.attempt()
    clock.now += 9 * S
    assert not waiting.attempt()
    clock.now += 2 * S
    assert waiting.attempt()


@pytest.mark.parametrize("content", [b"", b"{}", b"[1]", b'{"host": 1', b"\xff\x00", b"[" * 100_000])
def test_a_record_that_cannot_be_read_is_somebodys(store, content):
    obstore.put(store, NAME, content)
    clock = Clock()
    lease = Lease(store, NAME, "plane", S, clock)
    assert not lease.attempt()
    clock.now += module.SECONDS
    assert lease.attempt()


@pytest.mark.parametrize("done", [True, False])
def test_a_put_that_fails_may_have_been_done(store, done):
    clock, real = Clock(), obstore.put
    lease = taken(store, clock)

    def failing(*arguments, **options):
        if done:
            real(*arguments, **options)
        raise GenericError("500 Internal Server Error")

    clock.now += S
    with mock.patch("obstore.put", failing):
        if done:
            lease.check()
        else:
            with pytest.raises(GenericError):
                lease.check()
    assert record(store).renewal == 1 + done
    lease.check()
    assert record(store).renewal == 2


def test_a_store_that_keeps_no_conditions_is_refused(store):
    real = obstore.put
    with (
        mock.patch("obstore.put", lambda *arguments, mode: real(*arguments)),
        pytest.raises(StoreError, match="condit"),
    ):
        taken(store, Clock())


def test_what_is_not_ours_is_not_let_go(store):
    clock = Clock()
    first, second = taken(store, clock), Lease(store, NAME, "plane", S, clock)
    second.attempt()
    clock.now += S
    assert second.attempt()
    first.release()
    assert not record(store).free
    second.check()


class Clients(RuleBasedStateMachine):
    """Clients whose clocks show different hours take, renew, lose and let go a lease; puts fail, and others come
    between a client's reading and its writing. Who took it last is the only one that may write."""

    clients = Bundle("clients")

    def __init__(self):
        super().__init__()
        self.store, self.owner, self.all = MemoryStore(), None, []
        self.fault, self.between = None, []
        self.real = obstore.put
        self.patch = mock.patch("obstore.put", self.put)
        self.patch.start()

    def teardown(self):
        self.patch.stop()

    def put(self, *arguments, **options):
        between, self.between = self.between, []
        for step in between:
            step()
        fault, self.fault = self.fault, None
        if fault == "not done":
            raise GenericError("503")
        result = self.real(*arguments, **options)
        if fault == "done":
            raise GenericError("500")
        return result

    def _attempt(self, client):
        if client is self.owner:
            return
        try:
            if client.attempt():
                self.owner = client
        except GenericError:
            # Whether it has it is not known; it goes on as one that has not.
            client._watched = None
        except StoreError:
            assert not client.is_held

    def _write(self, client):
        if not client.is_held and client is not self.owner:
            with pytest.raises(StoreError):
                client.check()
            return
        try:
            client.check()
        except (GenericError, StoreError):
            return
        assert client is self.owner

    def _renew(self, client):
        if not client.is_held:
            return
        try:
            client.renew()
        except GenericError:
            return
        except StoreError:
            assert client is not self.owner
            return
        assert client is self.owner

    def _release(self, client):
        if not client.is_held:
            return
        try:
            client.release()
        except GenericError:
            return
        if client is self.owner:
            self.owner = None

    @rule(target=clients, hours=st.integers(-5, 5))
    def come(self, hours):
        clock = Clock(3600.0 * hours)
        client = Lease(self.store, NAME, "plane", S, clock)
        self.all.append(client)
        return client

    @rule(part=st.sampled_from([0.05, 0.25, 0.5, 0.8, 1.0, 3.0]))
    def time_passes(self, part):
        for client in self.all:
            client._clock.now += part * S

    @rule(client=clients)
    def attempt(self, client):
        self._attempt(client)

    @rule(client=clients)
    def renew(self, client):
        self._renew(client)

    @rule(client=clients)
    def write(self, client):
        self._write(client)

    @rule(client=consumes(clients))
    def release(self, client):
        self._release(client)

    @rule(client=consumes(clients))
    def die(self, client):
        self.all.remove(client)
        if client is self.owner:
            self.owner = None

    @rule(fault=st.sampled_from(["done", "not done"]), client=clients)
    def attempt_and_fail(self, fault, client):
        self.fault = fault
        self._attempt(client)
        self.fault = None

    @rule(fault=st.sampled_from(["done", "not done"]), client=clients)
    def renew_and_fail(self, fault, client):
        self.fault = fault
        self._renew(client)
        self.fault = None

    @rule(first=clients, second=clients, other=st.sampled_from(["_attempt", "_write", "_renew"]), late=st.booleans())
    def one_between(self, first, second, other, late):
        """The second acts between the first's reading and its put, after any time."""
        if first is second:
            return

        def step():
            if late:
                self.time_passes(2.0)
            getattr(self, other)(second)

        self.between = [step]
        self._attempt(first)
        self.between = []

    @invariant()
    def at_most_one_is_sure(self):
        sure = [client for client in self.all if client._clock() < client._sure]
        assert sure in ([], [self.owner])


TestClients = Clients.TestCase
TestClients.settings = settings(max_examples=60, stateful_step_count=25)


def test_a_lease_renews_itself_and_tells_of_its_loss(store):
    """In a thread of its own; each wait is for what must come, however long it takes."""
    told, lines = threading.Event(), []

    def say(line):
        lines.append(line)
        told.set()

    with leased(store, NAME, "a/plane", False, say, seconds=0.1):
        begun = record(store).renewal
        while record(store).renewal < begun + 3:
            time.sleep(0.01)
        check_held("a/plane/part")
        thief = json.dumps(
            {"host": "h", "pid": 7, "since": "t", "holder": "x", "renewal": 0, "seconds": 9, "free": False}
        )
        obstore.put(store, NAME, thief.encode())
        assert told.wait(60)
        assert "process 7 on h since t" in lines[0]
        with pytest.raises(StoreError):
            check_held("a/plane/part")
        check_held("a/plane2")
    check_held("a/plane/part")
    assert not record(store).free
