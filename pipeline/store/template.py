"""Writing the template of a store: all metadata, no rows."""

import json
import warnings
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path

import zarr

from pipeline.plan.plan import SCHEMA_VERSION, Plan
from pipeline.store.arrays import arrays_of
from pipeline.store.attributes import axis_attributes
from pipeline.store.codecs import COMPRESSORS
from pipeline.store.removal import remove
from pipeline.store.seal import sealed

__all__ = ["consolidate", "create", "create_again", "sizes_of"]

_PACKAGES = ("numpy", "scipy", "numba", "llvmlite", "zarr", "numcodecs", "xarray", "dask", "distributed")


def create(path: Path, plan: Plan, name: str, configuration: str) -> None:
    """Write the template: all metadata, no rows. It appears under its name only when it is whole.

    Parameters
    ----------
    path : Path
        Where the store shall be; must not exist.
    plan : Plan
    name : str
        Of the store, for its title.
    configuration : str
        The resolved configuration in YAML.
    """
    create_again(
        path,
        plan,
        sealed(
            {
                "Conventions": "CF-1.11",
                "title": f"Solution domain {name}: {' x '.join(axis.name for axis in plan.axes)}",
                "bevelmap_schema": SCHEMA_VERSION,
                "configuration": configuration,
                "numbers": json.dumps(plan.numbers, sort_keys=True),
                "configuration_hash": plan.digest,
                "versions": _versions(),
                "created": datetime.now(UTC).isoformat(timespec="seconds"),
            }
        ),
    )


def create_again(path: Path, plan: Plan, attributes: dict) -> None:
    """Write the template with the attributes that a store of this plan has already; see `create`."""
    path.parent.mkdir(parents=True, exist_ok=True)
    draft = path.with_name(f".{path.name}.template")
    remove(draft)
    column = plan.sweep
    root = zarr.create_group(draft, zarr_format=3, attributes=attributes)
    # A branch point's position is a coordinate; a plain variable would be hidden by the plane's axis of that name.
    # What the root says is kept twice: without it, nobody could tell what a damaged store holds.
    root.create_group("branches", attributes={"coordinates": column.name, "plane": attributes})
    places = {axis.name: axis for axis in plan.axes} | {f"branches/{axis.name}": axis for axis in plan.row_axes}
    for place, axis in places.items():
        root.create_array(
            place,
            data=axis.values,
            chunks=(axis.num,),
            dimension_names=[axis.name],
            compressors=COMPRESSORS,
            attributes=axis_attributes(axis.name),
        )
    sizes = sizes_of(plan)
    # A chunk holds rows of one layer.
    along_rows = (1,) * (len(plan.row_axes) - 1) + (plan.rows_per_block,)
    for array, spec in arrays_of(plan).items():
        shape = tuple(sizes[dim] for dim in spec["dims"])
        root.create_array(
            array,
            shape=shape,
            chunks=(*along_rows, *shape[len(along_rows) :]),
            dtype=spec["dtype"],
            compressors=COMPRESSORS,
            fill_value=spec["fill"],
            dimension_names=list(spec["dims"]),
            attributes=spec["attributes"],
        )
    consolidate(draft)
    draft.rename(path)


def sizes_of(plan: Plan) -> dict[str, int]:
    """Size of every dimension of the plane's own arrays."""
    return {
        **{axis.name: axis.num for axis in plan.axes},
        "solution": plan.max_solutions,
        "point": plan.max_points,
        "branch_number": plan.max_branches,
        "end": 2,
        "component": 2 * plan.solver["order"] * plan.solver["period"] + 1,
    }


def consolidate(path: Path) -> None:
    """Gather the metadata of all arrays in one file, which makes opening fast."""
    with warnings.catch_warnings():
        # zarr warns that consolidated metadata is not yet part of the format's third version; xarray reads it.
        warnings.filterwarnings("ignore", message="Consolidated metadata", category=UserWarning)
        zarr.consolidate_metadata(path)


def _versions() -> dict[str, str]:
    versions = {}
    for package in ("bevelmap", *_PACKAGES):
        try:
            versions[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            versions[package] = "not installed"
    return versions
