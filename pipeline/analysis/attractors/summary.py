"""What only the whole group tells: the label of every cell by its attractors, and how far the map's can be trusted."""

from collections.abc import Iterator

import numpy as np

from pipeline import store
from pipeline.analysis.attractors.credibility import Cells, Credibility, judge, reach
from pipeline.analysis.attractors.grid import Grid
from pipeline.analysis.attractors.tasks import MAP
from pipeline.analysis.attractors.wording import cell_label, label_meaning
from pipeline.config.places import Place
from pipeline.config.schema import Attractors
from pipeline.errors import DamagedError
from pipeline.plan.row_blocks import Block
from pipeline.store.row_groups import RowArray, RowGroup
from solver.timedomain import AttractorKind

__all__ = ["summary_of"]

#: What credibility depends on of the group.
_FOUND = ("kind", "impact", "mean", "amplitude", "motion", "size", "failures", "overflow", "message")


def summary_of(path: Place, group: RowGroup, grid: Grid, options: Attractors) -> dict[str, tuple[RowArray, np.ndarray]]:
    """Arrays of the whole group: name -> array and values, as `RowGroup.finish` takes them.

    Parameters
    ----------
    path : Place
        The store.
    group : RowGroup
        All of whose blocks are stored.
    grid : Grid
    options : Attractors

    Raises
    ------
    DamagedError
        If anything that is stored of the map or of the group is missing or damaged.
    """
    shape = (*grid.blocks.shape, len(grid.columns))
    judged, combinations = np.zeros(shape, np.int8), np.zeros(shape, np.int32)
    count, off = np.zeros(shape, np.uint8), np.full(shape, np.nan)
    known: dict[tuple, int] = {}
    for layer, found in _layers(group):
        here = layer if len(shape) == 3 else ...
        cells = cells_of(path, grid, 0 if layer is None else layer, found)
        x, p = grid.plan.sweep, grid.plan.parameter
        within = reach(grid.p, grid.x, (p.high - p.low, x.high - x.low), options.delta)
        judged[here], off[here] = judge(cells, options.tolerance, within)
        count[here] = np.sum(cells.settled & (cells.kind != AttractorKind.UNBOUNDED), axis=-1)
        combinations[here] = _combinations(cells, known)
    # Numbers of labels must not depend on where they were met.
    labels = {number: cell_label(*zip(*found, strict=True)) if found else "" for found, number in known.items()}
    order = sorted(set(labels.values()) - {""}, key=lambda text: (text.count("+"), text))
    codes = np.array([([""] + order).index(labels[number]) for number in range(len(labels))] or [0], np.int16)
    return {
        "n_attractors": (_array(grid, "uint8", 0, "number of attractors that were found", units="1"), count),
        "label": (
            _array(
                grid,
                "int16",
                0,
                "everything that was found in the cell",
                flag_values=list(range(len(order) + 1)),
                flag_meanings=" ".join(map(label_meaning, ["", *order])),
                labels=["", *order],
            ),
            codes[combinations],
        ),
        "credibility": (
            _array(grid, "int8", 0, "how far the map's label can be trusted", **store.flags(Credibility)),
            judged,
        ),
        "deviation": (
            _array(
                grid,
                "float64",
                float("nan"),
                "by how much mean or amplitude of a motion of the map is off at most, as a share of size",
                units="1",
            ),
            off,
        ),
    }


def _array(grid: Grid, dtype: str, fill: float, long_name: str, **more) -> RowArray:
    return RowArray(grid.dims[-1:], (len(grid.columns),), dtype, fill, {"long_name": long_name, **more})


def _layers(group: RowGroup) -> Iterator[tuple[int | None, dict[str, np.ndarray]]]:
    """Number and arrays of every layer, None for that of a plane."""
    rows = group.rows.of_layer
    for layer in range(group.rows.rows // rows):
        parts = []
        for block in group.rows.holding(Block(layer * rows, (layer + 1) * rows)):
            stored = group.read(block)
            if stored is None:
                raise DamagedError(
                    f"rows {block.start}-{block.stop - 1} of {group.folder.place} went missing meanwhile"
                )
            parts.append({name: stored[name] for name in _FOUND})
        found = {name: np.concatenate([part[name] for part in parts]) for name in _FOUND}
        yield (layer if len(group.rows.shape) == 2 else None), found


def cells_of(path: Place, grid: Grid, layer: int, found: dict[str, np.ndarray]) -> Cells:
    """The cells of one layer: what was found, beside what the map says.

    Parameters
    ----------
    path : Place
        The store.
    grid : Grid
    layer : int
        0 for a plane.
    found : dict
        Arrays of the group, (P, X, ...).
    """
    plan, columns = grid.plan, list(grid.columns)
    first = layer * plan.parameter.num
    stored = store.read_rows(path, plan, Block(first, first + plan.parameter.num), MAP)
    complete = (stored["status"] == store.COMPLETE)[list(grid.rows)]
    of_map = {name: stored[name][np.ix_(grid.rows, columns)] for name in MAP[1:]}
    return Cells(
        np.where(complete[:, None], of_map["domain"], 0),
        (of_map["stable"] == 1) & complete[:, None, None],
        of_map["mean"],
        of_map["amplitude"],
        of_map["impact"],
        found["motion"],
        found["kind"],
        found["impact"],
        found["mean"],
        found["amplitude"],
        found["size"],
        found["failures"] > 0,
        found["overflow"] != 0,
        np.broadcast_to((found["message"] != "")[:, None], found["size"].shape),
        int(plan.solver["period"]),
    )


def _combinations(cells: Cells, known: dict[tuple, int]) -> np.ndarray:
    """Which combination of kinds and impact states was found in every cell, (P, X); `known` gathers them."""
    pairs = np.where(cells.kind > 0, cells.kind.astype(np.int32) * 16 + cells.found_impact + 1, 0)
    rows, place = np.unique(np.sort(pairs, axis=-1).reshape(-1, pairs.shape[-1]), axis=0, return_inverse=True)
    numbers = []
    for row in rows.tolist():
        found = tuple((one // 16, one % 16 - 1) for one in row if one)
        numbers.append(known.setdefault(found, len(known)))
    return np.array(numbers, np.int32)[place.reshape(cells.label.shape)]
