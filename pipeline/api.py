"""What Python offers: a plane computed, and a stored plane opened."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from pipeline.config.compose import compose
from pipeline.config.places import Place
from pipeline.errors import ComputationError, ConfigurationError
from pipeline.multirun.index import read_index
from pipeline.multirun.opened_study import Study
from pipeline.opened_plane import OpenPlane
from pipeline.opened_volume import OpenVolume, opened_at
from pipeline.run.preparation import prepare, run_plane_stages
from pipeline.run.progress import SilentReporter
from pipeline.run.workforce import Workforce
from pipeline.store import store_path
from pipeline.store.zarr_library import check_zarr
from solver import ParameterError
from solver.model.checks import instance_of, instances_of

__all__ = ["OpenPlane", "OpenVolume", "Study", "compute", "open_plane", "open_study"]


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
) -> OpenPlane | OpenVolume:
    """Open a stored plane, or a volume, of which `layer(VALUE)` is one.

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
        If there is no such store, or this program cannot read it.
    ConfigurationError
        If zarr is set up in such a way that it would wait for ever, no store can be at such a URL, or a folder is given
        storage options.
    Unreachable
        If an object store does not answer, or refuses.
    solver.ParameterError
        If the name or the root is no path and no URL.
    """
    check_zarr()
    _check_options(storage_options)
    path, folder = (store_path(key, value, storage_options) for key, value in (("name", name), ("root", root)))
    if len(path.parts) == 1 and path.suffix != ".zarr":
        path = folder / f"{name}.zarr"
    return opened_at(_checked(path, storage_options))


def open_study(root: Place | str = "outputs/store", storage_options: Mapping | None = None) -> Study:
    """Open the planes that one command has computed, `python -m pipeline -m KEY=VALUE,VALUE`.

    Parameters
    ----------
    root : str or Path
        Folder of the stores, or its URL, which has the index `study.csv`.
    storage_options : mapping, optional
        As for `open_plane`.

    Returns
    -------
    Study
        With `planes`, `index`, `to_xarray()` and `to_datatree()`.

    Raises
    ------
    StoreError
        If there is no index, or it is none of this program's.
    ConfigurationError
        If zarr is set up in such a way that it would wait for ever, or a folder is given storage options.
    Unreachable
        If an object store does not answer, or refuses.
    solver.ParameterError
        If the root is no path and no URL.
    """
    check_zarr()
    _check_options(storage_options)
    return Study(read_index(_checked(store_path("root", root, storage_options), storage_options)))


def _check_options(storage_options: Mapping | None) -> None:
    if storage_options is not None and not isinstance(storage_options, Mapping):
        raise ParameterError("storage_options", type(storage_options), "a mapping")


def _checked(place: Place, storage_options: Mapping | None) -> Place:
    """A place, unless it is a folder that is given options."""
    if storage_options and isinstance(place, Path):
        raise ConfigurationError(f"storage_options are not allowed: {place} is a folder")
    return place
