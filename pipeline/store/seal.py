"""A digest by which a damaged copy of what a store says of itself is told from a sound one."""

import hashlib
import json

__all__ = ["sealed"]


def sealed(attributes: dict) -> dict:
    """What the root of a store says, with a digest of it."""
    said = {key: value for key, value in attributes.items() if key != "digest"}
    return {**said, "digest": hashlib.sha256(json.dumps(said, sort_keys=True).encode()).hexdigest()}
