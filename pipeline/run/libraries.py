"""Settings of libraries that come from files and environment variables of the user, and have nothing to do here."""

import contextlib
import os
from collections.abc import Iterator

from pipeline.errors import unusable

__all__ = ["drawing_into_files", "load_dask", "with_own_dask"]


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
        if isinstance(error, ImportError):
            raise
        raise unusable("dask", error) from None


@contextlib.contextmanager
def with_own_dask() -> Iterator[None]:
    """Dask with its own defaults for everything: what is started here belongs to this program alone."""
    import dask
    import distributed  # noqa: F401  (its defaults are known once it is imported)

    with dask.config.set(dask.config.merge(*dask.config.defaults)):
        yield


@contextlib.contextmanager
def drawing_into_files() -> Iterator[None]:
    """Matplotlib, if it is loaded within, knows of no display: MPLBACKEND may name one that is not there."""
    backend = os.environ.pop("MPLBACKEND", None)
    try:
        yield
    finally:
        if backend is not None:
            os.environ["MPLBACKEND"] = backend
