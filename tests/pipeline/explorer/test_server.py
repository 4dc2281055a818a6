"""The server of pages: for this machine and its own pages alone; what happens to its store is a line of text."""

import html
import json
import re
import shutil
import socket
import time
import urllib.request

import psutil
import pytest
from tornado.httpclient import HTTPClientError, HTTPRequest
from tornado.websocket import websocket_connect

from pipeline.__main__ import main
from pipeline.explorer import stage
from tests.pipeline.explorer.serving import served_plane
from tests.pipeline.planes import COARSE
from tests.pipeline.talk import done

#: Seconds until a page shows what it was asked for.
_PATIENCE = 60


def texts(url: str) -> str:
    """What a page says, as a browser would be told."""
    return told_by(url.partition("?")[0], get(url))


def told_by(url: str, page: str) -> str:
    """The same of a page that was given out."""
    content, found = done(pulled(url, page)), []

    def gather(part) -> None:
        for name, value in part.items() if isinstance(part, dict) else enumerate(part):
            if isinstance(value, dict | list):
                gather(value)
            elif name == "text" and isinstance(value, str):
                found.append(html.unescape(html.unescape(value)))

    gather(json.loads(content))
    return "\n".join(found)


async def pulled(url: str, page: str) -> str:
    """The document of a page, as its browser asks for it."""
    token = re.search(r'"token":"([^"]+)"', page)[1]
    pipe = await websocket_connect(f"{url.replace('http', 'ws')}ws", subprotocols=["bokeh", token])
    try:
        # Before it greets, it does not listen.
        assert '"ACK"' in await pipe.read_message()
        for part in ('{"msgid": "1", "msgtype": "PULL-DOC-REQ"}', "{}", "{}"):
            await pipe.write_message(part)
        while True:
            # Other messages, and numbers that belong to them, come in between.
            frame = await pipe.read_message()
            if isinstance(frame, str) and '"PULL-DOC-REPLY"' in frame:
                return [await pipe.read_message() for _ in range(2)][1]
            assert frame is not None
    finally:
        await hung_up(pipe)


async def hung_up(pipe) -> None:
    """The end of a connection, of which nothing is left."""
    pipe.close()
    while await pipe.read_message() is not None:
        pass


def get(url: str, **headers: str) -> str:
    with urllib.request.urlopen(urllib.request.Request(url, headers=headers), timeout=_PATIENCE) as answer:
        return answer.read().decode()


def test_it_listens_on_loopback_alone(served):
    listening = [
        c for c in psutil.Process(served.process.pid).net_connections("inet") if c.status == psutil.CONN_LISTEN
    ]
    assert [one.laddr.ip for one in listening] == ["127.0.0.1"]


def connected(served, origin: str) -> bool:
    """Whether a page of an origin can talk to the server, with the token of a session."""
    page = get(served.url)
    token = re.search(r'"token":"([^"]+)"', page)[1]

    async def connect() -> bool:
        request = HTTPRequest(f"{served.url.replace('http', 'ws')}ws", headers={"Origin": origin})
        try:
            pipe = await websocket_connect(request, subprotocols=["bokeh", token])
            said = await pipe.read_message()
            await hung_up(pipe)
        except HTTPClientError as error:
            assert error.code == 403
            return False
        return "ACK" in said

    return done(connect())


@pytest.mark.costly
def test_pages_of_other_origins_are_refused(served):
    port = served.url.rsplit(":", 1)[1].strip("/")
    assert connected(served, f"http://127.0.0.1:{port}")
    for origin in ("http://example.org", f"http://example.org:{port}", "http://127.0.0.1:1", "null"):
        assert not connected(served, origin), origin


def test_other_names_of_this_machine_are_told_nothing(served):
    # A name of another site may be made to lead here.
    said = told_by(served.url, get(served.url, Host="example.org"))
    assert "for this machine alone" in said and "omega_fe" not in said


@pytest.mark.parametrize(
    "path",
    [
        "static/../../../../etc/passwd",
        "static/extensions/panel/../../../../../etc/passwd",
        "components/pipeline.explorer.app/explorer/../../../../../etc/passwd",
        "components/os/path/etc/passwd",
        "omega_fe.zarr/zarr.json",
        "..%2f..%2fetc%2fpasswd",
        "static/js/%2e%2e/%2e%2e/%2e%2e/%2e%2e/etc/passwd",
    ],
)
def test_no_path_leads_to_files(served, path):
    host, port = re.match(r"http://([\d.]+):(\d+)/", served.url).groups()
    with socket.create_connection((host, int(port)), timeout=_PATIENCE) as raw:
        # Clients that tidy paths up are not the ones to be afraid of.
        raw.sendall(f"GET /{path} HTTP/1.1\r\nHost: {host}:{port}\r\nConnection: close\r\n\r\n".encode())
        answer = b"".join(iter(lambda: raw.recv(65536), b"")).decode(errors="replace")
    assert re.match(r"HTTP/1\.1 (400|403|404)", answer), answer[:200]
    assert "root:" not in answer


@pytest.mark.costly
def test_an_address_that_names_no_view_is_a_line_of_the_page(served):
    assert "layer = ../../etc is not allowed" in texts(f"{served.url}?layer=../../etc")
    assert "store = '../x' is not shown here" in texts(f"{served.url}?store=../x")


@pytest.mark.costly
def test_several_pages_at_once_have_views_of_their_own(served):
    # Both are given out before either is looked at.
    pages = [get(f"{served.url}?at={at}") for at in ("0.6,0.2", "1.3,0.3")]
    said = [told_by(served.url, page) for page in pages]
    for page, here, there in ((said[0], "Ω = 0.6, f_e = 0.2", "Ω = 1.3"), (said[1], "Ω = 1.3, f_e = 0.3", "Ω = 0.6")):
        assert here in page and there not in page


def test_a_store_that_vanishes_and_comes_back_is_a_message(served):
    away = served.store.with_name("away.zarr")
    served.store.rename(away)
    try:
        assert "is gone" in texts(served.url)
    finally:
        away.rename(served.store)
    assert "is gone" not in texts(served.url)


def test_a_store_that_is_broken_is_a_message(served):
    document = served.store / "zarr.json"
    whole = document.read_bytes()
    time.sleep(0.01)
    document.write_bytes(whole[: len(whole) // 2])
    try:
        said = texts(served.url)
        assert "damaged" in said or "not allowed" in said, said
    finally:
        document.write_bytes(whole)
    assert "<h1>omega_fe</h1>" in texts(served.url)


def told(capsys, *words: str) -> tuple[int, str]:
    status = main([*COARSE, "stages=[explore]", *words])
    return status, capsys.readouterr().err


def test_without_the_extra_one_line_says_what_to_install(monkeypatch, capsys, tmp_path):
    served_plane(tmp_path)
    monkeypatch.setattr(stage.importlib.util, "find_spec", lambda name: None)
    status, line = told(capsys, f"output.root={tmp_path}", "store.name=omega_fe")
    assert status == 2 and "bevelmap[explore]" in line and line.count("\n") == 1


def test_what_cannot_be_explored_is_refused_before_anything_is_served(capsys, tmp_path):
    words = (f"output.root={tmp_path}", "store.name=omega_fe")
    status, line = told(capsys, *words)
    assert status == 2 and "there is no store" in line
    served_plane(tmp_path)
    status, line = told(capsys, *words, "explore.view='at=9,9'")
    assert status == 2 and "at = 9,9" in line
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        status, line = told(capsys, *words, f"explore.port={taken.getsockname()[1]}")
    assert status == 2 and "explore.port" in line
    shutil.rmtree(tmp_path / "store")
