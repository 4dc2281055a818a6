"""How chunks are written: compressed, each with a checksum, and all of them, so that a missing one is a loss."""

from zarr import config
from zarr.codecs import Crc32cCodec, ZstdCodec

__all__ = ["COMPRESSORS", "every_chunk"]

#: For every array of every store: the checksum is taken of the compressed bytes, as they are in the file.
COMPRESSORS = (ZstdCodec(level=0, checksum=False), Crc32cCodec())


def every_chunk():
    """A context in which chunks that hold nothing but the fill value are written too.

    zarr leaves them out by default, and then nothing tells a chunk that was lost from one that was empty.
    """
    return config.set({"array.write_empty_chunks": True})
