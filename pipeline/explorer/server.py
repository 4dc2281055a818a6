"""The page's server: on this machine alone, for pages that it gave out itself."""

import contextlib
import logging
import socket
from collections.abc import Callable

import panel as pn
from bokeh.server.server import Server

from pipeline.errors import refused
from pipeline.explorer.messages import message
from pipeline.run.processes import signals_left_alone

__all__ = ["ADDRESS", "make_server", "run_server"]

#: Nobody else reaches it.
ADDRESS = "127.0.0.1"


def make_server(page: Callable[[], object], port: int = 0, title: str = "bevelmap") -> Server:
    """A server that listens; pages are answered once its loop runs.

    Parameters
    ----------
    page : callable
        Makes what one page shows, a Panel object; called for every page anew.
    port : int
        0 takes a free one.
    title : str

    Raises
    ------
    ConfigurationError
        If the port is taken.
    """
    port = _free_port(port)
    # Other sites that this browser shows are other origins; names that lead to this machine are other hosts.
    hosts = [f"{ADDRESS}:{port}", f"localhost:{port}"]
    # That a page was closed while something was sent to it is nothing to tell.
    for name in ("asyncio", "bokeh", "tornado.access", "tornado.general", "panel"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    with signals_left_alone():
        return pn.io.server.get_server(
            lambda: _for_this_machine(page, hosts),
            port=port,
            address=ADDRESS,
            websocket_origin=hosts,
            title=title,
            # What a page sends is small.
            websocket_max_message_size=2**20,
            # A page that is gone is forgotten, and what it holds.
            unused_session_lifetime_milliseconds=60_000,
            check_unused_sessions_milliseconds=10_000,
        )


def run_server(server: Server) -> None:
    """Answer until an exception, such as that of Ctrl-C, ends it."""
    try:
        server.start()
        server.io_loop.start()
    finally:
        with contextlib.suppress(Exception):
            server.stop()


def _for_this_machine(page: Callable[[], object], hosts: list[str]):
    host = (pn.state.headers or {}).get("Host", "")
    if host not in hosts:
        return message("This page is for this machine alone.")
    return page()


def _free_port(port: int) -> int:
    """A port that nobody listens on: this one, or any of them for 0."""
    with socket.socket() as found:
        # As the server itself takes it: what was just let go is free.
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            found.bind((ADDRESS, port))
        except OSError as error:
            raise refused("explore.port", port, f"a port that is free, or 0 ({error})") from None
        return found.getsockname()[1]
