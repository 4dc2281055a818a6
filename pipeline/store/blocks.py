"""Blocks of rows: what is stored of a row, reading rows with every chunk verified, and writing a block whole.

A block is written from what was computed or from what was read here: nothing that is stored is taken on trust.
"""

import errno
import os
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from pipeline.config.places import Place
from pipeline.config.quantities import READ
from pipeline.errors import StoreError
from pipeline.plan.plan import Block, Plan
from pipeline.store.array_layout import MOST_TEXT
from pipeline.store.arrays import arrays_of, row_layouts
from pipeline.store.block_states import is_stored, read_states, write_states
from pipeline.store.chunk_files import encoded, read_chunk
from pipeline.store.documents import document
from pipeline.store.files import Files, files_at
from pipeline.store.names import METADATA
from pipeline.store.states import COMPLETE, FAILED, PENDING
from solver import Row

__all__ = ["RowValues", "kept_rows", "pending_blocks", "read_rows", "row_values", "write_block"]

#: Array name -> the entries of one row.
RowValues = dict[str, np.ndarray]


def row_values(plan: Plan, row: Row | str | None) -> RowValues:
    """What is stored of a row: its values, the reason where it failed, nothing but fill values where there is none."""
    layouts, along = row_layouts(plan), len(plan.row_axes)
    values = {
        name: np.full(layouts[name].shape[along:], spec["fill"], object if spec["dtype"] == "str" else spec["dtype"])
        for name, spec in arrays_of(plan).items()
    }
    if isinstance(row, str):
        values["message"][...], values["status"][...] = row[:MOST_TEXT], FAILED
    elif row is not None:
        _fill_raster(values, row)
        _fill_branches(values, row, plan.sweep.name)
        values["message"][...], values["status"][...] = " ".join(row.notes)[:MOST_TEXT], COMPLETE
    return values


def read_rows(path: Place, plan: Plan, rows: Block, names: tuple[str, ...] | None = None) -> dict[str, np.ndarray]:
    """Stored values of some rows of one layer; fill values where a block is not stored.

    Parameters
    ----------
    path : Place
        Of the store.
    plan : Plan
    rows : Block
        Any rows of one layer, not only those of a block.
    names : tuple of str, optional
        Only these arrays.

    Returns
    -------
    dict
        Name -> (rows, ...) array; texts as objects.

    Raises
    ------
    DamagedError
        If a chunk of a stored block is missing or damaged.
    """
    layouts = row_layouts(plan)
    empty = row_values(plan, None)
    blocks, parts = plan.blocks_of(rows), {name: [] for name in names or layouts}
    files = files_at(path).at_hand(_chunks(plan, blocks, ("status", *parts)))
    for block in blocks:
        within = slice(max(rows.start, block.start) - block.start, min(rows.stop, block.stop) - block.start)
        stored = is_stored(files, plan, block)
        for name, found in parts.items():
            if stored:
                (file,) = layouts[name].files(*plan.place(block))
                # A chunk holds rows of one layer.
                found.append(read_chunk(files, file, layouts[name]).reshape(-1, *empty[name].shape)[within])
            else:
                found.append(np.stack([empty[name]] * (within.stop - within.start)))
    return {name: np.concatenate(found) for name, found in parts.items()}


def kept_rows(path: Place, plan: Plan, block: Block) -> dict[int, RowValues]:
    """Complete rows of a block and what is stored of them.

    Raises
    ------
    DamagedError
        If anything that is stored of the block is missing or damaged.
    """
    if not is_stored(files_at(path), plan, block):
        return {}
    complete = np.flatnonzero(read_rows(path, plan, block, ("status",))["status"] == COMPLETE)
    stored = read_rows(path, plan, block) if complete.size else {}
    return {block.start + int(i): {name: values[i, ...] for name, values in stored.items()} for i in complete}


def pending_blocks(path: Place, plan: Plan, done: tuple[int, ...] = (COMPLETE,)) -> list[Block]:
    """Blocks with a row whose state is not `done`; each is computed again as a whole, as far as its rows are not kept.

    Raises
    ------
    DamagedError
        If a chunk of `status` is damaged.
    """
    files = files_at(path).at_hand(_chunks(plan, plan.blocks, ("status",)))
    return [block for block in plan.blocks if not np.all(np.isin(read_states(files, plan, block), done))]


def write_block(path: Place, plan: Plan, block: Block, rows: list[RowValues]) -> None:
    """Write one block, the only writer of its chunks; they are on the disk before `status` says so, and then it is.

    Parameters
    ----------
    path : Place
        A store whose template matches the plan.
    plan : Plan
    block : Block
    rows : list of RowValues
        One per row of the block.

    Raises
    ------
    FileNotFoundError
        If the store is gone.
    StoreError
        If another one stands in its place.
    """
    files = files_at(path)
    told = _attributes(files)
    if told.get("configuration_hash") != plan.fingerprint:
        raise _other(files)
    place, contents = plan.place(block), {}
    for name, layout in row_layouts(plan).items():
        if name != "status":
            (file,) = layout.files(*place)
            contents[file] = encoded(np.stack([row[name] for row in rows]).ravel(), layout)
    # A block is not complete until it is whole; and where other chunks are, one of `status` is, unless it was lost.
    write_states(files, plan, block, PENDING)
    files.write(contents)
    try:
        _refuse_other(files, told)
        write_states(files, plan, block, np.array([row["status"] for row in rows]))
        _refuse_other(files, told)
    except StoreError:
        # What was written into another store counts as not stored.
        write_states(files, plan, block, PENDING)
        raise


def _attributes(files: Files) -> dict:
    """What a store says of itself, when it was made included."""
    told = document(files, METADATA)
    if told is None and not files.has(METADATA):
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(files.place))
    return (told or {}).get("attributes", {})


def _refuse_other(files: Files, told: dict) -> None:
    """Raise unless the store is still the one that said this.

    A task may outlive its run, on a scheduler that goes on or where its client has lost the store to another one. In
    the same store, whoever writes a block writes the same.
    """
    if _attributes(files) != told:
        raise _other(files)


def _other(files: Files) -> StoreError:
    return StoreError(f"{files.place} is no longer the store that these rows are of")


def _chunks(plan: Plan, blocks: Sequence[Block], names: Iterable[str]) -> Iterator[str]:
    """Names of the chunks of blocks."""
    layouts = row_layouts(plan)
    return (file for name in names for block in blocks for file in layouts[name].files(*plan.place(block)))


def _fill_raster(values: RowValues, row: Row) -> None:
    found = slice(row.mean.shape[1])
    for name in ("n_solutions", "n_stable", "domain", "open", "certified"):
        if name in values:
            values[name][...] = getattr(row, name)
    for one in READ:
        values[one.name][:, found] = row.quantities[..., one.slot]
    for name in ("amplitude", "phase", "stable", "impact", "instability", "multiplier"):
        values[name][:, found] = getattr(row, name)
    if "motion" in values:
        values["motion"][:, found] = row.motions


def _fill_branches(values: RowValues, row: Row, axis: str) -> None:
    start = 0
    for number, curve in enumerate(row.curves):
        here = slice(start, start + len(curve.points))
        mean, cos, sin = row.branch_motions(curve)
        for name, value in (("mean", mean), ("cos", cos), ("sin", sin), (axis, curve.points[:, -1])):
            values[f"branches/{name}"][here] = value
        values["branches/amplitude"][here] = np.hypot(cos, sin)
        if "branches/motion" in values:
            values["branches/motion"][here] = curve.points[:, :-1]
        values["branches/arclength"][here] = curve.arclength
        values["branches/stable"][here] = curve.stable
        values["branches/impact"][here] = row.branch_impact(curve)
        values["branches/branch"][here] = number
        values["branches/event"][here] = curve.event
        values["branches/end_reason"][number] = curve.ends
        start = here.stop
    values["branches/n_points"][...], values["branches/n_folds"][...] = start, row.n_folds
