"""Rows numbered through, layer by layer, and cut into blocks: each is a chunk of a store and a task."""

import math
from dataclasses import dataclass

__all__ = ["Block", "RowBlocks"]


@dataclass(frozen=True, slots=True)
class Block:
    """Rows start ... stop - 1: one chunk of the store and one task. Rows of a volume are numbered through, layer by
    layer; a block belongs to one layer."""

    start: int
    stop: int


@dataclass(frozen=True)
class RowBlocks:
    """The rows of a plane or of a volume in blocks.

    Parameters
    ----------
    shape : tuple of int
        (rows,), or (layers, rows) of a volume.
    size : int
        Rows of a block; the last one of a layer may have less.

    Examples
    --------
    >>> blocks = RowBlocks((2, 5), 3)
    >>> [(block.start, block.stop) for block in blocks.all]
    [(0, 3), (3, 5), (5, 8), (8, 10)]
    >>> blocks.place(Block(8, 10)), blocks.chunk_of(Block(8, 10))
    ((1, slice(3, 5, None)), (1, 1))
    """

    shape: tuple[int, ...]
    size: int

    @property
    def rows(self) -> int:
        """Number of rows, all layers together."""
        return math.prod(self.shape)

    @property
    def of_layer(self) -> int:
        """Number of rows of a layer."""
        return self.shape[-1]

    @property
    def all(self) -> list[Block]:
        """All blocks in order."""
        layer = self.of_layer
        return [block for first in range(0, self.rows, layer) for block in self.holding(Block(first, first + layer))]

    @property
    def count(self) -> int:
        """Number of blocks, without making them."""
        return self.rows // self.of_layer * -(-self.of_layer // self.size)

    def holding(self, rows: Block) -> list[Block]:
        """The blocks that hold some rows of one layer, in order."""
        size, layer = self.size, self.of_layer
        first = rows.start - rows.start % layer
        begin = (rows.start - first) // size * size
        return [Block(first + i, first + min(i + size, layer)) for i in range(begin, rows.stop - first, size)]

    def place(self, block: Block) -> tuple[int | slice, ...]:
        """Where a block is in arrays along the rows, the layers first."""
        layer, start = divmod(block.start, self.of_layer)
        rows = slice(start, start + block.stop - block.start)
        return (rows,) if len(self.shape) == 1 else (layer, rows)

    def chunk_of(self, block: Block) -> tuple[int, ...]:
        """Numbers of a block's chunk along the rows, the layers first."""
        layer, start = divmod(block.start, self.of_layer)
        return (start // self.size,) if len(self.shape) == 1 else (layer, start // self.size)
