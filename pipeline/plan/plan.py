"""What a run will compute: the axes, the gear of every row, and the blocks of rows that are chunks and tasks."""

import hashlib
import json
import math
from dataclasses import asdict, dataclass, replace

import numpy as np

from pipeline.plan.axes import ROLES, Axis
from pipeline.plan.row_blocks import Block, RowBlocks

__all__ = ["SCHEMA_VERSION", "Block", "Plan", "fingerprint_of", "plan_of"]

#: Raised when stored numbers would no longer mean the same; part of the configuration's digest. Only stores of this
#: version are read.
SCHEMA_VERSION = 4

_BLOCK_BYTES = 2**20
_BLOCKS_AT_LEAST = 16


@dataclass(frozen=True)
class Plan:
    """A plane, or a volume of planes, to be computed, independent of files and executors.

    Parameters
    ----------
    gear : dict
        Numbers of the system as its kind takes them, without what the axes replace; of a bevel pair keyword arguments
        of `solver.Model`.
    sweep, parameter : Axis
        Along a row, and from row to row.
    omega : float or None
        The frequency, where it is not an axis.
    solver : dict
        Continuation settings.
    max_solutions, max_branches, max_points : int
        Room per row.
    physical : dict or None
        A gear in SI units, `pipeline.plan.scales.describe`; None where it is dimensionless.
    thermal : dict or None
        Laws of temperature in SI units, where that is the row parameter; see `pipeline.plan.thermal`.
    parameter2 : Axis or None
        From layer to layer of a volume; None for a plane.
    kind : str
        Of the system, one of `pipeline.plan.kinds.KINDS`.
    """

    gear: dict
    sweep: Axis
    parameter: Axis
    omega: float | None
    solver: dict
    max_solutions: int
    max_branches: int
    max_points: int
    physical: dict | None = None
    thermal: dict | None = None
    parameter2: Axis | None = None
    kind: str = "bevel"

    @property
    def inputs(self) -> dict:
        """Everything that changes numbers, as plain data; what they mean in physical units included, where they do."""
        numbers = json.loads(json.dumps(asdict(self)))
        usual = {"physical": None, "thermal": None, "parameter2": None, "kind": "bevel"}
        for name, value in usual.items():
            if numbers[name] == value:
                del numbers[name]
        return numbers

    @property
    def fingerprint(self) -> str:
        """Digest of `numbers`."""
        return fingerprint_of(self.inputs)

    @property
    def row_axes(self) -> tuple[Axis, ...]:
        """The axes that rows are numbered along, the slowest first."""
        return (self.parameter,) if self.parameter2 is None else (self.parameter2, self.parameter)

    @property
    def axes(self) -> tuple[Axis, ...]:
        """All axes, as people name them: the columns' first."""
        return (self.sweep, *reversed(self.row_axes))

    @property
    def rows(self) -> int:
        """Number of rows, all layers together."""
        return math.prod(axis.num for axis in self.row_axes)

    def layer(self, index: int) -> "Plan":
        """The plane that one layer of a volume is."""
        name, value = self.parameter2.name, float(self.parameter2.values[index])
        if name == "omega":
            return replace(self, omega=value, parameter2=None)
        return replace(self, gear={**self.gear, name: value}, parameter2=None)

    def row(self, number: int) -> tuple["Plan", float]:
        """The plane that a row belongs to, and its value there of the row parameter."""
        layer, place = divmod(number, self.parameter.num)
        return self if self.parameter2 is None else self.layer(layer), float(self.parameter.values[place])

    def frequency(self, value: float) -> float | None:
        """The mesh frequency of the row at a value of the row parameter; None where it is what changes along rows."""
        return value if self.parameter.name == "omega" else self.omega

    def row_text(self, number: int) -> str:
        """Which row that is, for messages."""
        places = np.unravel_index(number, [axis.num for axis in self.row_axes])
        values = ", ".join(f"{axis.name} = {axis.values[i]:.6g}" for axis, i in zip(self.row_axes, places, strict=True))
        return f"row {number} ({values})"

    def place(self, block: Block) -> tuple[int | slice, ...]:
        """Where a block is in arrays along `row_axes`."""
        return self.row_blocks.place(block)

    def chunk_of(self, block: Block) -> tuple[int, ...]:
        """Numbers of a block's chunk along `row_axes`."""
        return self.row_blocks.chunk_of(block)

    @property
    def is_first_order(self) -> bool:
        """Whether motions are balanced by the describing function: all at a place can then be found, with proof."""
        return self.solver["balance"] == "describing_function"

    @property
    def order_text(self) -> str:
        """To which order motions are balanced, in words."""
        return "first order" if self.is_first_order else f"{self.solver['order']} harmonics"

    @property
    def motion_size(self) -> int:
        """Numbers of a motion stored beside mean, amplitude and phase: all harmonics of a Galerkin balance."""
        unknowns = 2 * int(self.solver["order"]) * int(self.solver["period"]) + 1
        return unknowns if self.solver["balance"] == "galerkin" else 0

    @property
    def rows_per_block(self) -> int:
        """Rows of a chunk: about 1 MB of the largest array, and at least sixteen blocks in all; no more is needed to
        keep workers busy, and the number of workers may not matter."""
        return min(self._rows_at_once, -(-self.rows // _BLOCKS_AT_LEAST), self.parameter.num)

    @property
    def _rows_at_once(self) -> int:
        """Rows of which the largest array takes about 1 MB, at least one."""
        row_bytes = 8 * max(self.motion_size, 1) * max(self.sweep.num * self.max_solutions, self.max_points)
        return max(_BLOCK_BYTES // row_bytes, 1)

    @property
    def parts(self) -> list[Block]:
        """All rows in whole blocks that are read together, which takes no more memory than a block may."""
        blocks = self.row_blocks
        return replace(blocks, size=blocks.size * (self._rows_at_once // blocks.size)).all

    @property
    def row_blocks(self) -> RowBlocks:
        """The rows in blocks."""
        return RowBlocks(tuple(axis.num for axis in self.row_axes), self.rows_per_block)

    @property
    def blocks(self) -> list[Block]:
        """All blocks in order."""
        return self.row_blocks.all

    def blocks_of(self, rows: Block) -> list[Block]:
        """The blocks that hold some rows of one layer, in order."""
        return self.row_blocks.holding(rows)

    @property
    def n_blocks(self) -> int:
        """Number of blocks, without making them."""
        return self.row_blocks.count

    @property
    def bytes(self) -> int:
        """Upper bound of the store's size, uncompressed."""
        extra = 8 * self.motion_size
        solution = 35 + (16 + extra if extra else 0)
        return self.rows * (self.sweep.num * (solution * self.max_solutions + 8) + (53 + extra) * self.max_points)


def fingerprint_of(numbers: dict) -> str:
    """Digest of what changes numbers, the same on every machine."""
    text = json.dumps({"schema": SCHEMA_VERSION, **numbers}, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def plan_of(numbers: dict) -> Plan:
    """The plan that `Plan.inputs` came from; a store keeps it, so that only the sweep needs a configuration."""
    axes = {role: Axis(**numbers[role]) for role in ROLES if role in numbers}
    return Plan(**{**numbers, **axes})
