"""Zarr, which only xarray reads stores with; what is stored is written, checked and read here without it.

A store is read in the same way whatever configuration files and variables say of zarr. It waits for ever with a
concurrency of 0, for one.
"""

import sys

from pipeline.errors import ConfigurationError, unusable

__all__ = ["check_assertions", "check_zarr", "load_zarr"]


def load_zarr() -> None:
    """Import zarr with its own defaults for everything, unless this process has it already.

    Raises
    ------
    ConfigurationError
        If its configuration files cannot be read: it does so when it is imported.
    """
    if "zarr" in sys.modules:
        # A user's own process, which `check_zarr` has looked at.
        return
    try:
        import zarr

        zarr.config.refresh(paths=[], env={})
    except ImportError:
        raise
    except Exception as error:
        raise unusable("zarr", error) from None


def check_assertions() -> None:
    """Raise ConfigurationError if Python leaves out assertions, without which zarr reads nothing."""
    if sys.flags.optimize:
        raise ConfigurationError("python -O (PYTHONOPTIMIZE) is not allowed: zarr does not work with it; leave it out")


def check_zarr() -> None:
    """Leave zarr's settings as they are in a process that is the user's own, if it can be used with them.

    Raises
    ------
    ConfigurationError
        If it would wait for ever, or as `check_assertions`.
    """
    check_assertions()
    import zarr

    concurrency = zarr.config.get("async.concurrency", None)
    if concurrency is not None and not (isinstance(concurrency, int) and concurrency >= 1):
        raise ConfigurationError(
            f"async.concurrency = {concurrency!r} of zarr's configuration (ZARR_ASYNC__CONCURRENCY) is not allowed: "
            "it must be a whole number from 1 on"
        )
