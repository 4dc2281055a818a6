"""The store of a plane: a zarr group whose template is written first and filled block by block.

Only the task that owns a block writes its chunks, `status` last, so that a block is either complete or computed again.
"""

import json
import shutil
import warnings
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path

import numpy as np
import zarr

from pipeline.errors import StoreError
from pipeline.plan import SCHEMA_VERSION, Block, Plan, numbers_digest, plan_of
from solver import EndReason, Event, ImpactState, Row, domain_labels
from solver.stability import Instability

__all__ = [
    "axis_attributes",
    "certified_rows",
    "check",
    "consolidate",
    "create",
    "failures",
    "flags",
    "label_flags",
    "pending_blocks",
    "read_numbers",
    "read_plan",
    "refuse_foreign",
    "rows_to_certify",
    "statuses",
    "write_block",
]

PENDING, COMPLETE, FAILED = 0, 1, 2

_PACKAGES = ("numpy", "scipy", "numba", "llvmlite", "zarr", "numcodecs", "xarray", "dask", "distributed")

_LONG_NAMES = {
    "omega": "dimensionless mesh frequency",
    "b": "half backlash",
    "alpha": "mesh stiffness variation",
    "alpha_phase": "phase of the mesh stiffness variation",
    "f_e": "transmission error amplitude",
    "f_e_phase": "phase of the transmission error",
    "f_pm": "mean load",
    "f_pv": "fluctuating load",
    "kappa": "mesh stiffness referred to the masses",
    "xi_mesh": "mesh damping ratio",
    "xi_translation": "mesh damping referred to the masses",
    "xi_support": "support damping ratio",
    "k_support": "support stiffness",
    "pitch_cone_angle": "pitch cone angle",
    "pressure_angle": "normal pressure angle",
    "translation_coupling": "translation coupling",
    "rotation_coupling": "rotation coupling",
    "variation_translation": "share of the stiffness variation in the translation rows",
    "variation_rotation": "share of the stiffness variation in the mesh row",
    "temperature": "temperature difference between gears and housing",
}
_UNITS = {
    "alpha_phase": "rad", "f_e_phase": "rad", "pitch_cone_angle": "degree", "pressure_angle": "degree",
    "temperature": "K",
}  # fmt: skip


def flags(members, labels=None) -> dict:
    """CF attributes of an enumeration."""
    return {
        "flag_values": [int(member) for member in members],
        "flag_meanings": " ".join(member.name.lower() for member in members),
        **({"labels": labels} if labels else {}),
    }


def _arrays(plan: Plan) -> dict[str, dict]:
    """Every array that has rows: name -> dims, dtype, fill value and attributes. `status` comes last."""
    row, column = plan.parameter.name, plan.sweep.name
    labels = domain_labels(plan.max_solutions)
    cell, solution, point = (row, column), (row, column, "solution"), (row, "point")
    states = flags(ImpactState, [state.symbol for state in ImpactState])

    def spec(dims, dtype, fill, long_name, units="1", **attributes):
        return {
            "dims": dims,
            "dtype": dtype,
            "fill": fill,
            "attributes": {"long_name": long_name, **({"units": units} if units else {}), **attributes},
        }

    nan = float("nan")
    certified = spec(cell, "int8", 0, "1: the solutions are proven to be all of them", None,
                     flag_values=[0, 1], flag_meanings="undecided proven")  # fmt: skip
    return {
        "n_solutions": spec(cell, "uint8", 255, "number of periodic solutions; 255: not computed"),
        "n_stable": spec(cell, "uint8", 255, "number of statically stable solutions; 255: not computed"),
        "domain": spec(
            cell, "uint16", 0, "n/I label of the solution domain; 0: not computed", None,
            **label_flags(labels),
        ),
        "mean": spec(solution, "float64", nan, "mean of the mesh displacement"),
        "amplitude": spec(solution, "float64", nan, "amplitude of the fundamental of the mesh displacement"),
        "phase": spec(solution, "float64", nan, "phase of the fundamental of the mesh displacement", "rad"),
        "stable": spec(solution, "int8", -1, "static stability; -1: no such solution", None,
                       flag_values=[-1, 0, 1], flag_meanings="no_solution unstable stable"),
        "impact": spec(solution, "int8", -1, "impact state; -1: no such solution", None, **states),
        "instability": spec(solution, "int8", -1, "dynamic stability: how the motion is unstable; -1: no such solution",
                            None, **flags(Instability)),
        "multiplier": spec(solution, "float64", nan, "largest modulus of the multipliers"),
        **(_order_h_arrays(spec, solution, point) if plan.solver["balance"] == "galerkin" else {}),
        "open": spec(cell, "int8", 0, "1: solutions above the amplitude ceiling are not excluded", None,
                     flag_values=[0, 1], flag_meanings="closed open"),
        **({"certified": certified} if plan.solver["certify"] == "all" else {}),
        "branches/n_folds": spec((row,), "int16", -1, "folds of the branches found without looking at the columns"),
        "branches/n_gained": spec((row,), "int16", -1, "branches that only the columns brought; -1: not looked at"),
        "branches/n_points": spec((row,), "int32", 0, "number of branch points"),
        f"branches/{column}": spec(point, "float64", nan, _LONG_NAMES[column], _UNITS.get(column, "1")),
        "branches/mean": spec(point, "float64", nan, "mean of the mesh displacement"),
        "branches/cos": spec(point, "float64", nan, "cosine amplitude of the mesh displacement"),
        "branches/sin": spec(point, "float64", nan, "sine amplitude of the mesh displacement"),
        "branches/amplitude": spec(point, "float64", nan, "amplitude of the fundamental of the mesh displacement"),
        "branches/arclength": spec(point, "float64", nan, "arc length along the branch, in scaled unknowns"),
        "branches/stable": spec(point, "int8", -1, "static stability; -1: no point", None,
                                flag_values=[-1, 0, 1], flag_meanings="no_point unstable stable"),
        "branches/impact": spec(point, "int8", -1, "impact state; -1: no point", None, **states),
        "branches/branch": spec(point, "int16", -1, "which connected curve the point belongs to; -1: no point"),
        "branches/event": spec(point, "int8", -1, "what is special about the point; -1: no point", None,
                               **flags(Event)),
        "branches/end_reason": spec((row, "branch_number", "end"), "int8", 0, "why the branch ends; 0: no such branch",
                                    None, **flags(EndReason)),
        "message": spec((row,), "str", "", "why the row failed, else empty", None),
        "status": spec((row,), "uint8", PENDING, "state of the row", None,
                       flag_values=[PENDING, COMPLETE, FAILED], flag_meanings="pending complete failed"),
    }  # fmt: skip


def _order_h_arrays(spec, solution: tuple[str, ...], point: tuple[str, ...]) -> dict[str, dict]:
    """What only a balance of order H has."""
    nan = float("nan")
    harmonics = "mean of the mesh displacement, then cosine and sine amplitude of each harmonic of the base frequency"
    return {
        "lowest": spec(solution, "float64", nan, "lowest mesh displacement over the period"),
        "highest": spec(solution, "float64", nan, "highest mesh displacement over the period"),
        "motion": spec((*solution, "component"), "float64", nan, harmonics),
        "branches/motion": spec((*point, "component"), "float64", nan, harmonics),
    }  # fmt: skip


def label_flags(labels: dict[int, str]) -> dict:
    """CF attributes of codes of n/I labels; 0 is "not computed"."""
    return {
        "flag_values": [0, *labels],
        "flag_meanings": " ".join(["not_computed", *(_meaning(label) for label in labels.values())]),
        "labels": ["", *labels.values()],
    }


def _meaning(label: str) -> str:
    """An n/I label in the alphabet of CF flag meanings: 2/0-1 -> n2_I0-1."""
    n, states = label.split("/")
    return f"n{n}" if states == "-" else f"n{n}_I{states}"


def axis_attributes(name: str) -> dict:
    """Name and unit of a parameter."""
    return {"long_name": _LONG_NAMES[name], "units": _UNITS.get(name, "1")}


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
    path.parent.mkdir(parents=True, exist_ok=True)
    draft = path.with_name(f".{path.name}.template")
    shutil.rmtree(draft, ignore_errors=True)
    row, column = plan.parameter, plan.sweep
    root = zarr.create_group(
        draft,
        zarr_format=3,
        attributes={
            "Conventions": "CF-1.11",
            "title": f"Solution domain {name}: {column.name} x {row.name}",
            "bevelmap_schema": SCHEMA_VERSION,
            "configuration": configuration,
            "numbers": json.dumps(plan.numbers, sort_keys=True),
            "configuration_hash": plan.digest,
            "versions": _versions(),
            "created": datetime.now(UTC).isoformat(timespec="seconds"),
        },
    )
    # A branch point's position is a coordinate; as a plain variable it would be hidden by the plane's axis of that name.
    root.create_group("branches", attributes={"coordinates": column.name})
    for place in (row.name, column.name, f"branches/{row.name}"):
        axis = column if place == column.name else row
        root.create_array(
            place, data=axis.values, dimension_names=[axis.name], attributes=axis_attributes(axis.name)
        )
    sizes = {
        row.name: row.num, column.name: column.num, "solution": plan.max_solutions, "point": plan.max_points,
        "branch_number": plan.max_branches, "end": 2,
        "component": 2 * plan.solver["order"] * plan.solver["period"] + 1,
    }  # fmt: skip
    for array, spec in _arrays(plan).items():
        shape = tuple(sizes[dim] for dim in spec["dims"])
        root.create_array(
            array, shape=shape, chunks=(plan.rows_per_block, *shape[1:]), dtype=spec["dtype"],
            fill_value=spec["fill"], dimension_names=list(spec["dims"]), attributes=spec["attributes"],
        )  # fmt: skip
    consolidate(draft)
    draft.rename(path)


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


def read_numbers(path: Path) -> dict:
    """What the numbers of an existing store depend on.

    Raises
    ------
    StoreError
        If there is no store, or it is not one of ours or of this version.
    """
    if not path.exists():
        raise StoreError(f"there is no store at {path}")
    try:
        attributes = dict(zarr.open_group(path, mode="r").attrs)
        version = attributes["bevelmap_schema"]
        numbers = json.loads(attributes["numbers"])
    except (OSError, KeyError, ValueError, zarr.errors.GroupNotFoundError, zarr.errors.NodeTypeValidationError):
        raise StoreError(f"{path} is not allowed: it is something else than a store of this program") from None
    if version != SCHEMA_VERSION:
        raise StoreError(f"{path} has schema version {version}, this program writes {SCHEMA_VERSION}: use another name")
    return numbers


def read_plan(path: Path) -> Plan:
    """The plan of an existing store; raises StoreError as `read_numbers` does."""
    return plan_of(read_numbers(path))


def check(path: Path, plan: Plan) -> bool:
    """Whether a store for exactly this plan exists.

    Raises
    ------
    StoreError
        If something else is there, with the difference and the ways on.
    """
    if not path.exists():
        return False
    stored = read_numbers(path)
    if numbers_digest(stored) == plan.digest:
        return True
    old, new = _flatten(stored), _flatten(plan.numbers)
    keys = [key for key in sorted(old.keys() | new.keys()) if old.get(key) != new.get(key)]
    changes = "; ".join(f"{key}: stored {old.get(key, 'nothing')}, asked {new.get(key, 'nothing')}" for key in keys)
    raise StoreError(
        f"{path} holds another configuration ({changes}): take another store.name=..., or store.overwrite=true"
    )


def refuse_foreign(path: Path) -> None:
    """Raise unless the path is free or holds a store of ours, so that overwriting never deletes anything else."""
    if path.exists():
        read_numbers(path)


def _flatten(value, prefix="") -> dict[str, object]:
    if not isinstance(value, dict):
        return {prefix: value}
    return {k: v for key, child in value.items() for k, v in _flatten(child, f"{prefix}.{key}".lstrip(".")).items()}


def statuses(path: Path) -> np.ndarray:
    """State of every row."""
    return zarr.open_group(path, mode="r")["status"][:]


def pending_blocks(path: Path, plan: Plan) -> list[Block]:
    """Blocks with a row that is not complete; each is computed again as a whole, failed rows included."""
    status = statuses(path)
    return [block for block in plan.blocks if np.any(status[block.start : block.stop] != COMPLETE)]


def rows_to_certify(path: Path) -> np.ndarray:
    """Rows next to which something comes or goes that the rows' own seeds may have missed, and not yet looked at everywhere.

    A row is one if the folds found from its evenly spaced seeds differ in number from a neighbour's, or if looking
    everywhere brought a neighbour a new branch. Looking at them everywhere can only add rows, and the order does not
    matter, so that a run that was interrupted arrives at the same store.
    """
    root = zarr.open_group(path, mode="r")
    complete = root["status"][:] == COMPLETE
    folds, gained = root["branches/n_folds"][:], root["branches/n_gained"][:]
    step = (np.diff(folds) != 0) & complete[1:] & complete[:-1]
    wanted = np.zeros(folds.size, dtype=bool)
    wanted[1:] |= step | (gained[:-1] > 0)
    wanted[:-1] |= step | (gained[1:] > 0)
    return np.flatnonzero(wanted & complete & (gained < 0))


def certified_rows(path: Path) -> np.ndarray:
    """Rows in which every column was looked at."""
    return np.flatnonzero(zarr.open_group(path, mode="r")["branches/n_gained"][:] >= 0)


def failures(path: Path) -> list[tuple[int, str]]:
    """Failed rows and their reasons."""
    root = zarr.open_group(path, mode="r")
    rows = np.flatnonzero(root["status"][:] == FAILED)
    messages = root["message"][:] if rows.size else []
    return [(int(row), str(messages[row])) for row in rows]


def write_block(path: str, plan: Plan, block: Block, rows: list[Row | str]) -> None:
    """Write one block; a row given as text has failed for that reason.

    Parameters
    ----------
    path : str
        A store whose template matches the plan.
    plan : Plan
    block : Block
    rows : list of Row or str
        One per row of the block.
    """
    root = zarr.open_group(path, mode="r+")
    count = block.stop - block.start
    specs = _arrays(plan)
    values = {}
    for name, spec in specs.items():
        shape = root[name].shape[1:]
        if spec["dtype"] == "str":
            values[name] = np.full(count, "", dtype=object)
        else:
            values[name] = np.full((count, *shape), spec["fill"], dtype=spec["dtype"])
    for i, row in enumerate(rows):
        if isinstance(row, str):
            values["message"][i], values["status"][i] = row, FAILED
        else:
            _fill_raster(values, i, row)
            _fill_branches(values, i, row, plan.sweep.name)
            values["status"][i] = COMPLETE
    # A block that is written again is not complete until it is whole again.
    root["status"][block.start : block.stop] = PENDING
    for name, value in values.items():
        root[name][block.start : block.stop] = value


def _fill_raster(values: dict, i: int, row: Row) -> None:
    found = slice(row.mean.shape[1])
    for name in ("n_solutions", "n_stable", "domain", "open", "certified"):
        if name in values:
            values[name][i] = getattr(row, name)
    for name in ("mean", "amplitude", "phase", "stable", "impact", "instability", "multiplier"):
        values[name][i, :, found] = getattr(row, name)
    if "motion" in values:
        values["motion"][i, :, found] = row.motions
        values["lowest"][i, :, found], values["highest"][i, :, found] = row.extremes


def _fill_branches(values: dict, i: int, row: Row, axis: str) -> None:
    start = 0
    for number, curve in enumerate(row.curves):
        here = slice(start, start + len(curve.points))
        mean, cos, sin = row.branch_motions(curve)
        for name, value in (("mean", mean), ("cos", cos), ("sin", sin), (axis, curve.points[:, -1])):
            values[f"branches/{name}"][i, here] = value
        values["branches/amplitude"][i, here] = np.hypot(cos, sin)
        if "branches/motion" in values:
            values["branches/motion"][i, here] = curve.points[:, :-1]
        values["branches/arclength"][i, here] = curve.arclength
        values["branches/stable"][i, here] = curve.stable
        values["branches/impact"][i, here] = row.branch_impact(curve)
        values["branches/branch"][i, here] = number
        values["branches/event"][i, here] = curve.event
        values["branches/end_reason"][i, number] = curve.ends
        start = here.stop
    values["branches/n_points"][i] = start
    values["branches/n_folds"][i], values["branches/n_gained"][i] = row.n_folds, row.n_gained
