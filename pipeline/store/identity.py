"""Whose store it is: the plan it was made for, and whether that is the plan at hand."""

import json
from pathlib import Path

import zarr

from pipeline.errors import StoreError
from pipeline.plan import SCHEMA_VERSION, Plan, numbers_digest, plan_of

__all__ = ["check", "read_numbers", "read_plan", "refuse_foreign"]


def read_numbers(path: Path) -> dict:
    """What the numbers of an existing store depend on.

    Raises
    ------
    StoreError
        If there is no store, or it is not one of ours or of this version.
    """
    if not path.exists():
        raise StoreError(f"there is no store at {path}")
    try:
        attributes = dict(zarr.open_group(path, mode="r").attrs)
        version = attributes["bevelmap_schema"]
        numbers = json.loads(attributes["numbers"])
    except (OSError, KeyError, ValueError, zarr.errors.GroupNotFoundError, zarr.errors.NodeTypeValidationError):
        raise StoreError(f"{path} is not allowed: it is something else than a store of this program") from None
    if version != SCHEMA_VERSION:
        raise StoreError(f"{path} has schema version {version}, this program writes {SCHEMA_VERSION}: use another name")
    return numbers


def read_plan(path: Path) -> Plan:
    """The plan of an existing store; raises StoreError as `read_numbers` does."""
    return plan_of(read_numbers(path))


def check(path: Path, plan: Plan) -> bool:
    """Whether a store for exactly this plan exists.

    Raises
    ------
    StoreError
        If something else is there, with the difference and the ways on.
    """
    if not path.exists():
        return False
    stored = read_numbers(path)
    if numbers_digest(stored) == plan.digest:
        return True
    old, new = _flatten(stored), _flatten(plan.numbers)
    keys = [key for key in sorted(old.keys() | new.keys()) if old.get(key) != new.get(key)]
    changes = "; ".join(f"{key}: stored {old.get(key, 'nothing')}, asked {new.get(key, 'nothing')}" for key in keys)
    raise StoreError(
        f"{path} holds another configuration ({changes}): take another store.name=..., or store.overwrite=true"
    )


def refuse_foreign(path: Path) -> None:
    """Raise unless the path is free or holds a store of ours, so that overwriting never deletes anything else."""
    if path.exists():
        read_numbers(path)


def _flatten(value, prefix="") -> dict[str, object]:
    if not isinstance(value, dict):
        return {prefix: value}
    return {k: v for key, child in value.items() for k, v in _flatten(child, f"{prefix}.{key}".lstrip(".")).items()}
