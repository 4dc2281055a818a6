"""The group `attractors`: its arrays, rows of the solver as they are stored, and reading it."""

import dataclasses
import hashlib
import json
from typing import TYPE_CHECKING

import numpy as np

from pipeline import store
from pipeline.analysis.attractors.grid import Grid
from pipeline.analysis.attractors.wording import bound
from pipeline.config.places import Place
from pipeline.config.quantities import QUANTITIES
from pipeline.config.schema import Attractors
from pipeline.plan.numerics import System, model_at
from pipeline.plan.plan import Plan
from pipeline.plan.traits import contact_system
from pipeline.store.files import files_at
from pipeline.store.row_groups import RowArray, RowGroup
from pipeline.store.stored_arrays import open_group
from solver import ImpactState
from solver.model.contact_system import reduced
from solver.timedomain import AttractorKind, AttractorRow, SeenFrom

if TYPE_CHECKING:
    # It takes a third of a second to load, which who only computes need not wait for.
    import xarray

__all__ = [
    "GROUP",
    "NUMBERS",
    "added_group",
    "empty_values",
    "group_of",
    "read_attractors",
    "row_of_values",
    "slot_attributes",
    "state_size",
    "values_of_row",
]

GROUP = "attractors"
_NAN = float("nan")
#: Of every attractor of a cell: name -> what it is. The dynamic factor is called by the force that it tells of.
NUMBERS = {
    **{name if name != "dynamic_factor" else "force": one.title for name, one in QUANTITIES.items()},
    "lyapunov": "largest Lyapunov exponent per unit of dimensionless time",
    "lyapunov_error": "standard error of the largest Lyapunov exponent",
}


def state_size(system: System) -> int:
    """Numbers of a state: of the coordinates that are in motion, and of their speeds."""
    return 2 * reduced(contact_system(system)).degrees


def _largest_state(plan: Plan) -> int:
    """Room for a state: the most that any corner of the plane needs."""
    corners = (
        model_at(plan if plan.parameter2 is None else plan.layer(layer), row, column)
        for layer in ((0,) if plan.parameter2 is None else (0, plan.parameter2.num - 1))
        for row in (plan.parameter.low, plan.parameter.high)
        for column in (plan.sweep.low, plan.sweep.high)
    )
    return max(map(state_size, corners))


def slot_attributes() -> dict[str, tuple]:
    """What every attractor of a cell has: name -> type, value where there is none, attributes."""
    seen = {
        "flag_masks": [int(bit) for bit in SeenFrom],
        "flag_meanings": " ".join(bit.name.lower() for bit in SeenFrom),
    }
    kinds = {
        "flag_values": [int(kind) for kind in AttractorKind],
        "flag_meanings": " ".join(kind.label or "none" for kind in AttractorKind),
    }
    states = store.flags(ImpactState, [state.symbol for state in ImpactState])
    return {
        "kind": ("int8", 0, {"long_name": "kind of attractor", **kinds}),
        "impact": ("int8", -1, {"long_name": "impact state; -1: none", **states}),
        **{name: ("float64", _NAN, {"long_name": text, "units": "1"}) for name, text in NUMBERS.items()},
        "hits": ("int32", 0, {"long_name": "random starts that reached it", "units": "1"}),
        "seen": ("uint8", 0, {"long_name": "what led to it", **seen}),
    }


def group_of(path: Place, grid: Grid, options: Attractors, made_from: bytes) -> RowGroup:
    """The group of a store for these cells and settings.

    Parameters
    ----------
    path : Place
        The store.
    grid : Grid
    options : Attractors
    made_from : bytes
        Digest of what is read of the map.
    """
    plan, dims = grid.plan, grid.dims
    places = {
        axis.name: ((dim,), values, store.axis_attributes(axis.name))
        for axis, dim, values in (
            *(() if plan.parameter2 is None else ((plan.parameter2, dims[0], plan.parameter2.values),)),
            (plan.parameter, dims[-2], grid.p),
            (plan.sweep, dims[-1], grid.x),
        )
    }
    settings = _settings(options)
    text = json.dumps(
        {"numbers": plan.fingerprint, "rows": grid.rows, "columns": grid.columns, **settings}, sort_keys=True
    )
    attributes = {
        "configuration_hash": plan.fingerprint,
        "made_from": hashlib.sha256(text.encode() + made_from).hexdigest()[:16],
        "bound": bound(options.starts),
        **settings,
    }
    arrays = _arrays(grid)
    return RowGroup(path, GROUP, grid.blocks, dims[:-1], arrays, places, attributes)


def _settings(options: Attractors) -> dict:
    """The settings that the whole plane depends on."""
    told = dataclasses.asdict(options)
    names = ("starts", "seed", "max_periods", "tolerance", "delta")
    return {name: told[name] for name in names}


def _arrays(grid: Grid) -> dict[str, RowArray]:
    plan, column = grid.plan, grid.dims[-1]
    cells, room = len(grid.columns), grid.room

    def array(dims, sizes, dtype, fill, long_name, units=None, **more):
        told = {"long_name": long_name, **({"units": units} if units else {}), **more}
        return RowArray(dims, sizes, dtype, fill, told)

    def slot(dtype, fill, long_name, units=None, **more):
        return array((column, "attractor"), (cells, room), dtype, fill, long_name, units, **more)

    def cell(dtype, fill, long_name, units=None, **more):
        return array((column,), (cells,), dtype, fill, long_name, units, **more)

    attractors = slot_attributes().items()
    return {
        **{name: RowArray((column, "attractor"), (cells, room), *told) for name, told in attractors},
        "share": slot("float64", _NAN, "share of the random starts that reached it", "1"),
        "round": slot("int16", -1, "0: found from its own row; more: from a neighbouring row, in that round; -1: none"),
        "upwards": slot("int8", -1, "attractor of the next column that it leads to; -1: none"),
        "downwards": slot("int8", -1, "attractor of the previous column that it leads to; -1: none"),
        "state": array(
            (column, "attractor", "component"),
            (cells, room, _largest_state(plan)),
            "float64",
            _NAN,
            "coordinates, then their speeds, where the phase of the mesh frequency is 0",
            "1",
        ),
        "motion": array(
            (column, "solution"),
            (cells, plan.max_solutions),
            "int8",
            -1,
            "attractor that a stable motion of the map leads to; -1: none",
        ),
        "starts": cell("int32", 0, "random starts", "1"),
        "box": array(
            (column, "half_width"),
            (cells, 2),
            "float64",
            _NAN,
            "random starts lie within these half widths about 0: of the coordinates, of the speeds",
            "1",
        ),
        "size": cell("float64", _NAN, "gap and static deflection, of which the tolerance is a share", "1"),
        "overflow": cell(
            "int8", 0, "1: there are more attractors than room", flag_values=[0, 1], flag_meanings="no yes"
        ),
        "failures": cell("int32", 0, "starts that could not be integrated", "1"),
        "message": array((), (), "str", "", "why the row failed, else empty"),
        "rounds": array((), (), "int16", -1, "last round of the row; -1: it failed"),
    }


def empty_values(group: RowGroup) -> dict[str, np.ndarray]:
    """Name -> what is stored of a row of which nothing is known."""
    return {name: array.empty(1)[0, ...] for name, array in group.arrays.items()}


def values_of_row(group: RowGroup, row: AttractorRow, sizes: np.ndarray, rounds: int) -> dict[str, np.ndarray]:
    """Name -> what is stored of a row.

    Parameters
    ----------
    group : RowGroup
    row : AttractorRow
    sizes : (X,) array
        Gap and static deflection of every cell.
    rounds : int
        The last round that it has been through.
    """
    values = empty_values(group)
    for name in (*NUMBERS, "kind", "impact", "hits", "seen", "round", "upwards", "downwards"):
        values[name][...] = getattr(row, name)
    values["state"][..., : row.state.shape[-1]] = row.state
    values["motion"][:, : row.motion.shape[1]] = row.motion
    for name in ("starts", "box", "overflow", "failures"):
        values[name][...] = getattr(row, name)
    known = (row.kind != AttractorKind.NONE) & (row.starts > 0)[:, None]
    values["share"][known] = (row.hits / np.maximum(row.starts, 1)[:, None])[known]
    values["size"][...], values["rounds"][...] = sizes, rounds
    return values


def row_of_values(values: dict[str, np.ndarray], size: int) -> AttractorRow:
    """What is stored of a row, for the solver to go on with; states have `size` numbers."""
    parts = {one.name: np.array(values[one.name]) for one in dataclasses.fields(AttractorRow)}
    parts["state"] = np.ascontiguousarray(parts["state"][..., :size])
    parts["overflow"] = parts["overflow"].astype(bool)
    return AttractorRow(**parts)


def read_attractors(path: Place) -> "xarray.Dataset | None":
    """The group of a store; None if there is none. Its arrays are read when they are used."""
    return added_group(path, GROUP)


def added_group(path: Place, name: str) -> "xarray.Dataset | None":
    """A group that was added to a store; None if there is none. Its arrays are read when they are used."""
    if open_group(path, name) is None:
        return None
    import xarray

    return xarray.open_zarr(files_at(path).zarr(), group=name, chunks=None)
