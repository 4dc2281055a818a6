"""Writing the template of a store: all metadata, no rows."""

import json
import warnings
from collections.abc import Collection
from datetime import UTC, datetime
from functools import cache
from importlib import metadata

import zarr
from zarr.core.buffer import Buffer, default_buffer_prototype
from zarr.storage import MemoryStore

from pipeline.config.places import Place
from pipeline.plan.plan import SCHEMA_VERSION, Plan
from pipeline.store.arrays import arrays_of, axes_in_store, layouts_of
from pipeline.store.attributes import axis_attributes
from pipeline.store.codecs import COMPRESSORS
from pipeline.store.files import files_at
from pipeline.store.names import ADDED, METADATA, ROWS
from pipeline.store.seal import sealed

__all__ = ["consolidate", "create", "template_files"]

_PACKAGES = ("numpy", "scipy", "numba", "llvmlite", "zarr", "numcodecs", "xarray", "dask", "distributed")


def create(path: Place, plan: Plan, name: str, configuration: str) -> None:
    """Write the template: all metadata, no rows. It appears under its name only when it is whole.

    Parameters
    ----------
    path : Place
        Where the store shall be; must not exist.
    plan : Plan
    name : str
        Of the store, for its title.
    configuration : str
        The resolved configuration in YAML.
    """
    attributes = sealed(
        {
            "Conventions": "CF-1.11",
            "title": f"Solution domain {name}: {' x '.join(axis.name for axis in plan.axes)}",
            "bevelmap_schema": SCHEMA_VERSION,
            "configuration": configuration,
            "numbers": json.dumps(plan.inputs, sort_keys=True),
            "configuration_hash": plan.fingerprint,
            "versions": _versions(),
            "created": datetime.now(UTC).isoformat(timespec="seconds"),
        }
    )
    files_at(path).appear(template_files(plan, attributes))


def template_files(plan: Plan, attributes: dict) -> dict[str, bytes]:
    """What the files of a store hold that has no rows.

    Parameters
    ----------
    plan : Plan
    attributes : dict
        What its root says of it, sealed.

    Returns
    -------
    dict
        Name in the store -> content.
    """
    files = {}
    root = zarr.create_group(MemoryStore(files), zarr_format=3, attributes=attributes)
    # A branch point's position is a coordinate; a plain variable would be hidden by the plane's axis of that name.
    # What the root says is kept twice: without it, nobody could tell what a damaged store holds.
    root.create_group(ROWS, attributes={"coordinates": plan.sweep.name, "plane": attributes})
    layouts = layouts_of(plan)
    for name, axis in axes_in_store(plan).items():
        root.create_array(
            name,
            data=axis.values,
            chunks=layouts[name].chunks,
            dimension_names=layouts[name].dims,
            compressors=COMPRESSORS,
            attributes=axis_attributes(axis.name, plan.kind),
        )
    for name, spec in arrays_of(plan).items():
        root.create_array(
            name,
            shape=layouts[name].shape,
            chunks=layouts[name].chunks,
            dtype=spec["dtype"],
            compressors=COMPRESSORS,
            fill_value=spec["fill"],
            dimension_names=layouts[name].dims,
            attributes=spec["attributes"],
        )
    return _consolidated(files)


def consolidate(path: Place, without: Collection[str] = ()) -> None:
    """Gather the metadata of all arrays in one file, by which a store is opened: what it does not list is not there.

    Parameters
    ----------
    path : Place
    without : collection of str
        Groups that are about to be taken away. What has no metadata of its own is left out as well: it is half made.
    """
    files = files_at(path)
    there = files.sizes()
    names = [name for name in there if name.rpartition("/")[2] == METADATA]
    gone = {group for group in ADDED if group in without or f"{group}/{METADATA}" not in there}
    names = [name for name in names if name.partition("/")[0] not in gone]
    files, buffer = files.at_hand(names), default_buffer_prototype().buffer
    documents = {name: buffer.from_bytes(files.read(name, there[name])) for name in names}
    files.write({METADATA: _consolidated(documents)[METADATA]})


def _consolidated(files: dict[str, Buffer]) -> dict[str, bytes]:
    """Files by their names in a store, the metadata of all gathered in the root's."""
    with warnings.catch_warnings():
        # zarr warns that consolidated metadata is not yet part of the format's third version; xarray reads it.
        warnings.filterwarnings("ignore", message="Consolidated metadata", category=UserWarning)
        zarr.consolidate_metadata(MemoryStore(files))
    return {name: content.to_bytes() for name, content in files.items()}


@cache
def _versions() -> dict[str, str]:
    versions = {}
    for package in ("bevelmap", *_PACKAGES):
        try:
            versions[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            versions[package] = "not installed"
    return versions
