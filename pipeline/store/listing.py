"""What stores a folder holds, by metadata, sizes of files and states of rows, so that many are listed at once."""

import math
import time
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cache

import numpy as np

from pipeline.config.places import Place
from pipeline.errors import ConfigurationError, DamagedError, StoreError, counted, shown
from pipeline.plan.plan import SCHEMA_VERSION, Plan
from pipeline.store.files import Files, files_at
from pipeline.store.identity import plan_from, root_attributes
from pipeline.store.layout import validate_layout
from pipeline.store.names import METADATA
from pipeline.store.states import COMPLETE, FAILED

__all__ = ["TITLES", "Entry", "Listing", "columns", "listing", "size_text"]

_USUAL = "published"
_SHOWN = 2
_APART = "  "
#: Columns that a narrow terminal has no room for, the first one first.
_MISSED_LEAST = ("hash", "age", "size", "groups", "solver", "gear", "plane")
TITLES = ("store", "plane", "gear", "solver", "status", "size", "hash", "age", "groups")


@dataclass(frozen=True)
class Entry:
    """One store, in words; `size` in bytes, `age` in seconds (nan where it is not known)."""

    name: str
    plane: str
    gear: str
    solver: str
    status: str
    size: int
    digest: str
    age: float
    groups: tuple[str, ...]

    @property
    def cells(self) -> tuple[str, ...]:
        """As shown, in the order of the columns."""
        age = "?" if math.isnan(self.age) else _age(self.age)
        texts = (
            self.name,
            self.plane,
            self.gear,
            self.solver,
            self.status,
            size_text(self.size),
            self.digest,
            age,
            " ".join(self.groups) or "-",
        )
        return tuple(map(shown, texts))


@dataclass(frozen=True)
class Listing:
    """The stores of a folder by name, and the names of folders in it that are something else."""

    entries: tuple[Entry, ...]
    foreign: tuple[str, ...]


def listing(root: Place) -> Listing:
    """Look into a folder; nothing is written, and nothing but metadata, sizes and states of rows is read."""
    entries, foreign = [], []
    for name in files_at(root).folders():
        # Drafts and locks of a run have names that begin with a dot.
        if name.startswith("."):
            continue
        files = files_at(root / name)
        try:
            attributes = root_attributes(files)
        except StoreError:
            if files.has(METADATA) and {"branches", "status"} <= set(files.folders()):
                entries.append(_entry(files, None, "damaged metadata: stages=[check] cannot tell what it was"))
            elif files.exists():
                foreign.append(shown(name))
            continue
        entries.append(_described(files, attributes))
    return Listing(tuple(entries), tuple(foreign))


def columns(found: Listing, room: int | None = None) -> list[str]:
    """Plain aligned lines, a heading first; without the columns that are missed least where there is no room."""
    rows = [TITLES, *(entry.cells for entry in found.entries)]
    widths = {title: max(len(row[i]) for row in rows) for i, title in enumerate(TITLES)}
    for title in _MISSED_LEAST:
        if room is None or sum(widths.values()) + len(_APART) * (len(widths) - 1) <= room:
            break
        del widths[title]
    kept = [(TITLES.index(title), width) for title, width in widths.items()]
    return [_APART.join(row[i].ljust(width) for i, width in kept).rstrip() for row in rows]


def _described(files: Files, attributes: dict) -> Entry:
    version = int(attributes["bevelmap_schema"])
    try:
        plan = plan_from(attributes, files.place)
    except StoreError:
        text = (
            "damaged metadata"
            if version == SCHEMA_VERSION
            else f"schema {version}, this program reads {SCHEMA_VERSION}"
        )
        return _entry(files, attributes, text)
    try:
        layout = validate_layout(files, plan, attributes)
        status, groups = _progress(layout.states), tuple(name for name in layout.groups if name in layout.listed)
    except DamagedError:
        status, groups = "damaged: stages=[check] says where", ()
    except StoreError:
        status, groups = "not allowed: stages=[check] says why", ()
    plane = " x ".join(f"{axis.name} {axis.num}" for axis in plan.axes)
    return _entry(files, attributes, status, plane, _gear(plan), _solver(plan), groups)


def _solver(plan: Plan) -> str:
    """By what balance, and of which order."""
    order, period = plan.solver["order"], plan.solver["period"]
    if plan.is_first_order:
        return "first order"
    return f"hb order {order}" + (f" period {period}" if period != 1 else "")


def _entry(
    files: Files, attributes: dict | None, status: str, plane: str = "?", gear: str = "?", solver: str = "?", groups=()
) -> Entry:
    said = attributes or {}
    return Entry(
        files.place.name.removesuffix(".zarr"),
        plane,
        gear,
        solver,
        status,
        sum(version[0] for version in files.versions().values()),
        str(said.get("configuration_hash", "?"))[:16],
        _seconds(said.get("created")),
        groups,
    )


def _progress(states: np.ndarray) -> str:
    """What has been computed."""
    failed, done = int(np.sum(states == FAILED)), int(np.sum(states == COMPLETE))
    if done == states.size:
        return "complete"
    parts = [f"{done} of {states.size} rows"] if done + failed < states.size else []
    return ", ".join([*parts, *([f"{counted(failed, 'row')} failed"] if failed else [])])


def _gear_names() -> list[str]:
    """Of every gear file that comes with the program: first the usual one, last those in units, which take longest."""
    from pipeline.config.typed import conf_folder

    texts = {file.stem: file.read_text(encoding="utf-8") for file in (conf_folder() / "gear").glob("*.yaml")}
    return sorted(texts, key=lambda name: ("\nphysical:\n" in texts[name], name != _USUAL, name))


@cache
def _known_gear(name: str) -> dict | None:
    """Kind and numbers of the system; None of a file that others start from, which has values missing."""
    from pipeline.config.compose import compose
    from pipeline.plan.planning import gear_of

    try:
        kind, gear, _ = gear_of(compose([f"gear={name}"]).config.gear)
    except ConfigurationError:
        return None
    return {"kind": kind, **{key: _plain(value) for key, value in gear.items()}}


def _plain(value):
    """Numbers and lists so that 0.5 and six times 0.5 compare equal."""
    flat = list(np.ravel(np.array(value, dtype=object)))
    return flat[0] if flat and all(one == flat[0] for one in flat) else str(value)


def _gear(plan: Plan) -> str:
    """The nearest gear that comes with the program, and what differs from it."""
    axes = {axis.name for axis in plan.axes}
    stored = {key: _plain(value) for key, value in plan.gear.items()}
    differences = {}
    for name in _gear_names():
        if (known := _known_gear(name)) is not None and known["kind"] == plan.kind:
            differences[name] = [key for key in stored if key not in axes and stored[key] != known.get(key)]
            if not differences[name]:
                break
    name = min(differences, key=lambda one: len(differences[one]))
    changed = differences[name]
    words = [f"{key}={stored[key]:g}" if isinstance(stored[key], int | float) else key for key in changed[:_SHOWN]]
    more = [f"and {len(changed) - _SHOWN} more"] if len(changed) > _SHOWN else []
    return " ".join([name, *words, *more])


def _seconds(created) -> float:
    """Since then, at least 0; nan where that cannot be read."""
    try:
        then = datetime.fromisoformat(str(created))
    except ValueError:
        return math.nan
    then = then if then.tzinfo else then.replace(tzinfo=UTC)
    return max(time.time() - then.timestamp(), 0.0)


def size_text(size: int) -> str:
    """As people write it.

    Examples
    --------
    >>> size_text(900), size_text(12_345_678)
    ('900 B', '12.3 MB')
    """
    for unit in ("B", "kB", "MB", "GB"):
        if size < 1000:
            return f"{size:.3g} {unit}"
        size /= 1000.0
    return f"{size:.3g} TB"


def _age(seconds: float) -> str:
    """In the largest unit of which there are two.

    Examples
    --------
    >>> _age(5), _age(7300), _age(3e6)
    ('5 s', '2 h', '34 d')
    """
    for size, unit in ((86400, "d"), (3600, "h"), (60, "min")):
        if seconds >= 2 * size:
            return f"{int(seconds // size)} {unit}"
    return f"{int(seconds)} s"
