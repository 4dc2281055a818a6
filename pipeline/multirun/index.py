"""The index of a study, `study.csv` beside its stores: which plane has which values, and what its map tells.

A folder of stores has one index. It is written when a study begins and whenever one of its planes ends. A command that
varies the same keys, all else equal, adds its planes to those listed; another study takes the place of the one before.
"""

import csv
import io
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pipeline import store
from pipeline.config.compose import Settings
from pipeline.config.default_name import is_name
from pipeline.config.places import Place
from pipeline.config.typed import key_of
from pipeline.errors import ConfigurationError, DamagedError, StoreError, shown
from pipeline.plane.result import map_summary
from pipeline.plane.stored import read_stored
from pipeline.run.sheets import csv_text
from pipeline.store.files import files_at

__all__ = ["FILE", "Index", "Listed", "Varied", "begun_index", "read_index"]

FILE = "study.csv"
_MAP = ("domains", "several_motions", "teeth_part", "back_flanks_struck")
#: Columns behind those of what varies.
_TOLD = ("status", "rows", "rows_complete", "cells", "cells_proven", *_MAP, "all_else")
#: Keys that change neither what is computed nor of what.
_ASIDE = re.compile(r"(stages|debug|output|store|cluster|figures|page|explore)(\.\w+)*")
_NUMBER_AND_UNIT = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)(?:\s*([A-Za-zµμ°/1].*))?")
_HEADING = re.compile(r"(.+) \[(.+)\]")
_LONGEST = 2**24


@dataclass(frozen=True)
class Varied:
    """A key that differs between the planes of a study; its unit, "1" of plain numbers, None where values are words."""

    key: str
    unit: str | None

    @property
    def heading(self) -> str:
        """Of its column."""
        return self.key if self.unit is None else f"{self.key} [{self.unit}]"


@dataclass(frozen=True)
class Listed:
    """One plane: the name of its store, its values in the order of the varied keys, what is told of it by column."""

    store: str
    values: tuple[float | str, ...]
    told: Mapping[str, str] = field(default_factory=dict)


@dataclass
class Index:
    """The planes of a study.

    Parameters
    ----------
    root : Place
        The folder of their stores.
    varied : tuple of Varied
    planes : dict of str to Listed
        By the name of their store, in the order of the command.
    """

    root: Place
    varied: tuple[Varied, ...]
    planes: dict[str, Listed]

    @property
    def path(self) -> Place:
        """The file."""
        return self.root / FILE

    def learn(self, name: str, failed: bool) -> None:
        """A plane has ended: list what its store tells, and write the file."""
        plane = self.planes[name]
        told = {**plane.told, **_told_of(self.root / f"{name}.zarr", failed)}
        self.planes[name] = replace(plane, told=told)
        self.write()

    def write(self) -> None:
        """Write the file, in place of what was there."""
        heading = ["store", *(one.heading for one in self.varied), *_TOLD]
        lines = [
            [plane.store, *map(_number_text, plane.values), *(plane.told.get(name, "") for name in _TOLD)]
            for plane in self.planes.values()
        ]
        files_at(self.root).write({FILE: csv_text(heading, lines).encode()})


def begun_index(all_settings: Sequence[Settings]) -> tuple[Index, str]:
    """The index of a study that begins.

    Parameters
    ----------
    all_settings : sequence of Settings
        Of one command, so that they have the same keys in the same order, and stores of their own.

    Returns
    -------
    Index
        With what its stores tell already.
    str
        A sentence where it takes the place of another study's, else empty.
    """
    root = all_settings[0].store_path.resolve().parent
    keys = [key_of(override) for override in all_settings[0].overrides]
    columns = [[override.partition("=")[2] for override in column] for column in _transposed(all_settings)]
    varying = [i for i, column in enumerate(columns) if len(set(column)) > 1 and not _ASIDE.fullmatch(keys[i])]
    same = [i for i in range(len(keys)) if i not in varying and not _ASIDE.fullmatch(keys[i])]
    all_else = " ".join(sorted(f"{keys[i]}={columns[i][0]}" for i in same))
    read = [_values(columns[i]) for i in varying]
    varied = tuple(Varied(keys[i], unit) for i, (unit, _) in zip(varying, read, strict=True))
    planes = {}
    for number, settings in enumerate(all_settings):
        told = {**_told_of(settings.store_path, False), "all_else": all_else}
        values = tuple(column[number] for _, column in read)
        planes[settings.store_name] = Listed(settings.store_name, values, told)
    return _going_on(Index(root, varied, planes), all_else)


def _transposed(all_settings: Sequence[Settings]) -> list[tuple[str, ...]]:
    return list(zip(*(settings.overrides for settings in all_settings), strict=True))


def _going_on(index: Index, all_else: str) -> tuple[Index, str]:
    """The index with the planes that were listed before, where that was the same study."""
    try:
        before = read_index(index.root)
    except StoreError:
        return index, ""
    there = {name: plane for name, plane in before.planes.items() if store.exists(index.root / f"{name}.zarr")}
    if before.varied == index.varied and all(plane.told["all_else"] == all_else for plane in there.values()):
        return Index(index.root, index.varied, {**there, **index.planes}), ""
    gone = sorted(there.keys() - index.planes.keys())
    if not gone:
        return index, ""
    keys = ", ".join(one.key for one in before.varied) or "nothing"
    return index, (
        f"note: {index.path} listed another study (of {keys}), whose stores are kept; store.root=FOLDER gives each "
        "study a folder of its own"
    )


def read_index(root: Place) -> Index:
    """The index of a folder.

    Raises
    ------
    StoreError
        If there is none, or it is none of this program's.
    """
    path = root / FILE
    try:
        text = files_at(root).read(FILE, _LONGEST).decode()
        heading, *lines = csv.reader(io.StringIO(text), strict=True)
    except (FileNotFoundError, NotADirectoryError):
        raise StoreError(
            f"there is no study at {root}: python -m pipeline -m KEY=VALUE,VALUE store.root={root} makes one"
        ) from None
    except (OSError, ValueError, csv.Error) as error:
        raise StoreError(f"{path} is no index of a study: {shown(str(error))}") from None
    count = len(heading) - 1 - len(_TOLD)
    if count < 0 or heading[0] != "store" or tuple(heading[1 + count :]) != _TOLD:
        raise StoreError(f"{path} is no index of a study: its columns are {shown(', '.join(heading))}")
    varied = tuple(
        Varied(*found.groups()) if (found := _HEADING.fullmatch(text)) else Varied(text, None)
        for text in heading[1 : 1 + count]
    )
    planes = {}
    for line in lines:
        if len(line) != len(heading) or not is_name(line[0]):
            raise StoreError(f"{path} is no index of a study: {shown(','.join(line))} is no line of it")
        values = tuple(
            _number(path, text) if one.unit else text for one, text in zip(varied, line[1 : 1 + count], strict=True)
        )
        planes[line[0]] = Listed(line[0], values, dict(zip(_TOLD, line[1 + count :], strict=True)))
    return Index(root, varied, planes)


def _number(path: Place, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise StoreError(f"{path} is no index of a study: {shown(text)} is no number") from None


def _values(texts: Sequence[str]) -> tuple[str | None, list[float | str]]:
    """Values as typed: a common unit and numbers, or None and words.

    Examples
    --------
    >>> _values(["0.5", "0.6"]), _values(["'90 N*m'", "'1e2 N*m'"]), _values(["miter", "published"])
    (('1', [0.5, 0.6]), ('N*m', [90.0, 100.0]), (None, ['miter', 'published']))
    >>> _values(["'50 um'", "'0.1 mm'"])
    (None, ['50 um', '0.1 mm'])
    """
    words = [text.strip("'\"") for text in texts]
    found = [_NUMBER_AND_UNIT.fullmatch(word) for word in words]
    units = {match[2] or "1" for match in found if match}
    if not all(found) or len(units) != 1:
        return None, words
    return units.pop(), [float(match[1]) for match in found]


def _number_text(value: float | str) -> str:
    return value if isinstance(value, str) else repr(value).removesuffix(".0")


def _told_of(path: Place, failed: bool) -> dict[str, str]:
    """What a store tells of its plane, by column."""
    if not store.exists(path):
        return {"status": "failed" if failed else "pending"}
    try:
        plane = read_stored(path)
        states, proven, summary = store.statuses(path), store.proven_cells(path), map_summary(plane)
    except DamagedError:
        return {"status": "damaged"}
    except (ConfigurationError, OSError):
        return {"status": "refused"}
    done = int(np.sum(states == store.COMPLETE))
    bad = failed or np.any(states == store.FAILED)
    told = {
        "status": "failed" if bad else "complete" if done == states.size else "incomplete",
        "rows": str(states.size),
        "rows_complete": str(done),
        "cells": str(states.size * plane.plan.sweep.num),
    }
    if proven is not None:
        told["cells_proven"] = str(proven[0])
    if summary is not None:
        shares = {name: f"{getattr(summary, name):.6g}" for name in _MAP[1:]}
        told |= {"domains": str(summary.domains), **shares}
    return told
