"""Chunk files, read and checked without zarr, which takes a missing one for one that was never written.

A chunk is the little-endian bytes of its entries, compressed by zstd, with a checksum in the last four bytes.
"""

import contextlib
import math
from collections.abc import Iterator

import google_crc32c
import numpy as np
from numcodecs.vlen import VLenUTF8
from numcodecs.zstd import Zstd

from pipeline.store.array_layout import ArrayLayout
from pipeline.store.damage import damaged
from pipeline.store.files import Files

__all__ = ["HEADER", "ChunkError", "claim_of", "decoded", "encoded", "fault_of", "read_chunk"]

#: Bytes at the start of a file that tell how many it stands for.
HEADER = 18
_MAGIC = b"\x28\xb5\x2f\xfd"
_CHECKSUM = 4


class ChunkError(Exception):
    """What is wrong with a chunk, as said of its file: "is empty"."""


def read_chunk(files: Files, file: str, array: ArrayLayout) -> np.ndarray:
    """The entries of one chunk, those beyond the end of the array included.

    Parameters
    ----------
    files : Files
        Of the store.
    file : str
        Name of the chunk, one of `array.files()`.
    array : ArrayLayout

    Returns
    -------
    (*array.chunks) ndarray
        Of objects where the array holds texts.

    Raises
    ------
    DamagedError
        If the file is missing, or is not a whole chunk of this array.
    """
    try:
        return decoded(_content(files, file, array), array)
    except ChunkError as error:
        raise damaged(files.place, f"{file} {error}") from None


def fault_of(files: Files, file: str, array: ArrayLayout) -> str | None:
    """What is wrong with a chunk file; None if nothing is."""
    try:
        decoded(_content(files, file, array), array)
    except ChunkError as error:
        return str(error)
    return None


def decoded(content: bytes, array: ArrayLayout) -> np.ndarray:
    """The entries of a chunk from the bytes of its file; see `read_chunk`.

    Raises
    ------
    ChunkError
    """
    if not content:
        raise ChunkError("is empty")
    frame, checksum = content[:-_CHECKSUM], content[-_CHECKSUM:]
    if google_crc32c.value(frame) != int.from_bytes(checksum, "little"):
        raise ChunkError("does not agree with its checksum")
    if (fault := _claim_fault(frame[:HEADER], array)) is not None:
        raise ChunkError(fault)
    try:
        entries = Zstd().decode(frame)
    except RuntimeError:
        raise ChunkError("cannot be decompressed") from None
    if array.kind != "string":
        return np.frombuffer(entries, np.dtype(array.kind).newbyteorder("<")).reshape(array.chunks)
    # The number of texts comes first, and whoever decodes them makes room for so many.
    if int.from_bytes(entries[:4], "little") != math.prod(array.chunks):
        raise ChunkError("holds another number of texts than it should")
    try:
        return VLenUTF8().decode(entries).reshape(array.chunks)
    except (ValueError, UnicodeDecodeError):
        raise ChunkError("holds what is no text") from None


def encoded(entries: np.ndarray, array: ArrayLayout) -> bytes:
    """What the file of a chunk holds; entries at its end that are not given are the fill value.

    Parameters
    ----------
    entries : (n,) ndarray
        In the order of the chunk; objects where the array holds texts.
    array : ArrayLayout
    """
    texts = array.kind == "string"
    chunk = np.full(math.prod(array.chunks), array.fill, object if texts else np.dtype(array.kind).newbyteorder("<"))
    chunk[: entries.size] = entries
    frame = Zstd(level=0).encode(VLenUTF8().encode(chunk) if texts else chunk.tobytes())
    return frame + google_crc32c.value(frame).to_bytes(_CHECKSUM, "little")


def _claim_fault(header: bytes, array: ArrayLayout) -> str | None:
    """What is wrong with the size that a chunk claims for its entries, by the first bytes of its file, if anything.

    Whoever decompresses it makes room for so many bytes.
    """
    claimed = _frame_size(header)
    low, high = array.chunk_bytes
    if claimed is None:
        return "is no compressed chunk"
    return (
        None
        if low <= claimed <= high
        else f"claims {claimed} bytes, where a chunk has {f'up to {high}' if low < high else high}"
    )


def claim_of(files: Files, file: str, array: ArrayLayout) -> int:
    """Bytes that a chunk file stands for, compared with what its array may have, without decompressing it.

    Raises
    ------
    ChunkError
        If it is missing, empty, too long, or claims another size than it may.
    """
    if array.kind == "string":
        # How many texts there are is told behind the compression; these chunks are small.
        decoded(_content(files, file, array), array)
    with _explained():
        header, size = files.head(file, HEADER)
    if not header:
        raise ChunkError("is empty")
    if size > _longest_file(array):
        raise ChunkError("is longer than a chunk can be")
    if (fault := _claim_fault(header, array)) is not None:
        raise ChunkError(fault)
    return _frame_size(header)


def _longest_file(array: ArrayLayout) -> int:
    """What zstd makes of what it cannot compress, and the checksum."""
    most = array.chunk_bytes[1]
    return most + most // 128 + 1024


def _frame_size(header: bytes) -> int | None:
    """Bytes that a zstd frame stands for, by its header (RFC 8878, section 3.1.1.1); None where it does not tell."""
    if header[:4] != _MAGIC or len(header) < 5:
        return None
    single, size = header[4] >> 5 & 1, header[4] >> 6
    width = (single, 2, 4, 8)[size]
    start = 5 + (1 - single) + (0, 1, 2, 4)[header[4] & 3]
    field = header[start : start + width]
    # Two bytes count from 256 on.
    return int.from_bytes(field, "little") + (256 if width == 2 else 0) if field and len(field) == width else None


def _content(files: Files, file: str, array: ArrayLayout) -> bytes:
    longest = _longest_file(array)
    with _explained():
        content = files.read(file, longest)
    if len(content) > longest:
        raise ChunkError("is longer than a chunk can be")
    return content


@contextlib.contextmanager
def _explained() -> Iterator[None]:
    try:
        yield
    except (FileNotFoundError, NotADirectoryError):
        raise ChunkError("is missing") from None
    except IsADirectoryError:
        raise ChunkError("is a folder") from None
