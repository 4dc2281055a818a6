"""Who can reach the processes of `cluster=local`: nobody without the key of the run, and on no port too many."""

import os
import socket
import ssl
from contextlib import closing
from pathlib import Path

import psutil
import pytest
from distributed import Client, Security, Worker
from distributed.comm import connect

from pipeline.run.workforce import Workforce
from tests.pipeline.planes import cluster
from tests.pipeline.talk import done

WORKERS = 1
#: The scheduler's port, and for each worker its own and its nanny's.
PORTS = 1 + 2 * WORKERS


def listening() -> set:
    """Addresses at which this process and what it started listen, over any network protocol."""
    here = psutil.Process()
    return {
        connection.laddr
        for process in (here, *here.children(recursive=True))
        for connection in process.net_connections(kind="inet")
        if connection.status in (psutil.CONN_LISTEN, psutil.CONN_NONE)
    }


def _folder(dask_worker) -> Path:
    return Path(dask_worker.local_directory)


@pytest.fixture(scope="module")
def started():
    before = listening()
    with Workforce(cluster("local", workers=WORKERS)) as workforce:
        workforce.start()
        yield workforce, sorted(listening() - before)


@pytest.fixture(scope="module")
def stranger():
    """Keys that another run made."""
    return Security.temporary()


def answers(address: str, security: Security) -> bool:
    """Whether a server of dask shakes hands."""

    async def shake_hands() -> bool:
        try:
            comm = await connect(address, timeout=2, **security.get_connection_args("client"))
        except OSError:
            return False
        await comm.close()
        return True

    return done(shake_hands())


def said(place, words: bytes, context: ssl.SSLContext | None = None) -> bytes:
    """What comes back for some bytes, in clear or through TLS; nothing where the connection is cut."""
    with closing(socket.create_connection(place, timeout=10)) as connection:
        try:
            if context is not None:
                connection = context.wrap_socket(connection)
            connection.sendall(words)
            return connection.recv(1000)
        except (ssl.SSLError, ConnectionError):
            return b""
        finally:
            connection.close()


def test_only_the_ports_that_peers_need_are_open_and_on_loopback_alone(started):
    _, places = started
    assert len(places) == PORTS and {place.ip for place in places} == {"127.0.0.1"}


def test_a_dask_client_without_the_key_cannot_connect(started, stranger):
    workforce, places = started
    address = workforce._connection.address
    assert address.startswith("tls://")
    for security, scheme in ((Security(), "tcp"), (stranger, "tls")):
        with pytest.raises(OSError):
            Client(address.replace("tls", scheme), security=security, timeout=1, set_as_default=False)


def test_scheduler_nannies_and_workers_know_the_key_of_the_run_and_no_other(started, stranger):
    workforce, places = started
    for place in places:
        own, other = f"tls://{place.ip}:{place.port}", f"tcp://{place.ip}:{place.port}"
        assert answers(own, workforce._connection._client.security)
        assert not answers(own, stranger) and not answers(other, Security(require_encryption=False))


def test_who_shows_no_certificate_is_cut_off(started):
    _, places = started
    anyone = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    anyone.check_hostname, anyone.verify_mode = False, ssl.CERT_NONE
    for place in places:
        assert said(place, bytes(64), anyone) == b"" == said(place, b"GET / HTTP/1.0\r\n\r\n")


@pytest.mark.costly
def test_a_worker_without_the_key_cannot_join(started, stranger):
    workforce, _ = started
    before = workforce._connection.workers()

    async def join():
        await Worker(workforce._connection.address, security=stranger, nthreads=1, death_timeout=2)

    with pytest.raises((OSError, TimeoutError)):
        done(join())
    assert workforce._connection.workers() == before


@pytest.mark.costly
def test_the_folders_of_workers_are_private_and_go_with_them():
    with Workforce(cluster("local", workers=1)) as workforce:
        workforce.start()
        (folder,) = workforce._connection._client.run(_folder).values()
        private = [place for place in folder.parents if place.exists() and place.stat().st_mode & 0o077 == 0]
        assert private and all(place.stat().st_uid == os.getuid() for place in private) and folder.is_dir()
    assert not private[-1].exists()


@pytest.mark.costly
def test_the_dashboard_is_on_loopback_and_the_only_page():
    before = listening()
    with Workforce(cluster("local", workers=1, dashboard=True)) as workforce:
        assert "dashboard http://127.0.0.1:" in workforce.start()
        places = listening() - before
        assert len(places) == 4 and {place.ip for place in places} == {"127.0.0.1"}
        (page,) = [place for place in places if said(place, b"GET / HTTP/1.0\r\n\r\n").startswith(b"HTTP/")]
        assert f"http://127.0.0.1:{page.port}/" in workforce.start()
