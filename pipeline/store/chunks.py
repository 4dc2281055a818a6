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

    def files(self, first: int = 0, stop: int | None = None) -> Iterator[Path]:
        """Files of the chunks that rows first ... stop - 1 touch."""
        counts = [-(-size // chunk) if size else 0 for size, chunk in zip(self.shape, self.chunks, strict=True)]
        last = counts[0] if stop is None else -(-stop // self.chunks[0])
        for place in product(range(first // self.chunks[0], last), *map(range, counts[1:])):
            yield self.folder.joinpath("c", *map(str, place))
