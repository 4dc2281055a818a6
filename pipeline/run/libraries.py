"""Settings of libraries that come from files and environment variables of the user, and have nothing to do here."""

import contextlib
import os
import sys
import traceback
from collections.abc import Iterator

from pipeline.errors import ConfigurationError, unusable

__all__ = ["drawing_into_files", "failed_import", "load_dask", "with_own_dask"]


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
