"""Talking with servers by coroutines."""

import asyncio
from collections.abc import Coroutine
from concurrent.futures import ThreadPoolExecutor

__all__ = ["done"]


def done(talk: Coroutine):
    """What comes of a coroutine; in a thread, as a browser of other tests has a loop in this one."""
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(asyncio.run, talk).result()
