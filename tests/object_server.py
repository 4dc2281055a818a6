"""A real S3 server on loopback for tests, and a proxy before it that makes faults.

The server is moto's, in a process of its own. The proxy stands in this process, so that a test sets faults and counts
requests by a call. Writes pass it one by one: moto looks at `If-Match` and writes in two steps, and a lock that is
taken by a conditional put needs both to be one.
"""

import contextlib
import http.client
import math
import subprocess
import sys
import threading
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import Enum
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

__all__ = ["BUCKET", "FaultKind", "ObjectServer", "object_server", "served_objects"]

#: A bucket that is there from the start.
BUCKET = "planes"

_REGION = "us-east-1"
#: Headers that belong to one connection, or that the answer gets anew.
_OF_A_HOP = {"connection", "keep-alive", "transfer-encoding", "content-length", "server", "date"}
_WRITES = frozenset({"PUT", "POST", "DELETE"})


class FaultKind(Enum):
    """What happens to a request."""

    #: Answered 503 SlowDown, not done.
    UNAVAILABLE = "unavailable"
    #: Answered 403 AccessDenied, not done.
    DENIED = "denied"
    #: Not answered, not done, until the fault ends: then the connection is closed.
    HANG = "hang"
    #: The connection is cut in the middle: of what a put sends (not done), else of what the answer sends.
    CUT = "cut"
    #: Done, and answered 500.
    DONE_WITH_ERROR = "done_with_error"
    #: Done, and the connection is closed without an answer.
    DONE_UNANSWERED = "done_unanswered"


_REFUSALS = {
    FaultKind.UNAVAILABLE: (503, "SlowDown"),
    FaultKind.DENIED: (403, "AccessDenied"),
    FaultKind.DONE_WITH_ERROR: (500, "InternalError"),
}


@dataclass
class Fault:
    """A fault that is set: which requests it hits, and how many it has hit."""

    kind: FaultKind
    times: float
    methods: frozenset[str]
    name: str
    hits: int = 0
    over: threading.Event = field(default_factory=threading.Event)

    def takes(self, method: str, path: str) -> bool:
        """Whether it hits this request."""
        return self.hits < self.times and (not self.methods or method in self.methods) and self.name in path


class _Handler(BaseHTTPRequestHandler):
    """Passes requests on to the server behind."""

    protocol_version = "HTTP/1.1"
    # Else each answer waits 40 ms for the client's acknowledgement of its head.
    disable_nagle_algorithm = True
    server: "_Proxy"

    def _handle(self) -> None:
        fault = self.server.record(self.command, unquote(self.path))
        kind = fault.kind if fault else None
        length = int(self.headers.get("Content-Length") or 0)
        if kind in (FaultKind.HANG, FaultKind.CUT, FaultKind.DONE_UNANSWERED):
            self.close_connection = True
        if kind is FaultKind.CUT and length:
            self.rfile.read(length // 2)
            return
        body = self.rfile.read(length)
        if kind is FaultKind.HANG:
            fault.over.wait()
        elif kind in (FaultKind.UNAVAILABLE, FaultKind.DENIED):
            self._refuse(kind)
        else:
            answer = self._forward(body)
            if kind is FaultKind.DONE_WITH_ERROR:
                self._refuse(kind)
            elif kind is not FaultKind.DONE_UNANSWERED:
                self._answer(*answer, half=kind is FaultKind.CUT)

    do_GET = do_HEAD = do_PUT = do_POST = do_DELETE = _handle

    def _forward(self, body: bytes) -> tuple[int, list[tuple[str, str]], bytes]:
        """Status, headers and body of the server's answer."""
        order = self.server.order if self.command in _WRITES else contextlib.nullcontext()
        headers = {name: value for name, value in self.headers.items() if name.lower() not in _OF_A_HOP}
        with order, contextlib.closing(http.client.HTTPConnection("127.0.0.1", self.server.behind)) as connection:
            connection.request(self.command, self.path, body, headers | {"Content-Length": str(len(body))})
            answer = connection.getresponse()
            return answer.status, answer.getheaders(), answer.read()

    def _answer(self, status: int, headers: list[tuple[str, str]], body: bytes, half: bool = False) -> None:
        self.send_response_only(status)
        of_head = {name.lower(): value for name, value in headers}
        for name, value in headers:
            if name.lower() not in _OF_A_HOP:
                self.send_header(name, value)
        length = of_head.get("content-length", "0") if self.command == "HEAD" else str(len(body))
        if status != 204:
            self.send_header("Content-Length", length)
        self.end_headers()
        self.wfile.write(body[: len(body) // 2] if half else body)

    def _refuse(self, kind: FaultKind) -> None:
        status, code = _REFUSALS[kind]
        text = (
            f"<?xml version='1.0' encoding='UTF-8'?><Error><Code>{code}</Code><Message>made by a test</Message></Error>"
        )
        self._answer(status, [("Content-Type", "application/xml")], b"" if self.command == "HEAD" else text.encode())

    def handle(self) -> None:
        # A client may go at any time; what it did not get is its own affair.
        with contextlib.suppress(ConnectionError):
            super().handle()

    def log_message(self, *_: object) -> None:
        """Nothing is printed."""


class _Proxy(ThreadingHTTPServer):
    """Counts requests, and knows the faults."""

    daemon_threads = True
    request_queue_size = 128

    def __init__(self, behind: int) -> None:
        super().__init__(("127.0.0.1", 0), _Handler)
        self.behind = behind
        self.order = threading.Lock()
        self.state = threading.Lock()
        self.faults: list[Fault] = []
        self.requests: list[tuple[str, str]] = []

    def record(self, method: str, path: str) -> Fault | None:
        """Count a request; the fault that hits it."""
        with self.state:
            self.requests.append((method, path))
            fault = next((fault for fault in self.faults if fault.takes(method, path)), None)
            if fault:
                fault.hits += 1
            return fault


class ObjectServer:
    """The server as tests see it.

    Attributes
    ----------
    endpoint : str
        `http://127.0.0.1:port`.
    """

    def __init__(self, proxy: _Proxy) -> None:
        self._proxy = proxy
        self.endpoint = f"http://127.0.0.1:{proxy.server_port}"

    def url(self, prefix: str) -> str:
        """The address of a prefix in the bucket that is there."""
        return f"s3://{BUCKET}/{prefix}"

    @property
    def options(self) -> dict[str, object]:
        """Storage options for it, as `obstore.store.from_url` takes them."""
        return {
            "endpoint": self.endpoint,
            "access_key_id": "test-key",
            "secret_access_key": "test-secret-nobody-may-see",
            "region": _REGION,
            "client_options": {"allow_http": True},
        }

    @property
    def environment(self) -> dict[str, str]:
        """The same as environment variables."""
        return {
            "AWS_ENDPOINT": self.endpoint,
            "AWS_ENDPOINT_URL": self.endpoint,
            "AWS_ACCESS_KEY_ID": self.options["access_key_id"],
            "AWS_SECRET_ACCESS_KEY": self.options["secret_access_key"],
            "AWS_REGION": _REGION,
            "AWS_DEFAULT_REGION": _REGION,
            "AWS_ALLOW_HTTP": "true",
        }

    def requests(self) -> list[tuple[str, str]]:
        """Method and path of each request since last asked."""
        with self._proxy.state:
            requests, self._proxy.requests = self._proxy.requests, []
        return requests

    def count(self) -> Counter[str]:
        """Requests since last asked, by method."""
        return Counter(method for method, _ in self.requests())

    @contextlib.contextmanager
    def fault(
        self, kind: FaultKind | str, times: float = math.inf, methods: str = "", name: str = ""
    ) -> Iterator[Fault]:
        """Make requests fail while in the block.

        Parameters
        ----------
        kind : FaultKind or str
        times : float, optional
            How many requests, from now; all if infinite.
        methods : str, optional
            Only these, with blanks between; any if empty.
        name : str, optional
            Only those whose path (`/bucket/prefix/name?query`) has this in it.

        Yields
        ------
        Fault
            Its `hits` are the requests that it has hit.
        """
        fault = Fault(FaultKind(kind), times, frozenset(methods.split()), name)
        with self._proxy.state:
            self._proxy.faults.append(fault)
        try:
            yield fault
        finally:
            with self._proxy.state:
                self._proxy.faults.remove(fault)
            fault.over.set()

    def denied(self, bucket: str = BUCKET) -> contextlib.AbstractContextManager[Fault]:
        """A bucket without permission while in the block."""
        return self.fault(FaultKind.DENIED, name=f"/{bucket}")


@contextlib.contextmanager
def served_objects() -> Iterator[ObjectServer]:
    """A server that runs while in the block."""
    # It ends when its input does: with this process, however that ends.
    behind = subprocess.Popen(
        [sys.executable, "-m", __name__],
        cwd=Path(__file__).parents[1],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )
    try:
        with _Proxy(int(behind.stdout.readline())) as proxy:
            thread = threading.Thread(target=proxy.serve_forever, args=(0.05,), daemon=True)
            thread.start()
            try:
                server = ObjectServer(proxy)
                _make_bucket(server)
                yield server
            finally:
                proxy.shutdown()
                thread.join()
    finally:
        behind.stdin.close()
        behind.wait()
        behind.stdout.close()


def _make_bucket(server: ObjectServer) -> None:
    with contextlib.closing(http.client.HTTPConnection(urlsplit(server.endpoint).netloc)) as connection:
        connection.request("PUT", f"/{BUCKET}")
        assert connection.getresponse().status == 200
    server.count()


@pytest.fixture(scope="session")
def object_server() -> Iterator[ObjectServer]:
    """An S3 server on loopback, started when the first test asks for it."""
    with served_objects() as server:
        yield server


def _serve() -> None:
    """Run moto's server until the input ends; its port is the first line of the output."""
    from moto.moto_server.werkzeug_app import DomainDispatcherApplication, MotoRequestHandler, create_backend_app
    from werkzeug.serving import make_server

    application = DomainDispatcherApplication(create_backend_app)
    server = make_server("127.0.0.1", 0, application, threaded=True, request_handler=MotoRequestHandler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    print(server.server_port, flush=True)
    sys.stdin.read()


if __name__ == "__main__":
    _serve()
