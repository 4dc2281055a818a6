"""What Python offers: a plane computed, and a stored plane opened."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import xarray as xr

from pipeline.config.compose import compose
from pipeline.config.places import Place
from pipeline.errors import ComputationError, ConfigurationError, StoreError
from pipeline.opened_plane import OpenPlane
from pipeline.plane.stored import read_stored
from pipeline.run.libraries import check_zarr
from pipeline.run.preparation import prepare, run_plane_stages
from pipeline.run.progress import SilentReporter
from pipeline.run.workforce import Workforce
from pipeline.store import store_path
from pipeline.store.files import files_at
from solver import ParameterError
from solver.model.checks import instance_of, instances_of

__all__ = ["OpenPlane", "compute", "open_plane"]


def compute(
    plane: str, overrides: Sequence[str] = (), config_dir: Path | str | None = None, progress: bool | None = None
) -> OpenPlane:
    """Compute a plane with its boundaries, as `python -m pipeline plane=NAME` does, and open it.

    What its store has already is kept, so that calling it again only opens the plane.

    Parameters
    ----------
    plane : str
        Name of a plane, such as "omega_fe", or of a file in `config_dir`/plane.
    overrides : sequence of str
        As on the command line: `["gear.b=0.5", "quality=draft", "cluster.workers=4"]`. `stages=[...]` replaces the
        sweep and the boundaries.
    config_dir : Path or str, optional
        A folder with files of one's own for gears, planes, ...
    progress : bool, optional
        Whether to draw a bar; in a notebook and on a terminal unless told.

    Returns
    -------
    OpenPlane

    Raises
    ------
    ConfigurationError
        If the configuration is not allowed, or names a store that was made with another; nothing is written then.
    ComputationError
        If rows or boundaries could not be computed. What could is stored, and `open_plane` opens it.
    solver.ParameterError
        If an argument is of the wrong type.

    Examples
    --------
    >>> import pipeline
    >>> plane = pipeline.compute("omega_fe", ["gear.b=0.5", "quality=draft"])  # doctest: +SKIP
    >>> plane.plot.map()  # doctest: +SKIP
    """
    check_zarr()
    if not isinstance(plane, str) or not plane:
        raise ParameterError("plane", plane, "the name of a plane")
    overrides = instances_of("overrides", overrides, str)
    if config_dir is not None:
        config_dir = store_path("config_dir", config_dir)
    if progress is not None:
        instance_of("progress", progress, bool)
    if not any(override.startswith("stages=") for override in overrides):
        overrides = [*overrides, "stages=[sweep,boundaries]"]
    settings = compose([f"plane={plane}", *overrides], None if config_dir is None else str(config_dir))
    job, reporter = prepare(settings), SilentReporter(progress)
    with Workforce(settings.config.cluster, reporter.note) as workforce:
        status = run_plane_stages(job, workforce, reporter)
    if status:
        raise ComputationError("; ".join(reporter.errors) or f"some rows of {job.store_path} failed")
    return open_plane(job.store_path)


def open_plane(
    name: Place | str, root: Place | str = "outputs/store", storage_options: Mapping | None = None
) -> OpenPlane:
    """Open a stored plane.

    Parameters
    ----------
    name : str or Path
        Name of the store, such as "omega_fe", or a path to it, or its URL.
    root : str or Path
        Folder of the stores, or its URL, for names.
    storage_options : mapping, optional
        For a URL: as `store.storage_options`.

    Raises
    ------
    StoreError
        If there is no such store, it is a volume, or this program cannot read it.
    ConfigurationError
        If zarr is set up in such a way that it would wait for ever, no store can be at such a URL, or a folder is given
        storage options.
    Unreachable
        If an object store does not answer, or refuses.
    solver.ParameterError
        If the name or the root is no path and no URL.
    """
    check_zarr()
    if storage_options is not None and not isinstance(storage_options, Mapping):
        raise ParameterError("storage_options", type(storage_options), "a mapping")
    path, folder = (store_path(key, value, storage_options) for key, value in (("name", name), ("root", root)))
    if len(path.parts) == 1 and path.suffix != ".zarr":
        path = folder / f"{name}.zarr"
    if storage_options and isinstance(path, Path):
        raise ConfigurationError(f"storage_options are not allowed: {path} is a folder")
    stored = read_stored(path)
    if stored.plan.parameter2 is not None:
        raise StoreError(f"{path} is a volume: plane.layer=VALUE takes out the plane of one layer, which can be opened")
    return OpenPlane(stored, xr.open_datatree(files_at(path).zarr(), engine="zarr"))
