"""Names of the files of a store. Nothing in a store is opened, written or removed under any other name."""

import re
from collections.abc import Iterable

from pipeline.config.places import Place
from pipeline.errors import StoreError

__all__ = [
    "ADDED",
    "GROUP_FILE",
    "IN_BLOCKS",
    "LEFT_OVER",
    "METADATA",
    "ROWS",
    "STORE_FILE",
    "is_name",
    "refuse_unknown",
]

METADATA = "zarr.json"
#: The group that the rows themselves fill.
ROWS = "branches"
#: Groups that stages add, arrays in them and no further groups.
ADDED = ("attractors", "boundaries", "isolated", "places")
#: Those of them that are written block by block; see `pipeline.store.row_groups`.
IN_BLOCKS = ("attractors",)

_NAME = r"[A-Za-z]\w{0,79}"
_PARTIAL = r"\.[0-9a-f]{32}\.partial"
_ARRAY = rf"zarr(\.json|{_PARTIAL})|c(/\d{{1,9}})+({_PARTIAL})?"
#: Metadata and chunks as zarr names them, those that are half written included: relative to a store, or to a group.
STORE_FILE = re.compile(rf"zarr{_PARTIAL}|({_NAME}/){{0,2}}({_ARRAY})", re.ASCII)
GROUP_FILE = re.compile(rf"({_NAME}/)?({_ARRAY})", re.ASCII)
#: What zarr leaves behind where a process is ended while it writes; never read.
LEFT_OVER = re.compile(rf".*{_PARTIAL}", re.ASCII)


def is_name(text: str) -> bool:
    """Whether an array of this program may be called so.

    Examples
    --------
    >>> is_name("domain_low"), is_name(".."), is_name("a/b"), is_name("")
    (True, False, False, False)
    """
    return re.fullmatch(_NAME, text, re.ASCII) is not None


def refuse_unknown(place: Place, names: Iterable[str], known: re.Pattern) -> None:
    """Raise unless every file at a place has a name that `known` matches.

    Raises
    ------
    StoreError
        Naming a file that has not.
    """
    for name in sorted(names):
        if not known.fullmatch(name):
            raise StoreError(
                f"{place} cannot be removed: {name[:200]!r} in it is no file of this program; move it away first"
            )
