"""Whose store it is: the plan it was made for, and whether that is the plan at hand."""

import json
from collections.abc import Mapping
from pathlib import Path

from pipeline.config.places import ObjectPlace, Place, is_url, place_of
from pipeline.errors import ConfigurationError, StoreError
from pipeline.plan.differences import by_key, differences
from pipeline.plan.plan import SCHEMA_VERSION, Plan
from pipeline.store.documents import read_json
from pipeline.store.files import Files, files_at
from pipeline.store.layout import Layout, validate_layout
from pipeline.store.names import METADATA, ROWS, STORE_FILE, refuse_unknown
from pipeline.store.seal import sealed
from pipeline.store.validation import validate_plan
from solver import ParameterError

__all__ = [
    "check",
    "exists",
    "plan_from",
    "read_layout",
    "read_plan",
    "refuse_foreign",
    "root_attributes",
    "store_path",
]


def store_path(name: str, value: str | Place, storage_options: Mapping | None = None) -> Place:
    """A path or URL as a caller gives it.

    Parameters
    ----------
    name : str
        The parameter as the caller knows it.
    value : str, Path or ObjectPlace
    storage_options : mapping, optional
        As `store.storage_options`, for a URL.

    Raises
    ------
    solver.ParameterError
        If it is none of these, or no path.
    ConfigurationError
        If it is a URL that no store can have.
    StoreError
        If the system refuses to look there.
    """
    if isinstance(value, ObjectPlace):
        return value
    if isinstance(value, str) and is_url(value):
        return place_of(name, value, storage_options)
    if isinstance(value, str | Path) and str(value) and "\0" not in str(value):
        path = Path(value)
        try:
            path.exists()
        except OSError as error:
            raise StoreError(f"{name} = {str(value)[:200]!r} cannot be read: {error.strerror}") from None
        return path
    raise ParameterError(name, value, "a path or a URL, as text or a pathlib.Path")


def exists(path: Place) -> bool:
    """Whether anything is at a place."""
    return files_at(path).exists()


def root_attributes(files: Files) -> dict:
    """What the root of a store says of itself; from its second place, in `branches`, where the first is damaged.

    Raises
    ------
    StoreError
        If there is no store, or neither place can be read.
    """
    path = files.place
    if not files.exists():
        raise StoreError(f"there is no store at {path}")
    places = (METADATA, ("attributes",)), (f"{ROWS}/{METADATA}", ("attributes", "plane"))
    copies = [copy for name, keys in places if (copy := _copy(files, name, *keys)) is not None]
    for attributes in copies:
        if attributes == sealed(attributes):
            return attributes
    for attributes in copies:
        # What another version seals, and how, is not known here.
        if attributes["bevelmap_schema"] != SCHEMA_VERSION:
            return attributes
    if not copies and _left_over(files):
        raise StoreError(f"there is no store at {path}")
    raise StoreError(
        f"{path} is not allowed: it is something else than a store of this program, or damaged beyond mending: "
        "move it away, or take another store.name="
    )


def _copy(files: Files, name: str, *keys: str) -> dict | None:
    """What a metadata file says of the whole store, if it can be read."""
    try:
        attributes = read_json(files, name)
        for key in keys:
            attributes = attributes[key]
        # A hash or a number too many is no store of ours.
        fine = type(attributes["bevelmap_schema"]) is int and isinstance(json.loads(attributes["numbers"]), dict)
        return attributes if fine else None
    except (KeyError, ValueError, TypeError, RecursionError):
        return None


def _left_over(files: Files) -> bool:
    """Whether only chunks are there: a task wrote them that ran on while the store was taken away."""
    if files.has(METADATA):
        return False
    try:
        names = files.sizes()
    except (FileNotFoundError, NotADirectoryError):
        return False
    return all(STORE_FILE.fullmatch(name) and not name.endswith(METADATA) for name in names)


def plan_from(attributes: dict, path: Place) -> Plan:
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


def read_layout(path: Place, going_on: bool = False) -> Layout:
    """A store looked over, as `validate_layout` does; whatever is done with one begins with this.

    Raises
    ------
    StoreError
        If there is no store, or it is not one of ours or of this version, or names, metadata and sizes of files show it
        to be damaged.
    solver.ParameterError
        If the path is none.
    """
    files = files_at(store_path("path", path))
    attributes = root_attributes(files)
    return validate_layout(files, plan_from(attributes, files.place), attributes, going_on)


def read_plan(path: Place) -> Plan:
    """The plan of an existing store whose rows are to be read.

    Raises
    ------
    StoreError
        As `read_layout`, and if next to nothing of a large plane is computed.
    """
    layout = read_layout(path)
    layout.refuse_hollow()
    return layout.plan


def check(path: Place, plan: Plan) -> bool:
    """Whether a store for exactly this plan exists, which a sweep can go on with.

    Raises
    ------
    StoreError
        If something else is there, with the difference and the ways on.
    """
    files = files_at(path)
    if not files.exists() or _left_over(files):
        return False
    stored = read_layout(path, going_on=True).plan.inputs
    if stored == plan.inputs:
        return True
    changes = differences(by_key(stored), by_key(plan.inputs)) or "in numbers that follow from it"
    raise StoreError(
        f"{path} holds another configuration ({changes}): take another store.name=..., or store.overwrite=true"
    )


def refuse_foreign(path: Place) -> None:
    """Raise unless the path is free or holds a store of ours alone, so that overwriting never deletes anything else."""
    files = files_at(path)
    if files.exists() and not _left_over(files):
        root_attributes(files)
        refuse_unknown(files.place, files.sizes(), STORE_FILE)
