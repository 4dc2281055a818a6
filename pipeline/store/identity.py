"""Whose store it is: the plan it was made for, and whether that is the plan at hand."""

import json
from pathlib import Path

from pipeline.errors import StoreError
from pipeline.plan import OLDEST_READ, SCHEMA_VERSION, Plan, plan_of

__all__ = [
    "check", "plan_from", "read_numbers", "read_plan", "refuse_foreign", "refuse_to_write_older", "root_attributes",
]  # fmt: skip


def root_attributes(path: Path) -> dict:
    """What the root of a store says of itself; from its second place, in `branches`, where the first is damaged.

    Raises
    ------
    StoreError
        If there is no store, or neither place can be read.
    """
    if not path.exists():
        raise StoreError(f"there is no store at {path}")
    for file, *keys in ((path / "zarr.json", "attributes"), (path / "branches" / "zarr.json", "attributes", "plane")):
        try:
            attributes = json.loads(file.read_text(encoding="utf-8"))
            for key in keys:
                attributes = attributes[key]
            json.loads(attributes["numbers"])
            int(attributes["bevelmap_schema"])
            return attributes
        except (OSError, KeyError, ValueError, TypeError):
            continue
    raise StoreError(f"{path} is not allowed: it is something else than a store of this program")


def plan_from(attributes: dict, path: Path) -> Plan:
    """The plan that the attributes of a store describe.

    Raises
    ------
    StoreError
        If they are of another schema version, or describe no plane that this program could have written.
    """
    version = attributes["bevelmap_schema"]
    if version > SCHEMA_VERSION:
        raise StoreError(
            f"{path} was made by a newer version of this program (schema {version}, this one knows {SCHEMA_VERSION}): update it"
        )
    if version < OLDEST_READ:
        raise _older(path, version)
    try:
        return plan_of(json.loads(attributes["numbers"]))
    except (TypeError, KeyError, ValueError, AttributeError) as error:
        raise StoreError(f"{path} is not allowed: what it says of its plane makes no sense ({error})") from None


def refuse_to_write_older(path: Path) -> None:
    """Raise if rows of a store were written by an older version: what this one writes would not go with them."""
    version = int(root_attributes(path)["bevelmap_schema"])
    if version < SCHEMA_VERSION:
        raise _older(path, version)


def _older(path: Path, version: int) -> StoreError:
    return StoreError(
        f"{path} was made by an older version of this program (schema {version}, this one writes {SCHEMA_VERSION}): "
        "store.overwrite=true makes it anew, another store.name= keeps it"
    )


def read_numbers(path: Path) -> dict:
    """What the numbers of an existing store depend on; raises StoreError as `read_plan` does."""
    return read_plan(path).numbers


def read_plan(path: Path) -> Plan:
    """The plan of an existing store.

    Raises
    ------
    StoreError
        If there is no store, or it is not one of ours or of this version.
    """
    return plan_from(root_attributes(path), path)


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
    if stored == plan.numbers:
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
        root_attributes(path)


def _flatten(value, prefix="") -> dict[str, object]:
    if not isinstance(value, dict):
        return {prefix: value}
    return {k: v for key, child in value.items() for k, v in _flatten(child, f"{prefix}.{key}".lstrip(".")).items()}
