"""Metadata of a store as plain data: what is read may be damaged, and may come from someone else."""

import json
from collections.abc import Mapping

from pipeline.errors import Unreachable
from pipeline.store.files import Files
from pipeline.store.names import METADATA

__all__ = ["content_of", "document", "document_of", "gathered", "gathering", "group_document", "listed_in", "read_json"]

#: Three times what the widest plane of this program needs.
_MOST_BYTES = 2**21


def read_json(files: Files, name: str) -> dict | None:
    """A metadata file; None if it is missing, cannot be read or is larger than any of this program."""
    try:
        content = files.read(name, _MOST_BYTES)
        read = json.loads(content.decode()) if len(content) <= _MOST_BYTES else None
    except Unreachable:
        raise
    except (OSError, ValueError, RecursionError):
        return None
    return read if isinstance(read, dict) else None


def document(files: Files, name: str) -> dict | None:
    """A metadata file without what is gathered from others; None if it cannot be read."""
    return _alone(read_json(files, name))


def document_of(content: bytes) -> dict:
    """The same of a file that this program has made."""
    return _alone(json.loads(content))


def listed_in(files: Files) -> dict[str, dict | None]:
    """The metadata that the root of a store gathers, which is what zarr goes by; empty if it cannot be read.

    None stands for what is no metadata. The names are as they are in the file: nothing may be opened by them.
    """
    return gathered(files)[1]


def gathered(files: Files) -> tuple[dict | None, dict[str, dict | None]]:
    """The root's own metadata, None if it cannot be read, and what it gathers as `listed_in`."""
    root = read_json(files, METADATA)
    inside = (root or {}).get("consolidated_metadata")
    known = isinstance(inside, dict) and (inside.get("kind"), inside.get("must_understand")) == ("inline", False)
    listed = inside.get("metadata") if known else None
    return _alone(root), {name: _alone(told) for name, told in listed.items()} if isinstance(listed, dict) else {}


def _alone(told) -> dict | None:
    return {key: told[key] for key in told if key != "consolidated_metadata"} if isinstance(told, dict) else None


def group_document(attributes: dict) -> dict:
    """The metadata of a group."""
    return {"attributes": attributes, "zarr_format": 3, "node_type": "group"}


def gathering(root: dict, others: Mapping[str, dict]) -> dict:
    """The metadata of a root that gathers that of all others in the store, by which zarr and xarray open it."""
    ordered = sorted(others, key=lambda name: (name.count("/"), name))
    # Groups in it say that they gather nothing: otherwise zarr would look for what is in them.
    listed = {
        name: others[name] | ({"consolidated_metadata": _inline({})} if others[name]["node_type"] == "group" else {})
        for name in ordered
    }
    return root | {"consolidated_metadata": _inline(listed)}


def _inline(listed: dict) -> dict:
    return {"kind": "inline", "must_understand": False, "metadata": listed}


def content_of(document: dict) -> bytes:
    """What the file of a document holds."""
    return json.dumps(document, indent=2).encode()
