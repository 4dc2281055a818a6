"""What workers do: seek the attractors of some rows, and go on with rows beside which others were found.

A row that raises is recorded with its reason and the others go on. What is found in a row depends on nothing but the
row, and in later rounds on what the rows beside it gained in the round before.
"""

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from pipeline import store
from pipeline.analysis.attractors.dataset import empty_values, group_of, row_of_values, state_size, values_of_row
from pipeline.analysis.attractors.grid import Grid
from pipeline.analysis.attractors.options import keys_of, search_of
from pipeline.config.places import Place
from pipeline.config.schema import Attractors
from pipeline.plan.numerics import model_at, row_system, sweep_axis
from pipeline.plan.plan import Plan
from pipeline.plan.row_blocks import Block
from pipeline.plan.traits import contact_system
from pipeline.run.kernels import ready_for_attractors
from pipeline.store.attempts import AttemptLog
from pipeline.store.row_groups import RowGroup
from solver.timedomain import AttractorRow, continue_attractors, find_attractors

__all__ = ["MAP", "Gains", "Receipt", "Spec", "continue_block", "gains_of_row", "map_motions", "search_block"]

#: Columns, kinds and states of attractors that a row has gained in one round.
Gains = tuple[np.ndarray, np.ndarray, np.ndarray]

#: What is read of the map, besides all harmonics where it has them.
MAP = ("status", "domain", "stable", "mean", "amplitude", "phase", "impact")


@dataclass(frozen=True)
class Spec:
    """What is computed, small enough to go with every task.

    Parameters
    ----------
    path : Place
        The store.
    grid : Grid
    options : Attractors
    made_from : bytes
        Digest of what is read of the map.
    limit : float or None
        Seconds that a row may take; the process ends where one takes longer.
    """

    path: Place
    grid: Grid
    options: Attractors
    made_from: bytes
    limit: float | None = None

    @property
    def group(self) -> RowGroup:
        """Where it is stored."""
        return group_of(self.path, self.grid, self.options, self.made_from)


@dataclass(frozen=True)
class Receipt:
    """What came of one block in one round.

    Parameters
    ----------
    block : Block
    round : int
    gains : dict
        Row -> what it gained; rows that gained nothing are left out.
    failures : tuple of (int, str)
        Rows that failed in this round, and the reasons.
    rows : int
        Rows that were computed.
    seconds : float
    """

    block: Block
    round: int
    gains: dict[int, Gains]
    failures: tuple[tuple[int, str], ...]
    rows: int
    seconds: float


def search_block(spec: Spec, block: Block) -> Receipt:
    """Seek attractors in every row of a block from rest, from the map's stable motions and from random states."""
    motions, options = map_motions(spec.path, spec.grid, block), spec.options
    search, period = search_of(options), int(spec.grid.plan.solver["period"])

    def found(row: int, model, omega: float | None) -> AttractorRow:
        grid = spec.grid
        return find_attractors(
            model,
            sweep_axis(grid.plan),
            grid.x,
            omega=omega,
            motions=motions[row - block.start],
            period=period,
            keys=keys_of(grid, row, options.seed),
            search=search,
        )

    rows, group = range(block.start, block.stop), spec.group
    return _computed(spec, group, block, 0, rows, found, [empty_values(group)] * len(rows))


def continue_block(spec: Spec, block: Block, round: int, brought: dict[int, Gains]) -> Receipt:
    """Go on with some rows of a block from what their neighbours gained in the round before.

    Parameters
    ----------
    spec : Spec
    block : Block
        Which has been through all rounds before.
    round : int
    brought : dict
        Row -> what is brought to it.
    """
    search, group = search_of(spec.options), spec.group
    stored = group.read(block)
    if stored is None:
        raise OSError(f"rows {block.start}-{block.stop - 1} of {group.folder.place} are stored no longer")

    def found(row: int, model, omega: float | None) -> AttractorRow:
        grid, (columns, kinds, states) = spec.grid, brought[row]
        before = row_of_values(known[row - block.start], _state_size(spec.grid, row))
        return continue_attractors(
            model,
            sweep_axis(grid.plan),
            grid.x,
            before,
            columns,
            kinds,
            states,
            round=round,
            omega=omega,
            search=search,
        )

    known = [{name: values[i, ...] for name, values in stored.items()} for i in range(block.stop - block.start)]
    return _computed(spec, group, block, round, sorted(brought), found, known)


def _computed(
    spec: Spec, group: RowGroup, block: Block, round: int, rows, found: Callable, values: list[dict]
) -> Receipt:
    """Compute some rows of a block and write all of it; `values` is what was known of them."""
    ready_for_attractors()
    begin, gains, failures = perf_counter(), {}, []
    with AttemptLog(group.folder.place, block.start, spec.limit) as tries:
        for row in rows:
            plane, _, value = spec.grid.place(row)
            reason = tries.verdict(row)
            if reason is None:
                try:
                    with tries.attempt(row):
                        result = found(row, row_system(plane, value), plane.frequency(value))
                except Exception as error:  # the same on every worker: it is recorded, and the others go on
                    reason = f"{type(error).__name__}: {' '.join(str(error).split())}"
                    tries.raised(row, reason)
            if reason is None:
                sizes = _sizes(plane, value, spec.grid.x)
                stored = values_of_row(group, result, sizes, round)
                values[row - block.start] = stored
                if (gained := gains_of_row(stored).get(round)) is not None:
                    gains[row] = gained
            else:
                # What is known stays: neighbours have gone on from it.
                values[row - block.start] = {**values[row - block.start], "message": np.array(reason, dtype=object)}
                failures.append((row, reason))
        group.write(block, {name: np.stack([row[name] for row in values]) for name in group.arrays})
        tries.forget()
    return Receipt(block, round, gains, tuple(failures), len(rows), perf_counter() - begin)


def _state_size(grid: Grid, row: int) -> int:
    """Numbers of a state in the cells of a row."""
    plane, _, value = grid.place(row)
    ends = (model_at(plane, value, column) for column in (plane.sweep.low, plane.sweep.high))
    return max(state_size(model) for model in ends)


def _sizes(plane: Plan, value: float, x: np.ndarray) -> np.ndarray:
    """Gap and static deflection of every cell of a row."""
    if plane.sweep.name == "omega":
        return np.full(x.size, contact_system(row_system(plane, value)).motion_size)
    return np.array([contact_system(model_at(plane, value, column)).motion_size for column in x.tolist()])


def gains_of_row(values: dict[str, np.ndarray]) -> dict[int, Gains]:
    """Round -> what a row has gained, from what is stored of it; states have room for those of any other row."""
    row = row_of_values(values, values["state"].shape[-1])
    gains = {round: row.gains(round) for round in np.unique(row.round[row.round >= 0]).tolist()}
    return {round: gained for round, gained in gains.items() if gained[0].size}


def map_motions(path: Place, grid: Grid, block: Block) -> np.ndarray:
    """Stable motions of the map in the rows of a block, (rows, X, S, 2 H + 1): mean, then cosine and sine amplitudes.

    nan where there is none, and where a row of the map is not complete.

    Raises
    ------
    DamagedError
        If anything that is stored of the rows is missing or damaged.
    """
    plan, columns = grid.plan, list(grid.columns)
    numbers = np.array([grid.place(row)[1] for row in range(block.start, block.stop)])
    names = (*MAP, *(("motion",) if plan.motion_size else ()))
    stored = store.read_rows(path, plan, Block(int(numbers[0]), int(numbers[-1]) + 1), names)
    stored = {name: values[numbers - numbers[0]] for name, values in stored.items()}
    cells = {name: values[:, columns] for name, values in stored.items() if name != "status"}
    if plan.motion_size:
        motions = cells["motion"].copy()
    else:
        # Lambda_1 = amplitude exp(i phase) = c_1 - i s_1.
        amplitude, phase = cells["amplitude"], cells["phase"]
        motions = np.stack([cells["mean"], amplitude * np.cos(phase), -amplitude * np.sin(phase)], axis=-1)
    used = (cells["stable"] == 1) & (stored["status"] == store.COMPLETE)[:, None, None]
    motions[~used] = np.nan
    return motions
