"""Regions of equal n/I label in a stored plane: shares and thresholds from the boundary curves, not from the raster."""

import numpy as np

from pipeline.config.places import Place
from pipeline.errors import StoreError
from pipeline.plan.numerics import continuation_of, frame_of
from pipeline.plane.stored import StoredPlane, read_stored
from pipeline.store import store_path
from solver import Event, ParameterError, label_parts
from solver.boundaries import FOLDS_AND_GRAZINGS, BoundaryCurve, boundary_curves
from solver.model.checks import value_range
from solver.regions.regions import Occurrence, RegionError, Regions, regions

__all__ = ["stored_curves", "stored_regions", "thresholds", "thresholds_of"]


def thresholds(
    path: Place | str, label: str | None = None, window: tuple[float, float] | None = None
) -> tuple[Occurrence, ...]:
    """Where in the row parameter the labels of a stored plane appear and disappear, and their shares of the area.

    Parameters
    ----------
    path : Place or str
        The store of a plane that was swept.
    label : str, optional
        For example "2/0-1"; all labels unless given.
    window : (low, high), optional
        Only this part of the swept axis counts, for example that of one resonance.

    Returns
    -------
    tuple of Occurrence
        With `label`, `appears`, `disappears` and `share`: one for every unbroken range of the row parameter, by
        label and ascending. The shares of all labels add up to 1.

    Raises
    ------
    StoreError
        If there is no such store, it has no complete row, its boundaries do not divide it, or the window is not inside
        the plane.
    solver.ParameterError
        If the path is none, the label is no n/I label, or the window is no range.

    Examples
    --------
    Between which backlashes can the published gear, at its mesh-frequency resonance, run smoothly or strike both
    flanks?

    >>> import tempfile, pipeline
    >>> from pathlib import Path
    >>> from pipeline import store
    >>> from pipeline.config.compose import compose
    >>> from pipeline.plan.planning import plan
    >>> from pipeline.run.rows import sweep_block
    >>> swept = plan(compose(["plane=omega_b", "plane.sweep.num=40", "plane.parameter.num=15"]))
    >>> folder = tempfile.TemporaryDirectory()
    >>> path = Path(folder.name) / "omega_b.zarr"
    >>> store.create(path, swept, "omega_b", "")
    >>> for block in swept.blocks:
    ...     _ = sweep_block(str(path), swept, block)
    >>> for found in pipeline.thresholds(path, "2/0-2", window=(0.05, 0.9)):
    ...     print(f"b = {found.appears:.6f} to {found.disappears:.6f}: {found.share:.4%} of the window")
    b = 0.082305 to 1.010830: 2.0645% of the window
    >>> folder.cleanup()
    """
    path = store_path("path", path)
    return thresholds_of(read_stored(path), label, window)


def thresholds_of(
    plane: StoredPlane, label: str | None = None, window: tuple[float, float] | None = None
) -> tuple[Occurrence, ...]:
    """`thresholds` of an opened plane, which may be a layer of a volume."""
    if label is not None:
        label_parts(label)
    if window is not None:
        window = value_range("window", window)
    try:
        part = _regions_of(plane) if window is None else _regions_of(plane).within(window)
        wanted = [name for name in part.labels if label in (None, name)]
        return tuple(one for name in wanted for one in part.occurrences(name))
    except RegionError as error:
        raise StoreError(f"{plane.path} has no regions of one label: {error}") from error
    except ParameterError as error:
        raise StoreError(f"{plane.path}: {error}") from error


def stored_regions(path: Place) -> Regions:
    """The regions of a stored plane.

    Raises
    ------
    StoreError
        If there is no such store, or it has no complete row.
    RegionError
        If the boundaries do not divide the plane.
    """
    return _regions_of(read_stored(path))


def _regions_of(plane: StoredPlane) -> Regions:
    plan = plane.plan
    if plan.parameter2 is not None:
        raise StoreError(f"{plane.path} is a volume: open_plane(...).layer(VALUE) is the plane of a layer")
    return regions(
        *frame_of(plan), stored_curves(plane), omega=plan.omega, amplitude_max=float(plan.solver["amplitude_max"])
    )


def stored_curves(plane: StoredPlane) -> tuple[BoundaryCurve, ...]:
    """All boundaries on which the events of the stored branches lie."""
    plan = plane.plan
    if not np.any(plane.complete):
        raise StoreError(f"{plane.path} has no complete row: run stages=[sweep] first")
    starts = [start for part in plane.parts for start in _starts(part)]
    return boundary_curves(*frame_of(plan), starts, omega=plan.omega, continuation=continuation_of(plan.solver))


def _starts(part: StoredPlane) -> list[tuple[Event, np.ndarray]]:
    """The folds and grazings of some rows: kind, and lambda_m, lambda_c, lambda_s, x, p."""
    events = part.along("event")
    rows, points = np.nonzero(np.isin(events, FOLDS_AND_GRAZINGS) & part.complete[:, None])
    columns = [part.along(name)[rows, points] for name in ("mean", "cos", "sin", part.plan.sweep.name)]
    places = np.column_stack([*columns, part.rows[rows]])
    return list(zip(map(Event, events[rows, points].tolist()), places, strict=True))
