"""Files that are on the disk when a function returns, and appear under their names only when they are whole."""

import os
import uuid
from pathlib import Path

__all__ = ["write_whole"]


def write_whole(file: Path, content: bytes) -> None:
    """Write a file, in place of what was there; its folder is made if need be."""
    file.parent.mkdir(parents=True, exist_ok=True)
    # Named as zarr names what it has not finished, so that what a killed process leaves is known.
    draft = file.with_suffix(f".{uuid.uuid4().hex}.partial")
    with draft.open("xb") as stream:
        stream.write(content)
        stream.flush()
        os.fsync(stream.fileno())
    draft.replace(file)
