"""Files that were made from a store, and whether they are still what would be made: then a stage need not make them.

They are, if nothing that they depend on has changed (files of the store, options, sources, libraries) and nobody has
changed them.
"""

import hashlib
import importlib.metadata
import json
from collections.abc import Sequence
from pathlib import Path

from pipeline.config.places import Place
from pipeline.run.environment import facts
from pipeline.store.durable import write_whole
from pipeline.store.files import files_at

__all__ = ["made_from", "still_made", "write_record"]


def made_from(store_path: Place, *options) -> str:
    """Digest of everything that files made from a store depend on.

    Parameters
    ----------
    store_path : Place
    *options
        With a `repr` that says all, such as dataclasses of numbers and texts.
    """
    libraries = [importlib.metadata.version(name) for name in ("matplotlib", "zarr", "xarray")]
    known = repr((sorted(facts().items()), libraries, options, sorted(files_at(store_path).versions().items())))
    return hashlib.blake2b(known.encode(), digest_size=16).hexdigest()


def still_made(record: Path, origin: str) -> list[Path] | None:
    """The files of a record if they have this origin and are as they were written; None otherwise."""
    try:
        said = json.loads(record.read_text(encoding="utf-8"))
        if said["origin"] != origin:
            return None
        # Names alone: a record may not send anybody elsewhere.
        paths = {record.parent / Path(name).name: digest for name, digest in said["files"].items()}
        return list(paths) if paths and all(_digest(path) == digest for path, digest in paths.items()) else None
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None


def write_record(record: Path, origin: str, paths: Sequence[Path]) -> None:
    """Note what has been made, in a file of the same folder."""
    files = {path.name: _digest(path) for path in paths}
    write_whole(record, json.dumps({"origin": origin, "files": files}, indent=1).encode())


def _digest(path: Path) -> str:
    return hashlib.blake2b(path.read_bytes(), digest_size=16).hexdigest()
