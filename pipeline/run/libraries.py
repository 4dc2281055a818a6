"""Settings of libraries that come from files and environment variables of the user, and have nothing to do here.

A store is read and written in the same way whatever they say. Zarr waits for ever with a concurrency of 0, for one.
"""

import contextlib
import functools
import os
import sys
import traceback
from collections.abc import Iterator

from pipeline.errors import ConfigurationError

__all__ = ["check_zarr", "drawing_into_files", "failed_import", "load_dask", "load_zarr", "unusable", "with_own_dask"]


@functools.cache
def load_zarr() -> None:
    """Import zarr, with its own defaults for everything.

    Raises
    ------
    ConfigurationError
        If its configuration files cannot be read: it does so when it is imported; or if Python leaves out assertions,
        without which zarr writes nothing.
    """
    if sys.flags.optimize:
        raise ConfigurationError("python -O (PYTHONOPTIMIZE) is not allowed: zarr does not work with it; leave it out")
    try:
        import zarr

        zarr.config.refresh(paths=[], env={})
    except Exception as error:
        raise _unreadable("zarr", error) from None


def check_zarr() -> None:
    """Leave zarr's settings as they are in a process that is the user's own, if it can be used with them.

    Raises
    ------
    ConfigurationError
        If it would wait for ever.
    """
    import zarr

    concurrency = zarr.config.get("async.concurrency", None)
    if concurrency is not None and not (isinstance(concurrency, int) and concurrency >= 1):
        raise ConfigurationError(
            f"async.concurrency = {concurrency!r} of zarr's configuration (ZARR_ASYNC__CONCURRENCY) is not allowed: "
            "it must be a whole number from 1 on"
        )


def load_dask() -> None:
    """Import dask's scheduler and client.

    Raises
    ------
    ConfigurationError
        If their configuration cannot be used.
    """
    try:
        import distributed  # noqa: F401
    except Exception as error:
        raise _unreadable("dask", error) from None


@contextlib.contextmanager
def with_own_dask() -> Iterator[None]:
    """Dask with its own defaults for everything: what is started here belongs to this program alone."""
    import dask
    import distributed  # noqa: F401  (its defaults are known once it is imported)

    with dask.config.set(dask.config.merge(*dask.config.defaults)):
        yield


@contextlib.contextmanager
def drawing_into_files() -> Iterator[None]:
    """Matplotlib within knows of no display, as MPLBACKEND may name one that is not there, and of no date: figures have
    none, and SOURCE_DATE_EPOCH may be no number."""
    taken = {name: os.environ.pop(name) for name in ("MPLBACKEND", "SOURCE_DATE_EPOCH") if name in os.environ}
    try:
        yield
    finally:
        os.environ.update(taken)


def failed_import(error: Exception) -> ConfigurationError | None:
    """What is said of an error that ended the import of a library, as a variable of its own does that it cannot use;
    None of any other."""
    frames = [frame for frame, _ in traceback.walk_tb(error.__traceback__)]
    library = frames[-1].f_globals.get("__name__", "").partition(".")[0] if frames else ""
    # An import that fails is taken back.
    if not library or library in sys.modules or isinstance(error, ImportError):
        return None
    return unusable(library, error)


def unusable(library: str, error: Exception) -> ConfigurationError:
    """What is said where a library cannot be used as the user has configured it."""
    reason = " ".join(str(error).split())
    return ConfigurationError(
        f"{library}'s own configuration, of files and of variables {library.upper()}_..., is not allowed: "
        f"{type(error).__name__}: {reason[:300]}"
    )


def _unreadable(library: str, error: Exception) -> ConfigurationError:
    if isinstance(error, ImportError):
        raise error
    return unusable(library, error)
