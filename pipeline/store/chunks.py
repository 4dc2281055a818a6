"""Which files an array is cut into."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from pathlib import Path

__all__ = ["Chunks"]


@dataclass(frozen=True)
class Chunks:
    """The chunk files of one array: its folder, and its shape and that of its chunks."""

    folder: Path
    shape: tuple[int, ...]
    chunks: tuple[int, ...]

    @classmethod
    def of(cls, folder: Path, document: dict) -> "Chunks":
        """The chunks of an array whose metadata is `document`."""
        return cls(folder, tuple(document["shape"]), tuple(document["chunk_grid"]["configuration"]["chunk_shape"]))

    def files(self, *place: int | slice) -> Iterator[Path]:
        """Files of the chunks that a place along the first axes touches; of all chunks unless told."""
        ends = [(at.start, at.stop) if isinstance(at, slice) else (at, at + 1) for at in place]
        ends += [(0, size) for size in self.shape[len(place) :]]
        along = (range(low // chunk, -(-high // chunk)) for (low, high), chunk in zip(ends, self.chunks, strict=True))
        for numbers in product(*along):
            yield self.folder.joinpath("c", *map(str, numbers))
