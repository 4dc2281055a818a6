"""Mesh stiffness and transmission error over one mesh cycle, from the CSV file of a tooth-contact program."""

import math
import re
from dataclasses import dataclass

import numpy as np

from pipeline.config.csv_table import Table, read_table
from pipeline.config.number_files import NumbersError
from pipeline.config.units import quantity, unit_size
from pipeline.errors import ConfigurationError, refused
from solver import CycleFit, ParameterError, PitchCones, fit_cycle

__all__ = ["MeshCycle", "read_mesh_cycle"]

KEY = "gear.physical.mesh_cycle"
LENGTH_KEY = "gear.physical.mesh_cycle_length"

#: Name of a column -> what it is; the first name of each is the one that messages use.
_PLACES = {
    **dict.fromkeys(("angle", "phase", "mesh angle", "mesh phase"), "angle"),
    **dict.fromkeys(("pinion angle", "pinion rotation"), "pinion angle"),
    **dict.fromkeys(("gear angle", "wheel angle", "gear rotation", "wheel rotation"), "gear angle"),
    **dict.fromkeys(("time", "t"), "time"),
}
_VALUES = {
    **dict.fromkeys(("stiffness", "mesh stiffness"), "stiffness"),
    **dict.fromkeys(("error", "transmission error"), "error"),
}
_ALLOWED = (
    "one of angle (deg), pinion angle (deg), gear angle (deg), time (ms), and one or both of "
    "stiffness (N/um), error (um), each with its unit"
)
_HEADER = re.compile(r"([\w\s]+?)\s*(?:\(([^()\[\]]*(?:\([^()]*\))?)\)|\[([^\[\]]*)\])")
_OVER_WIDTH = re.compile(r"(\w+)\s*/\s*(?:\(\s*(\w+)\s*[\s*·]\s*(\w+)\s*\)|(\w+)\s*/\s*(\w+))")
_LONGEST = 100
#: Shares of a mesh cycle within which two places are one; of the largest value, within which two values are.
_SAME_PLACE, _SAME_VALUE = 1e-4, 1e-6


@dataclass(frozen=True)
class MeshCycle:
    """Fits in SI units of what a file holds.

    Parameters
    ----------
    points : int
    stiffness : CycleFit or None
        N/m.
    error : CycleFit or None
        m; its mean, a rigid rotation, has no effect.
    """

    points: int
    stiffness: CycleFit | None
    error: CycleFit | None


@dataclass(frozen=True)
class _Columns:
    """Columns of a table in SI units: what the cycle runs over, and its values."""

    over: str
    place: np.ndarray
    values: dict[str, np.ndarray]
    lines: list[int]


def read_mesh_cycle(path: str, count: int, cones: PitchCones, length=None) -> MeshCycle:
    """Read a file and fit `count` harmonics.

    Parameters
    ----------
    path : str
        CSV with a header such as `angle (deg), stiffness (N/um), error (um)`, in any order: what the cycle runs over,
        and one or both of the others. An angle is that of the mesh, with 360 deg or 1 cycle for one mesh cycle, or the
        pinion's or the gear's; time counts from the first row. The stiffness may be over the face width, as
        N/(mm um). A last row that closes the cycle is left out.
    count : int
    cones : PitchCones
        Tooth numbers and face width of the gear.
    length : str or None
        One mesh cycle in the column that it runs over, such as "1.2 ms".

    Raises
    ------
    ConfigurationError
        One line that names the file, the line and what is allowed, or what to type where the file leaves it open.
    """
    try:
        table = read_table(path)
    except NumbersError as error:
        raise _wrong(path, str(error)) from None
    columns = _columns(path, table, cones.face_width)
    for line, value in zip(columns.lines, columns.values.get("stiffness", ()), strict=False):
        if value < 0.0:
            raise _wrong(path, f"line {line}: the stiffness must be at least 0 all cycle")
    share, values = _one_cycle(path, columns, _length(path, columns, cones, length))
    fits = {name: _fit(path, columns, share, value, count) for name, value in values.items()}
    return MeshCycle(share.size, fits.get("stiffness"), fits.get("error"))


def _wrong(path: str, why: str) -> ConfigurationError:
    return ConfigurationError(f"{KEY} = {path!r} is not allowed: {why}")


def _columns(path: str, table: Table, face_width: float) -> _Columns:
    found = {}
    for i, text in enumerate(table.header):
        match = _HEADER.fullmatch(text) if len(text) <= _LONGEST else None
        words = " ".join((match[1] if match else text[:_LONGEST]).lower().replace("_", " ").split())
        name = _PLACES.get(words) or _VALUES.get(words)
        if name is None or name in found or (name in _PLACES and any(one in _PLACES for one in found)):
            raise _wrong(path, f"its header has {text[:40]!r}, where it must have {_ALLOWED}")
        if match is None:
            raise _wrong(path, f"its header has {text[:40]!r} without a unit: write {_with_units(name)}")
        unit = (match[2] if match[2] is not None else match[3]).strip()
        found[name] = np.array([row[i] for row in table.rows]) * _size(name, unit, face_width)
    over = [name for name in found if name in _PLACES]
    if not over or len(found) < 2:
        raise _wrong(path, f"its header must have {_ALLOWED}")
    if not table.rows:
        raise _wrong(path, "it has no rows of numbers")
    place = found.pop(over[0])
    return _Columns(over[0], place, found, table.lines)


def _with_units(name: str) -> str:
    units = {"time": ("s", "ms"), "stiffness": ("N/um", "N/(mm um)"), "error": ("um", "mm")}.get(name, ("deg", "rad"))
    return " or ".join(f"{name} ({unit})" for unit in units)


def _size(name: str, unit: str, face_width: float) -> float:
    """SI units of a column's unit."""
    key = f"{KEY}, unit of {name}"
    if name == "stiffness" and (parts := _OVER_WIDTH.fullmatch(unit)):
        force, *lengths = [part for part in parts.groups() if part]
        return face_width * unit_size(key, "/".join((force, *lengths)), "stiffness over face width")
    return unit_size(key, unit, {"time": "time", "stiffness": "stiffness", "error": "length"}.get(name, "angle"))


def _length(path: str, columns: _Columns, cones: PitchCones, length) -> float:
    """One mesh cycle in the unit of the places."""
    over, place = columns.over, columns.place
    if length is not None:
        found = quantity(LENGTH_KEY, length, "time" if over == "time" else "angle")
        if found <= 0.0:
            raise refused(LENGTH_KEY, length, "above 0")
        return found
    if over != "time":
        return 2.0 * math.pi / {"angle": 1, "pinion angle": cones.teeth[0], "gear angle": cones.teeth[1]}[over]
    if place.size > 1 and place[-1] > place[0] and all(_repeats(value) for value in columns.values.values()):
        return float(place[-1] - place[0])
    raise _wrong(
        path, f"its last row does not repeat the first: type the time of one mesh cycle, such as {LENGTH_KEY}='1.2 ms'"
    )


def _repeats(values: np.ndarray) -> bool:
    """Whether the last value is the first again."""
    return abs(values[-1] - values[0]) <= _SAME_VALUE * np.max(np.abs(values))


def _one_cycle(path: str, columns: _Columns, length: float) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Places as shares of the mesh cycle within [0, 1), and the values there, without a row that closes the cycle."""
    place = columns.place
    if columns.over == "time":
        if np.any(np.diff(place) <= 0.0):
            line = columns.lines[int(np.argmax(np.diff(place) <= 0.0)) + 1]
            raise _wrong(path, f"line {line}: the time must be later than in the row before")
        place = place - place[0]
    share = place / length
    outside = (share < -_SAME_PLACE) | (share > 1.0 + _SAME_PLACE)
    if np.any(outside):
        line, unit = columns.lines[int(np.argmax(outside))], _shown(columns.over, length)
        raise _wrong(path, f"line {line}: the {columns.over} must be at least 0 and at most one mesh cycle, {unit}")
    share = np.maximum(share, 0.0)
    closing = np.flatnonzero(share >= 1.0 - _SAME_PLACE)
    opening = np.flatnonzero(share <= _SAME_PLACE)
    if closing.size == 1 and opening.size == 0:
        # The cycle runs from above 0 to its end, which is its beginning.
        share[closing] = 0.0
    if closing.size != 1 or opening.size != 1:
        return share, columns.values
    for name, value in columns.values.items():
        if abs(value[closing[0]] - value[opening[0]]) > _SAME_VALUE * np.max(np.abs(value)):
            raise _wrong(
                path,
                f"line {columns.lines[closing[0]]} closes the cycle with another {name} than "
                f"line {columns.lines[opening[0]]} has: make them equal, or leave one out",
            )
    kept = np.arange(share.size) != closing[0]
    return share[kept], {name: value[kept] for name, value in columns.values.items()}


def _shown(over: str, place: float) -> str:
    return f"{place:.6g} s" if over == "time" else f"{math.degrees(place):.6g} deg"


def _fit(path: str, columns: _Columns, share: np.ndarray, values: np.ndarray, count: int) -> CycleFit:
    try:
        return fit_cycle(2.0 * math.pi * share, values, count)
    except ParameterError as error:
        if error.name == "count":
            raise ConfigurationError(str(error).replace("count", "gear.physical.mesh_cycle_harmonics", 1)) from None
        if error.name != "angle":
            raise _wrong(path, f"its numbers are too large: {error}") from None
        raise _wrong(path, f"the {_asked_back(columns, share, error)}") from None


def _asked_back(columns: _Columns, share: np.ndarray, error: ParameterError) -> str:
    """What is wrong with an angle, or what to type where the file holds a part of the cycle only."""
    if columns.over == "angle" and float(np.max(share)) < 0.5:
        end = _shown("angle", float(np.max(columns.place)))
        return (
            f"angle ends at {end}, and a mesh cycle is 360 deg: name the column 'pinion angle' if it is the "
            f"pinion's, or type the angle of one mesh cycle, such as {LENGTH_KEY}='18 deg'"
        )
    of_cycle = "" if columns.over == "angle" else " of the mesh cycle"
    return f"{columns.over} {math.degrees(error.value):.6g} deg{of_cycle} must be {error.allowed}"
