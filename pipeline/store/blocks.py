"""Writing one block of rows, the only writer of its chunks."""

import numpy as np
import zarr

from pipeline.errors import StoreError
from pipeline.plan.plan import Block, Plan
from pipeline.store.arrays import arrays_of
from pipeline.store.codecs import every_chunk
from pipeline.store.states import COMPLETE, FAILED, PENDING
from solver import Row

__all__ = ["write_block"]


def write_block(path: str, plan: Plan, block: Block, rows: list[Row | str | None]) -> None:
    """Write one block; a row given as text has failed for that reason, and of a row that is None what is stored stays.

    Parameters
    ----------
    path : str
        A store whose template matches the plan.
    plan : Plan
    block : Block
    rows : list of Row, str or None
        One per row of the block.
    """
    root = zarr.open_group(path, mode="r+")
    count = block.stop - block.start
    specs = arrays_of(plan)
    values, place = {}, plan.place(block)
    with every_chunk():
        # What an array writes is settled when it is opened.
        arrays = {name: root[name] for name in specs}
    stored = {name: array[place] for name, array in arrays.items()} if None in rows else {}
    for name, spec in specs.items():
        shape = arrays[name].shape[len(plan.row_axes) :]
        if spec["dtype"] == "str":
            values[name] = np.full(count, "", dtype=object)
        else:
            values[name] = np.full((count, *shape), spec["fill"], dtype=spec["dtype"])
    for i, row in enumerate(rows):
        if row is None:
            for name, value in values.items():
                value[i] = stored[name][i]
        elif isinstance(row, str):
            values["message"][i], values["status"][i] = row, FAILED
        else:
            _fill_raster(values, i, row)
            _fill_branches(values, i, row, plan.sweep.name)
            values["status"][i] = COMPLETE
    if root.attrs["configuration_hash"] != plan.digest:
        # A task of a run that is no more, on a scheduler that goes on.
        raise StoreError(f"{path} is no longer the store that these rows are of")
    # A block is not complete until it is whole; and where other chunks are, one of `status` is, unless it was lost.
    arrays["status"][place] = PENDING
    for name, value in values.items():
        arrays[name][place] = value


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
