"""Whose store it is: the plan it was made for, and whether that is the plan at hand."""

import json
from pathlib import Path

from pipeline.errors import ConfigurationError, StoreError
from pipeline.plan.plan import SCHEMA_VERSION, Plan
from pipeline.store.documents import read_json
from pipeline.store.layout import Layout, validate_layout
from pipeline.store.names import METADATA, ROWS, STORE_FILE, files_of
from pipeline.store.removal import refuse_unknown
from pipeline.store.seal import sealed
from pipeline.store.validation import validate_plan
from solver import ParameterError

__all__ = ["check", "plan_from", "read_layout", "read_plan", "refuse_foreign", "root_attributes", "store_path"]


def store_path(name: str, value: str | Path) -> Path:
    """A path as a caller gives it.

    Parameters
    ----------
    name : str
        The parameter as the caller knows it.
    value : str or Path

    Raises
    ------
    solver.ParameterError
        If it is neither, or no path.
    StoreError
        If the system refuses to look there.
    """
    if isinstance(value, str | Path) and str(value) and "\0" not in str(value):
        path = Path(value)
        try:
            path.exists()
        except OSError as error:
            raise StoreError(f"{name} = {str(value)[:200]!r} cannot be read: {error.strerror}") from None
        return path
    raise ParameterError(name, value, "a path, as text or a pathlib.Path")


def root_attributes(path: Path) -> dict:
    """What the root of a store says of itself; from its second place, in `branches`, where the first is damaged.

    Raises
    ------
    StoreError
        If there is no store, or neither place can be read.
    """
    if not path.exists():
        raise StoreError(f"there is no store at {path}")
    first, second = path / METADATA, path / ROWS / METADATA
    copies = [copy for copy in (_copy(first, "attributes"), _copy(second, "attributes", "plane")) if copy is not None]
    for attributes in copies:
        if attributes == sealed(attributes):
            return attributes
    for attributes in copies:
        # What another version seals, and how, is not known here.
        if attributes["bevelmap_schema"] != SCHEMA_VERSION:
            return attributes
    if not copies and _left_over(path):
        raise StoreError(f"there is no store at {path}")
    raise StoreError(
        f"{path} is not allowed: it is something else than a store of this program, or damaged beyond mending: "
        "move it away, or take another store.name="
    )


def _copy(file: Path, *keys: str) -> dict | None:
    """What a metadata file says of the whole store, if it can be read."""
    try:
        attributes = read_json(file)
        for key in keys:
            attributes = attributes[key]
        # A hash or a number too many is no store of ours.
        fine = type(attributes["bevelmap_schema"]) is int and isinstance(json.loads(attributes["numbers"]), dict)
        return attributes if fine else None
    except (KeyError, ValueError, TypeError, RecursionError):
        return None


def _left_over(path: Path) -> bool:
    """Whether only chunks are there: a task wrote them that ran on while the store was taken away."""
    if not path.is_dir() or (path / METADATA).exists():
        return False
    return all(STORE_FILE.fullmatch(name) and not name.endswith(METADATA) for name in files_of(path))


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
            f"{path} was made by a newer version of this program "
            f"(schema {version}, this one knows {SCHEMA_VERSION}): update it"
        )
    if version < SCHEMA_VERSION:
        raise StoreError(
            f"{path} was made by an older version of this program (schema {version}, this one knows {SCHEMA_VERSION}): "
            "store.overwrite=true makes it anew, another store.name= keeps it"
        )
    try:
        return validate_plan(json.loads(attributes["numbers"]))
    except (
        ConfigurationError,
        ArithmeticError,
        AttributeError,
        LookupError,
        TypeError,
        ValueError,
        RecursionError,
    ) as error:
        raise StoreError(f"{path} is not allowed: what it says of its plane makes no sense ({_short(error)})") from None


def _short(error: Exception) -> str:
    """One line of an error that may quote anything."""
    said = " ".join(str(error).split()) or type(error).__name__
    return said if len(said) <= 200 else f"{said[:200]}…"


def read_layout(path: Path, going_on: bool = False) -> Layout:
    """A store looked over, as `validate_layout` does; whatever is done with one begins with this.

    Raises
    ------
    StoreError
        If there is no store, or it is not one of ours or of this version, or names, metadata and sizes of files show it
        to be damaged.
    solver.ParameterError
        If the path is none.
    """
    path = store_path("path", path)
    attributes = root_attributes(path)
    return validate_layout(path, plan_from(attributes, path), attributes, going_on)


def read_plan(path: Path) -> Plan:
    """The plan of an existing store whose rows are to be read.

    Raises
    ------
    StoreError
        As `read_layout`, and if next to nothing of a large plane is computed.
    """
    layout = read_layout(path)
    layout.refuse_hollow()
    return layout.plan


def check(path: Path, plan: Plan) -> bool:
    """Whether a store for exactly this plan exists, which a sweep can go on with.

    Raises
    ------
    StoreError
        If something else is there, with the difference and the ways on.
    """
    if not path.exists() or _left_over(path):
        return False
    stored = read_layout(path, going_on=True).plan.numbers
    if stored == plan.numbers:
        return True
    old, new = _flatten(stored), _flatten(plan.numbers)
    keys = [key for key in sorted(old.keys() | new.keys()) if old.get(key) != new.get(key)]
    changes = "; ".join(f"{key}: stored {old.get(key, 'nothing')}, asked {new.get(key, 'nothing')}" for key in keys)
    raise StoreError(
        f"{path} holds another configuration ({changes}): take another store.name=..., or store.overwrite=true"
    )


def refuse_foreign(path: Path) -> None:
    """Raise unless the path is free or holds a store of ours alone, so that overwriting never deletes anything else."""
    if path.exists() and not _left_over(path):
        root_attributes(path)
        refuse_unknown(path, STORE_FILE)


def _flatten(value, prefix="") -> dict[str, object]:
    if not isinstance(value, dict):
        return {prefix: value}
    return {k: v for key, child in value.items() for k, v in _flatten(child, f"{prefix}.{key}".lstrip(".")).items()}
