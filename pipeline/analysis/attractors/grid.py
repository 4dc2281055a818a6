"""Which cells of a plane are integrated: all, or some of its rows and columns."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.plan.axes import Axis
from pipeline.plan.plan import Plan
from pipeline.plan.row_blocks import RowBlocks

__all__ = ["Grid", "chosen"]

#: Blocks of rows, at least: few rows a block keep all workers busy to the end.
_BLOCKS = 32
#: Bytes of the largest array in a block, at most.
_BYTES = 2**21


def chosen(axis: Axis, wanted: int | list | None) -> tuple[int, ...]:
    """Indices of the values of an axis that a setting asks for, ascending.

    Parameters
    ----------
    axis : Axis
    wanted : int, list or None
        So many, evenly spaced with the first and the last; those nearest to these values; all.

    Examples
    --------
    >>> axis = Axis("f_e", 0.0, 1.0, 11)
    >>> chosen(axis, 3), chosen(axis, [0.21, 0.99]), len(chosen(axis, None))
    ((0, 5, 10), (2, 10), 11)
    """
    if wanted is None:
        return tuple(range(axis.num))
    if isinstance(wanted, list):
        return tuple(sorted({int(np.argmin(np.abs(axis.values - value))) for value in wanted}))
    return tuple(np.unique(np.linspace(0, axis.num - 1, wanted).round().astype(int)).tolist())


@dataclass(frozen=True)
class Grid:
    """The cells that are integrated. Rows are numbered through, layer by layer of a volume.

    Parameters
    ----------
    plan : Plan
        Of the plane or the volume.
    rows, columns : tuple of int
        Indices on the row axis and on the sweep axis.
    room : int
        Attractors of a cell.
    """

    plan: Plan
    rows: tuple[int, ...]
    columns: tuple[int, ...]
    room: int

    @property
    def blocks(self) -> RowBlocks:
        """Its rows in blocks."""
        layers = () if self.plan.parameter2 is None else (self.plan.parameter2.num,)
        total = len(self.rows) * int(np.prod(layers, initial=1))
        row_bytes = 8 * self.room * len(self.columns) * 4
        size = max(1, min(_BYTES // row_bytes, total // _BLOCKS, len(self.rows)))
        return RowBlocks((*layers, len(self.rows)), size)

    @cached_property
    def x(self) -> np.ndarray:
        """Values of the sweep parameter."""
        return self.plan.sweep.values[list(self.columns)]

    @cached_property
    def p(self) -> np.ndarray:
        """Values of the row parameter."""
        return self.plan.parameter.values[list(self.rows)]

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of its dimensions, the layers first: the plane's where the whole axis is taken, own ones else."""
        layers = () if self.plan.parameter2 is None else (self.plan.parameter2.name,)
        parts = ((self.plan.parameter, self.rows), (self.plan.sweep, self.columns))
        names = (axis.name if len(taken) == axis.num else f"attractor_{axis.name}" for axis, taken in parts)
        return (*layers, *names)

    def place(self, row: int) -> tuple[Plan, int, float]:
        """Of a row by number: the plane that it belongs to, its number in the plane or volume, its value there."""
        layer, index = divmod(row, len(self.rows))
        plane = self.plan if self.plan.parameter2 is None else self.plan.layer(layer)
        return plane, layer * self.plan.parameter.num + self.rows[index], float(self.p[index])

    def row_text(self, row: int) -> str:
        """Which row that is, for messages."""
        return self.plan.row_text(self.place(row)[1])

    def neighbours(self, row: int) -> tuple[int, ...]:
        """Numbers of the rows beside a row in the same layer, the lower one first."""
        count = len(self.rows)
        return tuple(other for other in (row - 1, row + 1) if other >= 0 and other // count == row // count)
