"""Writing the template of a store: all metadata, no rows."""

import json
from collections.abc import Collection, Mapping
from datetime import UTC, datetime
from functools import cache
from importlib import metadata

from pipeline.config.places import Place
from pipeline.plan.plan import SCHEMA_VERSION, Plan
from pipeline.store.array_files import array_files
from pipeline.store.arrays import arrays_of, axes_in_store, layouts_of
from pipeline.store.attributes import axis_attributes
from pipeline.store.documents import content_of, document_of, gathering, group_document
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
    layouts, axes = layouts_of(plan), axes_in_store(plan)
    # A branch point's position is a coordinate; a plain variable would be hidden by the plane's axis of that name.
    # What the root says is kept twice: without it, nobody could tell what a damaged store holds.
    branches = group_document({"coordinates": plan.sweep.name, "plane": attributes})
    contents = {METADATA: content_of(group_document(attributes)), f"{ROWS}/{METADATA}": content_of(branches)}
    for name, axis in axes.items():
        contents |= array_files(layouts[name], axis_attributes(axis.name, plan.kind), axis.values)
    for name, spec in arrays_of(plan).items():
        contents |= array_files(layouts[name], spec["attributes"])
    return contents | {METADATA: _gathered(contents)}


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
    files = files.at_hand(names)
    files.write({METADATA: _gathered({name: files.read(name, there[name]) for name in names})})


def _gathered(contents: Mapping[str, bytes]) -> bytes:
    """What the root's file shall hold, from the metadata among the files of a store."""
    documents = {
        name.removesuffix(METADATA).rstrip("/"): document_of(content)
        for name, content in contents.items()
        if name.rpartition("/")[2] == METADATA
    }
    return content_of(gathering(documents.pop(""), documents))


@cache
def _versions() -> dict[str, str]:
    versions = {}
    for package in ("bevelmap", *_PACKAGES):
        try:
            versions[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            versions[package] = "not installed"
    return versions
