"""The explorer's server: for this machine and its own pages alone; whatever happens to its store is a line of text."""

import asyncio
import re
import shutil
import socket
import time
import urllib.error
import urllib.request

import psutil
import pytest
from bokeh.client import pull_session
from tornado.httpclient import HTTPClientError, HTTPRequest
from tornado.websocket import websocket_connect

from pipeline.__main__ import main
from pipeline.explorer import stage
from tests.pipeline.explorer.serving import SIZES, served_plane, serving

#: Seconds until a page shows what it was asked for.
_PATIENCE = 60


@pytest.fixture(scope="module")
def served(tmp_path_factory):
    folder = tmp_path_factory.mktemp("served")
    served_plane(folder)
    with serving(folder) as found:
        yield found


def texts(url: str) -> list[str]:
    """What a page says, as a browser would be told."""
    session = pull_session(url=url)
    try:
        return [
            model.text
            for model in session.document.select({"type": object})
            if isinstance(getattr(model, "text", None), str)
        ]
    finally:
        session.close()


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
            socket = await websocket_connect(request, subprotocols=["bokeh", token])
            said = await socket.read_message()
            socket.close()
        except HTTPClientError as error:
            assert error.code == 403
            return False
        return "ACK" in said

    return asyncio.run(connect())


def test_pages_of_other_origins_are_refused(served):
    port = served.url.rsplit(":", 1)[1].strip("/")
    assert connected(served, f"http://127.0.0.1:{port}")
    for origin in ("http://example.org", f"http://example.org:{port}", "http://127.0.0.1:1", "null"):
        assert not connected(served, origin), origin


def test_other_names_of_this_machine_are_told_nothing(served):
    # A name of another site may be made to lead here.
    page = get(served.url, Host="example.org")
    session = re.search(r'"token":"([^"]+)"', page)
    assert session and served.store.name not in page
    assert "omega_fe" not in re.sub(r"<title>.*?</title>", "", page)


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


def test_an_address_that_names_no_view_is_a_line_of_the_page(served):
    assert any("layer = ../../etc is not allowed" in text for text in texts(f"{served.url}?layer=../../etc"))
    assert any("store = &#x27;../x&#x27; is not shown here" in text for text in texts(f"{served.url}?store=../x"))


def test_several_pages_at_once_have_views_of_their_own(served):
    one, other = (pull_session(url=f"{served.url}?at={at}") for at in ("0.6,0.2", "1.3,0.3"))
    try:
        for session, at in ((one, "Ω = 0.6"), (other, "Ω = 1.3")):
            heads = [
                model.text
                for model in session.document.select({"name": "HTML"}) or session.document.models
                if "<h2>" in str(getattr(model, "text", ""))
            ]
            assert any(at in head.replace("&lt;", "<") for head in heads)
    finally:
        one.close()
        other.close()


def test_a_store_that_vanishes_and_comes_back_is_a_message(served):
    away = served.store.with_name("away.zarr")
    served.store.rename(away)
    try:
        assert any("is gone" in text for text in texts(served.url))
    finally:
        away.rename(served.store)
    assert not any("is gone" in text for text in texts(served.url))


def test_a_store_that_is_broken_is_a_message(served):
    document = served.store / "zarr.json"
    whole = document.read_bytes()
    time.sleep(0.01)
    document.write_bytes(whole[: len(whole) // 2])
    try:
        said = texts(served.url)
        assert any("damaged" in text or "not allowed" in text for text in said), said
    finally:
        document.write_bytes(whole)
    assert any("<h1>" in text or "&lt;h1&gt;" in text for text in texts(served.url))


def told(capsys, *words: str) -> tuple[int, str]:
    status = main([*SIZES, "stages=[explore]", *words])
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
