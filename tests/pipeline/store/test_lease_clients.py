"""One writer at a time on an object store: real processes that are killed and stopped, and a server whose puts fail."""

import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import obstore
import pytest
from obstore.exceptions import PermissionDeniedError
from obstore.store import from_url

from pipeline.store.lease import Lease, leased
from tests.pipeline.store.lease_client import DATA, NAME, record

ROOT = Path(__file__).parents[3]


class Client:
    """A process that runs `lease_client`."""

    def __init__(self, server, url, seconds, wait="wait"):
        self.process = subprocess.Popen(
            [sys.executable, "-m", "tests.pipeline.store.lease_client", url, str(seconds), wait],
            cwd=ROOT,
            env=os.environ | server.environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def heard(self, *words):
        """The next line, which begins so."""
        line = self.process.stdout.readline().strip()
        assert line.startswith(" ".join(words)), line
        return line

    def writes(self, text):
        """Have it write."""
        self.process.stdin.write(f"{text}\n")
        self.process.stdin.flush()

    def ends(self):
        """Let it end; the lines that are left."""
        self.process.stdin.close()
        return self.process.stdout.read()

    @property
    def named(self):
        return f"process {self.process.pid} on {socket.gethostname()} since "


@pytest.fixture
def clients(object_server, request):
    """Makes processes on one object store, which end with the test."""
    made = []
    url = object_server.url(f"lease/{request.node.name}")

    def client(seconds, wait="wait"):
        made.append(Client(object_server, url, seconds, wait))
        return made[-1]

    client.store = from_url(url, **object_server.options)
    yield client
    for one in made:
        one.process.kill()
        one.process.wait()
        one.process.stdin.close()
        one.process.stdout.close()


def written(clients):
    return obstore.get(clients.store, DATA).bytes().to_bytes().decode()


@pytest.mark.costly
def test_a_second_client_waits_or_is_refused(clients):
    first = clients(8.0)
    first.heard("holds", "False")
    waiting, refused = clients(8.0), clients(8.0, "refuse")
    for other in (waiting, refused):
        assert first.named in other.heard("said")
    line = refused.heard("refused")
    assert first.named in line and "store.wait=true" in line
    first.writes("first")
    first.heard("wrote")
    assert written(clients) == "first"
    assert first.ends() == "let go\n"
    waiting.heard("holds", "True")


@pytest.mark.costly
def test_a_client_that_was_killed_is_followed(clients):
    first = clients(1.0)
    first.heard("holds")
    first.process.kill()
    second = clients(1.0, "refuse")
    assert first.named in second.heard("said")
    assert first.named in second.heard("said")
    second.heard("holds", "True")
    second.writes("second")
    second.heard("wrote")
    assert second.ends() == "let go\n"


@pytest.mark.costly
def test_a_client_that_was_stopped_writes_nothing_after_another_took_over(clients):
    first = clients(1.0)
    first.heard("holds")
    first.process.send_signal(signal.SIGSTOP)
    second = clients(1.0)
    second.heard("said")
    second.heard("said")
    second.heard("holds", "True")
    second.writes("second")
    second.heard("wrote")
    first.writes("first")
    first.process.send_signal(signal.SIGCONT)
    # Its thread may find out before it comes to write, or the write itself does.
    told = first.process.stdout.read()
    assert second.named in told and "\nrefused" in f"\n{told}" and "wrote" not in told
    assert written(clients) == "second"
    second.writes("again")
    second.heard("wrote")
    assert second.ends() == "let go\n"


@pytest.mark.costly
def test_a_client_that_was_stopped_goes_on_if_nobody_came(clients):
    first = clients(0.5)
    first.heard("holds")
    first.process.send_signal(signal.SIGSTOP)
    time.sleep(1.0)
    first.writes("first")
    first.process.send_signal(signal.SIGCONT)
    first.heard("wrote")
    assert first.ends() == "let go\n"


@pytest.mark.parametrize("kind", ["done_with_error", "done_unanswered", "unavailable", "cut"])
def test_each_put_of_a_lease_may_fail(object_server, clients, kind):
    """A put that is taken, renewed or let go in spite of what is answered; the client of the store asks again."""
    for number in range(4):
        lease = Lease(clients.store, NAME, "plane", 60.0)
        passed = 0
        with object_server.fault(kind, times=1, methods="PUT") as fault:
            for step in (lease.attempt, lease.renew, lease.check, lease.release)[: number + 1]:
                step()
                passed += 1
        assert fault.hits == 1 and passed == number + 1
        lease.release()
        assert record(clients.store).free


def test_without_permission_it_is_refused(object_server, clients):
    with object_server.denied(), pytest.raises(PermissionDeniedError), leased(clients.store, NAME, "plane", True, str):
        pytest.fail("it was leased")
